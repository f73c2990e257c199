// Empties a box of one level: the records of its voxels become free, and the volumes hold what the other layer (static or
// moving geometry) has there.
#include "cascade/buffers.glsl"
#include "cascade/records.glsl"
#include "cascade/coverage_store.glsl"
layout(local_size_x = 8, local_size_y = 4, local_size_z = 2) in;

uniform int u_level;
uniform ivec3 u_boxLow, u_boxHigh;
layout(r32ui) uniform uimage3D u_index;
#if LAYERS == 2
layout(r32ui) uniform readonly uimage3D u_otherIndex;
#if LEAVES
layout(std430, binding = MATTER_STORAGE) readonly buffer MatterBlock { uvec4 b_matter[]; };
#else
layout(std430, binding = COVERAGE_STORAGE) readonly buffer Coverage { uvec2 b_coverage[]; };
#endif
#endif
layout(std430, binding = COUNTER_STORAGE) coherent buffer Counters { VOXEL_COUNTERS };
layout(std430, binding = PLACE_STORAGE) writeonly buffer Places { uint b_places[]; };
layout(std430, binding = FREE_STORAGE) writeonly buffer Free { uint b_free[]; };

void main() {
    ivec3 voxel = u_boxLow + ivec3(gl_GlobalInvocationID);
    if (any(greaterThanEqual(voxel, u_boxHigh))) return;
    ivec3 texel = levelTexel(voxel, u_level);
    uint mark = imageLoad(u_index, texel).r;
    if (mark == 0u) return;
    b_free[atomicAdd(b_freeCount, 1u)] = mark - 1u;
    b_places[mark - 1u] = 0u;
    imageStore(u_index, texel, uvec4(0u));
    uvec4 left = uvec4(0u);
#if LAYERS == 2
    uint other = imageLoad(u_otherIndex, texel).r;
#if LEAVES
    if (other != 0u) left = b_matter[other - 1u];
#else
    if (other != 0u) left.xy = b_coverage[other - 1u];
#endif
#endif
    storeCoverage(voxel, u_level, left);
}
