#include "viewer/window.h"

#include <epoxy/gl.h>
// GLFW after the loader of OpenGL's functions.
#include <GLFW/glfw3.h>
#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "core/error.h"

namespace voxcone {
namespace {

std::string lastError() {
    const char* text = nullptr;
    glfwGetError(&text);
    return text ? text : "unknown error";
}

[[noreturn]] void fail(const std::string& reason) {
    throw DeviceError(
        fmt::format("no window: {}; `voxcone capture` renders the same pictures without a display", reason));
}

void hints(bool visible, bool debug) {
    glfwDefaultWindowHints();
    glfwWindowHint(GLFW_CLIENT_API, GLFW_OPENGL_API);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 4);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
    glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
    glfwWindowHint(GLFW_OPENGL_DEBUG_CONTEXT, debug ? GLFW_TRUE : GLFW_FALSE);
    glfwWindowHint(GLFW_VISIBLE, visible ? GLFW_TRUE : GLFW_FALSE);
    glfwWindowHint(GLFW_DEPTH_BITS, 0);
    glfwWindowHint(GLFW_STENCIL_BITS, 0);
}

std::unique_ptr<gl::Context> adopt(GLFWwindow* window, bool debug) {
    try {
        return gl::Context::adopt([window](bool current) { glfwMakeContextCurrent(current ? window : nullptr); },
                                  "GLFW window", debug);
    } catch (const DeviceError& error) {
        fail(error.what());
    }
}

}  // namespace

Window::Window(int width, int height, const std::string& title, bool debug) : debug_(debug) {
    if (!glfwInit()) fail(lastError());
    try {
        if (GLFWmonitor* monitor = glfwGetPrimaryMonitor()) {
            int x = 0, y = 0, w = 0, h = 0;
            glfwGetMonitorWorkarea(monitor, &x, &y, &w, &h);
            if (w > 0 && h > 0) width = std::min(width, w), height = std::min(height, h);
        }
        hints(true, debug);
        window_ = glfwCreateWindow(width, height, title.c_str(), nullptr, nullptr);
        if (!window_) fail(lastError());
        hints(false, debug);
        for (GLFWwindow*& hidden : hidden_) {
            hidden = glfwCreateWindow(16, 16, "", nullptr, window_);
            if (!hidden) fail(lastError());
        }
        context_ = adopt(window_, debug);
    } catch (...) {
        glfwTerminate();
        throw;
    }
    glfwSetWindowUserPointer(window_, this);
    glfwSetWindowSizeLimits(window_, 320, 180, GLFW_DONT_CARE, GLFW_DONT_CARE);
    const auto add = [](GLFWwindow* window, Event::Type type) -> Event& {
        Event& event = of(window).events_.emplace_back();
        event.type = type;
        return event;
    };
    static const auto kAdd = add;
    glfwSetKeyCallback(window_, [](GLFWwindow* window, int key, int, int action, int mods) {
        Event& event = kAdd(window, Event::Type::key);
        event.code = key, event.action = action, event.mods = mods;
    });
    glfwSetCharCallback(window_, [](GLFWwindow* window, unsigned character) {
        kAdd(window, Event::Type::character).character = character;
    });
    glfwSetCursorPosCallback(window_, [](GLFWwindow* window, double x, double y) {
        kAdd(window, Event::Type::cursor).position = {x, y};
    });
    glfwSetMouseButtonCallback(window_, [](GLFWwindow* window, int button, int action, int mods) {
        Event& event = kAdd(window, Event::Type::button);
        event.code = button, event.action = action, event.mods = mods;
    });
    glfwSetScrollCallback(window_, [](GLFWwindow* window, double x, double y) {
        kAdd(window, Event::Type::scroll).position = {x, y};
    });
    glfwSetDropCallback(window_, [](GLFWwindow* window, int count, const char** files) {
        kAdd(window, Event::Type::drop).files.assign(files, files + count);
    });
    glfwSetWindowFocusCallback(
        window_, [](GLFWwindow* window, int focused) { kAdd(window, Event::Type::focus).code = focused; });
    glfwSetWindowRefreshCallback(window_, [](GLFWwindow* window) { kAdd(window, Event::Type::refresh); });
    vsync(true);
}

Window::~Window() {
    context_.reset();
    for (GLFWwindow* hidden : hidden_) glfwDestroyWindow(hidden);
    glfwDestroyWindow(window_);
    glfwTerminate();
}

Window& Window::of(GLFWwindow* window) {
    return *static_cast<Window*>(glfwGetWindowUserPointer(window));
}

std::unique_ptr<gl::Context> Window::sharedContext(std::size_t index) {
    return adopt(hidden_.at(index), debug_);
}

std::vector<Event> Window::wait(double seconds) {
    if (seconds > 0) {
        glfwWaitEventsTimeout(seconds);
    } else {
        glfwPollEvents();
    }
    return std::exchange(events_, {});
}

void Window::wake() {
    glfwPostEmptyEvent();
}

bool Window::closeRequested() const {
    return glfwWindowShouldClose(window_) == GLFW_TRUE;
}

void Window::requestClose() {
    glfwSetWindowShouldClose(window_, GLFW_TRUE);
}

bool Window::minimized() const {
    return glfwGetWindowAttrib(window_, GLFW_ICONIFIED) == GLFW_TRUE || framebufferSize().x == 0 ||
           framebufferSize().y == 0;
}

glm::ivec2 Window::size() const {
    glm::ivec2 s(0);
    glfwGetWindowSize(window_, &s.x, &s.y);
    return s;
}

glm::ivec2 Window::framebufferSize() const {
    glm::ivec2 s(0);
    glfwGetFramebufferSize(window_, &s.x, &s.y);
    return s;
}

float Window::contentScale() const {
    float x = 1, y = 1;
    glfwGetWindowContentScale(window_, &x, &y);
    return std::clamp(std::max(x, y), 0.5f, 8.0f);
}

void Window::resize(int width, int height) {
    glfwSetWindowSize(window_, width, height);
}

void Window::minimize(bool on) {
    if (on) {
        glfwIconifyWindow(window_);
    } else {
        glfwRestoreWindow(window_);
    }
}

void Window::title(const std::string& text) {
    glfwSetWindowTitle(window_, text.c_str());
}

void Window::vsync(bool on) {
    glfwSwapInterval(on ? 1 : 0);
}

void Window::swap() {
    glfwSwapBuffers(window_);
}

std::string Window::clipboard() const {
    const char* text = glfwGetClipboardString(window_);
    return text ? text : "";
}

void Window::clipboard(const std::string& text) {
    glfwSetClipboardString(window_, text.c_str());
}

}  // namespace voxcone
