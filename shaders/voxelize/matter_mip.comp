// LEAVES: what the new voxels of one mip stop, from their eight children. Runs after mip_resolve.comp of this mip.
//
// Solid coverage as there. Leaves: along each axis the children are four columns of two, and the voxel lets pass the mean of
// what those let pass: clumps leave gaps between them, and a mean of depths would fill those.
#include "cascade/buffers.glsl"
#include "cascade/records.glsl"
#include "cascade/coverage_store.glsl"
#include "voxelize/slots.glsl"
layout(local_size_x = 64) in;

uniform int u_level;
uniform uint u_firstRecord, u_recordCount;  // those of the mips among the new
layout(r32ui) uniform readonly uimage3D u_index;
#if LAYERS == 2
layout(r32ui) uniform readonly uimage3D u_movingIndex;
#endif
layout(std430, binding = FRESH_STORAGE) readonly buffer Fresh { uint b_freshList[]; };
layout(std430, binding = MATTER_STORAGE) buffer MatterBlock { uvec4 b_matter[]; };

uvec4 childMatter(ivec3 voxel, ivec3 corner) {
    ivec3 texel = levelTexel(2 * voxel + corner, u_level - 1);
    uint mark = imageLoad(u_index, texel).r;
    uvec4 matter = mark != 0u ? b_matter[mark - 1u] : uvec4(0u);
#if LAYERS == 2
    uint moving = u_level == u_levels ? imageLoad(u_movingIndex, texel).r : 0u;
    if (moving != 0u) matter = addMatter(matter, b_matter[moving - 1u]);
#endif
    return matter;
}

void main() {
    if (gl_GlobalInvocationID.x >= u_recordCount) return;
    uint number = u_firstRecord + gl_GlobalInvocationID.x;
    uint place = b_freshList[number];
    if (placeLevel(place) != u_level) return;
    ivec3 voxel = fromToroidal(placeTexel(place), u_level);

    vec3 positive = vec3(0.0), negative = vec3(0.0), depths[8];
    float opacity = 0.0;
    for (int child = 0; child < 8; ++child) {
        uvec4 matter = childMatter(voxel, ivec3(child & 1, (child >> 1) & 1, child >> 2));
        vec3 p = unpackCoverage(matter.x), n = unpackCoverage(matter.y), fullest = max(p, n);
        positive += 0.25 * p;
        negative += 0.25 * n;
        opacity += 0.125 * max(fullest.x, max(fullest.y, fullest.z));
        depths[child] = unpackHalf3(matter.zw);
    }
#if !SIX_FACE
    positive = negative = vec3(opacity);
#endif
    vec3 passed = vec3(0.0);
    for (int a = 0; a < 3; ++a) {
        int along = 1 << a;
        for (int child = 0; child < 8; ++child)
            if ((child & along) == 0) passed[a] += 0.25 * exp(-depths[child][a] - depths[child | along][a]);
    }
    uvec4 matter = uvec4(packCoverage(positive), packCoverage(negative), packHalf3(-log(clamp(passed, 1e-6, 1.0))));
    b_matter[slotOfFresh(number)] = matter;
    storeCoverage(voxel, u_level, matter);
}
