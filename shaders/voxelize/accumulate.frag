// Second pass: adds each clipped triangle to the records of the voxels it lies in.
#include "voxelize/fragment_input.glsl"
VOXELIZE_VARYINGS(in)
#include "shared/material.glsl"
#include "shared/brdf.glsl"
#include "cascade/buffers.glsl"
#include "voxelize/region.glsl"
#include "cascade/records.glsl"
#include "voxelize/sums.glsl"

uniform uint u_firstRecord, u_recordCount;  // new records of this pass; more do not fit in a buffer at once
uniform float u_sheetGain;  // times the coverage of a sheet that a cone crosses is what it stops, as far as that is below 1
#if EMISSION
uniform float u_emissionUnit;  // fixed-point steps for a radiance of 1
#endif
layout(r32ui) uniform readonly uimage3D u_index;

layout(std430, binding = SUM_STORAGE) coherent buffer Records { uint b_sums[]; };
layout(std430, binding = COUNTER_STORAGE) coherent buffer Counters { VOXEL_COUNTERS };

// Rounding by a dither that only depends on the triangle and the voxel: unbiased for weights below the fixed-point step,
// and the same whatever the draw order.
uint g_dither;
uint hash(uint x) {  // PCG output permutation, Jarzynski and Olano 2020
    x = x * 747796405u + 2891336453u;
    x = ((x >> ((x >> 28) + 4u)) ^ x) * 277803737u;
    return (x >> 22) ^ x;
}
uint hash(vec3 p) { return hash(floatBitsToUint(p.x) ^ hash(floatBitsToUint(p.y) ^ hash(floatBitsToUint(p.z)))); }
float nextDither() {
    g_dither = hash(g_dither);
    return float(g_dither >> 8) * (1.0 / 16777216.0);
}
// A negative float (a normal's component may round to just below -1) or one beyond 32 bits has no conversion.
uint dithered(float value) { return uint(clamp(value + nextDither(), 0.0, 4294967040.0)); }

Surface surfaceOf(MaterialSample s) {
    float reflected = (1.0 - s.metallic) * (1.0 - s.transmission) * (1.0 - s.diffuseTransmission);
    return Surface(s.baseColor * reflected, mix(s.f0Dielectric, s.baseColor, s.metallic),
                   mix(s.specularFactor, 1.0, s.metallic), clamp(s.roughness * s.roughness, kMinAlpha, 1.0));
}

struct Surfel {
    vec3 albedo, normal, position, emission;
    float opacity;  // of what is there, by which the weights are scaled
};

#if COMPARE_AND_SWAP
// Running mean of Crassin and Green (OpenGL Insights, ch. 22): 8-bit colour and count in one word. The result depends on
// the order of fragments, and stops at 255 of them.
void meanInto(uint word, vec3 value) {
    uint expected = 0u;
    uvec3 q = uvec3(clamp(value, 0.0, 1.0) * 255.0 + 0.5);
    uint desired = q.x | (q.y << 8) | (q.z << 16) | (1u << 24);
    for (int attempt = 0; attempt < 1000; ++attempt) {
        uint found = atomicCompSwap(b_sums[word], expected, desired);
        if (found == expected) return;
        uint count = found >> 24;
        if (count == 255u) return;
        expected = found;
        vec3 mean = vec3(found & 255u, (found >> 8) & 255u, (found >> 16) & 255u);
        q = uvec3((mean * float(count) + clamp(value, 0.0, 1.0) * 255.0) / float(count + 1u) + 0.5);
        desired = q.x | (q.y << 8) | (q.z << 16) | ((count + 1u) << 24);
    }
}
void addToFace(uint record, int face, float weight, Surfel surfel) {
    uint base = record * uint(kRecordWords) + uint(face * kFaceWords);
    meanInto(base, surfel.albedo);
    meanInto(base + 1u, 0.5 * surfel.normal + 0.5);
    meanInto(base + 2u, surfel.position);
#if EMISSION
    meanInto(base + 3u, surfel.emission * u_emissionUnit);
#endif
}
#else
#if LEAVES
/// Optical depth over coverage of a piece of a leaf. It lets pass 1 - weight of what comes along the axis; leaves lie by
/// chance behind each other, so what they let pass multiplies, and logarithms add up. Filtering spreads a leaf over the
/// voxels around it, so that an opaque one that fills its voxel and had no end of depth would hide much more than itself.
/// The opacity of a screen is finer than voxels and takes no harm. The 0.4 is measured (docs/accuracy.md).
float leafDepth(float weight, float opacity) {
    float x = weight * (1.0 - 0.4 * opacity * opacity);
    return x < 1e-3 ? 1.0 + 0.5 * x : -log(1.0 - x) / x;
}
#endif

void addToFace(uint record, int face, float weight, Surfel surfel) {
    uint base = record * uint(kRecordWords) + uint(face * kFaceWords);
    uint w = dithered(weight * kUnit);
    if (w == 0u) return;
    if (b_sums[base] >= kSaturated) {
        atomicAdd(b_saturated, 1u);
        return;
    }
    atomicAdd(b_sums[base], w);
#if LEAVES
    if (materialLeaves()) {
        atomicAdd(b_sums[base + uint(kLeafWord)], w);
        atomicAdd(b_sums[base + uint(kLeafWord) + 1u],
                  dithered(float(w) * leafDepth(weight, surfel.opacity) * (kDepthUnit / kUnit)));
    }
#endif
    float fw = float(w);
    for (uint i = 0u; i < 3u; ++i) {
        atomicAdd(b_sums[base + 1u + i], dithered(fw * clamp(surfel.albedo[i], 0.0, 1.0)));
        atomicAdd(b_sums[base + 4u + i], dithered(fw * 0.5 * (surfel.normal[i] + 1.0)));
        atomicAdd(b_sums[base + 7u + i], dithered(fw * clamp(surfel.position[i], 0.0, 1.0)));
#if EMISSION
        uint e = dithered(weight * surfel.emission[i] * u_emissionUnit);
        if (e == 0u) continue;
        uint old = atomicAdd(b_sums[base + uint(kEmissionWord) + 2u * i], e);
        if (old + e < old) atomicAdd(b_sums[base + uint(kEmissionWord) + 1u + 2u * i], 1u);
#endif
    }
}

void addToPlane(uint record, int face, float weight, Surfel surfel) {
    uint word = record * uint(kRecordWords) + uint(face * kFaceWords + kPlaneWord);
    uint w = dithered(weight * kUnit);
    if (w == 0u || b_sums[word] >= kSaturated) return;
    atomicAdd(b_sums[word], w);
    for (uint i = 0u; i < 3u; ++i) {
        atomicAdd(b_sums[word + 1u + i], dithered(float(w) * 0.5 * (surfel.normal[i] + 1.0)));
        atomicAdd(b_sums[word + 4u + i], dithered(float(w) * clamp(surfel.position[i], 0.0, 1.0)));
    }
}
#endif

void main() {
    ivec2 cell = cellOfFragment();
    vec2 e1 = f_p1.xy - f_p0.xy, e2 = f_p2.xy - f_p0.xy;
    vec3 twiceArea = cross(f_p1 - f_p0, f_p2 - f_p0);  // z is its largest component
    float determinant = twiceArea.z;
    // Scaled before it is squared: the squares of tiny triangles' areas are below the range of floats.
    vec3 planeNormal = twiceArea / abs(determinant);
    vec3 frontNormal = sign(f_mirror) * unpermute(normalize(planeNormal), f_axis);
    // Texture space that a voxel covers on the triangle.
    vec4 uvE1 = f_uv1 - f_uv0, uvE2 = f_uv2 - f_uv0;
    vec2 uvArea = abs(uvE1.xz * uvE2.yw - uvE1.yw * uvE2.xz);
    vec2 uvPerVoxel = sqrt(uvArea / abs(determinant) / length(planeNormal));

    ivec2 depths = depthRange(cell);
    for (int z = depths.x; z <= depths.y; ++z) {
        Piece piece = pieceIn(vec3(cell, z), vec3(cell, z) + 1.0, 6);
        if (!piece.any) continue;
        vec3 middle = middleOf(piece);
        vec3 coverage = abs(unpermute(piece.area, f_axis));
#if BINARY_COVERAGE
        coverage = vec3(greaterThan(abs(frontNormal), vec3(1e-3)));
#else
        if (coverage.x + coverage.y + coverage.z <= 0.0) continue;
#endif
        ivec3 voxel = ivec3(unpermute(vec3(cell, z), f_axis));
        uint record = imageLoad(u_index, levelTexel(voxel, u_level)).r - kFresh - u_firstRecord;
        if (record >= u_recordCount) continue;

        // Barycentric coordinates from the projection; those of slivers are uncertain, but never leave the triangle.
        vec2 q = middle.xy - f_p0.xy;
        float b1 = clamp((q.x * e2.y - q.y * e2.x) / determinant, 0.0, 1.0);
        float b2 = clamp((q.y * e1.x - q.x * e1.y) / determinant, 0.0, 1.0 - b1);
        float b0 = 1.0 - b1 - b2;
        vec4 uv = b0 * f_uv0 + b1 * f_uv1 + b2 * f_uv2;
        vec4 color = b0 * f_color0 + b1 * f_color1 + b2 * f_color2;
        vec3 normal = b0 * f_n0 + b1 * f_n1 + b2 * f_n2;
        float length2 = dot(normal, normal);
        normal = length2 > 0.0 ? normal * inversesqrt(length2) : frontNormal;
        if (dot(normal, frontNormal) <= 0.0) normal = frontNormal;

        // The filtered alpha of a textured mask or a blended material is the share of the voxel that it covers.
        MaterialSample material = sampleMaterialFootprint(uv.xy, uv.zw, color, uvPerVoxel.x, uvPerVoxel.y);
        float opacity = material.alpha;
        if (materialAlphaMode() == ALPHA_MASK && !materialHas(BASE_COLOR_UNIT))
            opacity = opacity < materialAlphaCutoff() ? 0.0 : 1.0;
        // The fits of voxelAlbedo leave a trace of reflection even where there is none.
        vec3 albedo = materialUnlit() ? vec3(0.0) : voxelAlbedo(surfaceOf(material));
        // Cones pass what transmits as they pass what is not there: the rest reflects and emits all that the whole does.
        const float meanSchlickWeight = 1.0 / 21.0;
        vec3 passing = materialTransmittance(material, abs(f_mirror), meanSchlickWeight) +
                       material.diffuseTransmissionColor * (material.diffuseTransmission * (1.0 - material.transmission));
        float stopped = max(1.0 - dot(passing, vec3(1.0 / 3.0)), 1.0 / 255.0);
#if LEAVES
        float gain = materialLeaves() ? 1.0 : u_sheetGain;
#else
        float gain = u_sheetGain;
#endif
        if (stopped < 1.0) opacity *= stopped / gain;
        Surfel surfel = Surfel(min(albedo / stopped, vec3(1.0)), normal, unpermute(middle - vec3(cell, z), f_axis),
                               materialExtracted() ? vec3(0.0) : material.emission / stopped, opacity);

        atomicAdd(b_fragments, 1u);
        uvec3 v = uvec3(voxel) & 1023u;
        g_dither = hash(hash(f_p0) ^ hash(hash(f_p1) ^ hash(hash(f_p2) ^ (v.x | (v.y << 10) | (v.z << 20)))));
        for (int side = 0; side < 2; ++side) {
            if (side == 1) {
                if (u_closed) break;  // nothing ever sees the back of a watertight body
                surfel.normal = -surfel.normal;
                if (!materialDoubleSided()) surfel.emission = vec3(0.0);
            }
            float sign_ = side == 0 ? 1.0 : -1.0;
            for (int a = 0; a < 3; ++a) {
                float weight = coverage[a] * opacity;
                if (weight > 0.0) addToFace(record, 2 * a + int(sign_ * frontNormal[a] < 0.0), weight, surfel);
            }
#if !COMPARE_AND_SWAP
            uint next = g_dither;
            g_dither = ~next;
            for (int a = 0; a < 3; ++a) {
                float weight = coverage[a] * opacity * planeWeight(frontNormal[a]);
                if (weight > 0.0) addToPlane(record, 2 * a + int(sign_ * frontNormal[a] < 0.0), weight, surfel);
            }
            g_dither = next;
#endif
        }
    }
}
