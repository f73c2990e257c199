// Storage blocks of the voxels. Twin of src/cascade/buffers.h.
#define COUNTER_STORAGE 3
#define PLACE_STORAGE 5
#define FACE_STORAGE 6
#define COVERAGE_STORAGE 7
// While voxelizing.
#define FREE_STORAGE 0
#define EMISSION_STORAGE 1
#define FRESH_STORAGE 2
#define SUM_STORAGE 4
#define MATTER_STORAGE 6  // in passes that leave the faces alone
// While lighting, and EMISSION_STORAGE.
#define LIST_STORAGE 0
#define DIRECT_STORAGE 7
// While bouncing and tracing.
#define RADIANCE_STORAGE 1
#define LIT_STORAGE 2
#define GATHERED_STORAGE 4
#define TRACED_STORAGE 7    // coverage that the near field of cones meets, or with leaves b_matter
#define SAMPLE_STORAGE 4    // places that cones looked at, while counting them
#define BOUNCED_STORAGE 2   // coverage of the faces that gather

// In the order of VoxelCounters.
#define VOXEL_COUNTERS                                                                                           \
    uint b_fresh, b_freshOfLayer[2], b_freeCount, b_saturated, b_fragments, b_clamped, b_brightest, b_activeFaces, \
        b_added[6], b_records[16];
