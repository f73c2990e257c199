// What the faces of one level gather, from those of the next coarser one around them: the mean over the eight voxels around
// the face, by trilinear weight, coverage, and how far each coarse face looks the same way.
#include "cascade/buffers.glsl"
#include "cascade/clipmap.glsl"
#include "cascade/records.glsl"
#include "shared/octahedral.glsl"
layout(local_size_x = 64) in;

uniform int u_level;
uniform uint u_slotCount;
uniform bool u_listed;  // the slots of the list; else the first ones
uniform usampler3D u_index;
#if LAYERS == 2
uniform usampler3D u_movingIndex;
#endif
layout(std430, binding = LIST_STORAGE) readonly buffer List { uint b_list[]; };
layout(std430, binding = PLACE_STORAGE) readonly buffer Places { uint b_places[]; };
layout(std430, binding = FACE_STORAGE) readonly buffer Faces { FaceRecord b_faces[]; };
layout(std430, binding = COVERAGE_STORAGE) readonly buffer Coverage { uvec2 b_coverage[]; };
layout(std430, binding = GATHERED_STORAGE) buffer Gathered { uvec2 b_gathered[]; };

/// Adds a coarse record; any_ what its faces gather whatever they look to, for faces that find none of their kind.
void addRecord(uint mark, vec3 normal, float weight, inout vec4 sum, inout vec4 any_) {
    if (mark == 0u || mark >= kFresh) return;
    uint coarse = mark - 1u;
    uvec2 coverage = b_coverage[coarse];
    for (int f = 0; f < 6; ++f) {
        float share = weight * faceCoverage(coverage, f);
        if (share == 0.0) continue;
        float along = (f & 1) == 0 ? normal[f >> 1] : -normal[f >> 1];
        vec4 value = vec4(unpackHalf3(b_gathered[coarse * 6u + uint(f)]), 1.0);
        any_ += share * value;
        if (along > 0.0) sum += share * along * along * value;
    }
}

void main() {
    uint item = gl_WorkGroupID.y * gl_NumWorkGroups.x * 64u + gl_WorkGroupID.x * 64u + gl_LocalInvocationID.x;
    if (item >= u_slotCount) return;
    uint slot = u_listed ? b_list[item] : item;
    uint place = b_places[slot];
    if (!placeInUse(place) || placeLevel(place) != u_level) return;
    ivec3 voxel = fromToroidal(placeTexel(place), u_level);
    uvec2 coverage = b_coverage[slot];
    int coarse = u_level + 1;
    ivec3 mask = ivec3(u_resolution - 1), origin = levelOrigin(coarse, 0);
    ivec3 coarseLow = u_windowLow[coarse];
    for (int f = 0; f < 6; ++f) {
        if (faceCoverage(coverage, f) == 0.0) continue;
        FaceRecord face = b_faces[slot * 6u + uint(f)];
        vec3 normal = unpackOctahedral(face.normal);
        vec3 p = 0.5 * (vec3(voxel) + unpackPosition(face.position)) - 0.5, first = floor(p), t = p - first;
        vec4 sum = vec4(0.0), any_ = vec4(0.0);
        for (int i = 0; i < 8; ++i) {
            ivec3 corner = ivec3(i & 1, (i >> 1) & 1, i >> 2), at = ivec3(first) + corner;
            if (any(lessThan(at, coarseLow)) || any(greaterThanEqual(at, coarseLow + u_resolution))) continue;
            vec3 w = mix(1.0 - t, t, vec3(corner));
            ivec3 texel = origin + (at & mask);
            addRecord(texelFetch(u_index, texel, 0).r, normal, w.x * w.y * w.z, sum, any_);
#if LAYERS == 2
            addRecord(texelFetch(u_movingIndex, texel, 0).r, normal, w.x * w.y * w.z, sum, any_);
#endif
        }
        if (sum.a <= 0.0) sum = any_;
        b_gathered[slot * 6u + uint(f)] = sum.a > 0.0 ? packHalf3(sum.rgb / sum.a) : uvec2(0u);
    }
}
