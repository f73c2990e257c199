// Numbers the touched voxels of a box and lists where they are.
#include "cascade/buffers.glsl"
#include "cascade/records.glsl"
#include "cascade/clipmap.glsl"
layout(local_size_x = 8, local_size_y = 4, local_size_z = 2) in;

uniform int u_level, u_layer;
uniform ivec3 u_boxLow, u_boxHigh;
layout(r32ui) uniform uimage3D u_index;
layout(std430, binding = COUNTER_STORAGE) coherent buffer Counters { VOXEL_COUNTERS };
layout(std430, binding = FRESH_STORAGE) writeonly buffer Fresh { uint b_freshList[]; };
uniform uint u_freshCapacity;

void main() {
    ivec3 voxel = u_boxLow + ivec3(gl_GlobalInvocationID);
    if (any(greaterThanEqual(voxel, u_boxHigh))) return;
    ivec3 texel = levelTexel(voxel, u_level);
    uint mark = imageLoad(u_index, texel).r;
    // Marks that are numbered already come from a list that was too short.
    if (mark < kFresh) return;
    atomicAdd(b_freshOfLayer[u_layer], 1u);
    uint number = atomicAdd(b_fresh, 1u);
    // When the list is too short, a longer one is made and filled again.
    if (number < u_freshCapacity) b_freshList[number] = packPlace(voxel & (levelResolution(u_level) - 1), u_level, u_layer);
    imageStore(u_index, texel, uvec4(kFresh + number));
}
