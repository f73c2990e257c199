#include "gl/context.h"

#include <fmt/format.h>

#include <epoxy/egl.h>
#include <epoxy/gl.h>

#include <algorithm>
#include <array>
#include <utility>

#include "core/error.h"
#include "core/log.h"

namespace voxcone::gl {
namespace {

std::string eglErrorName(EGLint error) {
    switch (error) {
        case EGL_NOT_INITIALIZED:
            return "EGL_NOT_INITIALIZED";
        case EGL_BAD_ALLOC:
            return "EGL_BAD_ALLOC";
        case EGL_BAD_ATTRIBUTE:
            return "EGL_BAD_ATTRIBUTE";
        case EGL_BAD_CONFIG:
            return "EGL_BAD_CONFIG";
        case EGL_BAD_MATCH:
            return "EGL_BAD_MATCH";
        case EGL_BAD_DISPLAY:
            return "EGL_BAD_DISPLAY";
        default:
            return fmt::format("EGL error 0x{:04x}", error);
    }
}

/// Initialises `display` and makes a 4.3 core context; EGL_NO_CONTEXT and a reason when it cannot.
std::pair<EGLContext, std::string> makeContext(EGLDisplay display, bool debug) {
    if (display == EGL_NO_DISPLAY) return {EGL_NO_CONTEXT, "no display"};
    EGLint major = 0, minor = 0;
    if (!eglInitialize(display, &major, &minor)) {
        return {EGL_NO_CONTEXT, "eglInitialize: " + eglErrorName(eglGetError())};
    }
    if (!epoxy_has_egl_extension(display, "EGL_KHR_surfaceless_context")) {
        return {EGL_NO_CONTEXT, "no EGL_KHR_surfaceless_context"};
    }
    if (!eglBindAPI(EGL_OPENGL_API)) return {EGL_NO_CONTEXT, "no desktop OpenGL"};
    const std::array<EGLint, 5> configAttributes = {EGL_SURFACE_TYPE, EGL_DONT_CARE, EGL_RENDERABLE_TYPE,
                                                    EGL_OPENGL_BIT, EGL_NONE};
    EGLConfig config = nullptr;
    EGLint count = 0;
    if (!eglChooseConfig(display, configAttributes.data(), &config, 1, &count) || count == 0) {
        return {EGL_NO_CONTEXT, "no OpenGL configuration"};
    }
    const std::array<EGLint, 9> attributes = {EGL_CONTEXT_MAJOR_VERSION_KHR,
                                              4,
                                              EGL_CONTEXT_MINOR_VERSION_KHR,
                                              3,
                                              EGL_CONTEXT_OPENGL_PROFILE_MASK_KHR,
                                              EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT_KHR,
                                              EGL_CONTEXT_FLAGS_KHR,
                                              debug ? EGL_CONTEXT_OPENGL_DEBUG_BIT_KHR : 0,
                                              EGL_NONE};
    const EGLContext context = eglCreateContext(display, config, EGL_NO_CONTEXT, attributes.data());
    if (context == EGL_NO_CONTEXT) {
        return {EGL_NO_CONTEXT, "OpenGL 4.3 core refused: " + eglErrorName(eglGetError())};
    }
    if (!eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context)) {
        const std::string reason = "eglMakeCurrent: " + eglErrorName(eglGetError());
        eglDestroyContext(display, context);
        return {EGL_NO_CONTEXT, reason};
    }
    return {context, ""};
}

std::string glString(GLenum name) {
    const GLubyte* text = glGetString(name);
    return text ? reinterpret_cast<const char*>(text) : "";
}

int glInt(GLenum name) {
    GLint value = 0;
    glGetIntegerv(name, &value);
    return value;
}

}  // namespace

std::unique_ptr<Context> Context::createHeadless(bool debug) {
    std::string tried;
    const auto attempt = [&](EGLDisplay display, const std::string& platform) -> std::unique_ptr<Context> {
        const auto [handle, reason] = makeContext(display, debug);
        if (handle == EGL_NO_CONTEXT) {
            tried += fmt::format("{}{}: {}", tried.empty() ? "" : "; ", platform, reason);
            return nullptr;
        }
        std::unique_ptr<Context> context(new Context);
        context->makeCurrent_ = [display, made = handle](bool current) {
            if (eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, current ? made : EGL_NO_CONTEXT)) return;
            if (current) throw DeviceError("cannot make the OpenGL context current: " + eglErrorName(eglGetError()));
        };
        context->destroy_ = [display, made = handle] { eglDestroyContext(display, made); };
        context->debug_ = debug;
        context->readInfo(platform);
        context->listen();
        return context;
    };

    if (epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_EXT_platform_base")) {
        if (epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_MESA_platform_surfaceless")) {
            if (auto context = attempt(eglGetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA, nullptr, nullptr),
                                       "EGL surfaceless")) {
                return context;
            }
        } else {
            tried = "EGL surfaceless: no EGL_MESA_platform_surfaceless";
        }
        if (epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_EXT_device_enumeration") &&
            epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_EXT_platform_device")) {
            std::array<EGLDeviceEXT, 16> devices{};
            EGLint count = 0;
            eglQueryDevicesEXT(static_cast<EGLint>(devices.size()), devices.data(), &count);
            for (EGLint i = 0; i < count; ++i) {
                if (auto context = attempt(eglGetPlatformDisplayEXT(EGL_PLATFORM_DEVICE_EXT,
                                                                    devices[static_cast<std::size_t>(i)], nullptr),
                                           fmt::format("EGL device {}", i))) {
                    return context;
                }
            }
            if (count == 0) tried += "; EGL device: none found";
        } else {
            tried += "; EGL device: no EGL_EXT_platform_device";
        }
    } else {
        tried = "EGL: no EGL_EXT_platform_base (is an EGL driver installed?)";
    }
    throw DeviceError("no OpenGL 4.3 core device; tried " + tried);
}

std::unique_ptr<Context> Context::adopt(std::function<void(bool)> makeCurrent, const std::string& platform,
                                        bool debug) {
    std::unique_ptr<Context> context(new Context);
    context->makeCurrent_ = std::move(makeCurrent);
    context->debug_ = debug;
    context->makeCurrent();
    GLint profile = 0;
    if (epoxy_gl_version() >= 32) glGetIntegerv(GL_CONTEXT_PROFILE_MASK, &profile);
    if (epoxy_gl_version() < 43 || (profile & GL_CONTEXT_CORE_PROFILE_BIT) == 0)
        throw DeviceError(fmt::format("no OpenGL 4.3 core device; {} is {}", platform, glString(GL_VERSION)));
    context->readInfo(platform);
    context->listen();
    return context;
}

Context::~Context() {
    // The driver must not call back into what is gone, if the context lives on.
    if (!destroy_) glDebugMessageCallback(nullptr, nullptr);
    makeCurrent_(false);
    if (destroy_) destroy_();
}

void Context::makeCurrent() {
    makeCurrent_(true);
}

void Context::readInfo(const std::string& platform) {
    info_.platform = platform;
    info_.vendor = glString(GL_VENDOR);
    info_.renderer = glString(GL_RENDERER);
    info_.version = glString(GL_VERSION);
    info_.glslVersion = glString(GL_SHADING_LANGUAGE_VERSION);
    for (const char* name : {"llvmpipe", "softpipe", "swrast", "SWR", "Software Rasterizer"}) {
        info_.softwareRasterizer = info_.softwareRasterizer || info_.renderer.find(name) != std::string::npos;
    }
    info_.clearTexture = epoxy_gl_version() >= 44 || epoxy_has_gl_extension("GL_ARB_clear_texture");
    info_.max2DTextureSize = glInt(GL_MAX_TEXTURE_SIZE);
    info_.max3DTextureSize = glInt(GL_MAX_3D_TEXTURE_SIZE);
    info_.maxCubeSize = glInt(GL_MAX_CUBE_MAP_TEXTURE_SIZE);
    info_.maxArrayLayers = glInt(GL_MAX_ARRAY_TEXTURE_LAYERS);
    GLint64 ssbo = 0;
    glGetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &ssbo);
    info_.maxSsboBytes = ssbo;
    info_.maxImageUniforms = glInt(GL_MAX_COMPUTE_IMAGE_UNIFORMS);
    info_.maxFragmentImageUniforms = glInt(GL_MAX_FRAGMENT_IMAGE_UNIFORMS);
    info_.maxTextureUnits = glInt(GL_MAX_TEXTURE_IMAGE_UNITS);
    info_.maxComputeInvocations = glInt(GL_MAX_COMPUTE_WORK_GROUP_INVOCATIONS);
    info_.maxGeometryInvocations = glInt(GL_MAX_GEOMETRY_SHADER_INVOCATIONS);
    info_.maxDrawBuffers = glInt(GL_MAX_DRAW_BUFFERS);

    // OpenGL 4.3 guarantees neither storage blocks nor images outside compute shaders.
    const auto atLeast = [&](GLenum limit, const char* name, int needed) {
        if (glInt(limit) < needed)
            throw DeviceError(fmt::format("{}: {} is {}, {} are needed", info_.renderer, name, glInt(limit), needed));
    };
    atLeast(GL_MAX_VERTEX_SHADER_STORAGE_BLOCKS, "GL_MAX_VERTEX_SHADER_STORAGE_BLOCKS", 2);
    atLeast(GL_MAX_FRAGMENT_SHADER_STORAGE_BLOCKS, "GL_MAX_FRAGMENT_SHADER_STORAGE_BLOCKS", 2);
    atLeast(GL_MAX_FRAGMENT_IMAGE_UNIFORMS, "GL_MAX_FRAGMENT_IMAGE_UNIFORMS", 1);
}

void Context::listen() {
    glEnable(GL_DEBUG_OUTPUT);
    if (debug_) glEnable(GL_DEBUG_OUTPUT_SYNCHRONOUS);
    // Only errors and misuse are of interest; drivers send performance hints and group markers as lower severities.
    glDebugMessageControl(GL_DONT_CARE, GL_DONT_CARE, GL_DONT_CARE, 0, nullptr, GL_FALSE);
    glDebugMessageControl(GL_DONT_CARE, GL_DONT_CARE, GL_DEBUG_SEVERITY_HIGH, 0, nullptr, GL_TRUE);
    const auto callback = [](GLenum source, GLenum, GLuint, GLenum severity, GLsizei, const GLchar* text,
                             const void* user) {
        // A shader that does not compile is reported by ShaderLibrary, with file and line.
        if (severity != GL_DEBUG_SEVERITY_HIGH || source == GL_DEBUG_SOURCE_SHADER_COMPILER) return;
        static_cast<Context*>(const_cast<void*>(user))->onMessage(text);
    };
    glDebugMessageCallback(callback, this);
}

void Context::onMessage(const std::string& text) {
    if (!debug_) {
        log::warn("OpenGL: {}", text);
        return;
    }
    const std::scoped_lock lock(mutex_);
    errors_.push_back(text);
}

void Context::checkErrors() {
    const std::scoped_lock lock(mutex_);
    if (errors_.empty()) return;
    std::string all;
    for (const std::string& line : std::exchange(errors_, {})) all += (all.empty() ? "" : "\n") + line;
    throw GlError("OpenGL: " + all);
}

}  // namespace voxcone::gl
