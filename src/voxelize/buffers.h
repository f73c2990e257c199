// Storage blocks of the voxels and what is in them. Twin of shaders/voxelize/buffers.glsl.
#pragma once

#include <cstdint>

#include "voxelize/records.h"

namespace voxcone {

enum VoxelStorageBlock : int {
    kCounterStorage = 3,
    kRecordStorage = 4,  ///< sums, while voxelizing
    kVoxelStorage = 5,
    kFaceStorage = 6,
    kCoverageStorage = 7,
    kRadianceStorage = 1,  ///< while lighting: outgoing radiance of each face, coverage in w
    kDirectStorage = 7,    ///< while bouncing: radiance of the faces from lights and emission alone
};

struct VoxelCounters {
    std::uint32_t occupied = 0;   ///< voxels that hold a surface
    std::uint32_t saturated = 0;  ///< additions left out because a sum was full
    std::uint32_t fragments = 0;  ///< triangle pieces added
    std::uint32_t clamped = 0;    ///< emissions (voxelizing) or radiances (lighting) beyond the range of their storage
    std::uint32_t brightest = 0;  ///< bits of the largest radiance as a float
    /// Sums over faces of what the last bounce added, red, green and blue, each as low and high word.
    std::uint32_t added[6] = {};
};

}  // namespace voxcone
