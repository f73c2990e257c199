// An OpenGL 4.3 core context, without a display or a window's; what the device can do, and the debug messages it sends.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <string>
#include <vector>

namespace voxcone::gl {

/// An OpenGL call of ours that the driver refused (severity high): a bug, reported as an exception so that tests can
/// see it.
class GlError : public std::logic_error {
  public:
    using std::logic_error::logic_error;
};

/// What the device is and can do.
struct DeviceInfo {
    std::string vendor, renderer, version, glslVersion;
    std::string platform;             ///< how the context was made, e.g. "EGL surfaceless"
    bool softwareRasterizer = false;  ///< llvmpipe, softpipe, swrast: GPU timer queries mean nothing there
    bool clearTexture = false;        ///< GL_ARB_clear_texture or GL 4.4
    int max2DTextureSize = 0, max3DTextureSize = 0, maxCubeSize = 0, maxArrayLayers = 0;
    std::int64_t maxSsboBytes = 0;  ///< one shader storage block
    int maxImageUniforms = 0;       ///< in a compute shader
    int maxFragmentImageUniforms = 0;
    int maxTextureUnits = 0;        ///< per stage
    int maxComputeInvocations = 0;  ///< per work group
    int maxGeometryInvocations = 0;
    int maxDrawBuffers = 0;
};

/// One context. Lives on the thread that made it current.
class Context {
  public:
    /// Tries the EGL surfaceless platform, then every EGL device. `debug` asks for a debug context whose messages come
    /// synchronously and whose errors `checkErrors` throws; without it they are logged. The context is current on
    /// return. Throws DeviceError with all that was tried when there is no OpenGL 4.3 core.
    static std::unique_ptr<Context> createHeadless(bool debug);

    /// A context that something else has made and owns, such as a window. `makeCurrent` makes it current on the calling
    /// thread, or, given false, none; both outlive the Context, which is released when it goes. `platform` is for
    /// info(). The context is current on return. Throws DeviceError when it is not OpenGL 4.3 core.
    static std::unique_ptr<Context> adopt(std::function<void(bool)> makeCurrent, const std::string& platform,
                                          bool debug);

    ~Context();
    Context(const Context&) = delete;
    Context& operator=(const Context&) = delete;

    void makeCurrent();
    const DeviceInfo& info() const { return info_; }

    /// Throws GlError with every message of severity high since the last call, if there is one (debug contexts only).
    void checkErrors();

  private:
    Context() = default;
    void readInfo(const std::string& platform);
    void listen();
    void onMessage(const std::string& text);

    std::function<void(bool)> makeCurrent_;  ///< false: none is current on this thread
    std::function<void()> destroy_;          ///< empty for an adopted context
    bool debug_ = false;
    DeviceInfo info_;
    std::mutex mutex_;  ///< drivers may call back from their own threads
    std::vector<std::string> errors_;
};

}  // namespace voxcone::gl
