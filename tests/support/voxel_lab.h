// Voxelizes a scene, lights it and gathers at points, through the renderer's own passes: for tests with exact answers.
#pragma once

#include "cone/probe.h"
#include "core/settings.h"
#include "light/radiance.h"
#include "support/gl_context.h"
#include "voxelize/voxelizer.h"

namespace voxcone::test {

class VoxelLab {
  public:
    /// The grid fits the scene unless `voxelSize` is given. The sky is the scene's constant environment colour.
    VoxelLab(gl::Context& context, const Scene& scene, const Settings& settings, double voxelSize = 0);

    std::vector<ConeProbeResult> gather(const std::vector<ConeProbe>& probes);

    const Voxels& voxels() const { return voxels_; }
    const VoxelGrid& grid() const { return grid_; }
    const RadianceField& field() const { return field_; }
    Voxelizer& voxelizer() { return voxelizer_; }

  private:
    Settings settings_;
    gl::ShaderLibrary shaders_;
    gl::GpuScene gpuScene_;
    VoxelGrid grid_;
    Sky sky_;
    gl::PassTimers timers_{gl::TimerMode::finish};
    Voxelizer voxelizer_;
    RadianceField field_;
    Voxels voxels_;
};

}  // namespace voxcone::test
