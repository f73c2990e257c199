// Direct light and emission of every voxel face that holds a surface: outgoing radiance of its Lambert stand-in, with the
// face's coverage in w.
#include "voxelize/buffers.glsl"
#include "voxelize/records.glsl"
#include "shared/octahedral.glsl"
#include "shared/rgb9e5.glsl"
#if LIGHTS
#include "light/lights.glsl"
#endif
layout(local_size_x = 64) in;

uniform uint u_faceCount;
uniform float u_voxelSize;
layout(std430, binding = COUNTER_STORAGE) coherent buffer Counters { VOXEL_COUNTERS };
layout(std430, binding = VOXEL_STORAGE) readonly buffer Voxels { uint b_voxels[]; };
layout(std430, binding = FACE_STORAGE) readonly buffer Faces { FaceRecord b_faces[]; };
layout(std430, binding = COVERAGE_STORAGE) readonly buffer Coverage { float b_coverage[]; };
layout(std430, binding = RADIANCE_STORAGE) writeonly buffer Radiance { vec4 b_radiance[]; };

void main() {
    uint index = gl_WorkGroupID.y * gl_NumWorkGroups.x * 64u + gl_WorkGroupID.x * 64u + gl_LocalInvocationID.x;
    if (index >= u_faceCount) return;
    FaceRecord face = b_faces[index];
    vec3 radiance = vec3(0.0);
    if (faceHoldsSurface(face)) {
        radiance = unpackRgb9e5(face.emission);
#if LIGHTS
        vec3 worldPos = (vec3(unpackVoxel(b_voxels[index / 6u])) + unpackPosition(face.position)) * u_voxelSize;
        vec3 normal = unpackOctahedral(face.normal);
        // A record is the mean of what lies in its voxel: a quarter of an edge is how far a bent surface is from it.
        radiance += unpackAlbedo(face.albedo) * directIrradiance(worldPos, normal, 0.5 * u_voxelSize) * 0.318309886;
#endif
        float largest = max(radiance.r, max(radiance.g, radiance.b));
        // Floats that are not negative compare like their bits.
        atomicMax(b_brightest, floatBitsToUint(largest));
    }
    b_radiance[index] = vec4(radiance, b_coverage[index]);
}
