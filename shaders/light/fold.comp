// Without SIX_FACE, what cones read of a voxel instead of its faces.
// SH1 0: the mean radiance of its faces, weighted by coverage (thesis, section 3.4.1), and as coverage its opacity.
// SH1 1: radiance times coverage, and coverage, as spherical harmonics of first degree (thesis, section 3.4.5). A face shows
// its radiance R to the half of all directions w that its normal n points to: R (1/2 + 3/4 n.w) in that basis. Four words a
// voxel: the constant term, and those along x, y and z.
#include "cascade/buffers.glsl"
#include "cascade/records.glsl"
#include "shared/octahedral.glsl"
layout(local_size_x = 64) in;

uniform uint u_slotCount;
layout(std430, binding = PLACE_STORAGE) readonly buffer Places { uint b_places[]; };
layout(std430, binding = GATHERED_STORAGE) readonly buffer FaceRadiance { uvec2 b_faceRadiance[]; };
#if SH1
layout(std430, binding = FACE_STORAGE) readonly buffer Faces { FaceRecord b_faces[]; };
#endif
layout(std430, binding = RADIANCE_STORAGE) writeonly buffer Radiance { uvec2 b_radiance[]; };

void main() {
    uint slot = gl_WorkGroupID.y * gl_NumWorkGroups.x * 64u + gl_WorkGroupID.x * 64u + gl_LocalInvocationID.x;
    if (slot >= u_slotCount || !placeInUse(b_places[slot])) return;
    vec4 sum = vec4(0.0), alongX = vec4(0.0), alongY = vec4(0.0), alongZ = vec4(0.0);
    float opacity = 0.0;
    for (int f = 0; f < 6; ++f) {
        uvec2 stored = b_faceRadiance[slot * 6u + uint(f)];
        vec2 blueAndShare = unpackHalf2x16(stored.y);
        if (blueAndShare.y == 0.0) continue;
        vec4 value = blueAndShare.y * vec4(unpackHalf2x16(stored.x), blueAndShare.x, 1.0);
        sum += value;
        opacity = max(opacity, blueAndShare.y);
#if SH1
        vec3 normal = unpackOctahedral(b_faces[slot * 6u + uint(f)].normal);
        alongX += normal.x * value, alongY += normal.y * value, alongZ += normal.z * value;
#endif
    }
#if SH1
    b_radiance[slot * 4u] = packHalf4(0.5 * sum);
    b_radiance[slot * 4u + 1u] = packHalf4(0.75 * alongX);
    b_radiance[slot * 4u + 2u] = packHalf4(0.75 * alongY);
    b_radiance[slot * 4u + 3u] = packHalf4(0.75 * alongZ);
#else
    b_radiance[slot] = packHalf4(vec4(sum.a > 0.0 ? sum.rgb / sum.a : vec3(0.0), opacity));
#endif
}
