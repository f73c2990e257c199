// Radiance of one mip level from its children: the mean of each face, weighted by coverage.
#include "cascade/buffers.glsl"
#include "cascade/clipmap.glsl"
#include "cascade/records.glsl"
layout(local_size_x = 64) in;

uniform int u_level;
uniform uint u_slotCount;
uniform usampler3D u_index;
#if LAYERS == 2
uniform usampler3D u_movingIndex;
#endif
layout(std430, binding = PLACE_STORAGE) readonly buffer Places { uint b_places[]; };
layout(std430, binding = COVERAGE_STORAGE) readonly buffer Coverage { uvec2 b_coverage[]; };
layout(std430, binding = RADIANCE_STORAGE) buffer Radiance { uvec2 b_radiance[]; };

void main() {
    uint slot = gl_WorkGroupID.y * gl_NumWorkGroups.x * 64u + gl_WorkGroupID.x * 64u + gl_LocalInvocationID.x;
    if (slot >= u_slotCount) return;
    uint place = b_places[slot];
    if (!placeInUse(place) || placeLevel(place) != u_level) return;
    ivec3 voxel = fromToroidal(placeTexel(place), u_level);
    vec4 sums[6] = vec4[](vec4(0.0), vec4(0.0), vec4(0.0), vec4(0.0), vec4(0.0), vec4(0.0));
    for (int child = 0; child < 8 * LAYERS; ++child) {
        ivec3 texel = levelTexel(2 * voxel + ivec3(child & 1, (child >> 1) & 1, (child >> 2) & 1), u_level - 1);
#if LAYERS == 2
        uint mark = child < 8 ? texelFetch(u_index, texel, 0).r
                              : (u_level == u_levels ? texelFetch(u_movingIndex, texel, 0).r : 0u);
#else
        uint mark = texelFetch(u_index, texel, 0).r;
#endif
        if (mark == 0u) continue;
#define ADD_FACE(f)                                                                    \
    {                                                                                  \
        uvec2 stored = b_radiance[(mark - 1u) * 6u + uint(f)];                         \
        vec2 blueAndShare = unpackHalf2x16(stored.y);                                  \
        vec3 radiance = vec3(unpackHalf2x16(stored.x), blueAndShare.x);                \
        if (blueAndShare.y > 0.0) sums[f] += blueAndShare.y * vec4(radiance, 1.0);     \
    }
        ADD_FACE(0) ADD_FACE(1) ADD_FACE(2) ADD_FACE(3) ADD_FACE(4) ADD_FACE(5)
    }
    uvec2 coverage = b_coverage[slot];
#define STORE_FACE(f)                                                                                  \
    {                                                                                                  \
        vec3 radiance = sums[f].a > 0.0 ? sums[f].rgb / sums[f].a : vec3(0.0);                         \
        b_radiance[slot * 6u + uint(f)] =                                                              \
            uvec2(packHalf2x16(radiance.rg), packHalf2x16(vec2(radiance.b, faceCoverage(coverage, f)))); \
    }
    STORE_FACE(0) STORE_FACE(1) STORE_FACE(2) STORE_FACE(3) STORE_FACE(4) STORE_FACE(5)
}
