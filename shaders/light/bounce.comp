// One bounce: every voxel face gathers the radiance volume by cones, and adds what it reflects to its direct light.
#include "voxelize/buffers.glsl"
#include "voxelize/records.glsl"
#include "shared/octahedral.glsl"
#include "cone/sky.glsl"
#include "cone/trace.glsl"
#include "cone/cone_set.glsl"
layout(local_size_x = 64) in;

uniform uint u_faceCount;
uniform float u_fixedPointUnit;    // steps of the sums for a radiance of 1
uniform vec3 u_tail;               // what all further bounces add, over what this one adds
layout(std430, binding = COUNTER_STORAGE) coherent buffer Counters { VOXEL_COUNTERS };
layout(std430, binding = DIRECT_STORAGE) readonly buffer Direct { vec4 b_direct[]; };
layout(std430, binding = VOXEL_STORAGE) readonly buffer Voxels { uint b_voxels[]; };
layout(std430, binding = FACE_STORAGE) readonly buffer Faces { FaceRecord b_faces[]; };
layout(std430, binding = RADIANCE_STORAGE) buffer Radiance { vec4 b_radiance[]; };

void main() {
    uint index = gl_WorkGroupID.y * gl_NumWorkGroups.x * 64u + gl_WorkGroupID.x * 64u + gl_LocalInvocationID.x;
    if (index >= u_faceCount) return;
    FaceRecord face = b_faces[index];
    if (!faceHoldsSurface(face)) return;
    ivec3 voxel = unpackVoxel(b_voxels[index / 6u]);
    Cone cone;
    cone.origin = vec3(voxel) + unpackPosition(face.position);
    cone.normal = unpackOctahedral(face.normal);
    cone.tanHalfAngle = u_coneTanHalfAngle;
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
    vec4 before = b_radiance[index];
    vec3 after = b_direct[index].rgb + unpackAlbedo(face.albedo) * gathered;
    vec3 added = after - before.rgb;
    b_radiance[index].rgb = max(after + u_tail * added, vec3(0.0));
    // Integer sums do not depend on the order of the faces; a high word takes the carries.
    for (int c = 0; c < 3; ++c) {
        uint steps = uint(clamp(added[c] * before.a * u_fixedPointUnit, 0.0, 1e9));
        uint old = atomicAdd(b_added[2 * c], steps);
        if (old + steps < old) atomicAdd(b_added[2 * c + 1], 1u);
    }
}
