// New records of one mip level from their eight children.
//
// A surface that crosses a coarse cell fills half of its children, so its coverage of the coarse face is twice their mean,
// clamped at 1 where the surfaces of a cell hide each other. Without SIX_FACE opacity is plainly averaged (thesis, 3.4.2),
// and every face that holds a surface is given it. With LEAVES, matter_mip.comp fills the volumes.
#include "cascade/buffers.glsl"
#include "shared/octahedral.glsl"
#include "shared/rgb9e5.glsl"
#include "cascade/records.glsl"
#include "cascade/clipmap.glsl"
#if !LEAVES
#include "cascade/coverage_store.glsl"
#endif
#include "voxelize/slots.glsl"
layout(local_size_x = 64) in;

uniform int u_level;
uniform uint u_firstRecord, u_recordCount;  // those of the mips among the new
layout(r32ui) uniform uimage3D u_index;
#if LAYERS == 2
layout(r32ui) uniform readonly uimage3D u_movingIndex;
#endif
layout(std430, binding = FRESH_STORAGE) readonly buffer Fresh { uint b_freshList[]; };
layout(std430, binding = PLACE_STORAGE) writeonly buffer Places { uint b_places[]; };
layout(std430, binding = FACE_STORAGE) buffer Faces { FaceRecord b_faces[]; };
layout(std430, binding = COVERAGE_STORAGE) buffer Coverage { uvec2 b_coverage[]; };
#if EMISSION
layout(std430, binding = EMISSION_STORAGE) buffer Emission { uint b_emission[]; };
#endif

/// Index volume's word of a child of static (layer 0) or moving geometry; mips hold both in layer 0.
uint childMark(ivec3 voxel, int child, int layer) {
    ivec3 texel = levelTexel(2 * voxel + ivec3(child & 1, (child >> 1) & 1, child >> 2), u_level - 1);
#if LAYERS == 2
    if (layer == 1) return u_level == u_levels ? imageLoad(u_movingIndex, texel).r : 0u;
#endif
    return imageLoad(u_index, texel).r;
}

void main() {
    if (gl_GlobalInvocationID.x >= u_recordCount) return;
    uint number = u_firstRecord + gl_GlobalInvocationID.x;
    uint place = b_freshList[number];
    if (placeLevel(place) != u_level) return;
    uint slot = slotOfFresh(number);
    ivec3 voxel = fromToroidal(placeTexel(place), u_level);

    float opacity = 0.0;
    for (int child = 0; child < 8; ++child) {
        uvec2 both = uvec2(0u);
        for (int layer = 0; layer < LAYERS; ++layer) {
            uint mark = childMark(voxel, child, layer);
            if (mark != 0u) both = addCoverage(both, b_coverage[mark - 1u]);
        }
        vec3 fullest = max(unpackCoverage(both.x), unpackCoverage(both.y));
        opacity += 0.125 * max(fullest.x, max(fullest.y, fullest.z));
    }

    vec3 positive = vec3(0.0), negative = vec3(0.0);
    for (int f = 0; f < 6; ++f) {
        float sum = 0.0;
        vec3 albedo = vec3(0.0), normal = vec3(0.0), position = vec3(0.0), emission = vec3(0.0);
        for (int c = 0; c < 8; ++c) {
            float share = 0.0;
            for (int layer = 0; layer < LAYERS; ++layer) {
                uint child = childMark(voxel, c, layer);
                if (child == 0u) continue;
                uint index = (child - 1u) * 6u + uint(f);
                float weight = faceCoverage(b_coverage[child - 1u], f);
                if (weight == 0.0) continue;
                share += weight;
                FaceRecord face = b_faces[index];
                albedo += weight * unpackAlbedo(face.albedo);
                normal += weight * unpackOctahedral(face.normal);
                position += weight * 0.5 * (vec3(c & 1, (c >> 1) & 1, c >> 2) + unpackPosition(face.position));
#if EMISSION
                emission += weight * unpackRgb9e5(b_emission[index]);
#endif
                sum += weight;
            }
#if SIX_FACE
            share = 0.25 * min(share, 1.0);
#else
            share = 0.0;
#endif
            if ((f & 1) == 0) positive[f >> 1] += share;
            else negative[f >> 1] += share;
        }
        FaceRecord face = FaceRecord(0u, 0u, 0u);
        uint emitted = 0u;
        if (sum > 0.0) {
            vec3 axis = vec3(0.0);
            axis[f >> 1] = (f & 1) == 0 ? 1.0 : -1.0;
            float length2 = dot(normal, normal);
            face.normal = packOctahedral(length2 > 1e-4 * sum * sum ? normal * inversesqrt(length2) : axis);
            face.albedo = packAlbedo(albedo / sum);
            face.position = packPosition(position / sum);
            emitted = packRgb9e5(emission / sum);
#if !SIX_FACE
            if ((f & 1) == 0) positive[f >> 1] = opacity;
            else negative[f >> 1] = opacity;
#endif
        }
        b_faces[slot * 6u + uint(f)] = face;
#if EMISSION
        b_emission[slot * 6u + uint(f)] = emitted;
#endif
    }
    uvec2 coverage = uvec2(packCoverage(positive), packCoverage(negative));
    b_coverage[slot] = coverage;
    b_places[slot] = place;
    imageStore(u_index, levelTexel(voxel, u_level), uvec4(slot + 1u));
#if !LEAVES
    storeCoverage(voxel, u_level, uvec4(coverage, 0u, 0u));
#endif
}
