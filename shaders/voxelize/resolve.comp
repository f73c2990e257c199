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

vec3 axisOf(int f) {
    vec3 axis = vec3(0.0);
    axis[f >> 1] = (f & 1) == 0 ? 1.0 : -1.0;
    return axis;
}

/// Weighted means over the surfaces that a face holds. The normal is shorter than 1 where they look different ways.
struct Plane {
    float weight;  // 0: none
    vec3 normal, position;
};

#if COMPARE_AND_SWAP
Plane meanPlane(uint base) {
    return Plane(float(b_sums[base] >> 24), 2.0 * unpackByteMean(b_sums[base + 1u]) - 1.0, unpackByteMean(b_sums[base + 2u]));
}
#else
/// Of a weight, and sums of a normal and a position from `word` on.
Plane planeAt(uint weight, uint word) {
    if (weight == 0u) return Plane(0.0, vec3(0.0), vec3(0.0));
    float w = float(weight);
    return Plane(w, 2.0 * vec3(uvec3(b_sums[word], b_sums[word + 1u], b_sums[word + 2u])) / w - 1.0,
                 vec3(uvec3(b_sums[word + 3u], b_sums[word + 4u], b_sums[word + 5u])) / w);
}
Plane meanPlane(uint base) { return planeAt(b_sums[base], base + 4u); }

// Where two walls meet in a voxel, the mean of both is a plane where nothing is, through which cones pass from next to the
// edge. So a face that holds both takes the plane of the one that looks along its axis most; of the other it knows the
// area, from a face that holds it alone, and takes away what it adds.
Plane g_planes[6], g_unmixed[6];

bool isPure(Plane plane) { return plane.weight > 0.0 && dot(plane.normal, plane.normal) > kPure * kPure; }
bool isMixed(Plane plane) { return dot(plane.normal, plane.normal) < kMixed * kMixed; }

Plane unmixed(int f) {
    Plane mean = g_planes[f];
    if (!isMixed(mean)) return mean;
    Plane rest = Plane(mean.weight, mean.weight * mean.normal, mean.weight * mean.position);
    Plane most = Plane(0.0, vec3(0.0), vec3(0.0));
    for (int g = 0; g < 6; ++g) {
        Plane pure = g_planes[g];
        float along = dot(pure.normal, axisOf(f)), own = dot(pure.normal, axisOf(g));
        if (g == f || along <= 0.0 || !isPure(pure)) continue;
        // Each once: from the face that it looks along most.
        bool again = false;
        for (int h = 0; h < 6; ++h)
            again = again || (h != g && h != f && isPure(g_planes[h]) && dot(g_planes[h].normal, pure.normal) > kPure &&
                              dot(g_planes[h].normal, axisOf(h)) > own);
        if (again) continue;
        float weight = pure.weight * along * planeWeight(along) / (own * planeWeight(own));
        rest.weight -= weight;
        rest.normal -= weight * pure.normal;
        rest.position -= weight * pure.position;
        if (weight > most.weight) most = Plane(weight, pure.normal, pure.position);
    }
    // Nothing else is in it: it is the plane of the most of it.
    if (rest.weight < kRest * mean.weight) {
        rest.weight += most.weight;
        rest.normal += most.weight * most.normal;
        rest.position += most.weight * most.position;
    }
    if (rest.weight < kRest * mean.weight) return mean;
    // What is left is one surface that looks to this side, or those taken for pure were not.
    rest.normal /= rest.weight, rest.position /= rest.weight;
    bool one = abs(length(rest.normal) - 1.0) < 0.1 && dot(rest.normal, axisOf(f)) > 0.0 &&
               all(lessThan(abs(rest.position - 0.5), vec3(0.6)));
    return one ? rest : mean;
}

/// The plane of face `f`, from the face that its surface looks along most, where it has the largest weight.
Plane wholePlane(int f) {
    Plane plane = g_planes[f];
    float most = dot(plane.normal, axisOf(f));
    for (int g = 0; g < 6; ++g) {
        Plane other = g_planes[g];
        float along = dot(other.normal, axisOf(g));
        if (other.weight > 0.0 && along > most && dot(other.normal, g_planes[f].normal) > 0.9 &&
            abs(dot(other.normal, other.position - g_planes[f].position)) < 0.1)
            plane = other, most = along;
    }
    return plane;
}
#endif

void main() {
    if (gl_GlobalInvocationID.x >= u_recordCount) return;
    uint local = gl_GlobalInvocationID.x, number = u_firstRecord + local;
    uint place = b_freshList[number], slot = slotOfFresh(number);
    vec3 positive = vec3(0.0), negative = vec3(0.0);
#if !COMPARE_AND_SWAP
    for (int f = 0; f < 6; ++f) {
        uint plane = local * uint(kRecordWords) + uint(f * kFaceWords + kPlaneWord);
        g_planes[f] = planeAt(b_sums[plane], plane + 1u);
    }
    for (int round_ = 0; round_ < 2; ++round_) {
        for (int f = 0; f < 6; ++f) g_unmixed[f] = unmixed(f);
        g_planes = g_unmixed;
    }
#endif
    for (int f = 0; f < 6; ++f) {
        uint base = local * uint(kRecordWords) + uint(f * kFaceWords);
        FaceRecord face = FaceRecord(0u, 0u, 0u);
        float coverage = 0.0;
        Plane plane = meanPlane(base);
        if (plane.weight > 0.0) {
            vec3 emission = vec3(0.0);
#if COMPARE_AND_SWAP
            coverage = 1.0;
            face.albedo = packAlbedo(unpackByteMean(b_sums[base]));
#if EMISSION
            emission = unpackByteMean(b_sums[base + 3u]) / u_emissionUnit;
#endif
#else
            float sum = float(b_sums[base]);
            coverage = min(sum / kUnit, 1.0);
            face.albedo =
                packAlbedo(vec3(uvec3(b_sums[base + 1u], b_sums[base + 2u], b_sums[base + 3u])) / sum);
#if EMISSION
            for (uint i = 0u; i < 3u; ++i) {
                uint word = base + uint(kEmissionWord) + 2u * i;
                emission[i] = (float(b_sums[word + 1u]) * 4294967296.0 + float(b_sums[word])) / u_emissionUnit /
                              (sum / kUnit);
            }
#endif
            if (isMixed(plane)) {
                Plane one = wholePlane(f);
                if (abs(length(one.normal) - 1.0) < kFlat) plane = one;
            }
#endif
            // Opposed normals cancel only where a face's surfaces curl up inside one voxel; its axis is as good then.
            float length2 = dot(plane.normal, plane.normal);
            face.normal =
                packOctahedral(length2 > 1e-4 ? plane.normal * inversesqrt(length2) : axisOf(f));
            face.position = packPosition(plane.position);
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
