// Storage blocks of the voxels and what is in them. Twin of shaders/cascade/buffers.glsl.
#pragma once

#include <cstdint>

#include "cascade/records.h"

namespace voxcone {

enum VoxelStorageBlock : int {
    kCounterStorage = 3,
    kPlaceStorage = 5,
    kFaceStorage = 6,
    kCoverageStorage = 7,
    // While voxelizing.
    kFreeStorage = 0,
    kEmissionStorage = 1,
    kFreshStorage = 2,
    kSumStorage = 4,
    kMatterStorage = 6,  // in passes that leave the faces alone
    // While lighting, and kEmissionStorage.
    kListStorage = 0,
    kDirectStorage = 7,
    // While bouncing and tracing.
    kRadianceStorage = 1,
    kLitStorage = 2,
    kGatheredStorage = 4,
    kTracedStorage = 7,   // coverage that the near field of cones meets, or with leaves Voxels::matter
    kSampleStorage = 4,   // places that cones looked at, while counting them
    kBouncedStorage = 2,  // coverage of the faces that gather
};

/// Of the block of samples: shaders/cone/trace.glsl.
constexpr int kSampleWords = 8;

struct VoxelCounters {
    std::uint32_t fresh = 0;             ///< voxels that got a record in this update
    std::uint32_t freshOfLayer[2] = {};  ///< those of static and of moving geometry; the others are mips
    std::uint32_t freeCount = 0;         ///< slots on the stack of free ones
    std::uint32_t saturated = 0;         ///< additions left out because a sum was full
    std::uint32_t fragments = 0;         ///< triangle pieces added
    std::uint32_t clamped = 0;    ///< emissions (voxelizing) or radiances (lighting) beyond the range of their storage
    std::uint32_t brightest = 0;  ///< bits of the largest radiance as a float
    std::uint32_t activeFaces = 0;  ///< faces that gather
    /// Sums over faces of what the last bounce added, red, green and blue, each as low and high word.
    std::uint32_t added[6] = {};
    std::uint32_t records[16] = {};  ///< in use, by level
};

}  // namespace voxcone
