// Stores a voxel's coverage into the volumes that cones filter: also into the border on the other side when the voxel lies
// at an end of its level's box, so that filtering across the toroidal seam needs no copies. Levels that stay are surrounded
// by nothing.
#include "cascade/clipmap.glsl"

layout(rgb10_a2) uniform writeonly image3D u_coveragePositive;  // without SIX_FACE: opacity, that of the fullest face, in r
#if SIX_FACE
layout(rgb10_a2) uniform writeonly image3D u_coverageNegative;
#endif

void storeCoverage(ivec3 i, int level, uvec2 packed_) {
    int size = levelResolution(level);
    ivec3 place = i & (size - 1), first = levelOrigin(level, 1) + place;
    ivec3 toBorder = level >= u_firstFixed ? ivec3(0) : size * (ivec3(equal(place, ivec3(0))) - ivec3(equal(place, ivec3(size - 1))));
#if SIX_FACE
    vec3 positive = unpackCoverage(packed_.x), negative = unpackCoverage(packed_.y);
#else
    vec3 fullest = max(unpackCoverage(packed_.x), unpackCoverage(packed_.y));
    vec3 positive = vec3(max(fullest.x, max(fullest.y, fullest.z)), 0.0, 0.0);
#endif
    for (int copy = 0; copy < 8; ++copy) {
        ivec3 along = ivec3(copy & 1, (copy >> 1) & 1, copy >> 2);
        if (any(notEqual(along * ivec3(equal(toBorder, ivec3(0))), ivec3(0)))) continue;
        imageStore(u_coveragePositive, first + along * toBorder, vec4(positive, 0.0));
#if SIX_FACE
        imageStore(u_coverageNegative, first + along * toBorder, vec4(negative, 0.0));
#endif
    }
}
