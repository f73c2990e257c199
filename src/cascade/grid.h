// Where a cubic voxel grid lies in the world. Pure arithmetic in double.
#pragma once

#include <glm/glm.hpp>

#include "scene/scene.h"

namespace voxcone {

/// `resolution`³ voxels of edge `voxelSize` metres; `origin` is the lower corner in world space, a multiple of the
/// voxel edge in every coordinate, so that a scene moved by whole voxels keeps its voxels bit for bit.
struct VoxelGrid {
    int resolution = 0;
    double voxelSize = 0;
    glm::dvec3 origin{0};
    double size() const { return voxelSize * resolution; }
};

/// The grid that covers `bounds` with at least `margin` empty voxels on every side. `voxelSize` 0 chooses the smallest
/// edge that fits, otherwise the grid is centred on the bounds and may be smaller than them. Empty bounds give a grid
/// of 1 m. Scaling the bounds by a power of two scales the grid exactly.
VoxelGrid fitGrid(const Bounds& bounds, int resolution, int margin, double voxelSize = 0);

}  // namespace voxcone
