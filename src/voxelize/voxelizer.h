// Scene to voxels: conservative rasterisation along each triangle's dominant axis, clipped coverage, integer sums.
#pragma once

#include <algorithm>
#include <cstdint>

#include "cascade/voxels.h"
#include "core/settings.h"
#include "gl/framebuffer.h"
#include "gl/gpu_scene.h"
#include "gl/pass_timers.h"
#include "gl/program.h"
#include "gl/shader_library.h"

namespace voxcone {

class Voxelizer {
  public:
    /// Compiles for what `scene` and `settings` need.
    Voxelizer(const gl::Context& context, const gl::ShaderLibrary& shaders, const gl::GpuScene& scene,
              const Settings& settings);

    /// Voxels without anything in them. Throws DeviceError when a limit is too small.
    Voxels allocate(const ClipmapLayout& layout) const;

    /// Voxelizes the regions of `update`, after which `voxels` holds its windows. The scene's origin must be that of
    /// the voxels. What a voxel holds depends on the scene alone, not on updates before.
    void update(const gl::GpuScene& scene, const ClipmapUpdate& update, Voxels& voxels, gl::PassTimers& timers);

    /// Lowers the size of the buffer of sums from the device's largest storage block: regions are then drawn once for
    /// every part of their voxels. The result does not depend on it. At least the sums of one voxel are kept.
    void limitRecordBytes(std::int64_t bytes) { maxRecordBytes_ = std::min(maxRecordBytes_, bytes); }

  private:
    void clear(const std::vector<Region>& regions, bool moving, Voxels& voxels);
    void draw(gl::Program& program, const gl::GpuScene& scene, const Region& region, bool moving, Voxels& voxels,
              gl::TextureFiltering filtering);
    void allocateRecords(const ClipmapUpdate& update, const std::vector<Region>& mips, Voxels& voxels);
    void accumulate(const gl::GpuScene& scene, const std::vector<Region>& regions, bool moving, std::uint32_t first,
                    std::uint32_t count, Voxels& voxels);
    void reserve(std::uint32_t records, Voxels& voxels) const;

    Settings::Voxel settings_;
    float
        sheetGain_;  ///< times the coverage of a sheet that a cone crosses is what it stops, as far as that is below 1
    std::int64_t maxStorageBytes_, maxRecordBytes_;
    bool emission_, layers_, leaves_;
    float emissionUnit_ = 0;
    gl::Program clear_, mark_, allocate_, markMip_, accumulate_, resolve_, resolveMip_, matter_, matterMip_;
    gl::Framebuffer framebuffer_;
};

}  // namespace voxcone
