// The surfaces that a camera sees.
#pragma once

#include <cstdint>
#include <string>

#include "gl/framebuffer.h"
#include "gl/gpu_scene.h"
#include "gl/pass_timers.h"
#include "gl/program.h"
#include "gl/shader_library.h"
#include "gl/texture.h"
#include "metric/image.h"
#include "scene/scene.h"

namespace voxcone {

/// A camera as shaders see it: positions relative to the scene's origin, pixels counted from the lower left corner.
struct CameraView {
    int width = 0, height = 0;  ///< of the G-buffer: output × supersample
    glm::vec3 position{0};
    glm::mat4 clipFromWorld{1};  ///< clip w is the distance along the view
    glm::mat3 rays{1};           ///< times (x, y, 1) in pixels: ray whose length along the view is 1
    glm::vec2 clipRange{0};      ///< the camera's own near and far distance (0 and FLT_MAX when it has none)
};

/// Depth is spread between the nearest and farthest corner of `worldBounds` along the view, but over no more than a
/// ratio of 1000: what is nearer is drawn, only its order among itself is not resolved.
CameraView cameraView(const Camera& worldCamera, const glm::dvec3& origin, const Bounds& worldBounds, int width,
                      int height);

/// Per pixel: shading and geometric normal (octahedral, 16 bit snorm), metallic and roughness, distance along the view
/// as float (position is rebuilt from it), base colour and F90, dielectric F0, and emission where anything emits. Where
/// anything transmits also what does, and behind it the nearest back faces of solids (cone/refraction.h).
/// Shaders read it with frame/gbuffer.glsl.
///  - Back faces of single-sided materials are not drawn; double-sided ones turn their normals to the camera.
///  - MASK is tested against its cutoff. BLEND, and MASK where its texture is minified, is a deterministic screen door:
///  a
///    hash of pixel, object and distance.
class GBuffer {
  public:
    GBuffer(const gl::ShaderLibrary& shaders, const gl::GpuScene& scene, int width, int height);

    /// Another size.
    void resize(int width, int height);

    /// Pass "gbuffer". `scene` is the one of the constructor, its origin the one of `view`.
    void draw(const gl::GpuScene& scene, const CameraView& view, gl::PassTimers& timers);

    /// Texture units that `bind` takes.
    static constexpr int kUnits = 7;
    /// For programs that include frame/gbuffer.glsl, compiled with `defines()`: textures at units `firstUnit`… and
    /// camera.
    void bind(gl::Program& program, int firstUnit) const;
    gl::Defines defines() const;

    int width() const { return width_; }
    int height() const { return height_; }
    const CameraView& view() const { return view_; }
    std::uint64_t bytes() const;

    /// albedo, normal (world), depth (distance along the view, 0 = background), position (world) or emission of the
    /// last draw, mean over `supersample`² samples (over those that hit something for depth and position).
    Image channel(const std::string& name, int supersample);

  private:
    int transmissionLocation() const { return emission_ ? 4 : 3; }
    void drawExits(const gl::GpuScene& scene, const CameraView& view);

    int width_ = 0, height_ = 0;
    bool emission_, transmission_;
    glm::dvec3 origin_{0};
    CameraView view_;
    gl::Texture surface_, baseColor_, specular_, emissionTexture_, transmissionTexture_, scattered_, depth_, exits_;
    gl::Framebuffer framebuffer_, exitFramebuffer_;
    gl::Program opaque_, alphaTested_, exitProgram_, channels_;
};

/// The first `channels` components of a float texture as an image, row 0 on top.
Image imageFromTexture(const gl::Texture& texture, int channels);

}  // namespace voxcone
