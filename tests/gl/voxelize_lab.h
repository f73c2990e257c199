// Voxelizes scenes on the device and reads the voxels back as plain data: what the tests of the voxelizer look at.
#pragma once

#include <array>
#include <map>
#include <vector>

#include "core/octahedral.h"
#include "core/rgb9e5.h"
#include "core/settings.h"
#include "gl/gpu_scene.h"
#include "gl/pass_timers.h"
#include "gl/shader_library.h"
#include "support/gl_context.h"
#include "support/shapes.h"
#include "voxelize/voxelizer.h"

namespace voxcone::test {

using Cell = std::array<int, 3>;

/// One face of a voxel; the packed words are kept for comparisons bit for bit.
struct VoxelFace {
    FaceRecord record;
    float coverage = 0;
    bool operator==(const VoxelFace& o) const {
        return record.albedo == o.record.albedo && record.normal == o.record.normal &&
               record.position == o.record.position && record.emission == o.record.emission && coverage == o.coverage;
    }
    bool held() const { return faceHoldsSurface(record); }
    glm::vec3 albedo() const { return unpackAlbedo(record.albedo); }
    glm::vec3 normal() const { return unpackOctahedral(record.normal); }
    glm::vec3 position() const { return unpackPosition(record.position); }
    glm::vec3 emission() const { return unpackRgb9e5(record.emission); }
};
using VoxelFaces = std::array<VoxelFace, 6>;

/// Voxels by their place: the order of the list on the device is the scheduler's and means nothing.
struct VoxelMap {
    std::map<Cell, VoxelFaces> voxels;
    VoxelCounters counters;
    bool operator==(const VoxelMap& o) const { return voxels == o.voxels; }
    const VoxelFaces& at(int x, int y, int z) const { return voxels.at({x, y, z}); }
    bool has(int x, int y, int z) const { return voxels.contains({x, y, z}); }
};

inline VoxelMap readVoxels(const Voxels& voxels) {
    VoxelMap map;
    map.counters = voxels.counters;
    if (voxels.count == 0) return map;
    const auto list = voxels.list.read<std::uint32_t>();
    const auto faces = voxels.faces.read<FaceRecord>();
    const auto coverage = voxels.coverage.read<float>();
    for (std::size_t i = 0; i < voxels.count; ++i) {
        const glm::ivec3 v = unpackVoxel(list[i]);
        VoxelFaces& out = map.voxels[{v.x, v.y, v.z}];
        for (std::size_t f = 0; f < 6; ++f) out[f] = {faces[6 * i + f], coverage[6 * i + f]};
    }
    EXPECT_EQ(map.voxels.size(), voxels.count) << "a voxel is listed twice";
    return map;
}

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
        return voxelizer_.voxelize(gpuScene, grid, timers_);
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

}  // namespace voxcone::test
