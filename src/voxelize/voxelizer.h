// Scene to voxels: conservative rasterisation along each triangle's dominant axis, clipped coverage, integer sums.
#pragma once

#include <algorithm>
#include <cstdint>

#include "cascade/grid.h"
#include "core/settings.h"
#include "gl/buffer.h"
#include "gl/framebuffer.h"
#include "gl/gpu_scene.h"
#include "gl/pass_timers.h"
#include "gl/program.h"
#include "gl/shader_library.h"
#include "gl/texture.h"
#include "voxelize/buffers.h"

namespace voxcone {

/// The voxelized scene: lists of what is occupied, and volumes for filtering.
struct Voxels {
    VoxelGrid grid;
    std::uint32_t count = 0;  ///< occupied voxels
    gl::Buffer list;          ///< uint a voxel: x, y, z in 10 bits each
    gl::Buffer faces;         ///< six FaceRecord a voxel, in the order of `list`
    gl::Buffer coverage;      ///< six floats a voxel, 0 to 1
    /// Densities (coverage per edge of the finest voxel) of surfaces that look along +x, +y, +z (rgb) and −x, −y, −z,
    /// with all mips. Six-face storage only.
    gl::Texture coveragePositive, coverageNegative;
    VoxelCounters counters;
    bool emission = false;  ///< some surface emits
};

class Voxelizer {
  public:
    /// Compiles for what `scene` and `settings` need.
    Voxelizer(const gl::Context& context, const gl::ShaderLibrary& shaders, const gl::GpuScene& scene,
              const Settings& settings);

    /// Voxelizes `scene`, whose origin must be the grid's, into new `Voxels`. Throws DeviceError when a limit is too
    /// small.
    Voxels voxelize(const gl::GpuScene& scene, const VoxelGrid& grid, gl::PassTimers& timers);

    /// Lowers the size of the buffer of sums from the device's largest storage block: the scene is then drawn once for
    /// every part of the voxels. The result does not depend on it. At least the sums of one voxel are kept.
    void limitRecordBytes(std::int64_t bytes) { maxRecordBytes_ = std::min(maxRecordBytes_, bytes); }

    /// Index volume of the last voxelization: 1 + record of each voxel, 0 where nothing is.
    const gl::Texture& index() const { return index_; }

  private:
    void accumulate(const gl::GpuScene& scene, Voxels& voxels);

    Settings::Voxel settings_;
    std::int64_t maxStorageBytes_, maxRecordBytes_;
    bool emission_;
    float emissionUnit_ = 0;
    gl::Program mark_, allocate_, list_, accumulate_, resolve_, mip_;
    gl::Texture index_;
    gl::Framebuffer framebuffer_;
};

}  // namespace voxcone
