#include "frame/gbuffer.h"

#include <algorithm>
#include <array>
#include <cfloat>
#include <cmath>

#include "core/check.h"
#include "gl/bindings.h"

namespace voxcone {
namespace {

/// Largest ratio of far to near plane: keeps neighbouring depths at the far plane 6e-8 · 1000 of its distance apart.
constexpr double kDepthRatio = 1000;

gl::DrawState depthTested() {
    gl::DrawState state;
    state.depthTest = true;
    state.depthWrite = true;
    state.depthClamp = true;
    state.clipDistances = 2;
    return state;
}

/// Uniforms of frame/gbuffer.vert.
void setView(gl::Program& program, const CameraView& view) {
    program.set("u_clipFromWorld", view.clipFromWorld);
    program.set("u_cameraPosition", view.position);
    program.set("u_clipRange", view.clipRange);
}

constexpr std::array<const char*, 5> kChannels = {"albedo", "normal", "depth", "position", "emission"};

}  // namespace

CameraView cameraView(const Camera& worldCamera, const glm::dvec3& origin, const Bounds& worldBounds, int width,
                      int height) {
    // Rows of a view matrix are the camera's axes. Its translation is replaced: the difference of two far places must
    // be taken before anything is rotated.
    const glm::dmat4 axes = viewMatrix(worldCamera);
    const glm::dmat3 rotation(axes);
    const glm::dvec3 right(axes[0][0], axes[1][0], axes[2][0]), up(axes[0][1], axes[1][1], axes[2][1]);
    const glm::dvec3 forward = -glm::dvec3(axes[0][2], axes[1][2], axes[2][2]);
    const glm::dvec3 position = worldCamera.position - origin;

    double nearest = 0, farthest = 0;
    if (!worldBounds.empty()) {
        nearest = 1e300;
        for (int corner = 0; corner < 8; ++corner) {
            const glm::dvec3 p((corner & 1) ? worldBounds.max.x : worldBounds.min.x,
                               (corner & 2) ? worldBounds.max.y : worldBounds.min.y,
                               (corner & 4) ? worldBounds.max.z : worldBounds.min.z);
            const double along = glm::dot(p - worldCamera.position, forward);
            nearest = std::min(nearest, along);
            farthest = std::max(farthest, along);
        }
    }
    if (farthest <= 0) farthest = 1;  // nothing in front of the camera
    const double farPlane = 1.001 * farthest;
    const double nearPlane = std::clamp(0.999 * nearest, farPlane / kDepthRatio, 0.5 * farPlane);

    const double tanY = std::tan(glm::radians(0.5 * worldCamera.verticalFovDeg));
    const double tanX = tanY * width / height;
    glm::dmat4 projection(0);
    projection[0][0] = 1 / tanX;
    projection[1][1] = 1 / tanY;
    projection[2][2] = -(farPlane + nearPlane) / (farPlane - nearPlane);
    projection[2][3] = -1;
    projection[3][2] = -2 * farPlane * nearPlane / (farPlane - nearPlane);
    glm::dmat4 view(rotation);
    view[3] = glm::dvec4(-(rotation * position), 1);

    CameraView result;
    result.width = width;
    result.height = height;
    result.position = glm::vec3(position);
    result.clipFromWorld = glm::mat4(projection * view);
    result.rays =
        glm::mat3(glm::dmat3(right * (2 * tanX / width), up * (2 * tanY / height), forward - tanX * right - tanY * up));
    result.clipRange = glm::vec2(worldCamera.near, worldCamera.far > 0 ? static_cast<float>(worldCamera.far) : FLT_MAX);
    return result;
}

GBuffer::GBuffer(const gl::ShaderLibrary& shaders, const gl::GpuScene& scene, int width, int height)
    : emission_(scene.anyEmission()), transmission_(scene.anyTransmission()) {
    resize(width, height);
    if (transmission_) exitProgram_ = shaders.graphics({"frame/gbuffer.vert", "frame/exits.frag"});

    const auto& batches = scene.batches();
    const bool anyOpaque = std::any_of(batches.begin(), batches.end(),
                                       [](const gl::Batch& batch) { return batch.alphaMode == AlphaMode::opaque; });
    const std::vector<std::string> stages = {"frame/gbuffer.vert", "frame/gbuffer.frag"};
    if (anyOpaque) opaque_ = shaders.graphics(stages, defines());
    if (scene.anyAlphaTest()) {
        gl::Defines alpha = defines();
        alpha["ALPHA_TEST"] = "1";
        alphaTested_ = shaders.graphics(stages, alpha);
    }
    channels_ = shaders.compute("frame/channels.comp", defines());
}

void GBuffer::resize(int width, int height) {
    width_ = width;
    height_ = height;
    framebuffer_ = gl::Framebuffer();
    surface_ = gl::Texture::create2D(GL_RGBA32UI, width, height);
    baseColor_ = gl::Texture::create2D(GL_RGBA16, width, height);
    specular_ = gl::Texture::create2D(GL_RGBA16, width, height);
    depth_ = gl::Texture::create2D(GL_DEPTH_COMPONENT32F, width, height);
    framebuffer_.attachColor(0, surface_);
    framebuffer_.attachColor(1, baseColor_);
    framebuffer_.attachColor(2, specular_);
    if (emission_) {
        // 32 bits: emitters of any strength, and software rasterisers truncate when they store 16-bit floats.
        emissionTexture_ = gl::Texture::create2D(GL_RGBA32F, width, height);
        framebuffer_.attachColor(3, emissionTexture_);
    }
    if (transmission_) {
        transmissionTexture_ = gl::Texture::create2D(GL_RGBA32UI, width, height);
        scattered_ = gl::Texture::create2D(GL_RGBA16, width, height);
        exits_ = gl::Texture::create2D(GL_RG32UI, width, height);
        framebuffer_.attachColor(transmissionLocation(), transmissionTexture_);
        framebuffer_.attachColor(transmissionLocation() + 1, scattered_);
        exitFramebuffer_ = gl::Framebuffer();
        exitFramebuffer_.attachColor(0, exits_);
        exitFramebuffer_.attachDepth(depth_);
    }
    framebuffer_.attachDepth(depth_);
}

gl::Defines GBuffer::defines() const {
    gl::Defines defines;
    if (emission_) defines["GBUFFER_EMISSION"] = "1";
    if (transmission_) {
        defines["GBUFFER_TRANSMISSION"] = std::to_string(transmissionLocation());
        defines["GBUFFER_SCATTERED"] = std::to_string(transmissionLocation() + 1);
    }
    return defines;
}

void GBuffer::draw(const gl::GpuScene& scene, const CameraView& view, gl::PassTimers& timers) {
    VOXCONE_CHECK(view.width == width_ && view.height == height_, "view of {}×{} in a G-buffer of {}×{}", view.width,
                  view.height, width_, height_);
    const auto pass = timers.pass("gbuffer");
    view_ = view;
    origin_ = scene.origin();
    framebuffer_.clearColorUint(0, glm::uvec4(0));
    framebuffer_.clearColor(1, glm::vec4(0));
    framebuffer_.clearColor(2, glm::vec4(0));
    if (emission_) framebuffer_.clearColor(3, glm::vec4(0));
    if (transmission_) {
        framebuffer_.clearColorUint(transmissionLocation(), glm::uvec4(0));
        framebuffer_.clearColor(transmissionLocation() + 1, glm::vec4(0));
    }
    framebuffer_.clearDepth(1);

    gl::DrawState state = depthTested();
    for (gl::Program* program : {&opaque_, &alphaTested_}) {
        if (!*program) continue;
        setView(*program, view);
        for (const bool doubleSided : {false, true}) {
            state.cullBack = !doubleSided;
            state.apply();
            scene.draw(*program, [&](const gl::Batch& batch) {
                return batch.doubleSided == doubleSided &&
                       (batch.alphaMode != AlphaMode::opaque) == (program == &alphaTested_);
            });
        }
    }
    if (transmission_) drawExits(scene, view);
    gl::DrawState{}.apply();
}

void GBuffer::drawExits(const gl::GpuScene& scene, const CameraView& view) {
    exitFramebuffer_.clearColorUint(0, glm::uvec4(0));
    exitFramebuffer_.clearDepth(1);
    depthTested().apply();
    setView(exitProgram_, view);
    scene.draw(exitProgram_, [](const gl::Batch& batch) { return batch.transmits && batch.closed; });
}

void GBuffer::bind(gl::Program& program, int firstUnit) const {
    const auto texture = [&](const char* name, const gl::Texture& source, int offset) {
        source.bindTo(firstUnit + offset);
        program.set(name, firstUnit + offset);
    };
    texture("u_gbufferSurface", surface_, 0);
    texture("u_gbufferBaseColor", baseColor_, 1);
    texture("u_gbufferSpecular", specular_, 2);
    if (emission_) texture("u_gbufferEmission", emissionTexture_, 3);
    if (transmission_) {
        texture("u_gbufferTransmission", transmissionTexture_, 4);
        texture("u_gbufferScattered", scattered_, 5);
        texture("u_exits", exits_, 6);
    }
    program.set("u_cameraPosition", view_.position);
    program.set("u_cameraRays", view_.rays);
}

std::uint64_t GBuffer::bytes() const {
    return surface_.bytes() + baseColor_.bytes() + specular_.bytes() + emissionTexture_.bytes() +
           transmissionTexture_.bytes() + scattered_.bytes() + exits_.bytes() + depth_.bytes();
}

Image GBuffer::channel(const std::string& name, int supersample) {
    const auto found = std::find(kChannels.begin(), kChannels.end(), name);
    VOXCONE_CHECK(found != kChannels.end(), "the G-buffer has no channel {}", name);
    VOXCONE_CHECK(supersample > 0 && width_ % supersample == 0 && height_ % supersample == 0, "{}×{} by {}", width_,
                  height_, supersample);
    const gl::Texture output = gl::Texture::create2D(GL_RGBA32F, width_ / supersample, height_ / supersample);
    bind(channels_, gl::kPassTextureUnit);
    output.bindImage(0, 0, GL_WRITE_ONLY);
    channels_.set("u_channel", static_cast<int>(found - kChannels.begin()));
    channels_.set("u_supersample", supersample);
    gl::dispatch(channels_, gl::groupsFor(output.width(), 8), gl::groupsFor(output.height(), 8), 1);
    if (name != "position") return imageFromTexture(output, name == "depth" ? 1 : 3);

    const Image relative = imageFromTexture(output, 4);
    Image world(relative.width, relative.height, 3);
    for (int y = 0; y < world.height; ++y) {
        for (int x = 0; x < world.width; ++x) {
            const float* p = relative.pixel(x, y);
            if (p[3] <= 0) continue;  // background stays 0
            for (int k = 0; k < 3; ++k) {
                world.pixel(x, y)[k] = static_cast<float>(static_cast<double>(p[k]) + origin_[k]);
            }
        }
    }
    return world;
}

Image imageFromTexture(const gl::Texture& texture, int channels) {
    const int components = texture.components();
    VOXCONE_CHECK(channels <= components, "{} of {} components", channels, components);
    const std::vector<float> data = texture.readFloats();
    Image image(texture.width(), texture.height(), channels);
    for (int y = 0; y < image.height; ++y) {
        for (int x = 0; x < image.width; ++x) {
            const auto texel = static_cast<std::size_t>(image.height - 1 - y) * static_cast<std::size_t>(image.width) +
                               static_cast<std::size_t>(x);
            std::copy_n(data.data() + texel * static_cast<std::size_t>(components), channels, image.pixel(x, y));
        }
    }
    return image;
}

}  // namespace voxcone
