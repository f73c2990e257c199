// Lists the voxels of a mip that hold something, because one of their eight children does.
#include "cascade/buffers.glsl"
#include "cascade/records.glsl"
#include "cascade/clipmap.glsl"
layout(local_size_x = 8, local_size_y = 4, local_size_z = 2) in;

uniform int u_level;
uniform ivec3 u_boxLow, u_boxHigh;
uniform uint u_freshCapacity;
layout(r32ui) uniform uimage3D u_index;
#if LAYERS == 2
layout(r32ui) uniform readonly uimage3D u_movingIndex;
#endif
layout(std430, binding = COUNTER_STORAGE) coherent buffer Counters { VOXEL_COUNTERS };
layout(std430, binding = FRESH_STORAGE) writeonly buffer Fresh { uint b_freshList[]; };

void main() {
    ivec3 voxel = u_boxLow + ivec3(gl_GlobalInvocationID);
    if (any(greaterThanEqual(voxel, u_boxHigh))) return;
    uint any_ = 0u;
    for (int child = 0; child < 8; ++child) {
        ivec3 texel = levelTexel(2 * voxel + ivec3(child & 1, (child >> 1) & 1, child >> 2), u_level - 1);
        any_ |= imageLoad(u_index, texel).r;
#if LAYERS == 2
        if (u_level == u_levels) any_ |= imageLoad(u_movingIndex, texel).r;
#endif
    }
    if (any_ == 0u) return;
    uint number = atomicAdd(b_fresh, 1u);
    if (number < u_freshCapacity) b_freshList[number] = packPlace(voxel & (levelResolution(u_level) - 1), u_level, 0);
    imageStore(u_index, levelTexel(voxel, u_level), uvec4(kFresh + number));
}
