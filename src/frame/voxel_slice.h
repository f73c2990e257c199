// One slice through the voxels of a level, read back to be looked at.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "cone/cone_uniforms.h"

namespace voxcone {

/// A voxel that a surface touches. Faces: +x, -x, +y, -y, +z, -z, by the side that the surface looks to.
struct VoxelFace {
    glm::vec3 albedo{0}, normal{0}, radiance{0};  ///< W/(m² sr)
    float coverage = 0;
};
struct VoxelFacts {
    bool occupied = false;
    std::array<VoxelFace, 6> faces;
    float opacity() const;  ///< coverage of the fullest face
};

/// Perpendicular to `axis`. Voxel (u, v) lies at `low` plus u and v along the two other axes: z and y for x, x and z
/// for y, x and y for z.
struct VoxelSlice {
    int level = 0, axis = 1;
    glm::ivec3 low{0};  ///< index of voxel (0, 0)
    int width = 0, height = 0;
    double voxelSize = 0;  ///< metres
    glm::dvec3 origin{0};  ///< world position of voxel index 0
    std::vector<VoxelFacts> voxels;
    const VoxelFacts& at(int u, int v) const {
        return voxels[static_cast<std::size_t>(v) * static_cast<std::size_t>(width) + static_cast<std::size_t>(u)];
    }
    glm::ivec3 index(int u, int v) const;
};

/// How full voxels are.
struct Occupancy {
    std::uint64_t voxels = 0, occupied = 0;
    std::array<std::uint64_t, 20> histogram{};  ///< occupied ones by opacity, 0 to 1
    void add(const VoxelSlice& slice);
};

/// Reads the slice of a level or mip that lies `depth` voxels above the lower side of its window.
class VoxelSlicer {
  public:
    VoxelSlicer(const gl::ShaderLibrary& shaders, const Voxels& voxels);
    VoxelSlice read(int level, int axis, int depth, const RadianceVolume& volume, const gl::Buffer& faceRadiance);

  private:
    gl::Program program_;
};

}  // namespace voxcone
