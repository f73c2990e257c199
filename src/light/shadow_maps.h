// The scene's lights and their shadow maps on the device (light_layout.h says which maps there are).
#pragma once

#include <cstdint>
#include <optional>

#include "core/settings.h"
#include "gl/buffer.h"
#include "gl/context.h"
#include "gl/gpu_scene.h"
#include "gl/pass_timers.h"
#include "gl/program.h"
#include "gl/shader_library.h"
#include "gl/texture.h"
#include "light/light_layout.h"

namespace voxcone {

/// Storage blocks and texture units of shaders/light/lights.glsl. They are chosen not to meet those of the voxels
/// (cascade/buffers.h) in one shader, except for records, which light does not read beside lights.
constexpr int kLightStorage = 2;
constexpr int kShadowViewStorage = 4;
constexpr int kShadowDepthUnit = 15;

/// One depth atlas for all lights, drawn when something moved. Both sides of every surface cast shadows; masked
/// materials where they are opaque, blended ones as a screen door of their opacity.
class ShadowMaps {
  public:
    /// Compiles nothing and allocates nothing yet: update() does, for the lights that exist.
    ShadowMaps(const gl::Context& context, const gl::ShaderLibrary& shaders, const Settings::Light& settings);

    /// Brings lights and maps to the time and origin of `scene`; does nothing when they have not changed since. The
    /// draw is the pass "shadow_maps". True when light or shadow has changed. Throws DeviceError when they do not fit
    /// in memory.
    bool update(const gl::GpuScene& scene, gl::PassTimers& timers);

    /// Draws again with the next update(), for timing.
    void invalidate() { state_.reset(); }

    /// Lights of the last update. Without any, programs need not include lights.glsl, and bind() must not be called.
    int lightCount() const { return static_cast<int>(layout_.lights.size()); }

    /// For programs that include shaders/light/lights.glsl: binds records and atlas, sets u_lightCount.
    void bind(gl::Program& program) const;

    const LightLayout& layout() const { return layout_; }
    /// Depth atlas, 32-bit float; empty without lights or geometry.
    const gl::Texture& atlas() const { return atlas_; }
    std::uint64_t bytes() const { return atlas_.bytes() + lightBuffer_.bytes() + viewBuffer_.bytes(); }

  private:
    void layOut(const gl::GpuScene& scene);
    void draw(const gl::GpuScene& scene);

    struct State {
        double time;                ///< of what moves
        std::vector<Light> lights;  ///< in the world
        glm::dvec3 origin;
        bool operator==(const State&) const = default;
    };

    const gl::Context& context_;
    const gl::ShaderLibrary& shaders_;
    Settings::Light settings_;
    std::optional<Bounds> bounds_;  ///< of the scene over all times
    std::optional<State> state_;    ///< of the maps; none yet, or forgotten
    LightLayout layout_;
    gl::Texture atlas_;
    gl::Buffer lightBuffer_, viewBuffer_;
    gl::Program opaqueProgram_, alphaProgram_;
};

}  // namespace voxcone
