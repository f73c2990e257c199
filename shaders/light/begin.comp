// MEASURE: records by level, and if asked for, of the last level the brightest face and a list of the faces, which gather. Otherwise: the radiance of
// every face, from its direct light and what it has gathered; half floats, as cones read them.
#include "cascade/buffers.glsl"
#include "cascade/clipmap.glsl"
#include "cascade/records.glsl"
#include "shared/rgb9e5.glsl"
#include "light/dither.glsl"
layout(local_size_x = 64) in;

uniform uint u_slotCount;
layout(std430, binding = COUNTER_STORAGE) coherent buffer Counters { VOXEL_COUNTERS };
layout(std430, binding = PLACE_STORAGE) readonly buffer Places { uint b_places[]; };
layout(std430, binding = COVERAGE_STORAGE) readonly buffer Coverage { uvec2 b_coverage[]; };
layout(std430, binding = LIT_STORAGE) readonly buffer Direct { uint b_direct[]; };
#if MEASURE
uniform bool u_list;
layout(std430, binding = LIST_STORAGE) writeonly buffer List { uvec2 b_list[]; };  // face, and what it gathers in a bounce
#else
layout(std430, binding = LIST_STORAGE) readonly buffer List { uint b_list[]; };
uniform bool u_listed;  // the slots of the list; else the first ones
uniform int u_firstLevel;
uniform bool u_count;  // values that are clamped
uniform float u_inverseRadianceScale;
layout(std430, binding = FACE_STORAGE) readonly buffer Faces { FaceRecord b_faces[]; };
layout(std430, binding = RADIANCE_STORAGE) writeonly buffer Radiance { uvec2 b_radiance[]; };
layout(std430, binding = GATHERED_STORAGE) readonly buffer Gathered { uvec2 b_gathered[]; };
#endif

void main() {
    uint slot = gl_WorkGroupID.y * gl_NumWorkGroups.x * 64u + gl_WorkGroupID.x * 64u + gl_LocalInvocationID.x;
    if (slot >= u_slotCount) return;
#if !MEASURE
    if (u_listed) slot = b_list[slot];
#endif
    uint place = b_places[slot];
    int level = placeLevel(place);
    if (!placeInUse(place)) return;
#if MEASURE
    atomicAdd(b_records[level], 1u);
    if (!u_list) return;
#endif
    if (level >= u_levels) return;
#if !MEASURE
    if (level < u_firstLevel) return;
#endif
    uvec2 coverage = b_coverage[slot];
    for (int f = 0; f < 6; ++f) {
        float share = faceCoverage(coverage, f);
        uint index = slot * 6u + uint(f);
#if MEASURE
        if (share == 0.0) continue;
        if (level < u_levels - 1) break;
        vec3 radiance = unpackRgb9e5(b_direct[index]);
        b_list[atomicAdd(b_activeFaces, 1u)] = uvec2(index, 0u);
        // Floats that are not negative compare like their bits.
        atomicMax(b_brightest, floatBitsToUint(max(radiance.r, max(radiance.g, radiance.b))));
#else
        vec3 radiance = vec3(0.0);
        if (share > 0.0)
            radiance = u_inverseRadianceScale * unpackRgb9e5(b_direct[index]) +
                       unpackAlbedo(b_faces[index].albedo) * unpackHalf3(b_gathered[index]);
        if (u_count && any(greaterThan(radiance, vec3(kMostHalf)))) atomicAdd(b_clamped, 1u);
        radiance = ditherToHalf(min(radiance, vec3(kMostHalf)), faceHash(place, uint(f)));
        b_radiance[index] = uvec2(packHalf2x16(radiance.rg), packHalf2x16(vec2(radiance.b, share)));
#endif
    }
}
