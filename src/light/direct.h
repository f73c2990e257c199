// Direct light from analytic lights at every visible surface, with shadows.
#pragma once

#include <cstdint>
#include <functional>

#include "gl/pass_timers.h"
#include "gl/program.h"
#include "gl/shader_library.h"
#include "gl/texture.h"
#include "light/shadow_maps.h"

namespace voxcone {

class DirectPass {
  public:
    /// `gbufferDefines`: those that frame/gbuffer.glsl is compiled with. Size in pixels of the G-buffer.
    DirectPass(const gl::ShaderLibrary& shaders, const gl::Defines& gbufferDefines, int width, int height);

    /// Pass "direct". `bindGBuffer` binds what frame/gbuffer.glsl reads to the given program, at units below
    /// kShadowDepthUnit. `maps` must have lights (lightCount() > 0): without any there is no direct light and no need
    /// for this pass. On return texture() may be sampled or loaded.
    void run(const ShadowMaps& maps, const std::function<void(gl::Program&)>& bindGBuffer, gl::PassTimers& timers);

    /// Another size of the G-buffer.
    void resize(int width, int height);

    /// Radiance towards the eye in W/(m² sr), diffuse and specular together; black background. RGBA32F: the sum with
    /// what else reaches the eye is stored once more, and highlights may exceed the range of a half.
    const gl::Texture& texture() const { return texture_; }
    std::uint64_t bytes() const { return texture_.bytes(); }

  private:
    gl::Program program_;
    gl::Texture texture_;
};

}  // namespace voxcone
