// Sums to means: fills the faces of each record and the two coverage volumes.
//
// A coverage is the projected area of the surfaces in the voxel that look along an axis, over the area of a voxel face,
// clamped to 1. It is an optical density per voxel edge, and mips keep it per edge of the finest voxel.
#include "voxelize/buffers.glsl"
#include "shared/octahedral.glsl"
#include "shared/rgb9e5.glsl"
#include "voxelize/records.glsl"
layout(local_size_x = 64) in;

uniform uint u_firstRecord, u_recordCount;
#if EMISSION
uniform float u_emissionUnit;
#endif
layout(std430, binding = COUNTER_STORAGE) coherent buffer Counters { VOXEL_COUNTERS };
layout(std430, binding = RECORD_STORAGE) readonly buffer Records { uint b_records[]; };
layout(std430, binding = VOXEL_STORAGE) readonly buffer Voxels { uint b_voxels[]; };
layout(std430, binding = FACE_STORAGE) writeonly buffer Faces { FaceRecord b_faces[]; };
layout(std430, binding = COVERAGE_STORAGE) writeonly buffer Coverage { float b_coverage[]; };
#if SIX_FACE
layout(rgba16) uniform writeonly image3D u_coveragePositive;
layout(rgba16) uniform writeonly image3D u_coverageNegative;
#endif

vec3 unpackByteMean(uint word) { return vec3(word & 255u, (word >> 8) & 255u, (word >> 16) & 255u) / 255.0; }

void main() {
    if (gl_GlobalInvocationID.x >= u_recordCount) return;
    uint local = gl_GlobalInvocationID.x, record = u_firstRecord + local;
    vec3 positive = vec3(0.0), negative = vec3(0.0);
    for (int f = 0; f < 6; ++f) {
        uint base = local * uint(kRecordWords) + uint(f * kFaceWords);
        FaceRecord face = FaceRecord(0u, 0u, 0u, 0u);
        float coverage = 0.0;
#if COMPARE_AND_SWAP
        if ((b_records[base] >> 24) != 0u) {
            coverage = 1.0;
            face.albedo = packAlbedo(unpackByteMean(b_records[base]));
            vec3 normal = 2.0 * unpackByteMean(b_records[base + 1u]) - 1.0;
            vec3 position = unpackByteMean(b_records[base + 2u]);
            vec3 emission = vec3(0.0);
#if EMISSION
            emission = unpackByteMean(b_records[base + 3u]) / u_emissionUnit;
#endif
#else
        float sum = float(b_records[base]);
        if (sum > 0.0) {
            coverage = min(sum / kUnit, 1.0);
            vec3 albedo, normal, position, emission = vec3(0.0);
            for (uint i = 0u; i < 3u; ++i) {
                albedo[i] = float(b_records[base + 1u + i]) / sum;
                normal[i] = 2.0 * float(b_records[base + 4u + i]) / sum - 1.0;
                position[i] = float(b_records[base + 7u + i]) / sum;
#if EMISSION
                float high = float(b_records[base + 11u + 2u * i]), low = float(b_records[base + 10u + 2u * i]);
                emission[i] = (high * 4294967296.0 + low) / u_emissionUnit / (sum / kUnit);
#endif
            }
            face.albedo = packAlbedo(albedo);
#endif
            // Opposed normals cancel only where a face's surfaces curl up inside one voxel; its axis is as good then.
            vec3 axis = vec3(0.0);
            axis[f >> 1] = (f & 1) == 0 ? 1.0 : -1.0;
            float length2 = dot(normal, normal);
            face.normal = packOctahedral(length2 > 1e-4 ? normal * inversesqrt(length2) : axis);
            face.position = packPosition(position);
            if (any(greaterThan(emission, vec3(kMaxRgb9e5)))) atomicAdd(b_clamped, 1u);
            face.emission = packRgb9e5(emission);
        }
        b_faces[record * 6u + uint(f)] = face;
        b_coverage[record * 6u + uint(f)] = coverage;
        if ((f & 1) == 0) positive[f >> 1] = coverage;
        else negative[f >> 1] = coverage;
    }
#if SIX_FACE
    ivec3 voxel = unpackVoxel(b_voxels[record]);
    imageStore(u_coveragePositive, voxel, vec4(positive, 0.0));
    imageStore(u_coverageNegative, voxel, vec4(negative, 0.0));
#endif
}
