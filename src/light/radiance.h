// Radiance of the voxels: direct light and emission of every face that holds a surface, then bounces between them.
#pragma once

#include <functional>

#include "cone/cone_uniforms.h"
#include "core/settings.h"
#include "gl/pass_timers.h"
#include "gl/shader_library.h"
#include "voxelize/voxelizer.h"

namespace voxcone {

class RadianceField {
  public:
    /// `lights`: the scene has analytic lights. Compiles for what settings and sky need.
    RadianceField(const gl::ShaderLibrary& shaders, const Settings& settings, const Sky& sky, bool lights);

    /// Lights `voxels`. `bindLights` binds what light/lights.glsl reads to the given program.
    void update(const Voxels& voxels, const Sky& sky, const std::function<void(gl::Program&)>& bindLights,
                gl::PassTimers& timers);

    /// Valid until the next update; `voxels` must still live.
    RadianceVolume volume(const Voxels& voxels) const { return {&voxels, &volume_, scale_}; }
    const gl::Texture& texture() const { return volume_; }

    /// Radiances that were beyond the range of their storage at the last update.
    std::uint32_t clamped() const { return counters_.clamped; }
    std::uint64_t bytes() const { return volume_.bytes() + radiance_.bytes() + direct_.bytes(); }

    /// RGB radiance and coverage of each face of each voxel, in the order of Voxels::list.
    const gl::Buffer& faces() const { return radiance_; }

  private:
    void store(const Voxels& voxels);

    Settings settings_;
    bool lights_;
    gl::Program inject_, bounce_, store_, mip_;
    gl::Texture volume_;
    gl::Buffer radiance_, direct_;
    VoxelCounters counters_;
    float scale_ = 1;
};

}  // namespace voxcone
