// Voxelizes scenes on the device on a grid that stays, and reads the voxels back: what the tests of the voxelizer look
// at.
#pragma once

#include <array>
#include <vector>

#include "core/settings.h"
#include "gl/gpu_scene.h"
#include "gl/pass_timers.h"
#include "gl/shader_library.h"
#include "support/gl_context.h"
#include "support/shapes.h"
#include "support/voxel_lab.h"
#include "voxelize/voxelizer.h"

namespace voxcone::test {

inline Settings voxelSettings(int resolution, VoxelCoverage coverage = VoxelCoverage::area,
                              VoxelAveraging averaging = VoxelAveraging::integer_sum) {
    Settings settings;
    settings.voxel.resolution = resolution;
    settings.voxel.coverage = coverage;
    settings.voxel.averaging = averaging;
    return settings;
}

/// A grid of voxels of 1 m with its corner in the origin: positions are voxel units.
inline VoxelGrid unitGrid(int resolution) {
    return {resolution, 1, glm::dvec3(0)};
}

/// One level that stays, with its mips.
inline ClipmapLayout layoutOf(const VoxelGrid& grid) {
    ClipmapLayout layout;
    layout.resolution = grid.resolution;
    layout.voxelSize = grid.voxelSize;
    layout.origin = grid.origin;
    while (grid.resolution >> (layout.mips + 1) >= 4) ++layout.mips;
    return layout;
}

inline const gl::ShaderLibrary& voxelizeShaders() {
    static const gl::ShaderLibrary shaders;
    return shaders;
}

/// A voxelizer compiled once for scenes that emit as `model` does.
class VoxelizeLab {
  public:
    VoxelizeLab(const Settings& settings, const Scene& model)
        : voxelizer_(glContext(), voxelizeShaders(), gl::GpuScene(model), settings) {}

    /// The voxels themselves; `reversed` draws batches and triangles backwards.
    Voxels run(const Scene& scene, const VoxelGrid& grid, bool reversed = false) {
        gl::GpuScene gpuScene(scene);
        gpuScene.setOrigin(grid.origin);
        if (reversed) gpuScene.reverseDrawOrder();
        Voxels voxels = voxelizer_.allocate(layoutOf(grid));
        voxelizer_.update(gpuScene, ClipmapSchedule(voxels.layout, 0, false).next(glm::dvec3(0), {}), voxels, timers_);
        return voxels;
    }
    VoxelMap voxelize(const Scene& scene, const VoxelGrid& grid, bool reversed = false) {
        return readVoxels(run(scene, grid, reversed));
    }
    Voxelizer& voxelizer() { return voxelizer_; }

  private:
    gl::PassTimers timers_{gl::TimerMode::finish};
    Voxelizer voxelizer_;
};

/// A scene voxelized with a voxelizer of its own.
inline VoxelMap voxelizeOnce(const Scene& scene, const VoxelGrid& grid, const Settings& settings) {
    return VoxelizeLab(settings, scene).voxelize(scene, grid);
}

using Triangle = std::array<glm::vec3, 3>;

/// Loose triangles (sheets), with the normals of their planes.
inline Mesh triangleMesh(const std::vector<Triangle>& triangles) {
    Mesh mesh;
    mesh.name = "triangles";
    for (const Triangle& t : triangles) {
        const glm::dvec3 a(t[0]), b(t[1]), c(t[2]);
        const glm::dvec3 n = glm::cross(b - a, c - a);
        const double length = glm::length(n);
        for (const glm::vec3& corner : t) {
            mesh.indices.push_back(static_cast<std::uint32_t>(mesh.positions.size()));
            mesh.positions.push_back(corner);
            mesh.normals.emplace_back(length > 0 ? n / length : glm::dvec3(0));
        }
        mesh.closed.push_back(0);
    }
    return mesh;
}

/// Sum over all voxels of the coverage of face `f`.
inline double summedCoverage(const VoxelMap& map, std::size_t f) {
    double sum = 0;
    for (const auto& [cell, faces] : map.voxels) sum += static_cast<double>(faces[f].coverage);
    return sum;
}

/// How far that sum may be off because coverages are stored to ten bits: full faces are exact.
inline double storageRounding(const VoxelMap& map, std::size_t f) {
    double sum = 0;
    for (const auto& [cell, faces] : map.voxels)
        if (faces[f].held() && faces[f].coverage < 1) sum += kCoverageRounding;
    return sum;
}

}  // namespace voxcone::test
