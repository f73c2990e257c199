#include "viewer/panels.h"

#include <GLFW/glfw3.h>
#include <fmt/format.h>
#include <imgui.h>
#include <imgui_stdlib.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>

namespace voxcone {
namespace {

const ImVec4 kDim{0.6f, 0.6f, 0.6f, 1}, kChanged{1, 0.75f, 0.25f, 1}, kError{1, 0.45f, 0.4f, 1};

/// Dear ImGui's format strings are not ours to fill.
void text(const std::string& line) {
    ImGui::TextUnformatted(line.c_str(), line.c_str() + line.size());
}

void dim(const std::string& line) {
    ImGui::PushStyleColor(ImGuiCol_Text, kDim);
    ImGui::PushTextWrapPos(0);
    text(line);
    ImGui::PopTextWrapPos();
    ImGui::PopStyleColor();
}

void tip(const std::string& line) {
    if (!ImGui::IsItemHovered(ImGuiHoveredFlags_AllowWhenDisabled)) return;
    ImGui::BeginTooltip();
    ImGui::PushTextWrapPos(26 * ImGui::GetFontSize());
    text(line);
    ImGui::PopTextWrapPos();
    ImGui::EndTooltip();
}

std::string megabytes(std::uint64_t bytes) {
    return fmt::format("{:.1f} MB", static_cast<double>(bytes) / 1e6);
}

// ---- Scene

constexpr std::array kLightTypes = {"directional", "point", "spot", "sphere", "rectangle"};

void drawLight(Session& session, std::size_t index) {
    Light& light = session.lights[index];
    const std::string label = fmt::format("{} ({}{})", light.name, kLightTypes[static_cast<std::size_t>(light.type)],
                                          light.extracted ? ", extracted" : "");
    ImGui::PushID(static_cast<int>(index));
    if (ImGui::TreeNode("##light", "%s", label.c_str())) {
        const bool animated = !light.track.position.empty() || !light.track.direction.empty() ||
                              !light.track.intensity.empty() || light.extracted;
        ImGui::BeginDisabled(animated);
        const double extent = glm::length(session.facts->bounds.size());
        if (auto position = session.lightPosition(index)) {
            if (ImGui::DragScalarN("position", ImGuiDataType_Double, &position->x, 3,
                                   static_cast<float>(std::max(extent, 1e-9) * 1e-3), nullptr, nullptr, "%.4g"))
                session.moveLight(index, *position);
            tip("metres, in the world");
        }
        if (light.type == LightType::directional || light.type == LightType::spot) {
            // Height and bearing of where the light comes from.
            const glm::dvec3 way = *session.lightDirection(index);
            double height = glm::degrees(std::asin(std::clamp(-way.y, -1.0, 1.0)));
            double bearing = glm::degrees(std::atan2(-way.x, -way.z));
            const double low = -89.9, high = 89.9, west = -180, east = 180;
            bool turned = ImGui::SliderScalar("height", ImGuiDataType_Double, &height, &low, &high, "%.1f deg");
            turned |= ImGui::SliderScalar("bearing", ImGuiDataType_Double, &bearing, &west, &east, "%.1f deg");
            if (turned) {
                const double h = glm::radians(height), b = glm::radians(bearing);
                session.pointLight(index,
                                   -glm::dvec3(std::cos(h) * std::sin(b), std::sin(h), std::cos(h) * std::cos(b)));
            }
        }
        ImGui::DragFloat3("intensity", &light.intensity.x,
                          0.01f * std::max(0.1f, std::max({light.intensity.x, light.intensity.y, light.intensity.z})),
                          0, 1e9f, "%.4g");
        if (ImGui::SmallButton("off")) light.intensity = glm::vec3(0);
        ImGui::EndDisabled();
        if (animated) dim(light.extracted ? "stands for a part of the panorama or for an emitting mesh" : "animated");
        ImGui::TreePop();
    }
    ImGui::PopID();
}

std::string nodeName(const Session& session, int node) {
    const Node& n = session.scene().nodes[static_cast<std::size_t>(node)];
    return n.name.empty() ? fmt::format("node {}", n.fileIndex) : n.name;
}

void drawNode(Session& session, const std::vector<std::vector<int>>& children, int node) {
    const auto& below = children[static_cast<std::size_t>(node)];
    const auto flags = (below.empty() ? ImGuiTreeNodeFlags_Leaf : ImGuiTreeNodeFlags_OpenOnArrow) |
                       (session.selectedNode == node ? ImGuiTreeNodeFlags_Selected : ImGuiTreeNodeFlags_None);
    const bool moved = session.placed.contains(node);
    if (moved) ImGui::PushStyleColor(ImGuiCol_Text, kChanged);
    const bool open = ImGui::TreeNodeEx(reinterpret_cast<void*>(static_cast<std::intptr_t>(node + 1)), flags, "%s",
                                        nodeName(session, node).c_str());
    if (moved) ImGui::PopStyleColor();
    if (ImGui::IsItemClicked() && !ImGui::IsItemToggledOpen())
        session.selectedNode = session.selectedNode == node ? -1 : node;
    if (!open) return;
    for (const int child : below) drawNode(session, children, child);
    ImGui::TreePop();
}

/// Place, rotation and scale of the selected node, and what dragging it does.
void drawObject(Session& session) {
    const int index = session.selectedNode;
    ImGui::Separator();
    text(nodeName(session, index));
    if (const std::string why = session.fixedBecause(index); !why.empty())
        return dim(fmt::format("cannot be put elsewhere: {}", why));
    int mode = static_cast<int>(session.gizmoMode);
    ImGui::RadioButton("move", &mode, static_cast<int>(GizmoMode::move));
    ImGui::SameLine();
    ImGui::RadioButton("turn", &mode, static_cast<int>(GizmoMode::turn));
    ImGui::SameLine();
    ImGui::RadioButton("scale", &mode, static_cast<int>(GizmoMode::scale));
    tip("what the handles in the picture do (T)");
    session.gizmoMode = static_cast<GizmoMode>(mode);
    ImGui::SameLine();
    ImGui::BeginDisabled(!session.placed.contains(index));
    if (ImGui::SmallButton("put back")) session.putBack(index);
    ImGui::EndDisabled();

    Node node = session.scene().nodes[static_cast<std::size_t>(index)];
    decompose(node);
    const auto extent = static_cast<float>(std::max(glm::length(session.facts->bounds.size()), 1e-9));
    Placement next;
    if (ImGui::DragScalarN("translation", ImGuiDataType_Double, &node.translation.x, 3, 1e-3f * extent, nullptr,
                           nullptr, "%.4g"))
        next.translation = node.translation;
    tip("metres, in the space of the node's parent");
    // As it was given, since other angles may mean the same rotation.
    const auto placed = session.placed.find(index);
    glm::dvec3 degrees =
        placed != session.placed.end() && placed->second.rotation ? *placed->second.rotation : degreesOf(node.rotation);
    if (ImGui::DragScalarN("rotation", ImGuiDataType_Double, &degrees.x, 3, 0.5f, nullptr, nullptr, "%.1f"))
        next.rotation = degrees;
    tip("degrees about x, then y, then z of the parent's axes");
    const double least = 1e-6, most = 1e6;
    if (ImGui::DragScalarN("scale", ImGuiDataType_Double, &node.scale.x, 3, 0.005f, &least, &most, "%.4g"))
        next.scale = node.scale;
    if (!next.empty()) session.placeNode(index, next);
}

void drawScenePanel(Session& session) {
    const SceneFacts& facts = *session.facts;
    const Scene& scene = facts.outline;
    text(facts.file.filename().string());
    const glm::dvec3 size = facts.bounds.size();
    dim(fmt::format("{} triangles, {:.4g} x {:.4g} x {:.4g} m", facts.triangles, size.x, size.y, size.z));
    if (ImGui::TreeNodeEx("cameras", ImGuiTreeNodeFlags_DefaultOpen)) {
        for (std::size_t i = 0; i < facts.shots.size(); ++i) {
            ImGui::PushID(static_cast<int>(i));
            if (ImGui::Selectable(("shot " + facts.shots[i].name).c_str(), session.shot == static_cast<int>(i)))
                session.takeShot(static_cast<int>(i));
            ImGui::PopID();
        }
        for (std::size_t i = 0; i < scene.cameras.size(); ++i) {
            ImGui::PushID(static_cast<int>(i + 10000));
            if (ImGui::Selectable(("camera " + scene.cameras[i].name).c_str())) session.takeCamera(scene.cameras[i]);
            ImGui::PopID();
        }
        ImGui::TreePop();
    }
    if (ImGui::TreeNode("lights", "lights (%d)", static_cast<int>(session.lights.size()))) {
        ImGui::Checkbox("handles in the picture", &session.showLights);
        tip("drag a light, or one of its axes (G); turn it by its rings (T)");
        for (std::size_t i = 0; i < session.lights.size(); ++i) drawLight(session, i);
        ImGui::TreePop();
    }
    if (ImGui::TreeNode("materials", "materials (%d)", static_cast<int>(scene.materials.size()))) {
        for (const Material& m : scene.materials) {
            const ImVec4 color(m.baseColor.x, m.baseColor.y, m.baseColor.z, 1);
            ImGui::PushID(&m);
            ImGui::ColorButton("##color", color, ImGuiColorEditFlags_NoTooltip);
            ImGui::SameLine();
            text(m.name.empty() ? "unnamed" : m.name);
            tip(fmt::format("metallic {:.3g}, roughness {:.3g}{}{}{}{}", m.metallic, m.roughness,
                            m.emits() ? ", emits" : "", m.transmits() ? ", transmits" : "", m.unlit ? ", unlit" : "",
                            scene.isLeaves(m) ? ", leaves" : ""));
            ImGui::PopID();
        }
        ImGui::TreePop();
    }
    if (ImGui::TreeNode("nodes", "nodes (%d)", static_cast<int>(scene.nodes.size()))) {
        std::vector<std::vector<int>> children(scene.nodes.size());
        for (std::size_t i = 0; i < scene.nodes.size(); ++i)
            if (scene.nodes[i].parent >= 0)
                children[static_cast<std::size_t>(scene.nodes[i].parent)].push_back(static_cast<int>(i));
        for (std::size_t i = 0; i < scene.nodes.size(); ++i)
            if (scene.nodes[i].parent < 0) drawNode(session, children, static_cast<int>(i));
        ImGui::TreePop();
    }
    if (session.selectedNode >= 0) drawObject(session);
    if (facts.duration > 0) {
        ImGui::Checkbox("play", &session.playing);
        ImGui::SameLine();
        const double zero = 0;
        ImGui::SetNextItemWidth(-1);
        ImGui::SliderScalar("##time", ImGuiDataType_Double, &session.time, &zero, &facts.duration, "%.3f s");
        const Shot& shot = facts.shots[static_cast<std::size_t>(session.shot)];
        if (!shot.path.empty() || shot.camera.node >= 0)
            ImGui::Checkbox("camera follows the shot", &session.followShot);
    }
}

// ---- View

void drawViewPanel(Session& session) {
    if (ImGui::BeginCombo("channel", session.channel.c_str())) {
        for (const std::string& name : channelNames())
            if (ImGui::Selectable(name.c_str(), name == session.channel)) session.channel = name;
        ImGui::EndCombo();
    }
    const Camera c = session.camera.camera();
    double fov = c.verticalFovDeg;
    const double low = 1, high = 170;
    if (ImGui::SliderScalar("field of view", ImGuiDataType_Double, &fov, &low, &high, "%.1f deg"))
        session.camera.fieldOfView(fov);
    dim(fmt::format("eye {:.4g} {:.4g} {:.4g}\ntarget {:.4g} {:.4g} {:.4g}", c.position.x, c.position.y, c.position.z,
                    c.target.x, c.target.y, c.target.z));
    ImGui::Checkbox("picture follows the window", &session.followWindow);
    tip("output.width and output.height are those of the place in the window");
    if (ImGui::Button("all of the scene")) session.frameScene();
    for (std::size_t i = 0; i < session.views.size(); ++i) {
        ImGui::PushID(static_cast<int>(i));
        if (ImGui::Button("go")) session.recallView(session.views[i]);
        ImGui::SameLine();
        const bool remove = ImGui::Button("x");
        ImGui::SameLine();
        const SavedView& v = session.views[i];
        text(v.path.empty() ? fmt::format("{}: {}", v.name, v.channel)
                            : fmt::format("{}: {}, {} frames", v.name, v.channel, v.frames()));
        ImGui::PopID();
        if (remove) {
            session.views.erase(session.views.begin() + static_cast<std::ptrdiff_t>(i));
            break;
        }
    }
}

// ---- Settings

/// A control for one field. Answers whether it changed.
bool control(const Field& field) {
    const char* id = "##value";
    if (auto* const* flag = std::get_if<bool*>(&field.value)) return ImGui::Checkbox(id, *flag);
    if (const auto* choice = std::get_if<Field::Choice>(&field.value)) {
        bool changed = false;
        const auto now = static_cast<std::size_t>(choice->get());
        if (ImGui::BeginCombo(id, choice->names[now].c_str())) {
            for (std::size_t i = 0; i < choice->names.size(); ++i) {
                if (!ImGui::Selectable(choice->names[i].c_str(), i == now) || i == now) continue;
                choice->set(static_cast<int>(i));
                changed = true;
            }
            ImGui::EndCombo();
        }
        return changed;
    }
    if (auto* const* number = std::get_if<double*>(&field.value)) {
        const double range = field.max - field.min;
        // Wide ranges are passed by ratios, not by steps.
        const auto flags =
            ImGuiSliderFlags_AlwaysClamp | (range > 1000 ? ImGuiSliderFlags_Logarithmic : ImGuiSliderFlags_None);
        const auto speed = static_cast<float>(range > 1000 ? 0.01 : range / 400);
        return ImGui::DragScalar(id, ImGuiDataType_Double, *number, speed, &field.min, &field.max, "%.4g", flags);
    }
    int* value = std::get<int*>(field.value);
    if (!field.allowed.empty()) {
        bool changed = false;
        if (ImGui::BeginCombo(id, fmt::format("{}", *value).c_str())) {
            for (const int allowed : field.allowed) {
                if (!ImGui::Selectable(fmt::format("{}", allowed).c_str(), allowed == *value) || allowed == *value)
                    continue;
                *value = allowed;
                changed = true;
            }
            ImGui::EndCombo();
        }
        return changed;
    }
    const int min = static_cast<int>(field.min), max = static_cast<int>(field.max);
    const auto speed = static_cast<float>(std::clamp((field.max - field.min) / 400, 0.05, 4.0));
    return ImGui::DragScalar(id, ImGuiDataType_S32, value, speed, &min, &max, "%d", ImGuiSliderFlags_AlwaysClamp);
}

std::string valueText(const Field& field) {
    if (auto* const* flag = std::get_if<bool*>(&field.value)) return **flag ? "true" : "false";
    if (const auto* choice = std::get_if<Field::Choice>(&field.value))
        return choice->names[static_cast<std::size_t>(choice->get())];
    if (auto* const* number = std::get_if<double*>(&field.value)) return fmt::format("{:.4g}", **number);
    return fmt::format("{}", *std::get<int*>(field.value));
}

std::string rangeText(const Field& field) {
    if (std::holds_alternative<bool*>(field.value) || std::holds_alternative<Field::Choice>(field.value)) return "";
    if (!field.allowed.empty()) return "";
    return fmt::format("\n{} to {} {}", field.min, field.max, field.unit);
}

void drawSettingsPanel(Session& session) {
    if (session.other) text(session.controlsOther ? "settings B (X)" : "settings A (X)");
    ImGui::BeginDisabled(!session.settings.canUndo());
    if (ImGui::Button("undo")) session.undo();
    ImGui::EndDisabled();
    if (session.settings.canUndo()) tip(session.settings.undoName() + "  (Ctrl+Z)");
    ImGui::SameLine();
    ImGui::BeginDisabled(!session.settings.canRedo());
    if (ImGui::Button("redo")) session.redo();
    ImGui::EndDisabled();
    if (session.settings.canRedo()) tip(session.settings.redoName() + "  (Ctrl+Y)");
    ImGui::SameLine();
    if (ImGui::Button("reset all")) session.settings.change(session.settings.base(), "reset all");
    tip("all settings as the file was opened with");
    std::string& name = session.presetName;
    ImGui::SetNextItemWidth(-1);
    if (ImGui::BeginCombo("##preset", "load preset")) {
        for (const std::string& preset : presetNames())
            if (ImGui::Selectable(preset.c_str())) session.applyPresetByName(preset);
        ImGui::EndCombo();
    }
    ImGui::InputTextWithHint("##name", "name, or file.json", &name);
    ImGui::SameLine();
    if (ImGui::Button("save") && !name.empty()) session.savePreset(name);
    ImGui::SameLine();
    if (ImGui::Button("load") && !name.empty()) session.applyPresetByName(name);
    ImGui::SetNextItemWidth(-1);
    ImGui::InputTextWithHint("##filter", "show those with ...", &session.settingsFilter);
    drawSettings(session);
}

// ---- Figures

void drawFiguresPanel(Session& session) {
    if (!session.picture || session.picture->surfaces) return dim("no picture yet");
    const Picture& p = *session.picture;
    const Settings::Output& output = p.view.settings.output;
    const int n = p.finished ? output.supersample * output.supersample : 1;
    text(fmt::format("{} x {}{}", output.width, output.height,
                     p.finished ? "" : fmt::format(", shown at 1/{}", p.divisor)));
    dim(fmt::format("{} sample{} a pixel; {} cones diffuse", n, n == 1 ? "" : "s", p.view.settings.cone.diffuse));
    dim(fmt::format("{:.1f} ms on the device (timer: {}), {:.1f} ms in all", p.stats.frameMilliseconds, p.stats.timer,
                    p.milliseconds));
    ImGui::Checkbox("count samples", &session.countSamples);
    tip("what the cones of a finished picture look at: voxels of near fields and steps beyond. Counting gathers it "
        "again");
    if (session.countSamples && session.samplesPerPixel && session.samplesSerial == p.serial) {
        ImGui::SameLine();
        text(fmt::format("{:.1f} a pixel", *session.samplesPerPixel));
    }
    const float width = ImGui::GetContentRegionAvail().x;
    const auto plot = [&](const char* id, const std::deque<float>& values, float height) {
        const std::vector<float> flat(values.begin(), values.end());
        ImGui::PlotLines(id, flat.data(), static_cast<int>(flat.size()), 0, nullptr, 0, FLT_MAX,
                         ImVec2(ImGui::GetContentRegionAvail().x, height));
    };
    plot("##frame", session.history.frame, 2.5f * ImGui::GetFontSize());
    tip("milliseconds of the last frames");
    if (ImGui::BeginTable("passes", 3, ImGuiTableFlags_SizingFixedFit)) {
        ImGui::TableSetupColumn("pass", ImGuiTableColumnFlags_WidthFixed, 0.5f * width);
        ImGui::TableSetupColumn("ms");
        ImGui::TableSetupColumn("history", ImGuiTableColumnFlags_WidthStretch);
        for (const auto& [name, values] : session.history.passes) {
            ImGui::TableNextRow();
            ImGui::TableNextColumn();
            text(name);
            ImGui::TableNextColumn();
            text(fmt::format("{:7.1f}", values.empty() ? 0.0f : values.back()));
            ImGui::TableNextColumn();
            plot(("##" + name).c_str(), values, 0);
        }
        ImGui::EndTable();
    }
    if (ImGui::TreeNodeEx("memory", ImGuiTreeNodeFlags_DefaultOpen)) {
        std::uint64_t sum = 0;
        for (const FrameStats::Memory& item : p.stats.memory) {
            text(fmt::format("{:>10}  {}", megabytes(item.bytes), item.name));
            sum += item.bytes;
        }
        text(fmt::format("{:>10}  in all", megabytes(sum)));
        ImGui::TreePop();
    }
    if (ImGui::TreeNodeEx("counts", ImGuiTreeNodeFlags_DefaultOpen)) {
        for (const auto& [name, count] : p.stats.counts) text(fmt::format("{:>10}  {}", count, name));
        ImGui::TreePop();
    }
    if (ImGui::TreeNodeEx("not modelled", ImGuiTreeNodeFlags_DefaultOpen)) {
        for (const LeftOut& item : p.leftOut) dim(fmt::format("{}: {}", item.what, item.why));
        for (const Renderer::Level& l : p.levels)
            if (!l.leftOut.empty()) dim(fmt::format("level {}: {}", l.level, l.leftOut));
        if (p.leftOut.empty()) dim("nothing is left out");
        ImGui::TreePop();
    }
    if (ImGui::TreeNode("scene and device")) {
        dim(session.facts->description);
        ImGui::TreePop();
    }
}

// ---- Clipmap

/// What a level's voxelization took in the last frames, in milliseconds: the last one that did any, and all.
void drawLevelCost(const std::deque<float>& milliseconds) {
    const std::vector<float> flat(milliseconds.begin(), milliseconds.end());
    const auto last = std::find_if(flat.rbegin(), flat.rend(), [](float ms) { return ms > 0; });
    const std::string label = last == flat.rend() ? "no update yet" : fmt::format("last update {:.1f} ms", *last);
    ImGui::PlotHistogram("##milliseconds", flat.data(), static_cast<int>(flat.size()), 0, label.c_str(), 0, FLT_MAX,
                         ImVec2(ImGui::GetContentRegionAvail().x, 1.6f * ImGui::GetFontSize()));
    tip("milliseconds that voxelizing this level took in each of the last frames");
}

void drawClipmapPanel(Session& session) {
    bool frozen = session.frozen();
    if (ImGui::Checkbox("frozen", &frozen)) session.freeze(frozen);
    tip("the clipmap stays where it is while the camera flies on (C)");
    ImGui::SameLine();
    if (ImGui::Button("step")) session.stepClipmap();
    tip("moves the frozen clipmap by one snap towards the camera (N)");
    ImGui::Checkbox("boxes of levels", &session.showLevels);
    ImGui::SameLine();
    ImGui::Checkbox("snap grid", &session.showSnapGrid);
    ImGui::Checkbox("flash what is voxelized", &session.showUpdates);
    const bool overlay = session.channel == "cascade";
    if (ImGui::Button(overlay ? "back to beauty" : "levels and blend weights"))
        session.channel = overlay ? "beauty" : "cascade";
    ImGui::SameLine();
    const bool seam = session.channel == "seam";
    if (ImGui::Button(seam ? "back to beauty##seam" : "seams")) session.channel = seam ? "beauty" : "seam";
    tip("the step in diffuse light where levels blend");
    if (!session.picture || session.picture->clipmap.layout.levels == 0) return dim("no voxels");
    const Picture& p = *session.picture;
    const ClipmapLayout& layout = p.clipmap.layout;
    for (const Renderer::Level& l : p.levels) {
        if (!l.leftOut.empty()) continue;
        const auto i = static_cast<std::size_t>(l.level);
        ImGui::PushID(l.level);
        ImGui::PushStyleColor(ImGuiCol_Text, levelColor(l.mip ? 7 : l.level));
        const std::string label = fmt::format("{} {}: {}^3 of {:.4g} m, {:.4g} m wide{}", l.mip ? "mip" : "level",
                                              l.level, l.resolution, l.voxelSize, l.size,
                                              l.mip     ? ""
                                              : l.moves ? ", moves"
                                                        : ", stays");
        if (!l.mip && i < session.levelShown.size()) {
            bool shown = session.levelShown[i] != 0;
            if (ImGui::Checkbox(label.c_str(), &shown)) session.levelShown[i] = shown ? 1 : 0;
        } else {
            text(label);
        }
        ImGui::PopStyleColor();
        const std::string count =
            l.mip ? fmt::format("mip_{}_voxels", l.level - layout.levels + 1) : fmt::format("level_{}_voxels", l.level);
        const auto records = p.stats.counts.find(count);
        const VoxelBox& window = p.clipmap.update.windows[i];
        dim(fmt::format("  {} surface voxels of {} ({:.2f} %), {}, from ({}, {}, {})",
                        records == p.stats.counts.end() ? 0 : records->second, window.volume(),
                        100.0 * static_cast<double>(records == p.stats.counts.end() ? 0 : records->second) /
                            static_cast<double>(std::max(1LL, window.volume())),
                        megabytes(l.volumeBytes), window.low.x, window.low.y, window.low.z));
        if (!l.mip && i < session.history.voxels.size()) {
            const auto& values = session.history.voxels[i];
            const std::vector<float> flat(values.begin(), values.end());
            ImGui::PlotHistogram("##updates", flat.data(), static_cast<int>(flat.size()), 0, nullptr, 0, FLT_MAX,
                                 ImVec2(ImGui::GetContentRegionAvail().x, 1.6f * ImGui::GetFontSize()));
            tip("voxels of this level that each of the last frames voxelized");
            drawLevelCost(session.history.levels[i]);
        }
        ImGui::PopID();
    }
    const FrameStats& last = session.history.lastUpdate;
    if (last.counts.empty()) return;
    std::string line = fmt::format("last update: {} triangles drawn, {} records made, {} levels wait",
                                   last.counts.at("voxel_triangles_drawn"), last.counts.at("voxel_records_made"),
                                   last.counts.at("levels_waiting"));
    for (const FrameStats::Pass& pass : p.updatePasses)
        line += fmt::format("; {} {:.1f} ms", pass.name, pass.milliseconds);
    dim(line);
}

// ---- Voxels

std::string faceText(const VoxelFace& face) {
    return fmt::format(
        "albedo {:.2f} {:.2f} {:.2f}, normal {:.2f} {:.2f} {:.2f}, radiance {:.3g} {:.3g} {:.3g}, "
        "coverage {:.2f}",
        face.albedo.x, face.albedo.y, face.albedo.z, face.normal.x, face.normal.y, face.normal.z, face.radiance.x,
        face.radiance.y, face.radiance.z, face.coverage);
}

/// What the slice shows of a voxel in the view that is looked at: of one face, or the mean of all.
ImVec4 sliceColor(const VoxelFacts& voxel, const VoxelChannel& channel, float exposure) {
    glm::vec3 sum(0);
    float weight = 0;
    for (int f = 0; f < 6; ++f) {
        if (channel.face >= 0 && channel.face != f) continue;
        const VoxelFace& face = voxel.faces[static_cast<std::size_t>(f)];
        const glm::vec3 value = channel.base == "voxel_albedo"   ? face.albedo
                                : channel.base == "voxel_normal" ? 0.5f * face.normal + 0.5f
                                : channel.showsLight()           ? exposure * face.radiance
                                                                 : glm::vec3(face.coverage);
        sum += face.coverage * value;
        weight += face.coverage;
    }
    const glm::vec3 mean = weight > 0 ? sum / weight : glm::vec3(0);
    const bool encoded = channel.base == "voxel_normal" || channel.base == "voxel_opacity";
    const auto shown = [&](float v) { return encoded ? v : srgbFromLinear(std::clamp(v, 0.0f, 1.0f)); };
    return {shown(mean.x), shown(mean.y), shown(mean.z), 1};
}

void drawOccupancy(const Occupancy& occupancy, const std::string& of) {
    const std::vector<float> bins(occupancy.histogram.begin(), occupancy.histogram.end());
    ImGui::PlotHistogram(("##occupancy of " + of).c_str(), bins.data(), static_cast<int>(bins.size()), 0,
                         "opacity, 0 to 1", 0, FLT_MAX,
                         ImVec2(ImGui::GetContentRegionAvail().x, 3 * ImGui::GetFontSize()));
    dim(fmt::format("{} of {} voxels of {} are occupied; histogram of their fullest faces' coverage",
                    occupancy.occupied, occupancy.voxels, of));
}

void drawSlice(Session& session) {
    const ClipmapState& clipmap = session.picture->clipmap;
    const int level = std::clamp(session.level, 0, clipmap.layout.count() - 1);
    const int last = clipmap.layout.resolutionOf(level) - 1;
    bool ask = session.slice == nullptr || session.slice->level != level || session.sliceStale();
    constexpr std::array kAxes = {"across x", "across y", "across z"};
    for (int axis = 0; axis < 3; ++axis) {
        if (axis > 0) ImGui::SameLine();
        ask |= ImGui::RadioButton(kAxes[static_cast<std::size_t>(axis)], &session.sliceAxis, axis);
    }
    if (!session.slice && !session.slicePending()) session.sliceDepth = last / 2;
    session.sliceDepth = std::clamp(session.sliceDepth, 0, last);
    ask |= ImGui::SliderInt("depth", &session.sliceDepth, 0, last);
    if (ask && !session.slicePending()) session.askSlice();
    if (!session.slice || session.slice->width == 0) return;
    const VoxelSlice& slice = *session.slice;
    const float edge = std::max(1.0f, std::floor(ImGui::GetContentRegionAvail().x / static_cast<float>(slice.width)));
    const ImVec2 corner = ImGui::GetCursorScreenPos();
    const ImVec2 size(edge * static_cast<float>(slice.width), edge * static_cast<float>(slice.height));
    ImGui::InvisibleButton("slice", size);
    ImDrawList& list = *ImGui::GetWindowDrawList();
    list.AddRectFilled(corner, ImVec2(corner.x + size.x, corner.y + size.y), 0xff181818);
    const auto exposure = static_cast<float>(std::exp2(session.settings.now().output.exposure));
    const VoxelChannel channel = session.voxelChannel();
    for (int v = 0; v < slice.height; ++v) {
        for (int u = 0; u < slice.width; ++u) {
            const VoxelFacts& voxel = slice.at(u, v);
            if (!voxel.occupied) continue;
            // v grows upwards.
            const ImVec2 low(corner.x + edge * static_cast<float>(u),
                             corner.y + edge * static_cast<float>(slice.height - 1 - v));
            list.AddRectFilled(low, ImVec2(low.x + edge, low.y + edge),
                               ImGui::ColorConvertFloat4ToU32(sliceColor(voxel, channel, exposure)));
        }
    }
    if (ImGui::IsItemHovered()) {
        const ImVec2 mouse = ImGui::GetIO().MousePos;
        const int u = std::clamp(static_cast<int>((mouse.x - corner.x) / edge), 0, slice.width - 1);
        const int v = std::clamp(slice.height - 1 - static_cast<int>((mouse.y - corner.y) / edge), 0, slice.height - 1);
        const glm::ivec3 index = slice.index(u, v);
        const glm::dvec3 centre = slice.origin + slice.voxelSize * (glm::dvec3(index) + 0.5);
        ImGui::BeginTooltip();
        text(fmt::format("voxel ({}, {}, {}) of level {} at {:.4g} {:.4g} {:.4g} m", index.x, index.y, index.z,
                         slice.level, centre.x, centre.y, centre.z));
        constexpr std::array kFaces = {"+x", "-x", "+y", "-y", "+z", "-z"};
        const VoxelFacts& voxel = slice.at(u, v);
        if (!voxel.occupied) text("empty");
        for (std::size_t f = 0; f < 6; ++f)
            if (voxel.faces[f].coverage > 0) text(fmt::format("{}: {}", kFaces[f], faceText(voxel.faces[f])));
        ImGui::EndTooltip();
    }
    Occupancy here;
    here.add(slice);
    drawOccupancy(here, "the slice");
}

/// Of all voxels of the level that is shown, on demand.
void drawLevelOccupancy(Session& session) {
    const int level = std::clamp(session.level, 0, std::max(session.picture->clipmap.layout.count() - 1, 0));
    if (ImGui::Button("occupancy of the level")) session.askOccupancy(level);
    tip("reads all slices of the level: its voxels by the coverage of their fullest face");
    if (session.occupancy) drawOccupancy(*session.occupancy, fmt::format("level {}", session.occupancyLevel));
}

void drawVoxelPanel(Session& session) {
    if (ImGui::RadioButton("off", !session.channel.starts_with("voxel_"))) session.channel = "beauty";
    for (std::size_t i = 0; i < VoxelChannel::kNames.size(); ++i) {
        const char* name = VoxelChannel::kNames[i];
        if (i != 2) ImGui::SameLine();  // two rows
        if (ImGui::RadioButton(name + 6, session.channel == name)) session.channel = name;
    }
    const VoxelChannel channel = session.voxelChannel();
    if (channel.hasFaces())
        ImGui::SliderInt("face", &session.voxelFace, -1, 5,
                         session.voxelFace < 0
                             ? "that to the eye"
                             : VoxelChannel::kFaces[static_cast<std::size_t>(std::min(session.voxelFace, 5))]);
    session.voxelFace = std::clamp(session.voxelFace, -1, 5);
    if (channel.showsLight()) {
        ImGui::SliderInt("bounce", &session.voxelBounce, -1, std::max(8, session.settings.now().light.bounces + 1),
                         session.voxelBounce < 0    ? "all light"
                         : session.voxelBounce == 0 ? "direct and emitted"
                                                    : "%d alone");
        session.voxelBounce = std::clamp(session.voxelBounce, -1, VoxelChannel::kMostBounces);
        tip("what each bounce between voxels brings, also beyond light.bounces; gathered when it is first shown");
    }
    const int count = session.picture ? std::max(session.picture->clipmap.layout.count(), 1) : 1;
    ImGui::SliderInt("level", &session.level, -1, count - 1,
                     session.level < 0                                                            ? "as cones read"
                     : session.picture && session.level >= session.picture->clipmap.layout.levels ? "%d (mip)"
                                                                                                  : "%d");
    session.level = std::min(session.level, count - 1);
    ImGui::Checkbox("edges", &session.voxels.edges);
    ImGui::SameLine();
    auto share = static_cast<float>(session.triangles);
    if (ImGui::SliderFloat("triangles", &share, 0, 1, "%.2f")) session.triangles = static_cast<double>(share);
    tip("share of the picture of the triangles that is mixed in");
    constexpr std::array kAxes = {"no cut", "cut x", "cut y", "cut z"};
    for (int axis = -1; axis < 3; ++axis) {
        if (axis >= 0) ImGui::SameLine();
        ImGui::RadioButton(kAxes[static_cast<std::size_t>(axis + 1)], &session.cutAxis, axis);
    }
    if (session.cutAxis >= 0) {
        const double zero = 0, one = 1;
        ImGui::SliderScalar("place", ImGuiDataType_Double, &session.cutPlace, &zero, &one, "%.3f");
        ImGui::SameLine();
        ImGui::Checkbox("flip", &session.cutFlipped);
    }
    if (!session.picture || session.picture->clipmap.layout.levels == 0) return;
    drawLevelOccupancy(session);
    ImGui::Checkbox("slice", &session.sliceShown);
    if (session.sliceShown) drawSlice(session);
}

// ---- Inspector

/// Transmittance, radiance and level along a cone.
void plotCone(const InspectedCone& cone) {
    const ImVec2 corner = ImGui::GetCursorScreenPos();
    const ImVec2 size(ImGui::GetContentRegionAvail().x, 8 * ImGui::GetFontSize());
    ImGui::InvisibleButton("plot", size);
    ImDrawList& list = *ImGui::GetWindowDrawList();
    list.AddRectFilled(corner, ImVec2(corner.x + size.x, corner.y + size.y), 0xff181818);
    if (cone.samples.empty()) return;
    const double longest = std::max(cone.samples.back().distance, 1e-9);
    double brightest = 1e-12, coarsest = 1;
    const auto mean = [](const glm::vec3& c) { return static_cast<double>(c.x + c.y + c.z) / 3; };
    for (const ConeSample& s : cone.samples) {
        brightest = std::max(brightest, mean(s.radiance));
        coarsest = std::max(coarsest, s.level);
    }
    const auto at = [&](double distance, double height) {
        return ImVec2(corner.x + static_cast<float>(distance / longest) * size.x,
                      corner.y + static_cast<float>(1 - std::clamp(height, 0.0, 1.0)) * (size.y - 4) + 2);
    };
    ImVec2 clear = at(0, 1), bright = at(0, 0);
    for (const ConeSample& s : cone.samples) {
        const float x = at(s.distance, 0).x;
        list.AddLine(ImVec2(x, corner.y + size.y), ImVec2(x, at(0, 0.9 * s.level / coarsest + 0.02).y),
                     levelColor(static_cast<int>(std::lround(s.level)), 0.7f), s.length > 0 ? 2.0f : 1.0f);
        const ImVec2 t = at(s.distance, s.transmittance), r = at(s.distance, mean(s.radiance) / brightest);
        list.AddLine(clear, t, 0xffffffff, 1.5f);
        list.AddLine(bright, r, 0xff40d0ff, 1.5f);
        clear = t, bright = r;
    }
    if (ImGui::IsItemHovered()) {
        const double distance = static_cast<double>((ImGui::GetIO().MousePos.x - corner.x) / size.x) * longest;
        const auto nearest =
            std::min_element(cone.samples.begin(), cone.samples.end(), [&](const ConeSample& a, const ConeSample& b) {
                return std::abs(a.distance - distance) < std::abs(b.distance - distance);
            });
        tip(fmt::format("{:.4g} m: level {:.2f}, {}, transmittance {:.4f}, radiance so far {:.4g} {:.4g} {:.4g}",
                        nearest->distance, nearest->level,
                        nearest->length > 0 ? fmt::format("segment of {:.4g} m", nearest->length) : "a plane",
                        nearest->transmittance, nearest->radiance.x, nearest->radiance.y, nearest->radiance.z));
    }
    dim(
        fmt::format("{} samples over {:.4g} m; white: transmittance, yellow: radiance up to {:.3g}, bars: level up to "
                    "{:.1f}",
                    cone.samples.size(), longest, brightest, coarsest));
}

void drawInspectorPanel(Session& session) {
    ImGui::Checkbox("a click asks about a pixel", &session.inspecting);
    tip("or I with the cursor over the picture");
    if (!session.inspection) return dim("no pixel was asked about");
    Inspection& asked = *session.inspection;
    text(fmt::format("pixel ({}, {})", asked.pixel.x, asked.pixel.y));
    ImGui::SameLine();
    if (ImGui::SmallButton("copy as JSON")) ImGui::SetClipboardText(asked.json().c_str());
    ImGui::SameLine();
    if (ImGui::SmallButton("forget")) {
        session.forgetInspection();
        return;
    }
    dim("by voxels, W/(m2 sr), and below path traced");
    if (ImGui::BeginTable("terms", 2, ImGuiTableFlags_SizingFixedFit | ImGuiTableFlags_RowBg)) {
        for (const auto& [name, value] : asked.terms) {
            ImGui::TableNextRow();
            ImGui::TableNextColumn();
            text(name);
            ImGui::TableNextColumn();
            text(fmt::format("{:.4g}  {:.4g}  {:.4g}", value.x, value.y, value.z));
            const auto traced = asked.traced(name);
            ImGui::PushStyleColor(ImGuiCol_Text, kDim);
            text(traced ? fmt::format("{:.4g}  {:.4g}  {:.4g}", traced->x, traced->y, traced->z) : "...");
            ImGui::PopStyleColor();
        }
        ImGui::EndTable();
    }
    if (const auto traced = asked.tracer ? asked.tracer->picture() : nullptr)
        dim(fmt::format("{} paths, error {:.2g} %{}", traced->samples, 100 * traced->error,
                        asked.tracer->running() ? "" : ", done"));
    if (asked.lobes.empty()) return dim("the pixel shows no surface");
    for (std::size_t i = 0; i < asked.lobes.size(); ++i) {
        if (i > 0) ImGui::SameLine();
        ImGui::RadioButton(nameOf(asked.lobes[i].lobe), &asked.lobe, static_cast<int>(i));
    }
    const PixelCones& lobe = *asked.shown();
    const glm::vec3 sum = lobe.radiance(), out = lobe.outgoing();
    dim(fmt::format(
        "its {} cones gather {:.4f} {:.4f} {:.4f}; times {:.4f} {:.4f} {:.4f}, which the surface sends to "
        "the eye, {:.4f} {:.4f} {:.4f} in {}{}",
        nameOf(lobe.lobe), sum.x, sum.y, sum.z, lobe.share.x, lobe.share.y, lobe.share.z, out.x, out.y, out.z,
        channelOf(lobe.lobe),
        lobe.lobe == ConeLobe::diffuse || lobe.lobe == ConeLobe::specular ? ", before neighbours are averaged" : ""));
    const int last = static_cast<int>(lobe.cones.size()) - 1;
    asked.selected = std::clamp(asked.selected, 0, last);
    ImGui::SliderInt("cone", &asked.selected, 0, last);
    ImGui::SameLine();
    ImGui::Checkbox("alone", &asked.onlySelected);
    const InspectedCone& cone = lobe.cones[static_cast<std::size_t>(asked.selected)];
    const glm::vec3 total = cone.total();
    dim(fmt::format(
        "weight {:.4f}, half-angle {:.1f} deg; voxels {:.4f} {:.4f} {:.4f} + {:.4f} x sky {:.4f} {:.4f} {:.4f} = "
        "{:.4f} {:.4f} {:.4f}",
        cone.weight, glm::degrees(std::atan(cone.tanHalfAngle)), cone.radiance.x, cone.radiance.y, cone.radiance.z,
        cone.transmittance, cone.sky.x, cone.sky.y, cone.sky.z, total.x, total.y, total.z));
    plotCone(cone);
}

// ---- Comparison

void drawErrors(const char* what, const Measurement& measurement) {
    const Errors* errors = measurement.errors();
    if (!errors) return;
    text(what);
    if (!errors->whyNot.empty()) return dim(errors->whyNot);
    const auto& [linear, display] = std::tie(errors->linear, errors->display);
    text(fmt::format("relMSE {:.4g}, RMSE {:.4g}, bias {:+.2f} %", linear.relMse, linear.rmse,
                     100 * linear.relativeBias));
    text(fmt::format("FLIP {:.4f}, SSIM {:.4f}, PSNR {:.1f} dB", display.flip, display.ssim, display.psnr));
}

void drawOtherSettings(Session& session) {
    if (!session.other) {
        if (ImGui::Button("compare settings")) {
            session.compareWith(session.otherPreset);
            session.otherPreset.clear();
        }
        tip("renders a second tree of settings, B, beside the present one, A: a copy of it, or a preset");
        ImGui::SameLine();
        ImGui::InputTextWithHint("##preset", "preset, or file.json", &session.otherPreset);
        return;
    }
    text("left: settings A, right: settings B");
    int controls = session.controlsOther ? 1 : 0;
    bool exchange = ImGui::RadioButton("controls change A", &controls, 0);
    ImGui::SameLine();
    exchange |= ImGui::RadioButton("B (X)", &controls, 1);
    if (exchange && (controls == 1) != session.controlsOther) session.exchangeControls();
    Settings a = session.settingsA(), b = session.settingsB();
    const std::vector<Field> left = fields(a), right = fields(b);
    for (std::size_t i = 0; i < left.size(); ++i)
        if (fieldDiffers(a, b, i))
            dim(fmt::format("{}: {} | {}", left[i].key, valueText(left[i]), valueText(right[i])));
    if (const auto& picture = session.other->picture(); picture && !picture->surfaces) {
        std::uint64_t bytes = 0;
        for (const FrameStats::Memory& item : picture->stats.memory) bytes += item.bytes;
        dim(fmt::format("B: {:.1f} ms on the device, {} there", picture->stats.frameMilliseconds, megabytes(bytes)));
    }
    if (const std::string activity = session.other->thread().activity(); !activity.empty()) dim("B: " + activity);
    if (ImGui::Button("end")) return session.endOther();
    ImGui::SameLine();
    if (ImGui::Button("end, B becomes A")) return session.endOther(true);
}

void drawFlickerControls(Session& session) {
    constexpr std::array kNames = {"off", "indirect light", "beauty", "seam"};
    int watched = static_cast<int>(session.flicker.watched);
    if (ImGui::Combo("change", &watched, kNames.data(), static_cast<int>(kNames.size())))
        session.watch(static_cast<Watched>(watched));
    tip("from each picture to the next, on the surfaces that both show, over the mean of the picture; seam: between "
        "levels, over the mean of both (J)");
    if (session.flicker.watched == Watched::none) return;
    const double low = 1, high = 1000;
    ImGui::SliderScalar("exaggeration", ImGuiDataType_Double, &session.flicker.exaggeration, &low, &high, "x %.3g",
                        ImGuiSliderFlags_Logarithmic);
    ImGui::Checkbox("hold the largest", &session.flicker.hold);
    ImGui::SameLine();
    if (ImGui::Button("clear")) session.clearChanges();
    const auto& latest = session.flicker.latest();
    if (!latest || !latest->known) return dim("the next picture is compared with this one");
    if (latest->figures.valid > 0 && latest->figures.mean > 0)
        dim(fmt::format("this picture: rms {:.3g} %, mean {:+.3g} %, {:.0f} % of the pixels compared",
                        100 * latest->figures.rms / latest->figures.mean,
                        100 * latest->figures.meanChange / latest->figures.mean, 100 * latest->figures.valid));
    if (session.flicker.leftOut() > 0) dim(fmt::format("{} pictures came too fast", session.flicker.leftOut()));
}

void drawComparePanel(Session& session) {
    if (ImGui::Button("hold this picture")) session.hold();
    ImGui::SameLine();
    if (ImGui::Button("path trace this view")) session.holdReference();
    ImGui::InputTextWithHint("##file", "picture.exr", &session.heldName);
    ImGui::SameLine();
    if (ImGui::Button("hold file") && !session.heldName.empty()) session.holdFile(session.heldName);
    if (session.held) {
        text((session.other ? "held: " : "left: ") + session.held->name);
        ImGui::SameLine();
        if (ImGui::SmallButton("release")) session.releaseHeld();
    } else {
        dim(session.referenceTracer ? "tracing ..." : "nothing is held");
    }
    drawOtherSettings(session);
    if (session.held || session.other) {
        auto split = static_cast<float>(session.split);
        if (ImGui::SliderFloat("split", &split, 0, 1, "%.2f")) session.split = static_cast<double>(split);
        int map = static_cast<int>(session.errorMap);
        if (ImGui::Combo("map", &map, kErrorMapNames.data(), static_cast<int>(kErrorMapNames.size())))
            session.errorMap = static_cast<ErrorMap>(map);
        tip("the error of every pixel over finished pictures: against what is held, or of B against A");
        if (session.errorMap != ErrorMap::none) {
            const double least = 1e-3, most = 10, none = 0, all = 1;
            ImGui::SliderScalar("scale", ImGuiDataType_Double, &session.errorScale, &least, &most, "%.3g",
                                ImGuiSliderFlags_Logarithmic);
            ImGui::SliderScalar("opacity", ImGuiDataType_Double, &session.errorOpacity, &none, &all, "%.2f");
        }
        if (session.held) drawErrors(session.other ? "A to what is held" : "to what is held", session.presentToHeld);
        if (session.held && session.other) drawErrors("B to what is held", session.otherToHeld);
        if (session.other) drawErrors("B to A", session.otherToPresent);
        dim("of finished pictures; FLIP, SSIM and PSNR of what a display shows");
    }
    drawFlickerControls(session);
}

// ---- Recording

void drawRecordPanel(Session& session) {
    if (ImGui::Button("save view")) session.saveView();
    tip("Ctrl+1");
    ImGui::SameLine();
    if (session.recording ? ImGui::Button("stop") : ImGui::Button("record path")) {
        if (session.recording) {
            session.stopRecording();
        } else {
            session.startRecording();
        }
    }
    tip("the camera's way from now on (R)");
    ImGui::SameLine();
    if (ImGui::Button("write script")) session.writeScript();
    tip("all saved views and paths as a capture script; without any, the present view (Ctrl+S)");
    if (ImGui::Button("screenshot")) session.screenshot();
    tip("the finished picture as PNG and EXR (P)");
    dim(fmt::format("{} saved; files go to {}", session.views.size(), session.folders.output.string()));
}

// ---- Messages

void drawMessagePanel(Session& session) {
    for (auto m = session.messages.rbegin(); m != session.messages.rend(); ++m) {
        ImGui::PushTextWrapPos(0);
        if (m->error) ImGui::PushStyleColor(ImGuiCol_Text, kError);
        text(m->text);
        if (m->error) ImGui::PopStyleColor();
        ImGui::PopTextWrapPos();
    }
}

}  // namespace

std::uint32_t levelColor(int level, float alpha) {
    // shaders/frame/cascade_view.comp, lightened so that lines are seen on dark ground.
    constexpr std::array<std::array<float, 3>, 8> kColors = {{{0.95f, 0.25f, 0.25f},
                                                              {0.95f, 0.6f, 0.15f},
                                                              {0.3f, 0.8f, 0.3f},
                                                              {0.2f, 0.8f, 0.8f},
                                                              {0.35f, 0.45f, 1.0f},
                                                              {0.65f, 0.35f, 0.95f},
                                                              {0.95f, 0.3f, 0.8f},
                                                              {0.9f, 0.9f, 0.9f}}};
    const auto& c = kColors[static_cast<std::size_t>(std::clamp(level, 0, 7))];
    return ImGui::ColorConvertFloat4ToU32(ImVec4(c[0], c[1], c[2], alpha));
}

std::set<std::string> drawSettings(Session& session) {
    std::set<std::string> drawn;
    Settings edited = session.settings.now();
    const std::vector<Field> all = fields(edited);
    const std::string& filter = session.settingsFilter;
    std::string group;
    bool open = false;
    for (std::size_t i = 0; i < all.size(); ++i) {
        const Field& field = all[i];
        const std::string head = field.key.substr(0, field.key.find('.'));
        if (head != group) {
            if (open) ImGui::TreePop();
            group = head;
            const auto matches = [&](const Field& f) {
                return f.key.starts_with(head + ".") && f.key.find(filter) != std::string::npos;
            };
            open = false;
            if (!filter.empty() && std::none_of(all.begin(), all.end(), matches)) continue;
            if (!filter.empty()) ImGui::SetNextItemOpen(true);
            open = ImGui::TreeNodeEx(group.c_str());
        }
        if (!open || field.key.find(filter) == std::string::npos) continue;
        drawn.insert(field.key);
        const bool changed = fieldDiffers(session.settings.now(), session.settings.base(), i);
        ImGui::PushID(field.key.c_str());
        if (changed) ImGui::PushStyleColor(ImGuiCol_Text, kChanged);
        text((changed ? "* " : "  ") + field.key.substr(group.size() + 1));
        if (changed) ImGui::PopStyleColor();
        tip(field.meaning + rangeText(field));
        ImGui::SameLine(12 * ImGui::GetFontSize());
        ImGui::SetNextItemWidth(-3 * ImGui::GetFontSize());
        const bool given = control(field);
        tip(field.meaning + rangeText(field));
        const bool held = ImGui::IsItemActive();
        if (given) session.settings.change(edited, field.key, held);
        if (ImGui::IsItemDeactivated()) session.settings.release();
        ImGui::SameLine();
        ImGui::BeginDisabled(!changed);
        if (ImGui::SmallButton("reset")) {
            Settings back = session.settings.now();
            copyField(session.settings.base(), back, i);
            session.settings.change(back, "reset " + field.key);
        }
        ImGui::EndDisabled();
        ImGui::PopID();
    }
    if (open) ImGui::TreePop();
    return drawn;
}

std::vector<Panel> makePanels() {
    return {{"Scene", GLFW_KEY_F2, drawScenePanel, true},   {"View", GLFW_KEY_F3, drawViewPanel, true},
            {"Settings", GLFW_KEY_F4, drawSettingsPanel},   {"Figures", GLFW_KEY_F6, drawFiguresPanel},
            {"Clipmap", GLFW_KEY_F7, drawClipmapPanel},     {"Voxels", GLFW_KEY_F8, drawVoxelPanel},
            {"Recording", GLFW_KEY_F9, drawRecordPanel},    {"Inspector", GLFW_KEY_F10, drawInspectorPanel},
            {"Comparison", GLFW_KEY_F11, drawComparePanel}, {"Messages", GLFW_KEY_F12, drawMessagePanel}};
}

void drawHelp(bool& open) {
    constexpr auto kKeys = std::to_array<std::array<const char*, 2>>({
        {"left drag", "turn around the target"},
        {"right drag", "look about"},
        {"middle drag, Shift + left drag", "move sidewise"},
        {"wheel", "towards the target and away; while flying: speed"},
        {"W A S D, Q E", "fly; with Shift faster, with Ctrl slower"},
        {"double click, F", "look at the surface under the cursor"},
        {"Home", "all of the scene"},
        {"1 to 9", "saved view"},
        {"Ctrl + 1 to 9", "save the view"},
        {"Space", "play and pause"},
        {"B", "back to beauty"},
        {"[ and ]", "channel before and after"},
        {"C", "freeze the clipmap"},
        {"N", "step the frozen clipmap by one snap"},
        {"L", "boxes of levels"},
        {"G", "handles of lights: drag one, or one of its axes"},
        {"Alt + click", "select an object: drag its handles; Escape lets go"},
        {"T", "handles move, turn or scale"},
        {"P", "screenshot"},
        {"R", "record the camera's path"},
        {"Ctrl + S", "write a capture script"},
        {"Ctrl + O", "open by name"},
        {"Ctrl + Z, Ctrl + Y", "undo and redo a setting or what was moved"},
        {"V", "vertical synchronisation"},
        {"M", "picture follows the window"},
        {"F5", "compile all shaders anew"},
        {"I", "ask about the pixel under the cursor"},
        {"H", "hold the picture to compare"},
        {"X", "controls change settings A or B"},
        {"J", "change from picture to picture"},
        {"F2 to F12 but F5", "panels"},
        {"Tab", "side bar"},
        {"F1", "this help"},
        {"drop a file", "glTF, capture script, panorama"},
        {"Ctrl + Q", "end"},
    });
    ImGui::SetNextWindowPos(ImVec2(0.5f * ImGui::GetIO().DisplaySize.x, 0.5f * ImGui::GetIO().DisplaySize.y),
                            ImGuiCond_Appearing, ImVec2(0.5f, 0.5f));
    if (ImGui::Begin("Keys and mouse", &open, ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoSavedSettings)) {
        if (ImGui::BeginTable("keys", 2, ImGuiTableFlags_SizingFixedFit | ImGuiTableFlags_RowBg)) {
            for (const auto& row : kKeys) {
                ImGui::TableNextRow();
                ImGui::TableNextColumn();
                ImGui::TextUnformatted(row[0]);
                ImGui::TableNextColumn();
                ImGui::TextUnformatted(row[1]);
            }
            ImGui::EndTable();
        }
    }
    ImGui::End();
}

}  // namespace voxcone
