// Stores a voxel's coverage into the volumes that cones filter: also into the border on the other side when the voxel lies
// at an end of its level's box, so that filtering across the toroidal seam needs no copies. Levels that stay are surrounded
// by nothing. Needs the defines SIX_FACE and LEAVES.
#include "cascade/clipmap.glsl"

layout(rgb10_a2) uniform writeonly image3D u_coveragePositive;  // without SIX_FACE: opacity, that of the fullest face, in r
#if SIX_FACE
layout(rgb10_a2) uniform writeonly image3D u_coverageNegative;
#endif

#if LEAVES
layout(r11f_g11f_b10f) uniform writeonly image3D u_leaves;

/// Rounded as the volume holds it: what a device does to other floats is its own.
vec3 roundedToVolume(vec3 v) {
    uvec3 bits = floatBitsToUint(min(v, vec3(64000.0)));
    return uintBitsToFloat((bits + uvec3(0x10000u, 0x10000u, 0x20000u)) & ~uvec3(0x1ffffu, 0x1ffffu, 0x3ffffu));
}
#endif

/// `matter` as b_matter has it; without LEAVES xy alone, the coverage.
void storeCoverage(ivec3 i, int level, uvec4 matter) {
    int size = levelResolution(level);
    ivec3 place = i & (size - 1), first = levelOrigin(level, 1) + place;
    ivec3 toBorder = level >= u_firstFixed ? ivec3(0) : size * (ivec3(equal(place, ivec3(0))) - ivec3(equal(place, ivec3(size - 1))));
#if SIX_FACE
    vec3 positive = unpackCoverage(matter.x), negative = unpackCoverage(matter.y);
#else
    vec3 fullest = max(unpackCoverage(matter.x), unpackCoverage(matter.y));
    vec3 positive = vec3(max(fullest.x, max(fullest.y, fullest.z)), 0.0, 0.0);
#endif
#if LEAVES
    vec3 leaves = roundedToVolume(unpackHalf3(matter.zw));
#endif
    for (int copy = 0; copy < 8; ++copy) {
        ivec3 along = ivec3(copy & 1, (copy >> 1) & 1, copy >> 2);
        if (any(notEqual(along * ivec3(equal(toBorder, ivec3(0))), ivec3(0)))) continue;
        imageStore(u_coveragePositive, first + along * toBorder, vec4(positive, 0.0));
#if SIX_FACE
        imageStore(u_coverageNegative, first + along * toBorder, vec4(negative, 0.0));
#endif
#if LEAVES
        imageStore(u_leaves, first + along * toBorder, vec4(leaves, 0.0));
#endif
    }
}
