#include "cascade/grid.h"

#include <algorithm>
#include <cmath>

#include "core/check.h"

namespace voxcone {

VoxelGrid fitGrid(const Bounds& bounds, int resolution, int margin, double voxelSize) {
    VOXCONE_CHECK(resolution > 2 * margin + 1, "resolution {} margin {}", resolution, margin);
    VoxelGrid grid;
    grid.resolution = resolution;
    const glm::dvec3 size = bounds.size();
    const double extent = std::max({size.x, size.y, size.z});
    // One voxel is lost to snapping the origin down to a whole voxel.
    grid.voxelSize = voxelSize > 0 ? voxelSize : extent > 0 ? extent / (resolution - 2 * margin - 1) : 1.0 / resolution;
    const glm::dvec3 lower = bounds.center() / grid.voxelSize - 0.5 * resolution;
    grid.origin = glm::floor(lower + 0.5) * grid.voxelSize;
    return grid;
}

}  // namespace voxcone
