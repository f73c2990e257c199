// From layers of light to the picture: composite, supersamples to pixels, tone curve.
#pragma once

#include <vector>

#include "cone/cone_uniforms.h"
#include "core/settings.h"
#include "frame/gbuffer.h"
#include "gl/gpu_environment.h"
#include "gl/pass_timers.h"
#include "gl/program.h"
#include "gl/shader_library.h"
#include "gl/texture.h"
#include "metric/image.h"

namespace voxcone {

/// The environment as cone and frame shaders take it; it refers to `environment`'s panorama.
Sky skyOf(const gl::GpuEnvironment& environment);

/// Adds up radiance in the G-buffer's resolution.
class Composite {
  public:
    /// `sky` decides the variant; its kind must not change afterwards.
    Composite(const gl::ShaderLibrary& shaders, const GBuffer& gbuffer, const Sky& sky);

    /// Another size of the G-buffer.
    void resize(int width, int height);

    /// Pass "composite": beauty = (sum of `layers` + emission, or sky where nothing was hit) · 2^exposure. At most
    /// three layers of outgoing radiance (direct, indirect diffuse, indirect specular), all of the G-buffer's size.
    void run(const GBuffer& gbuffer, const Sky& sky, const std::vector<const gl::Texture*>& layers, double exposure,
             gl::PassTimers& timers);

    /// RGBA32F, linear radiance scaled by the exposure.
    const gl::Texture& beauty() const { return beauty_; }

  private:
    gl::Program program_;
    gl::Texture beauty_;
};

/// Reads textures of the G-buffer's size back in output resolution.
class Readout {
  public:
    explicit Readout(const gl::ShaderLibrary& shaders);

    /// Box mean over `supersample`² texels of the first `channels` components of `source`.
    Image read(const gl::Texture& source, int channels, int supersample);
    /// The same through a tone curve (after the mean): linear display-referred in [0,1], three channels.
    Image display(const gl::Texture& beauty, ToneMap curve, int supersample);
    /// What display() reads back, left on the device as RGBA32F and ready to be fetched.
    gl::Texture displayTexture(const gl::Texture& beauty, ToneMap curve, int supersample);

  private:
    gl::Texture run(gl::Program& program, const gl::Texture& source, int supersample);
    gl::Program mean_, toneMap_;
};

}  // namespace voxcone
