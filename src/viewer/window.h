// A window with an OpenGL 4.3 core context, a second context that shares with it, and what the user does to it.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <glm/glm.hpp>
#include <memory>
#include <string>
#include <vector>

#include "gl/context.h"

struct GLFWwindow;

namespace voxcone {

/// One thing that the user did. Keys, buttons, actions and modifiers are GLFW's.
struct Event {
    enum class Type : int { key, character, cursor, button, scroll, drop, focus, refresh };
    Type type = Type::key;
    int code = 0;    ///< key or button; 1 or 0 for focus gained or lost
    int action = 0;  ///< GLFW_PRESS, GLFW_RELEASE, GLFW_REPEAT
    int mods = 0;
    std::uint32_t character = 0;
    glm::dvec2 position{0};  ///< cursor: screen coordinates from the upper left corner; scroll: offsets
    std::vector<std::filesystem::path> files;  ///< dropped
    // refresh: what the window showed is lost, as after it was restored or uncovered.
};

/// Lives on the main thread, as GLFW demands; only the shared context goes to another.
class Window {
  public:
    /// Opens a window of `width`×`height` screen coordinates, at most as large as the monitor. Throws DeviceError,
    /// which names `voxcone capture`, when there is no display or no OpenGL 4.3 core.
    Window(int width, int height, const std::string& title, bool debug);
    ~Window();
    Window(const Window&) = delete;
    Window& operator=(const Window&) = delete;

    /// The window's own context, current on the main thread.
    gl::Context& context() { return *context_; }
    /// One of two contexts that share textures with the window's; to be called on the thread that is to have it. The
    /// window must outlive it.
    std::unique_ptr<gl::Context> sharedContext(std::size_t index = 0);

    /// Waits for something to happen, `seconds` at most, and takes what did.
    std::vector<Event> wait(double seconds);
    /// Ends a wait; from any thread.
    static void wake();

    bool closeRequested() const;
    void requestClose();
    bool minimized() const;
    glm::ivec2 size() const;             ///< screen coordinates
    glm::ivec2 framebufferSize() const;  ///< pixels; 0 while minimised
    float contentScale() const;          ///< of text and controls, 1 on ordinary monitors
    void resize(int width, int height);
    void minimize(bool on);
    void title(const std::string& text);
    void vsync(bool on);
    void swap();
    std::string clipboard() const;
    void clipboard(const std::string& text);

  private:
    static Window& of(GLFWwindow* window);

    bool debug_;
    GLFWwindow* window_ = nullptr;
    std::array<GLFWwindow*, 2> hidden_{};  ///< carry the shared contexts
    std::unique_ptr<gl::Context> context_;
    std::vector<Event> events_;
};

}  // namespace voxcone
