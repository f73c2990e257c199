// voxcone info: the device, its limits, what a scene holds and what of it is modelled.
#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "app/commands.h"
#include "capture/capture.h"
#include "capture/output.h"
#include "frame/renderer.h"
#include "gl/context.h"

namespace voxcone {

using nlohmann::json;

namespace {

/// Key and value a line; objects are indented.
void print(const json& tree, int indent) {
    for (const auto& [key, value] : tree.items()) {
        if (value.is_object()) {
            fmt::print("{:{}}{}{}\n", "", indent, key, value.empty() ? "  none" : "");
            print(value, indent + 2);
        } else {
            fmt::print("{:{}}{:<{}} {}\n", "", indent, key, 26 - indent,
                       value.is_string() ? value.get<std::string>() : value.dump());
        }
    }
}

/// What an extracted light gives and how large it is.
json describeExtracted(const Light& light) {
    const auto three = [](const auto& v) { return json{v.x, v.y, v.z}; };
    json out{{"name", light.name}, {"direction", three(light.direction)}};
    if (light.type == LightType::directional) {
        out["irradiance"] = three(light.intensity);
        out["angular_radius_deg"] = glm::degrees(light.angularRadius);
    } else {
        out["position"] = three(light.position);
        out["radiance"] = three(light.intensity);
        out["size_m"] = json{light.width, light.height};
    }
    return out;
}

std::string extractedText(const json& light) {
    const auto three = [&](const char* key) {
        return fmt::format("({:.4g}, {:.4g}, {:.4g})", light[key][0].get<double>(), light[key][1].get<double>(),
                           light[key][2].get<double>());
    };
    if (light.contains("irradiance"))
        return fmt::format("{}: along {}, {} W/m², angular radius {:.3g}°", light["name"].get<std::string>(),
                           three("direction"), three("irradiance"), light["angular_radius_deg"].get<double>());
    return fmt::format("{}: {:.4g} m × {:.4g} m at {} along {}, {} W/(m² sr)", light["name"].get<std::string>(),
                       light["size_m"][0].get<double>(), light["size_m"][1].get<double>(), three("position"),
                       three("direction"), three("radiance"));
}

}  // namespace

Command infoCommand(CLI::App& app) {
    struct Options : ScriptOptions {
        bool json = false;
    };
    const auto options = std::make_shared<Options>();
    CLI::App* parser =
        app.add_subcommand("info", "Device and limits; with a scene its facts and what of it is modelled");
    options->addTo(*parser, false);
    parser->add_flag("--json", options->json, "print JSON");
    return {parser, "voxcone info [SCRIPT.json|SCENE.gltf] [--json] [--set KEY=VALUE]…", [options] {
                json out;
                std::optional<CaptureScript> script;
                if (!options->file.empty()) script = options->load();
                const auto context = gl::Context::createHeadless(false);
                out["device"] = describeDevice(context->info());
                if (script) {
                    out["scene"] = describeScene(script->scene);
                    out["extracted_lights"] = json::array();
                    for (const Light& light : script->scene.lightsAt())
                        if (light.extracted) out["extracted_lights"].push_back(describeExtracted(light));
                    const Renderer renderer(*context, script->scene, script->settings);
                    out["levels"] = json::array();
                    std::uint64_t bytes = 0;
                    for (const Renderer::Level& l : renderer.levels()) {
                        out["levels"].push_back({{"level", l.level},
                                                 {"kind", l.mip     ? "mip"
                                                          : l.moves ? "follows the camera"
                                                                    : "stays"},
                                                 {"resolution", l.resolution},
                                                 {"voxel_size_m", l.voxelSize},
                                                 {"size_m", l.size},
                                                 {"volume_bytes", l.volumeBytes},
                                                 {"left_out", l.leftOut}});
                        bytes += l.volumeBytes;
                    }
                    out["volume_bytes"] = bytes;
                    out["left_out"] = json::array();
                    for (const LeftOut& item : renderer.leftOut())
                        out["left_out"].push_back({{"what", item.what}, {"why", item.why}});
                }
                if (options->json) {
                    fmt::print("{}\n", out.dump(2));
                    return 0;
                }
                const json extracted = out.value("extracted_lights", json::array());
                out.erase("extracted_lights");
                const json levels = out.value("levels", json::array());
                out.erase("levels");
                const json leftOut = out.value("left_out", json::array());
                out.erase("left_out");
                print(out, 0);
                if (script) fmt::print("extracted_lights{}\n", extracted.empty() ? "  none" : "");
                for (const json& light : extracted) fmt::print("  {}\n", extractedText(light));
                if (script) fmt::print("levels{}\n", levels.empty() ? "  none" : "");
                for (const json& l : levels) {
                    const auto why = l["left_out"].get<std::string>();
                    fmt::print("  {}  {}³ voxels of {:.4g} m, {:.4g} m wide: {}\n",
                               why.empty() ? fmt::format("{}", l["level"].get<int>()) : std::string("-"),
                               l["resolution"].get<int>(), l["voxel_size_m"].get<double>(), l["size_m"].get<double>(),
                               why.empty()
                                   ? fmt::format("{}, volumes {:.1f} MB", l["kind"].get<std::string>(),
                                                 static_cast<double>(l["volume_bytes"].get<std::uint64_t>()) / 1e6)
                                   : "not allocated, " + why);
                }
                if (script) fmt::print("left_out{}\n", leftOut.empty() ? "  nothing" : "");
                for (const json& item : leftOut)
                    fmt::print("  {}: {}\n", item["what"].get<std::string>(), item["why"].get<std::string>());
                return 0;
            }};
}

}  // namespace voxcone
