// The window: events to camera and keys, panels beside the picture, overlays on it.
#pragma once

#include <array>
#include <atomic>
#include <deque>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "metric/image.h"
#include "viewer/comparison_view.h"
#include "viewer/gizmo.h"
#include "viewer/panels.h"
#include "viewer/session.h"
#include "viewer/window.h"

struct ImGuiContext;

namespace voxcone {

struct ViewerOptions {
    std::filesystem::path file;              ///< scene, script, or empty
    std::function<void(Settings&)> prepare;  ///< changes the settings of whatever is opened (--set)
    ViewerFolders folders;
    std::filesystem::path shaders;  ///< goes before the embedded shaders and is watched for changes; or empty
    int width = 1280, height = 720;
    bool debug = false;  ///< OpenGL errors are thrown by turn()
};

class Viewer {
  public:
    /// Opens the window. Throws DeviceError without a display.
    explicit Viewer(const ViewerOptions& options);
    ~Viewer();
    Viewer(const Viewer&) = delete;
    Viewer& operator=(const Viewer&) = delete;

    /// Turns until the window is closed.
    void run();

    /// One turn: waits up to `seconds` for something to happen, handles it, and draws when anything has changed. False
    /// once the window is to be closed.
    bool turn(double seconds);

    /// Adds an event as if the window had sent it.
    void post(const Event& event);

    Session& session() { return session_; }
    Window& window() { return window_; }
    std::vector<Panel>& panels() { return panels_; }
    bool sideBar() const { return sideBar_; }
    bool helpOpen() const { return help_; }
    /// Place of the picture in screen coordinates.
    const PictureRect& pictureRect() const { return rect_; }
    /// Draws, and gives the pixels of the window, row 0 on top, encoded values in [0,1].
    Image readWindow();
    /// Turns so far, and those that drew.
    std::uint64_t turns() const { return turns_; }
    std::uint64_t drawn() const { return drawn_; }

  private:
    using Clock = std::chrono::steady_clock;
    void handle(const Event& event);
    void key(const Event& event);
    void cursor(const glm::dvec2& to);
    void button(const Event& event);
    void scroll(double amount);
    void drop(const std::vector<std::filesystem::path>& files);
    bool fly(double seconds);
    void stepChannel(int by);
    void layOut();
    void draw();
    void drawMenu();
    void drawSideBar();
    void drawStatus();
    void drawLightProgress();
    void drawPicture();
    void drawOverlays();
    void drawLevels(const Projection& projection);
    void drawFlashes(const Projection& projection);
    void drawCones(const Projection& projection);
    void drawSlicePlane(const Projection& projection);
    void drawOpenDialog();
    glm::dvec2 placeInPicture(const glm::dvec2& screen) const;
    bool keyDown(int key) const { return down_.contains(key); }
    void watchShaders();

    // Declared in the order in which they are needed: the thread's context shares with the window's.
    ViewerOptions options_;
    Window window_;
    ImGuiContext* imgui_ = nullptr;
    std::string layoutFile_;
    std::atomic<bool> woken_{true};
    RenderThread thread_;
    Session session_;

    ComparisonView comparison_;
    std::vector<Panel> panels_;
    bool sideBar_ = true, help_ = false, openDialog_ = false, vsync_ = true;
    std::string openName_;
    PictureRect rect_, area_;  ///< the picture, and the place that it may take
    float uiScale_ = 1;

    std::deque<Event> events_;  ///< not yet handled
    std::set<int> down_;        ///< keys that the scene has, not a text field
    Gizmo gizmo_;
    int drag_ = -1;  ///< button that turns the camera
    int dragMods_ = 0;
    glm::dvec2 cursor_{0};
    Clock::time_point lastClick_, lastTurn_, lastShaderCheck_;
    std::filesystem::file_time_type shaderTime_{};
    double flySpeed_ = 1;
    int redraw_ = 3;  ///< turns that draw whatever happens
    bool wasActive_ = false;
    std::uint64_t turns_ = 0, drawn_ = 0;
};

}  // namespace voxcone
