// Storage blocks of the voxels. Twin of src/voxelize/buffers.h.
#define COUNTER_STORAGE 3
#define RECORD_STORAGE 4
#define VOXEL_STORAGE 5
#define FACE_STORAGE 6
#define COVERAGE_STORAGE 7
// While lighting: the sums are done with, and so is the coverage once radiance carries it in w.
#define RADIANCE_STORAGE 1
#define DIRECT_STORAGE 7

// In the order of VoxelCounters.
#define VOXEL_COUNTERS uint b_occupied, b_saturated, b_fragments, b_clamped, b_brightest, b_added[6];
