// LEAVES: what each new voxel stops, in its record and in the volumes that cones filter. Runs before resolve.comp, from the
// same sums.
#include "cascade/buffers.glsl"
#include "cascade/records.glsl"
#include "voxelize/sums.glsl"
#include "cascade/coverage_store.glsl"
#include "voxelize/slots.glsl"
layout(local_size_x = 64) in;

uniform uint u_firstRecord, u_recordCount;
layout(r32ui) uniform readonly uimage3D u_index;
#if LAYERS == 2
layout(r32ui) uniform readonly uimage3D u_movingIndex;
#endif
layout(std430, binding = SUM_STORAGE) readonly buffer Records { uint b_sums[]; };
layout(std430, binding = FRESH_STORAGE) readonly buffer Fresh { uint b_freshList[]; };
layout(std430, binding = MATTER_STORAGE) buffer MatterBlock { uvec4 b_matter[]; };

void main() {
    if (gl_GlobalInvocationID.x >= u_recordCount) return;
    uint local = gl_GlobalInvocationID.x, number = u_firstRecord + local;
    uint place = b_freshList[number];
    vec3 positive = vec3(0.0), negative = vec3(0.0), depth = vec3(0.0);
    for (int f = 0; f < 6; ++f) {
        uint base = local * uint(kRecordWords) + uint(f * kFaceWords), leaf = base + uint(kLeafWord);
        float solid = min(float(b_sums[base] - b_sums[leaf]) / kUnit, 1.0);
        if ((f & 1) == 0) positive[f >> 1] = solid;
        else negative[f >> 1] = solid;
        // Sheets are on both sides, and bodies are entered as often as left.
        depth[f >> 1] += 0.5 * float(b_sums[leaf + 1u]) / kDepthUnit;
    }
    uvec4 matter = uvec4(packCoverage(positive), packCoverage(negative), packHalf3(min(depth, vec3(kMostHalf))));
    b_matter[slotOfFresh(number)] = matter;

    int level = placeLevel(place);
#if LAYERS == 2
    // Static geometry is resolved first, moving geometry then adds to it.
    ivec3 texel = levelOrigin(level, 0) + placeTexel(place);
    uint other = placeMoves(place) ? imageLoad(u_index, texel).r : imageLoad(u_movingIndex, texel).r;
    if (other != 0u && other < kFresh) matter = addMatter(matter, b_matter[other - 1u]);
#endif
    storeCoverage(placeTexel(place), level, matter);
}
