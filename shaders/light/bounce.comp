// One bounce: every voxel face of the coarsest level gathers the radiance of the others by cones, and adds what it reflects to
// its direct light. Finer levels take what these faces gather (spread.comp): so the bounces do not depend on the camera.
#include "cascade/buffers.glsl"
#include "shared/octahedral.glsl"
#include "shared/rgb9e5.glsl"
#include "light/dither.glsl"
#include "cone/sky.glsl"
#include "cone/trace.glsl"
#include "cone/cone_set.glsl"
layout(local_size_x = 64) in;

uniform uint u_firstFace, u_endFace;  // of the list, of this dispatch
uniform float u_fixedPointUnit;    // steps of the sums for a radiance of 1
layout(std430, binding = COUNTER_STORAGE) coherent buffer Counters { VOXEL_COUNTERS };
layout(std430, binding = LIST_STORAGE) buffer List { uvec2 b_list[]; };  // face, what this bounce adds as RGB9E5
layout(std430, binding = PLACE_STORAGE) readonly buffer Places { uint b_places[]; };
layout(std430, binding = BOUNCED_STORAGE) readonly buffer Coverage { uvec2 b_coverage[]; };
#if !NEAR_FIELD
layout(std430, binding = FACE_STORAGE) readonly buffer Faces { FaceRecord b_faces[]; };
#endif
layout(std430, binding = GATHERED_STORAGE) buffer Gathered { uvec2 b_gathered[]; };

void main() {
    uint item = gl_WorkGroupID.y * gl_NumWorkGroups.x * 64u + gl_WorkGroupID.x * 64u + gl_LocalInvocationID.x;
    item += u_firstFace;
    if (item >= u_endFace) return;
    uint index = b_list[item].x, slot = index / 6u;
    FaceRecord face = b_faces[index];
    uint place = b_places[slot];
    int level = placeLevel(place);
    ivec3 voxel = fromToroidal(placeTexel(place), level);
    Cone cone;
    cone.origin = (vec3(voxel) + unpackPosition(face.position)) * float(1 << level);
    cone.normal = unpackOctahedral(face.normal);
    cone.tanHalfAngle = u_coneTanHalfAngle;
    cone.level = float(level);
    cone.near = u_nearDistance;
    mat3 frame = frameAround(cone.normal);
    // Neighbouring voxels turn their sets differently, so that what one set misses the next one sees.
    int turn = (voxel.x * 5 + voxel.y * 11 + voxel.z * 7) & 15;
    vec3 gathered = vec3(0.0);
    for (int i = 0; i < CONES; ++i) {
        vec4 local = coneOfSet(i, turnOf(turn, 16), shiftOf(turn, 16));
        cone.direction = frame * local.xyz;
        ConeResult result = traceCone(cone);
        gathered += local.w * (result.radiance + result.transmittance * skyRadiance(cone.direction, cone.tanHalfAngle));
    }
    gathered /= u_radianceScale;
    vec3 more = gathered - unpackHalf3(b_gathered[index]);
    uint hash = faceHash(place, index % 6u);
    b_gathered[index] = packHalf3(ditherToHalf(min(gathered, vec3(kMostHalf)), hash >> 13));
    b_list[item].y = packRgb9e5(more * (1.0 + (float(hash >> 26) - 31.5) / (64.0 * 384.0)));
    // What the face reflects of it, by area: the coverage of a surface along an axis is its area times that of its normal,
    // and so the squares of the normal share the area among the axes. Integer sums do not depend on the order of the
    // faces; a high word takes carries and signs.
    int side = int(index % 6u);
    vec3 added = unpackAlbedo(face.albedo) * more *
                 (faceCoverage(b_coverage[slot], side) * abs(cone.normal[side >> 1]) * u_fixedPointUnit);
    for (int c = 0; c < 3; ++c) {
        int signedSteps = int(round(clamp(added[c], -1e9, 1e9)));
        if (signedSteps == 0) continue;
        uint steps = uint(signedSteps), old = atomicAdd(b_added[2 * c], steps);
        uint high = (old + steps < old ? 1u : 0u) + (signedSteps < 0 ? 0xffffffffu : 0u);
        if (high != 0u) atomicAdd(b_added[2 * c + 1], high);
    }
}
