// Voxelizes a scene, lights it and gathers at points, through the renderer's own passes, and reads voxels back as plain
// data: for tests with exact answers.
#pragma once

#include <array>
#include <map>

#include "cone/probe.h"
#include "core/octahedral.h"
#include "core/rgb9e5.h"
#include "core/settings.h"
#include "light/radiance.h"
#include "light/shadow_maps.h"
#include "support/gl_context.h"
#include "voxelize/voxelizer.h"

namespace voxcone::test {

/// One face of a voxel; the packed words are kept for comparisons bit for bit.
struct VoxelFace {
    FaceRecord record;
    std::uint32_t emitted = 0;  ///< RGB9E5
    float coverage = 0;         ///< as stored: a multiple of 1/1023
    bool operator==(const VoxelFace& o) const {
        return record.albedo == o.record.albedo && record.normal == o.record.normal &&
               record.position == o.record.position && emitted == o.emitted && coverage == o.coverage;
    }
    bool held() const { return faceHoldsSurface(record); }
    glm::vec3 albedo() const { return unpackAlbedo(record.albedo); }
    glm::vec3 normal() const { return unpackOctahedral(record.normal); }
    glm::vec3 position() const { return unpackPosition(record.position); }
    glm::vec3 emission() const { return unpackRgb9e5(emitted); }
};
using VoxelFaces = std::array<VoxelFace, 6>;

/// How far a stored coverage may be from what was stored: half a step of ten bits, and the rounding of a float.
constexpr double kCoverageRounding = 1.0 / 2046 + 1e-7;

/// Whose voxel: level or mip, 1 for moving geometry (else 0), x, y, z of the voxel's index in the level's lattice.
using VoxelName = std::array<int, 5>;

/// Slot of every record. Fails the test when records, index volumes and counts do not agree.
std::map<VoxelName, std::uint32_t> readSlots(const Voxels& voxels);

/// Every record of all levels and mips.
std::map<VoxelName, VoxelFaces> readRecords(const Voxels& voxels);

using Cell = std::array<int, 3>;

/// The occupied voxels of one level by index.
struct VoxelMap {
    std::map<Cell, VoxelFaces> voxels;
    VoxelCounters counters;
    bool operator==(const VoxelMap& o) const { return voxels == o.voxels; }
    const VoxelFaces& at(int x, int y, int z) const { return voxels.at({x, y, z}); }
    bool has(int x, int y, int z) const { return voxels.contains({x, y, z}); }
};
VoxelMap readVoxels(const Voxels& voxels, int level = 0, bool moving = false);

/// The voxels of a scene around a camera that moves, as the renderer keeps them with cascade.update = exact.
class ClipmapLab {
  public:
    /// voxel and cascade of `settings` lay out the levels. `scene` must outlive this object.
    ClipmapLab(const gl::Context& context, const gl::ShaderLibrary& shaders, const Scene& scene,
               const Settings& settings);

    /// Brings the voxels to a camera at `eye` (world) and to `time`, by what has changed since the last call.
    void show(const glm::dvec3& eye, double time = 0);

    /// The voxels of the last show() made from nothing, by another upload of the scene.
    Voxels anew();

    const Voxels& voxels() const { return voxels_; }
    const ClipmapLayout& layout() const { return voxels_.layout; }
    /// As of the last show().
    const gl::GpuScene& gpuScene() const { return gpuScene_; }

  private:
    const Scene& scene_;
    gl::PassTimers timers_{gl::TimerMode::finish};
    gl::GpuScene gpuScene_;
    Voxelizer voxelizer_;
    Voxels voxels_;
    ClipmapSchedule schedule_;
};

/// A lit clipmap that can be gathered from.
class VoxelLab {
  public:
    /// The last level fits the scene unless `voxelSize`, the edge of level 0's voxels, is given. Finer levels are
    /// around `eye` (world). The sky is the scene's constant environment colour.
    VoxelLab(gl::Context& context, const Scene& scene, const Settings& settings, double voxelSize = 0,
             const glm::dvec3& eye = glm::dvec3(0));

    /// What cones gather: light from analytic lights only after a bounce.
    std::vector<ConeProbeResult> gather(const std::vector<ConeProbe>& probes);

    const Voxels& voxels() const { return clipmap_.voxels(); }
    const RadianceField& field() const { return field_; }

  private:
    Settings settings_;
    gl::ShaderLibrary shaders_;
    ClipmapLab clipmap_;
    Sky sky_;
    gl::PassTimers timers_{gl::TimerMode::finish};
    ShadowMaps shadowMaps_;
    RadianceField field_;
};

}  // namespace voxcone::test
