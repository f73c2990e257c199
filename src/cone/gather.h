// What the picture's pixels gather by cones: diffuse light with openness, specular light.
#pragma once

#include <functional>

#include "cone/cone_uniforms.h"
#include "cone/sample_counter.h"
#include "gl/pass_timers.h"
#include "gl/pieces.h"

namespace voxcone {

/// What a surface reads where two levels of the clipmap blend: the blend, or one level alone.
enum class SeamSide { blended, finer, coarser };

/// Binds what frame/gbuffer.glsl reads to a program, at texture units from `firstUnit`.
using BindGBuffer = std::function<void(gl::Program&, int firstUnit)>;

/// True abandons the pass.
using gl::Stop;

/// Work groups of 8×8 pixels that a pass which may be abandoned begins with: gl::inPieces.
constexpr int kFirstPiece = 8;

// What the programs that trace a pixel's cones need, also that which asks what they meet (inspect.h): defines with
// those of frame/gbuffer.glsl, and uniforms from texture unit `unit` on, kConeUnits of them.
gl::Defines diffuseDefines(const Settings& settings, const Voxels& voxels, const Sky& sky,
                           const gl::Defines& gbufferDefines);
void setDiffuseUniforms(gl::Program& program, const Settings& settings, const Sky& sky, const RadianceVolume& volume,
                        int unit);
gl::Defines specularDefines(const Settings& settings, const Voxels& voxels, const Sky& sky,
                            const gl::Defines& gbufferDefines);
void setSpecularUniforms(gl::Program& program, const Settings& settings, const Sky& sky, const RadianceVolume& volume,
                         int unit);

class DiffusePass {
  public:
    /// `gbufferDefines`: those that frame/gbuffer.glsl is compiled with. Size in pixels of the G-buffer.
    DiffusePass(const gl::ShaderLibrary& shaders, const Settings& settings, const Voxels& voxels, const Sky& sky,
                const gl::Defines& gbufferDefines, int width, int height);

    /// Passes "cones: diffuse" and "cones: filter". `side`: without a blend, to measure the seam. When `stop` ends them
    /// the texture holds nothing of use.
    void run(const RadianceVolume& volume, const Sky& sky, const BindGBuffer& bindGBuffer, gl::PassTimers& timers,
             SeamSide side = SeamSide::blended, const Stop& stop = {});

    /// Another size of the G-buffer.
    void resize(int width, int height);

    /// Places that the cones of `run` look at: sample_counter.h.
    std::uint64_t countSamples(const RadianceVolume& volume, const Sky& sky, const BindGBuffer& bindGBuffer);

    /// RGBA32F: indirect diffuse radiance towards the eye, W/(m² sr), and openness (1 on the background).
    const gl::Texture& texture() const { return diffuse_; }
    std::uint64_t bytes() const { return gathered_.bytes() + diffuse_.bytes(); }

  private:
    void gather(gl::Program& program, const RadianceVolume& volume, const Sky& sky, const BindGBuffer& bindGBuffer,
                SeamSide side, const Stop& stop);

    Settings settings_;
    SampleCounter samples_;
    gl::Program gather_, filter_;
    gl::Texture gathered_, diffuse_;
    int piece_ = kFirstPiece;
};

class SpecularPass {
  public:
    /// `specularAlbedo`: light/specular_table.h; it must outlive this pass.
    SpecularPass(const gl::ShaderLibrary& shaders, const Settings& settings, const Voxels& voxels, const Sky& sky,
                 const gl::Defines& gbufferDefines, const gl::Texture& specularAlbedo, int width, int height);

    /// Passes "cones: specular" and "cones: specular filter". When `stop` ends them the texture holds nothing of use.
    void run(const RadianceVolume& volume, const Sky& sky, const BindGBuffer& bindGBuffer, gl::PassTimers& timers,
             const Stop& stop = {});

    /// Another size of the G-buffer.
    void resize(int width, int height);

    /// Places that the cones of `run` look at: sample_counter.h.
    std::uint64_t countSamples(const RadianceVolume& volume, const Sky& sky, const BindGBuffer& bindGBuffer);

    /// RGBA32F: indirect specular radiance towards the eye, W/(m² sr).
    const gl::Texture& texture() const { return specular_; }
    std::uint64_t bytes() const { return gathered_.bytes() + specular_.bytes(); }

  private:
    void gather(gl::Program& program, const RadianceVolume& volume, const Sky& sky, const BindGBuffer& bindGBuffer,
                const Stop& stop);

    Settings settings_;
    const gl::Texture& specularAlbedo_;
    SampleCounter samples_;
    gl::Program gather_, filter_;
    gl::Texture gathered_, specular_;
    int piece_ = kFirstPiece;
};

/// Visibility of all lights through cones: the channel `soft_shadow`.
class SoftShadowPass {
  public:
    SoftShadowPass(const gl::ShaderLibrary& shaders, const Settings& settings, const Voxels& voxels,
                   const gl::Defines& gbufferDefines, int width, int height);

    /// Pass "cones: soft shadow". `bindLights` binds what light/lights.glsl reads to the given program.
    void run(const RadianceVolume& volume, const std::function<void(gl::Program&)>& bindLights,
             const BindGBuffer& bindGBuffer, gl::PassTimers& timers);

    /// Another size of the G-buffer.
    void resize(int width, int height);

    /// R32F: share of the irradiance without shadows that arrives, 0 to 1; 1 on the background.
    const gl::Texture& texture() const { return visibility_; }

  private:
    Settings settings_;
    gl::Program program_;
    gl::Texture visibility_;
};

}  // namespace voxcone
