// Radiance of the faces into the volume that cones read.
#include "voxelize/buffers.glsl"
#include "voxelize/records.glsl"
layout(local_size_x = 64) in;

uniform uint u_voxelCount;
uniform int u_resolution;
uniform float u_inverseRadianceScale;
layout(std430, binding = COUNTER_STORAGE) coherent buffer Counters { VOXEL_COUNTERS };
layout(std430, binding = VOXEL_STORAGE) readonly buffer Voxels { uint b_voxels[]; };
layout(std430, binding = RADIANCE_STORAGE) readonly buffer Radiance { vec4 b_radiance[]; };
layout(rgba16f) uniform writeonly image3D u_volume;

const float kMostHalf = 65504.0;

vec3 clampedToHalf(vec3 value) {
    if (any(greaterThan(value, vec3(kMostHalf)))) atomicAdd(b_clamped, 1u);
    return min(value, vec3(kMostHalf));
}

void main() {
    uint record = gl_WorkGroupID.y * gl_NumWorkGroups.x * 64u + gl_WorkGroupID.x * 64u + gl_LocalInvocationID.x;
    if (record >= u_voxelCount) return;
    ivec3 voxel = unpackVoxel(b_voxels[record]);
#if SIX_FACE
    for (int f = 0; f < 6; ++f) {
        vec4 face = b_radiance[record * 6u + uint(f)];
        imageStore(u_volume, voxel + ivec3(0, 0, f * u_resolution),
                   vec4(clampedToHalf(face.rgb * (face.a * u_inverseRadianceScale)), 0.0));
    }
#else
    vec4 sum = vec4(0.0);
    float opacity = 0.0;
    for (int f = 0; f < 6; ++f) {
        vec4 face = b_radiance[record * 6u + uint(f)];
        sum += vec4(face.rgb * face.a, face.a);
        opacity = max(opacity, face.a);
    }
    if (sum.a > 0.0)
        imageStore(u_volume, voxel,
                   vec4(clampedToHalf(sum.rgb * (opacity / sum.a * u_inverseRadianceScale)), opacity));
#endif
}
