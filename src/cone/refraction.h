// Light that comes through the visible surface from behind: the channel `transmission`.
#pragma once

#include "cone/gather.h"

namespace voxcone {

// As diffuseDefines and setDiffuseUniforms. `scene` transmits (gl::GpuScene::anyTransmission).
gl::Defines refractionDefines(const Settings& settings, const Scene& scene, const Voxels& voxels, const Sky& sky,
                              const gl::Defines& gbufferDefines);
void setRefractionUniforms(gl::Program& program, const Settings& settings, const Sky& sky, const RadianceVolume& volume,
                           int unit);

/// Beams: one cone from where the eye's ray leaves the body. Thin sheets let it pass straight; solids refract it where
/// it enters and where it leaves, which is looked for among the back faces that the G-buffer holds (after Wyman, "An
/// Approximate Image-Space Approach for Interactive Refraction", 2005), and absorb along the way between. Diffuse
/// transmission: the cone set of diffuse light over the hemisphere behind. All cones see voxels and sky.
class RefractionPass {
  public:
    /// `scene` transmits (gl::GpuScene::anyTransmission). `gbufferDefines`: those that frame/gbuffer.glsl is compiled
    /// with. `specularAlbedo`: light/specular_table.h; it must outlive this pass. Size in pixels of the G-buffer.
    RefractionPass(const gl::ShaderLibrary& shaders, const Settings& settings, const Scene& scene, const Voxels& voxels,
                   const Sky& sky, const gl::Defines& gbufferDefines, const gl::Texture& specularAlbedo, int width,
                   int height);

    /// Pass "cones: refraction".
    void run(const RadianceVolume& volume, const Sky& sky, const BindGBuffer& bindGBuffer, gl::PassTimers& timers);

    /// Places that the cones of `run` look at: sample_counter.h.
    std::uint64_t countSamples(const RadianceVolume& volume, const Sky& sky, const BindGBuffer& bindGBuffer);

    /// Another size of the G-buffer.
    void resize(int width, int height);

    /// RGBA32F: transmitted radiance towards the eye, W/(m² sr), without that of analytic lights.
    const gl::Texture& texture() const { return transmission_; }

  private:
    void gather(gl::Program& program, const RadianceVolume& volume, const Sky& sky, const BindGBuffer& bindGBuffer);

    Settings settings_;
    const gl::Texture& specularAlbedo_;
    SampleCounter samples_;
    gl::Program program_;
    gl::Texture transmission_;
};

}  // namespace voxcone
