#include "viewer/viewer.h"

#include <epoxy/gl.h>
// GLFW after the loader of OpenGL's functions.
#include <GLFW/glfw3.h>
#include <backends/imgui_impl_opengl3.h>
#include <fmt/format.h>
#include <imgui.h>
#include <imgui_stdlib.h>

#include <algorithm>
#include <cmath>

#include "gl/framebuffer.h"

namespace voxcone {

namespace fs = std::filesystem;

namespace {

constexpr double kSideBar = 380;       ///< width at a content scale of 1
constexpr double kTurnPerWidth = 3.2;  ///< radians that a drag over the picture's height turns
constexpr double kDoubleClick = 0.3;   ///< seconds

ImVec2 vec(const glm::dvec2& p) {
    return {static_cast<float>(p.x), static_cast<float>(p.y)};
}

/// Keys that Dear ImGui edits text with.
void mapKeys(ImGuiIO& io) {
    const std::pair<int, int> keys[] = {{ImGuiKey_Tab, GLFW_KEY_TAB},
                                        {ImGuiKey_LeftArrow, GLFW_KEY_LEFT},
                                        {ImGuiKey_RightArrow, GLFW_KEY_RIGHT},
                                        {ImGuiKey_UpArrow, GLFW_KEY_UP},
                                        {ImGuiKey_DownArrow, GLFW_KEY_DOWN},
                                        {ImGuiKey_PageUp, GLFW_KEY_PAGE_UP},
                                        {ImGuiKey_PageDown, GLFW_KEY_PAGE_DOWN},
                                        {ImGuiKey_Home, GLFW_KEY_HOME},
                                        {ImGuiKey_End, GLFW_KEY_END},
                                        {ImGuiKey_Insert, GLFW_KEY_INSERT},
                                        {ImGuiKey_Delete, GLFW_KEY_DELETE},
                                        {ImGuiKey_Backspace, GLFW_KEY_BACKSPACE},
                                        {ImGuiKey_Space, GLFW_KEY_SPACE},
                                        {ImGuiKey_Enter, GLFW_KEY_ENTER},
                                        {ImGuiKey_Escape, GLFW_KEY_ESCAPE},
                                        {ImGuiKey_KeyPadEnter, GLFW_KEY_KP_ENTER},
                                        {ImGuiKey_A, GLFW_KEY_A},
                                        {ImGuiKey_C, GLFW_KEY_C},
                                        {ImGuiKey_V, GLFW_KEY_V},
                                        {ImGuiKey_X, GLFW_KEY_X},
                                        {ImGuiKey_Y, GLFW_KEY_Y},
                                        {ImGuiKey_Z, GLFW_KEY_Z}};
    for (const auto& [to, from] : keys) io.KeyMap[to] = from;
}

/// The newest change of any file below `folder`.
fs::file_time_type newestBelow(const fs::path& folder) {
    fs::file_time_type newest = fs::file_time_type::min();
    std::error_code none;
    for (fs::recursive_directory_iterator it(folder, none), end; it != end; it.increment(none)) {
        const auto time = it->last_write_time(none);
        if (!none && it->is_regular_file(none)) newest = std::max(newest, time);
    }
    return newest;
}

}  // namespace

Viewer::Viewer(const ViewerOptions& options)
    : options_(options),
      window_(options.width, options.height, "voxcone", options.debug),
      thread_([this] { return window_.sharedContext(); },
              [this] {
                  woken_ = true;
                  Window::wake();
              },
              options.shaders),
      session_(thread_, options.folders, options.prepare),
      panels_(makePanels()),
      lastTurn_(Clock::now()) {
    IMGUI_CHECKVERSION();
    imgui_ = ImGui::CreateContext();
    ImGuiIO& io = ImGui::GetIO();
    if (!options.folders.config.empty()) layoutFile_ = (options.folders.config / "layout.ini").string();
    io.IniFilename = layoutFile_.empty() ? nullptr : layoutFile_.c_str();
    io.BackendPlatformName = "voxcone";
    io.ClipboardUserData = &window_;
    io.GetClipboardTextFn = [](void* user) {
        // Dear ImGui reads the text at once.
        static thread_local std::string text;
        text = static_cast<Window*>(user)->clipboard();
        return text.c_str();
    };
    io.SetClipboardTextFn = [](void* user, const char* text) { static_cast<Window*>(user)->clipboard(text); };
    mapKeys(io);
    uiScale_ = window_.contentScale();
    ImGui::StyleColorsDark();
    ImGui::GetStyle().ScaleAllSizes(uiScale_);
    ImFontConfig font;
    font.SizePixels = std::round(13 * uiScale_);
    io.Fonts->AddFontDefault(&font);
    ImGui_ImplOpenGL3_Init("#version 430 core");
    if (!options.shaders.empty()) shaderTime_ = newestBelow(options.shaders);
    session_.wake = [this] {
        woken_ = true;
        Window::wake();
    };
    session_.otherThread = [this] {
        return std::make_unique<RenderThread>([this] { return window_.sharedContext(1); }, session_.wake,
                                              options_.shaders);
    };
    if (!options.file.empty()) session_.open(options.file);
    layOut();
}

Viewer::~Viewer() {
    ImGui_ImplOpenGL3_Shutdown();
    ImGui::DestroyContext(imgui_);
    // Their textures go while a context of theirs is current.
    comparison_ = {};
    session_.endOther();
    session_.presentImage = session_.otherImage = {};
    session_.picture.reset();
    session_.held.reset();
}

void Viewer::run() {
    while (turn(0.1)) {
    }
}

void Viewer::post(const Event& event) {
    events_.push_back(event);
}

// ---- Events

bool Viewer::turn(double seconds) {
    // A minimised window keeps what is to be drawn for later.
    const bool draws = redraw_ > 0 && !window_.minimized();
    const bool busy = !events_.empty() || draws || !down_.empty() || session_.animated() || woken_;
    for (Event& event : window_.wait(busy ? 1e-3 : seconds)) events_.push_back(std::move(event));
    ++turns_;
    const auto now = Clock::now();
    const double passed = std::min(std::chrono::duration<double>(now - lastTurn_).count(), 0.25);
    lastTurn_ = now;
    if (!events_.empty()) redraw_ = 3;  // Dear ImGui settles its layout over a few frames

    // A button that is pressed and released between two pictures would be missed, so that ends the turn.
    bool buttonSeen = false;
    while (!events_.empty()) {
        const bool isButton = events_.front().type == Event::Type::button;
        if (isButton && std::exchange(buttonSeen, true)) break;
        const Event event = std::move(events_.front());
        events_.pop_front();
        handle(event);
    }
    if (fly(passed)) redraw_ = 3;
    watchShaders();
    layOut();
    if (woken_.exchange(false)) redraw_ = std::max(redraw_, 1);
    const glm::dvec2 pixels =
        area_.size * glm::dvec2(window_.framebufferSize()) / glm::max(glm::dvec2(window_.size()), glm::dvec2(1));
    session_.dragging = ImGui::GetIO().MouseDown[GLFW_MOUSE_BUTTON_LEFT];
    if (session_.update(passed, glm::ivec2(glm::round(pixels)))) redraw_ = std::max(redraw_, 2);
    const bool active = !thread_.idle();
    if (active || active != wasActive_) redraw_ = std::max(redraw_, 1);
    wasActive_ = active;
    if (session_.animated()) redraw_ = std::max(redraw_, 1);
    if (redraw_ > 0 && !window_.minimized()) {
        --redraw_;
        draw();
        window_.swap();
    }
    window_.context().checkErrors();
    return !window_.closeRequested();
}

void Viewer::handle(const Event& event) {
    ImGuiIO& io = ImGui::GetIO();
    switch (event.type) {
        case Event::Type::key: {
            const bool press = event.action != GLFW_RELEASE;
            if (event.code >= 0 && event.code < 512) io.KeysDown[event.code] = press;
            // Modifiers as they are with this key; that of a modifier's own press does not hold it yet on X11.
            const auto held = [&](int left, int right) { return io.KeysDown[left] || io.KeysDown[right]; };
            io.KeyCtrl = held(GLFW_KEY_LEFT_CONTROL, GLFW_KEY_RIGHT_CONTROL) || (event.mods & GLFW_MOD_CONTROL) != 0;
            io.KeyShift = held(GLFW_KEY_LEFT_SHIFT, GLFW_KEY_RIGHT_SHIFT) || (event.mods & GLFW_MOD_SHIFT) != 0;
            io.KeyAlt = held(GLFW_KEY_LEFT_ALT, GLFW_KEY_RIGHT_ALT) || (event.mods & GLFW_MOD_ALT) != 0;
            if (!press) down_.erase(event.code);
            if (press && !io.WantTextInput) key(event);
            break;
        }
        case Event::Type::character:
            io.AddInputCharacter(event.character);
            break;
        case Event::Type::cursor:
            io.MousePos = vec(event.position);
            cursor(event.position);
            break;
        case Event::Type::button:
            if (event.code >= 0 && event.code < 5) io.MouseDown[event.code] = event.action == GLFW_PRESS;
            button(event);
            break;
        case Event::Type::scroll:
            io.MouseWheel += static_cast<float>(event.position.y);
            io.MouseWheelH += static_cast<float>(event.position.x);
            scroll(event.position.y);
            break;
        case Event::Type::drop:
            drop(event.files);
            break;
        case Event::Type::refresh:  // any event draws
            break;
        case Event::Type::focus:
            // Releases that go elsewhere are never seen.
            if (event.code == 0) {
                down_.clear();
                drag_ = -1;
                gizmo_.release();
                std::fill(std::begin(io.KeysDown), std::end(io.KeysDown), false);
                std::fill(std::begin(io.MouseDown), std::end(io.MouseDown), false);
            }
            break;
    }
}

void Viewer::key(const Event& event) {
    const bool ctrl = (event.mods & GLFW_MOD_CONTROL) != 0, repeat = event.action == GLFW_REPEAT;
    for (Panel& panel : panels_)
        if (panel.key == event.code && !repeat) panel.open = !panel.open;
    if (event.code == GLFW_KEY_F1 && !repeat) help_ = !help_;
    if (event.code == GLFW_KEY_TAB && !repeat) sideBar_ = !sideBar_;
    if (event.code == GLFW_KEY_ESCAPE) {
        help_ = openDialog_ = false;
        session_.selectedNode = -1;
    }
    if (event.code == GLFW_KEY_V && !ctrl && !repeat) window_.vsync(vsync_ = !vsync_);
    if (ctrl && event.code == GLFW_KEY_Q) window_.requestClose();
    if (ctrl && event.code == GLFW_KEY_O) openDialog_ = true;
    if (event.code == GLFW_KEY_F5 && !repeat) session_.reloadShaders();
    if (!session_.facts) return;
    if (ctrl) {
        if (event.code == GLFW_KEY_Z) session_.undo();
        if (event.code == GLFW_KEY_Y) session_.redo();
        if (event.code == GLFW_KEY_S && !repeat) session_.writeScript();
        if (event.code >= GLFW_KEY_1 && event.code <= GLFW_KEY_9 && !repeat) session_.saveView();
        return;
    }
    if (event.code >= GLFW_KEY_1 && event.code <= GLFW_KEY_9) {
        const auto index = static_cast<std::size_t>(event.code - GLFW_KEY_1);
        if (index < session_.views.size()) session_.recallView(session_.views[index]);
        return;
    }
    switch (event.code) {
        case GLFW_KEY_W:
        case GLFW_KEY_A:
        case GLFW_KEY_S:
        case GLFW_KEY_D:
        case GLFW_KEY_Q:
        case GLFW_KEY_E:
        case GLFW_KEY_LEFT_SHIFT:
            down_.insert(event.code);
            return;
        case GLFW_KEY_LEFT_BRACKET:
            return stepChannel(-1);
        case GLFW_KEY_RIGHT_BRACKET:
            return stepChannel(1);
        default:
            break;
    }
    if (repeat) return;
    switch (event.code) {
        case GLFW_KEY_F:
            if (rect_.contains(cursor_)) session_.focus(placeInPicture(cursor_));
            break;
        case GLFW_KEY_HOME:
            session_.frameScene();
            break;
        case GLFW_KEY_SPACE:
            session_.playing = !session_.playing;
            break;
        case GLFW_KEY_B:
            session_.channel = "beauty";
            break;
        case GLFW_KEY_I:
            if (rect_.contains(cursor_)) session_.inspect(placeInPicture(cursor_));
            break;
        case GLFW_KEY_H:
            session_.hold();
            break;
        case GLFW_KEY_X:
            session_.exchangeControls();
            break;
        case GLFW_KEY_J:
            session_.watch(session_.flicker.watched == Watched::none ? Watched::indirect : Watched::none);
            break;
        case GLFW_KEY_C:
            session_.freeze(!session_.frozen());
            break;
        case GLFW_KEY_N:
            session_.stepClipmap();
            break;
        case GLFW_KEY_G:
            session_.showLights = !session_.showLights;
            break;
        case GLFW_KEY_T:
            session_.gizmoMode = static_cast<GizmoMode>((static_cast<int>(session_.gizmoMode) + 1) % 3);
            break;
        case GLFW_KEY_L:
            session_.showLevels = !session_.showLevels;
            break;
        case GLFW_KEY_M:
            session_.followWindow = !session_.followWindow;
            break;
        case GLFW_KEY_P:
            session_.screenshot();
            break;
        case GLFW_KEY_R:
            if (session_.recording) {
                session_.stopRecording();
            } else {
                session_.startRecording();
            }
            break;
        default:
            break;
    }
}

void Viewer::stepChannel(int by) {
    const auto& names = channelNames();
    const auto at = std::find(names.begin(), names.end(), session_.channel) - names.begin();
    const auto count = static_cast<std::ptrdiff_t>(names.size());
    session_.channel = names[static_cast<std::size_t>((at + by + count) % count)];
}

glm::dvec2 Viewer::placeInPicture(const glm::dvec2& screen) const {
    return (screen - rect_.low) / glm::max(rect_.size, glm::dvec2(1));
}

void Viewer::cursor(const glm::dvec2& to) {
    const glm::dvec2 by = (to - cursor_) / std::max(rect_.size.y, 1.0);
    cursor_ = to;
    if (gizmo_.holds()) return gizmo_.drag(session_, Projection(session_.camera.camera(), rect_), to);
    if (drag_ < 0 || !session_.facts) return;
    session_.moved();
    if (drag_ == GLFW_MOUSE_BUTTON_RIGHT) {
        session_.camera.look(kTurnPerWidth * by.x, -kTurnPerWidth * by.y);
    } else if (drag_ == GLFW_MOUSE_BUTTON_MIDDLE || (dragMods_ & GLFW_MOD_SHIFT) != 0) {
        // What lies at the target stays below the cursor.
        const double metres =
            2 * session_.camera.distance() * std::tan(glm::radians(0.5 * session_.camera.camera().verticalFovDeg));
        session_.camera.pan(-metres * by.x, metres * by.y);
    } else {
        session_.camera.orbit(-kTurnPerWidth * by.x, kTurnPerWidth * by.y);
    }
}

void Viewer::button(const Event& event) {
    if (event.action == GLFW_RELEASE) {
        if (event.code == drag_) drag_ = -1;
        if (event.code == GLFW_MOUSE_BUTTON_LEFT) gizmo_.release();
        return;
    }
    if (ImGui::GetIO().WantCaptureMouse || !rect_.contains(cursor_) || !session_.facts) return;
    const Projection projection(session_.camera.camera(), rect_);
    if (event.code == GLFW_MOUSE_BUTTON_LEFT && (event.mods & GLFW_MOD_ALT) != 0)
        return session_.pick(placeInPicture(cursor_));
    if (event.code == GLFW_MOUSE_BUTTON_LEFT && gizmo_.take(session_, projection, cursor_, uiScale_)) return;
    drag_ = event.code;
    dragMods_ = event.mods;
    if (event.code != GLFW_MOUSE_BUTTON_LEFT) return;
    if (session_.inspecting) session_.inspect(placeInPicture(cursor_));
    const auto now = Clock::now();
    const bool twice = now - lastClick_ < std::chrono::duration<double>(kDoubleClick);
    lastClick_ = now;
    if (twice) session_.focus(placeInPicture(cursor_));
}

void Viewer::scroll(double amount) {
    if (ImGui::GetIO().WantCaptureMouse || !rect_.contains(cursor_) || !session_.facts) return;
    if (!down_.empty() || drag_ == GLFW_MOUSE_BUTTON_RIGHT) {
        flySpeed_ = std::clamp(flySpeed_ * std::exp2(0.25 * amount), 1e-3, 1e3);
        return;
    }
    session_.moved();
    session_.camera.dolly(std::exp2(-0.2 * amount));
}

void Viewer::drop(const std::vector<fs::path>& files) {
    for (const fs::path& file : files) session_.open(file);
}

bool Viewer::fly(double seconds) {
    glm::dvec3 way(0);
    way.z += keyDown(GLFW_KEY_W) - keyDown(GLFW_KEY_S);
    way.x += keyDown(GLFW_KEY_D) - keyDown(GLFW_KEY_A);
    way.y += keyDown(GLFW_KEY_E) - keyDown(GLFW_KEY_Q);
    if (way == glm::dvec3(0) || !session_.facts) return false;
    const ImGuiIO& io = ImGui::GetIO();
    // The length of the scene in a few seconds.
    const double speed = 0.2 * std::max(glm::length(session_.facts->bounds.size()), 1e-9) * flySpeed_ *
                         (io.KeyShift  ? 4
                          : io.KeyCtrl ? 0.25
                                       : 1);
    session_.moved();
    session_.camera.fly(seconds * speed * way);
    return true;
}

void Viewer::watchShaders() {
    if (options_.shaders.empty()) return;
    const auto now = Clock::now();
    if (now - lastShaderCheck_ < std::chrono::milliseconds(500)) return;
    lastShaderCheck_ = now;
    const auto newest = newestBelow(options_.shaders);
    if (newest <= shaderTime_) return;
    shaderTime_ = newest;
    session_.reloadShaders();
}

// ---- Drawing

void Viewer::layOut() {
    const glm::dvec2 window(window_.size());
    const double bar = std::ceil(19.0 * uiScale_);  // the menu; one line of it at the bottom, too
    const double side = sideBar_ ? std::min(kSideBar * uiScale_, 0.6 * window.x) : 0;
    area_.low = {0, bar};
    area_.size = glm::max(glm::dvec2(window.x - side, window.y - 2 * bar), glm::dvec2(1));
    const Settings::Output& output = session_.settings.now().output;
    const glm::dvec2 size(output.width, output.height);
    const double perPixel = window.x / std::max(1, window_.framebufferSize().x);
    double scale = std::min(area_.size.x / size.x, area_.size.y / size.y);
    // Small pictures are shown in whole pixels.
    if (scale >= perPixel) scale = perPixel * std::floor(scale / perPixel);
    rect_.size = glm::min(glm::round(scale * size), area_.size);
    rect_.low = area_.low + glm::floor(0.5 * (area_.size - rect_.size));
}

void Viewer::draw() {
    ++drawn_;
    ImGuiIO& io = ImGui::GetIO();
    const glm::ivec2 size = window_.size(), pixels = window_.framebufferSize();
    io.DisplaySize = ImVec2(static_cast<float>(size.x), static_cast<float>(size.y));
    io.DisplayFramebufferScale =
        ImVec2(static_cast<float>(pixels.x) / io.DisplaySize.x, static_cast<float>(pixels.y) / io.DisplaySize.y);
    io.DeltaTime = 1.0f / 30;
    ImGui_ImplOpenGL3_NewFrame();
    ImGui::NewFrame();
    drawPicture();
    drawOverlays();
    drawMenu();
    if (sideBar_) drawSideBar();
    drawStatus();
    drawOpenDialog();
    if (help_) drawHelp(help_);
    ImGui::Render();
    gl::beginWindow(pixels.x, pixels.y, glm::vec3(0.1f));
    ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
}

Image Viewer::readWindow() {
    const glm::ivec2 size = window_.framebufferSize();
    draw();
    const std::vector<std::uint8_t> bytes = gl::readWindow(size.x, size.y);
    window_.swap();
    Image image(size.x, size.y, 3);
    for (int y = 0; y < size.y; ++y)
        for (int i = 0; i < 3 * size.x; ++i)
            image.pixel(0, size.y - 1 - y)[i] =
                static_cast<float>(bytes[static_cast<std::size_t>(3 * size.x * y + i)]) / 255.0f;
    return image;
}

void Viewer::drawPicture() {
    if (!session_.picture || !session_.picture->texture) return;
    comparison_.draw(session_, rect_, cursor_, uiScale_);
}

void Viewer::drawOverlays() {
    if (!session_.picture) return;
    ImDrawList& list = *ImGui::GetBackgroundDrawList();
    list.PushClipRect(vec(rect_.low), vec(rect_.low + rect_.size));
    // Lines belong to the picture that is shown, not to the camera that is ahead of it.
    const Projection projection(session_.picture->view.camera, rect_);
    if (session_.showUpdates) drawFlashes(projection);
    if (session_.picture->clipmap.layout.levels > 0) {
        if (session_.showLevels || session_.showSnapGrid) drawLevels(projection);
        if (session_.sliceShown && session_.slice) drawSlicePlane(projection);
    }
    if (session_.inspection) drawCones(projection);
    gizmo_.draw(session_, Projection(session_.camera.camera(), rect_), uiScale_);
    list.PopClipRect();
}

void Viewer::drawFlashes(const Projection& projection) {
    ImDrawList& list = *ImGui::GetBackgroundDrawList();
    const auto now = Clock::now();
    for (const Flash& flash : session_.flashes) {
        const double age = std::chrono::duration<double>(now - flash.start).count() / 0.8;
        const auto alpha = static_cast<float>(std::clamp(1 - age, 0.0, 1.0));
        for (const auto& [a, b] : kBoxEdges)
            if (const auto line = projection.line(boxCorner(flash.box, a), boxCorner(flash.box, b)))
                list.AddLine(vec(line->first), vec(line->second), levelColor(flash.level, alpha), 2 * uiScale_);
        // The sides that look to the eye, filled.
        constexpr int kFaces[6][4] = {{0, 2, 6, 4}, {1, 3, 7, 5}, {0, 1, 5, 4},
                                      {2, 3, 7, 6}, {0, 1, 3, 2}, {4, 5, 7, 6}};
        for (const auto& face : kFaces) {
            ImVec2 corners[4];
            bool whole = true;
            for (int i = 0; i < 4 && whole; ++i) {
                const auto p = projection.point(boxCorner(flash.box, face[i]));
                whole = p.has_value();
                if (whole) corners[i] = vec(*p);
            }
            if (whole)
                list.AddQuadFilled(corners[0], corners[1], corners[2], corners[3],
                                   levelColor(flash.level, 0.12f * alpha));
        }
    }
}

void Viewer::drawLevels(const Projection& projection) {
    ImDrawList& list = *ImGui::GetBackgroundDrawList();
    const ClipmapState& clipmap = session_.picture->clipmap;
    const auto draw = [&](const glm::dvec3& a, const glm::dvec3& b, std::uint32_t color, float width) {
        if (const auto line = projection.line(a, b)) list.AddLine(vec(line->first), vec(line->second), color, width);
    };
    for (int level = clipmap.layout.levels - 1; level >= 0; --level) {
        const auto i = static_cast<std::size_t>(level);
        if (i < session_.levelShown.size() && session_.levelShown[i] == 0) continue;
        const double edge = clipmap.layout.voxelSizeOf(level);
        const VoxelBox& window = clipmap.update.windows[i];
        const Bounds box{clipmap.origin + edge * glm::dvec3(window.low),
                         clipmap.origin + edge * glm::dvec3(window.high)};
        if (session_.showLevels) {
            for (const auto& [a, b] : kBoxEdges)
                draw(boxCorner(box, a), boxCorner(box, b), levelColor(level), 1.5f * uiScale_);
            if (const auto label = projection.point(box.max))
                list.AddText(vec(*label), levelColor(level), fmt::format("level {}", level).c_str());
        }
        if (!session_.showSnapGrid || !clipmap.layout.moves(level)) continue;
        // Where the window's lower side can come to lie.
        const int snap = clipmap.layout.snapOf(level);
        for (int n = 0; n <= clipmap.layout.resolution; n += snap) {
            const double x = box.min.x + n * edge, z = box.min.z + n * edge;
            draw({x, box.min.y, box.min.z}, {x, box.min.y, box.max.z}, levelColor(level, 0.35f), 1);
            draw({box.min.x, box.min.y, z}, {box.max.x, box.min.y, z}, levelColor(level, 0.35f), 1);
        }
    }
    if (session_.frozen()) {
        if (const auto eye = projection.point(*session_.frozenEye)) {
            list.AddCircle(vec(*eye), 6 * uiScale_, 0xffffffff);
            list.AddText(vec(*eye + glm::dvec2(8 * uiScale_, -6 * uiScale_)), 0xffffffff, "clipmap");
        }
    }
}

void Viewer::drawSlicePlane(const Projection& projection) {
    const VoxelSlice& slice = *session_.slice;
    if (slice.width == 0) return;
    const glm::dvec3 low = slice.origin + slice.voxelSize * glm::dvec3(slice.low);
    glm::dvec3 high = slice.origin + slice.voxelSize * glm::dvec3(slice.index(slice.width, slice.height));
    high[slice.axis] += slice.voxelSize;
    const Bounds box{low, high};
    for (const auto& [a, b] : kBoxEdges)
        if (const auto line = projection.line(boxCorner(box, a), boxCorner(box, b)))
            ImGui::GetBackgroundDrawList()->AddLine(vec(line->first), vec(line->second), 0xc0ffffff, uiScale_);
}

void Viewer::drawCones(const Projection& projection) {
    ImDrawList& list = *ImGui::GetBackgroundDrawList();
    const Inspection& asked = *session_.inspection;
    if (asked.shown() == nullptr) return;
    const PixelCones& lobe = *asked.shown();
    for (std::size_t i = 0; i < lobe.cones.size(); ++i) {
        const bool selected = static_cast<int>(i) == asked.selected;
        if (asked.onlySelected && !selected) continue;
        const InspectedCone& cone = lobe.cones[i];
        if (cone.samples.empty()) continue;
        const glm::dvec3 end = cone.origin + cone.samples.back().distance * cone.direction;
        // A beam's cone begins behind the surface.
        for (const auto& [from, to] : {std::pair(lobe.position, cone.origin), std::pair(cone.origin, end)})
            if (const auto line = projection.line(from, to))
                list.AddLine(vec(line->first), vec(line->second), selected ? 0xffffffff : 0x80ffffff,
                             (selected ? 2.0f : 1.0f) * uiScale_);
        double before = 1;
        for (const ConeSample& sample : cone.samples) {
            // A sphere of the footprint, filled by what it stops.
            const glm::dvec3 centre = cone.origin + sample.distance * cone.direction;
            const double stopped = std::clamp(before - sample.transmittance, 0.0, 1.0);
            before = sample.transmittance;
            const auto place = projection.point(centre);
            if (!place) continue;
            const auto radius = static_cast<float>(0.5 * sample.footprint * projection.scaleAt(centre));
            if (radius > rect_.size.y) continue;
            const int level = static_cast<int>(std::lround(sample.level));
            if (sample.length > 0) {
                list.AddCircle(vec(*place), radius, levelColor(level, selected ? 0.9f : 0.35f), 0,
                               (selected ? 1.5f : 1.0f) * uiScale_);
                if (stopped > 1e-3)
                    list.AddCircleFilled(vec(*place), radius, levelColor(level, 0.6f * static_cast<float>(stopped)));
            } else {
                list.AddCircleFilled(vec(*place), 2.5f * uiScale_,
                                     levelColor(level, 0.4f + 0.6f * static_cast<float>(stopped)));
            }
        }
    }
    if (const auto place = projection.point(lobe.position))
        list.AddCircle(vec(*place), 4 * uiScale_, 0xffffffff, 0, 2 * uiScale_);
}

void Viewer::drawMenu() {
    if (!ImGui::BeginMainMenuBar()) return;
    if (ImGui::BeginMenu("File")) {
        if (ImGui::MenuItem("open ...", "Ctrl+O")) openDialog_ = true;
        if (ImGui::BeginMenu("recent", !session_.recent.empty())) {
            const std::vector<fs::path> recent = session_.recent;
            for (const fs::path& file : recent)
                if (ImGui::MenuItem(file.string().c_str())) session_.open(file);
            ImGui::EndMenu();
        }
        if (ImGui::MenuItem("screenshot", "P", false, session_.facts != nullptr)) session_.screenshot();
        if (ImGui::MenuItem("write script", "Ctrl+S", false, session_.facts != nullptr)) session_.writeScript();
        if (ImGui::MenuItem("end", "Ctrl+Q")) window_.requestClose();
        ImGui::EndMenu();
    }
    if (ImGui::BeginMenu("Panels")) {
        ImGui::MenuItem("side bar", "Tab", &sideBar_);
        for (Panel& panel : panels_)
            ImGui::MenuItem(panel.name, fmt::format("F{}", panel.key - GLFW_KEY_F1 + 1).c_str(), &panel.open);
        if (ImGui::MenuItem("vertical synchronisation", "V", &vsync_)) window_.vsync(vsync_);
        ImGui::EndMenu();
    }
    if (ImGui::MenuItem("Help (F1)")) help_ = !help_;
    ImGui::EndMainMenuBar();
}

void Viewer::drawSideBar() {
    const ImGuiIO& io = ImGui::GetIO();
    const auto left = static_cast<float>(area_.low.x + area_.size.x);
    const auto top = static_cast<float>(area_.low.y), bottom = static_cast<float>(area_.low.y + area_.size.y);
    ImGui::SetNextWindowPos(ImVec2(left, top));
    ImGui::SetNextWindowSize(ImVec2(io.DisplaySize.x - left, bottom - top));
    ImGui::Begin("side bar", nullptr,
                 ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove |
                     ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoBringToFrontOnFocus);
    if (!session_.facts) ImGui::TextWrapped("Drop a glTF scene or a capture script here, or open one (Ctrl+O).");
    for (Panel& panel : panels_) {
        ImGui::SetNextItemOpen(panel.open);
        panel.open = ImGui::CollapsingHeader(panel.name);
        if (!panel.open || !session_.facts) continue;
        ImGui::PushID(panel.name);
        ImGui::PushItemWidth(-9 * ImGui::GetFontSize());
        panel.draw(session_);
        ImGui::PopItemWidth();
        ImGui::PopID();
    }
    ImGui::End();
}

void Viewer::drawStatus() {
    const ImGuiIO& io = ImGui::GetIO();
    const auto top = static_cast<float>(area_.low.y + area_.size.y);
    ImGui::SetNextWindowPos(ImVec2(0, top));
    ImGui::SetNextWindowSize(ImVec2(io.DisplaySize.x, io.DisplaySize.y - top));
    ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, ImVec2(6 * uiScale_, 2 * uiScale_));
    ImGui::PushStyleVar(ImGuiStyleVar_WindowMinSize, ImVec2(1, 1));
    ImGui::Begin("status", nullptr,
                 ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoSavedSettings |
                     ImGuiWindowFlags_NoBringToFrontOnFocus);
    std::string line = session_.shownChannel();
    if (session_.picture && session_.picture->surfaces) line += " (albedo until there is light)";
    if (session_.frozen()) line += ", frozen";
    if (session_.recording) line += ", recording";
    if (session_.other) line += session_.controlsOther ? ", controls: B" : ", controls: A";
    const std::string activity = thread_.activity();
    if (!activity.empty()) {
        const double seconds = thread_.activitySeconds();
        line += ", " + activity + (seconds > 1 ? fmt::format(" {:.0f} s", seconds) : "");
    }
    ImGui::TextUnformatted(line.c_str());
    drawLightProgress();
    if (!session_.messages.empty() && Clock::now() - session_.messageTime < std::chrono::seconds(15)) {
        const Message& last = session_.messages.back();
        ImGui::SameLine();
        if (last.error) ImGui::PushStyleColor(ImGuiCol_Text, ImVec4(1, 0.45f, 0.4f, 1));
        ImGui::TextUnformatted(("   " + last.text.substr(0, last.text.find('\n'))).c_str());
        if (last.error) ImGui::PopStyleColor();
    }
    ImGui::End();
    ImGui::PopStyleVar(2);
}

/// How much light is still to come, in words and as a bar.
void Viewer::drawLightProgress() {
    const LightProgress light = thread_.light();
    if (light.whole) return;
    ImGui::SameLine(0, 0);
    ImGui::TextUnformatted((", " + lightText(light)).c_str());
    // Of all steps: direct light, and each bounce.
    const double steps = light.direct ? 1 + light.bounces + light.share : light.share;
    const double share = light.levelsLeft > 0 ? 0 : std::min(steps / (1 + light.of), 1.0);
    ImGui::SameLine();
    ImGui::PushStyleVar(ImGuiStyleVar_FramePadding, ImVec2(0, 0));
    ImGui::ProgressBar(static_cast<float>(share), ImVec2(6 * ImGui::GetFontSize(), ImGui::GetFontSize()), "");
    ImGui::PopStyleVar();
}

void Viewer::drawOpenDialog() {
    if (!openDialog_) return;
    ImGui::SetNextWindowPos(ImVec2(40 * uiScale_, 60 * uiScale_), ImGuiCond_Appearing);
    if (ImGui::Begin("Open", &openDialog_, ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoSavedSettings)) {
        if (ImGui::IsWindowAppearing()) ImGui::SetKeyboardFocusHere();
        ImGui::SetNextItemWidth(30 * ImGui::GetFontSize());
        const bool entered = ImGui::InputTextWithHint("##file", "scene.gltf, script.json, sky.hdr", &openName_,
                                                      ImGuiInputTextFlags_EnterReturnsTrue);
        ImGui::SameLine();
        if ((ImGui::Button("open") || entered) && !openName_.empty()) {
            session_.open(openName_);
            openDialog_ = false;
        }
    }
    ImGui::End();
}

}  // namespace voxcone
