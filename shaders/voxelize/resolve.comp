// Sums to means: fills the faces of each new record and the volumes that cones filter.
//
// A coverage is the projected area of the surfaces in the voxel that look along an axis, over the area of a voxel face,
// clamped to 1. It is an optical density per voxel edge. With LEAVES, matter.comp fills the volumes.
#include "cascade/buffers.glsl"
#include "shared/octahedral.glsl"
#include "shared/rgb9e5.glsl"
#include "cascade/records.glsl"
#include "voxelize/sums.glsl"
#include "cascade/clipmap.glsl"
#if !LEAVES
#include "cascade/coverage_store.glsl"
#endif
#include "voxelize/slots.glsl"
layout(local_size_x = 64) in;

uniform uint u_firstRecord, u_recordCount;
layout(r32ui) uniform uimage3D u_index;
#if LAYERS == 2
layout(r32ui) uniform uimage3D u_movingIndex;
#endif
layout(std430, binding = COUNTER_STORAGE) coherent buffer Counters { VOXEL_COUNTERS };
layout(std430, binding = SUM_STORAGE) readonly buffer Records { uint b_sums[]; };
layout(std430, binding = FRESH_STORAGE) buffer Fresh { uint b_freshList[]; };
layout(std430, binding = PLACE_STORAGE) writeonly buffer Places { uint b_places[]; };
layout(std430, binding = FACE_STORAGE) writeonly buffer Faces { FaceRecord b_faces[]; };
layout(std430, binding = COVERAGE_STORAGE) buffer Coverage { uvec2 b_coverage[]; };
#if EMISSION
uniform float u_emissionUnit;
layout(std430, binding = EMISSION_STORAGE) writeonly buffer Emission { uint b_emission[]; };
#endif

vec3 unpackByteMean(uint word) { return vec3(word & 255u, (word >> 8) & 255u, (word >> 16) & 255u) / 255.0; }

void main() {
    if (gl_GlobalInvocationID.x >= u_recordCount) return;
    uint local = gl_GlobalInvocationID.x, number = u_firstRecord + local;
    uint place = b_freshList[number], slot = slotOfFresh(number);
    vec3 positive = vec3(0.0), negative = vec3(0.0);
    for (int f = 0; f < 6; ++f) {
        uint base = local * uint(kRecordWords) + uint(f * kFaceWords);
        FaceRecord face = FaceRecord(0u, 0u, 0u);
        float coverage = 0.0;
#if COMPARE_AND_SWAP
        if ((b_sums[base] >> 24) != 0u) {
            coverage = 1.0;
            face.albedo = packAlbedo(unpackByteMean(b_sums[base]));
            vec3 normal = 2.0 * unpackByteMean(b_sums[base + 1u]) - 1.0;
            vec3 position = unpackByteMean(b_sums[base + 2u]);
            vec3 emission = vec3(0.0);
#if EMISSION
            emission = unpackByteMean(b_sums[base + 3u]) / u_emissionUnit;
#endif
#else
        float sum = float(b_sums[base]);
        if (sum > 0.0) {
            coverage = min(sum / kUnit, 1.0);
            vec3 albedo, normal, position, emission = vec3(0.0);
            for (uint i = 0u; i < 3u; ++i) {
                albedo[i] = float(b_sums[base + 1u + i]) / sum;
                normal[i] = 2.0 * float(b_sums[base + 4u + i]) / sum - 1.0;
                position[i] = float(b_sums[base + 7u + i]) / sum;
#if EMISSION
                float high = float(b_sums[base + 11u + 2u * i]), low = float(b_sums[base + 10u + 2u * i]);
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
#if EMISSION
            if (any(greaterThan(emission, vec3(kMaxRgb9e5)))) atomicAdd(b_clamped, 1u);
            b_emission[slot * 6u + uint(f)] = packRgb9e5(emission);
#endif
        }
        b_faces[slot * 6u + uint(f)] = face;
        if ((f & 1) == 0) positive[f >> 1] = coverage;
        else negative[f >> 1] = coverage;
    }
    uvec2 coverage = uvec2(packCoverage(positive), packCoverage(negative));
    b_coverage[slot] = coverage;
    b_places[slot] = place;
    b_freshList[number] = slot;

    int level = placeLevel(place);
    ivec3 texel = levelOrigin(level, 0) + placeTexel(place);
#if LAYERS == 2
    // Static geometry is resolved first, moving geometry then adds to it.
    uint other;
    if (placeMoves(place)) {
        imageStore(u_movingIndex, texel, uvec4(slot + 1u));
        other = imageLoad(u_index, texel).r;
    } else {
        imageStore(u_index, texel, uvec4(slot + 1u));
        other = imageLoad(u_movingIndex, texel).r;
    }
    if (other != 0u && other < kFresh) coverage = addCoverage(coverage, b_coverage[other - 1u]);
#else
    imageStore(u_index, texel, uvec4(slot + 1u));
#endif
#if !LEAVES
    storeCoverage(placeTexel(place), level, uvec4(coverage, 0u, 0u));
#endif
}
