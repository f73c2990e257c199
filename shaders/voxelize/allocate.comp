// Numbers the touched voxels: the index volume then holds 1 + the voxel's record, and 0 where nothing is.
#include "voxelize/buffers.glsl"
#include "voxelize/records.glsl"
layout(local_size_x = 8, local_size_y = 8, local_size_z = 1) in;

uniform int u_resolution;
layout(r32ui) uniform uimage3D u_index;
layout(std430, binding = COUNTER_STORAGE) coherent buffer Counters { VOXEL_COUNTERS };
#if WRITE_VOXELS
layout(std430, binding = VOXEL_STORAGE) writeonly buffer Voxels { uint b_voxels[]; };
#endif

void main() {
    ivec3 voxel = ivec3(gl_GlobalInvocationID);
    if (any(greaterThanEqual(voxel, ivec3(u_resolution)))) return;
    uint mark = imageLoad(u_index, voxel).r;
    if (mark == 0u) return;
#if WRITE_VOXELS
    b_voxels[mark - 1u] = packVoxel(voxel);
#else
    imageStore(u_index, voxel, uvec4(atomicAdd(b_occupied, 1u) + 1u));
#endif
}
