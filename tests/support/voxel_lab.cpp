#include "support/voxel_lab.h"

namespace voxcone::test {

VoxelLab::VoxelLab(gl::Context& context, const Scene& scene, const Settings& settings, double voxelSize)
    : settings_(settings),
      gpuScene_(scene),
      grid_(fitGrid(scene.bounds(), settings.voxel.resolution, settings.voxel.margin, voxelSize)),
      sky_{scene.environment.color},
      voxelizer_(context, shaders_, gpuScene_, settings),
      field_(shaders_, settings, sky_, false) {
    gpuScene_.setOrigin(grid_.origin);
    voxels_ = voxelizer_.voxelize(gpuScene_, grid_, timers_);
    field_.update(
        voxels_, sky_, [](gl::Program&) {}, timers_);
}

std::vector<ConeProbeResult> VoxelLab::gather(const std::vector<ConeProbe>& probes) {
    return ConeProber(shaders_, settings_, sky_).gather(probes, field_.volume(voxels_), sky_);
}

}  // namespace voxcone::test
