// Cones through the voxels. Needs the defines SIX_FACE, SH1, COMPOSITING_{LINEAR,EXPONENTIAL,ALPHA}, START_NORMAL, FOOTPRINT_CAP,
// AO_DISTANCE, NEAR_FIELD, CASCADES (more than one level), LAYERS, LEAVES and COUNT_SAMPLES.
//
// All lengths are in voxels of level 0, and positions are relative to the lattice's origin. A place is read at level
// max(log2 footprint, containment level), where a fraction blends two levels as densities per length.
#include "cascade/buffers.glsl"
#include "cascade/containment.glsl"
#include "cascade/records.glsl"

uniform int u_coarsest;          // the last mip
uniform float u_coneStep;        // footprints
uniform float u_coneGain;        // g
uniform float u_footprintCap;    // K
uniform float u_startOffset;     // voxels of the level at the start, times |n|_1
uniform float u_nearDistance;    // voxels of the level at the start
uniform float u_nudge;           // voxel diagonals of the level at the start
uniform float u_coneMaxDistance;
uniform float u_radianceScale;   // stored radiance times this is W/(m² sr)
uniform vec3 u_readableLow, u_readableHigh;  // cones end there
#if AO_DISTANCE
uniform float u_aoDistance;
uniform int u_aoFalloff;         // 0 none, 1 linear, 2 square root
#endif

uniform sampler3D u_coveragePositive;  // coverage of surfaces that look along +x, +y, +z; without SIX_FACE opacity
#if SIX_FACE
uniform sampler3D u_coverageNegative;  // … along -x, -y, -z
#endif
#if LEAVES
uniform sampler3D u_leaves;  // optical depth of leaves along x, y, z: not in the coverages
#endif
uniform usampler3D u_index;
#if LAYERS == 2
uniform usampler3D u_movingIndex;
#endif
// Radiance over u_radianceScale, and coverage, as half floats: six faces a slot, or what light/fold.comp makes of them.
layout(std430, binding = RADIANCE_STORAGE) readonly buffer Radiance { uvec2 b_radiance[]; };

// What is to be done with each sample of a cone: its distance, length (0 for a plane of the near field), level, and the
// result so far, whose radiance is not yet scaled. For cone/inspect.comp.
#ifndef RECORD
#define RECORD(t, length, lod, result)
#endif

#if COUNT_SAMPLES
// What the cones of all pixels did, each as low and high word: places that they looked at, which are voxels of their near
// fields and steps beyond; of these the near fields' voxels; levels looked up in the coverage volumes; levels of radiance.
layout(std430, binding = SAMPLE_STORAGE) buffer Samples { uvec2 b_samples[4]; };
uint g_counts[4] = uint[](0u, 0u, 0u, 0u);
#define COUNT(what) ++g_counts[what]
/// Once a pixel, at its end.
void storeSamples() {
    for (int i = 0; i < 4; ++i) {
        uint before = atomicAdd(b_samples[i].x, g_counts[i]);
        if (before + g_counts[i] < before) atomicAdd(b_samples[i].y, 1u);
    }
}
#else
#define COUNT(what)
void storeSamples() {}
#endif

struct Cone {
    vec3 origin;     // of the surface, not yet offset
    vec3 normal;     // geometric
    vec3 direction;
    float tanHalfAngle;
    float level;     // finest level to read: that of the voxel a cone starts from, or 0
    float near;      // reach of its near field, voxels of the level at the start: u_nearDistance, or nearOfOne()
};

/// Reach of the near field of a cone that has no others beside it to find what its axis misses: as far as it is thin.
float nearOfOne(float tanHalfAngle) { return clamp(0.75 / max(tanHalfAngle, 1e-3), min(2.0, u_nearDistance), u_nearDistance); }

struct ConeResult {
    vec3 radiance;        // without sky
    float transmittance;  // what is left for the sky
    float openness;       // transmittance with the occluders' distance weighted
};

float occluderWeight(float distance_) {
#if AO_DISTANCE
    float x = distance_ / u_aoDistance;
    if (x >= 1.0) return 0.0;
    return u_aoFalloff == 0 ? 1.0 : (u_aoFalloff == 1 ? 1.0 - x : 1.0 - sqrt(x));
#else
    return 1.0;
#endif
}

/// Distances along `d` from `o` to where it enters the voxels (0 from inside) and leaves them; it leaves before it enters
/// when it never meets them.
vec2 gridRange(vec3 o, vec3 d) {
    vec3 inverse = 1.0 / mix(d, vec3(1e-20), equal(d, vec3(0.0)));
    vec3 a = (u_readableLow - o) * inverse, b = (u_readableHigh - o) * inverse;
    vec3 near = min(a, b), far = max(a, b);
    return vec2(max(max(near.x, near.y), max(near.z, 0.0)), min(far.x, min(far.y, far.z)));
}

/// Level to read at distance t: of the cone's diameter, but no more than the height above the tangent plane over K, so that
/// a sample never reaches down into the surface that the cone leaves; and what is there.
float levelAt(Cone cone, vec3 start, float offset, float t) {
    float diameter = 2.0 * cone.tanHalfAngle * t;
#if FOOTPRINT_CAP
    diameter = min(diameter, max(t * dot(cone.normal, cone.direction), offset) / u_footprintCap);
#endif
#if !START_NORMAL
    diameter /= sqrt(3.0);
#endif
    float level = max(containmentLevel(start + cone.direction * t), cone.level);
    return clamp(log2(max(diameter, 1.0)), level, max(float(u_coarsest), level));
}

#if SIX_FACE
/// Takes away the surface that the cone leaves. Filtering spreads it 1.5 |n|_1 footprints high, over the start of the cone,
/// where its net normal would cancel that of a wall beside it, and the back of a sheet would stop the cone. What a plane
/// with this normal adds to the faces is proportional to the normal, so it is at most what all of them have in common, and
/// at most what the plane's filtered profile allows at this height.
void withoutOwnPlane(Cone cone, float height, float diameter, inout vec3 positive, inout vec3 negative) {
    vec3 a = abs(cone.normal);
    float profile = clamp(1.5 - height / (diameter * (a.x + a.y + a.z)), 0.0, 1.0) / diameter;
    if (profile == 0.0) return;
    bvec3 up = greaterThan(cone.normal, vec3(0.0));
    bvec3 edgeOn = lessThan(a, vec3(0.05));
    vec3 front = mix(negative, positive, up), back = mix(positive, negative, up);
    vec3 frontShare = mix(front / max(a, vec3(1e-6)), vec3(1e6), edgeOn);
    vec3 backShare = mix(back / max(a, vec3(1e-6)), vec3(1e6), edgeOn);
    float own = min(profile, min(frontShare.x, min(frontShare.y, frontShare.z)));
    float ownBack = min(own, min(backShare.x, min(backShare.y, backShare.z)));
    front = max(front - own * a, vec3(0.0));
    back = max(back - ownBack * a, vec3(0.0));
    positive = mix(back, front, up);
    negative = mix(front, back, up);
}
#endif

/// Texture coordinates of `x` at a level of the coverage volumes, whose borders make its toroidal box whole.
vec3 coverageCoordinates(vec3 x, int level, vec3 texels) {
    float size = float(levelResolution(level));
    vec3 p = x * exp2(-float(level));
    p = level < u_firstFixed ? p - size * floor(p / size) : clamp(p, 0.0, size);
    return (vec3(levelOrigin(level, 1)) + p) / texels;
}

/// What a coverage of 1 is at a level as density per unit of length. Without SIX_FACE mips hold mean opacities (see
/// voxelize/mip_resolve.comp), and COMPOSITING_ALPHA takes opacities as they are.
float densityScale(int level) {
#if SIX_FACE
    return exp2(-float(level));
#elif COMPOSITING_ALPHA
    return 1.0;
#else
    return exp2(-float(min(level, u_levels - 1)));
#endif
}

/// Densities per unit of length. At a whole level nothing of another one is read.
void densitiesAt(vec3 x, float lod, out vec3 positive, out vec3 negative) {
    vec3 texels = vec3(textureSize(u_coveragePositive, 0));
    int level = int(lod);
    float next = lod - float(level);
    vec3 at = coverageCoordinates(x, level, texels);
    COUNT(2);
    float scale = densityScale(level) * (1.0 - next);
    positive = scale * textureLod(u_coveragePositive, at, 0.0).rgb;
#if SIX_FACE
    negative = scale * textureLod(u_coverageNegative, at, 0.0).rgb;
#else
    negative = vec3(0.0);
#endif
    if (next > 0.0) {
        at = coverageCoordinates(x, level + 1, texels);
        COUNT(2);
        scale = densityScale(level + 1) * next;
        positive += scale * textureLod(u_coveragePositive, at, 0.0).rgb;
#if SIX_FACE
        negative += scale * textureLod(u_coverageNegative, at, 0.0).rgb;
#endif
    }
}

#if LEAVES
/// Optical depth of leaves along the axes per unit of length.
vec3 leavesAt(vec3 x, float lod) {
    vec3 texels = vec3(textureSize(u_leaves, 0));
    int level = int(lod);
    float next = lod - float(level);
    vec3 leaves = exp2(-float(level)) * (1.0 - next) *
                  textureLod(u_leaves, coverageCoordinates(x, level, texels), 0.0).rgb;
    if (next > 0.0)
        leaves += exp2(-float(level + 1)) * next *
                  textureLod(u_leaves, coverageCoordinates(x, level + 1, texels), 0.0).rgb;
    return leaves;
}
#endif

/// Adds radiance times coverage, and coverage, of a record: of one of its faces, or of what it shows against `d`.
void addRecord(uint mark, int face, vec3 d, float weight, inout vec4 sum) {
    if (mark == 0u) return;
    uint slot = mark - 1u;
#if SIX_FACE
    vec4 stored = unpackHalf4(b_radiance[slot * 6u + uint(face)]);
    sum += weight * stored.a * vec4(stored.rgb, 1.0);
#elif SH1
    vec4 shown = unpackHalf4(b_radiance[slot * 4u]) - d.x * unpackHalf4(b_radiance[slot * 4u + 1u]) -
                 d.y * unpackHalf4(b_radiance[slot * 4u + 2u]) - d.z * unpackHalf4(b_radiance[slot * 4u + 3u]);
    if (shown.a > 0.0) sum += weight * max(shown, vec4(0.0));
#else
    vec4 stored = unpackHalf4(b_radiance[slot]);
    sum += weight * stored.a * vec4(stored.rgb, 1.0);
#endif
}

/// The same of voxel `i` of a level, unless the level ends before it.
void addVoxel(ivec3 i, int level, ivec3 origin, int face, vec3 d, float weight, inout vec4 sum) {
    ivec3 mask = ivec3(levelResolution(level) - 1);
    if (level >= u_firstFixed && any(notEqual(i & ~mask, ivec3(0)))) return;
    ivec3 texel = origin + (i & mask);
    addRecord(texelFetch(u_index, texel, 0).r, face, d, weight, sum);
#if LAYERS == 2
    if (level < u_levels) addRecord(texelFetch(u_movingIndex, texel, 0).r, face, d, weight, sum);
#endif
}

/// The same of the eight voxels around `x` at one level, as trilinear filtering weights them. Written out: as a loop inside
/// those over steps and cones it would use up the iterations that drivers run (see traceConeTo).
void addLevel(vec3 x, int level, int face, vec3 d, float weight, inout vec4 sum) {
    COUNT(3);
    vec3 p = x * exp2(-float(level)) - 0.5;
    vec3 low = floor(p), f = p - low, g = 1.0 - f;
    ivec3 first = ivec3(low), origin = levelOrigin(level, 0);
    addVoxel(first, level, origin, face, d, weight * g.x * g.y * g.z, sum);
    addVoxel(first + ivec3(1, 0, 0), level, origin, face, d, weight * f.x * g.y * g.z, sum);
    addVoxel(first + ivec3(0, 1, 0), level, origin, face, d, weight * g.x * f.y * g.z, sum);
    addVoxel(first + ivec3(1, 1, 0), level, origin, face, d, weight * f.x * f.y * g.z, sum);
    addVoxel(first + ivec3(0, 0, 1), level, origin, face, d, weight * g.x * g.y * f.z, sum);
    addVoxel(first + ivec3(1, 0, 1), level, origin, face, d, weight * f.x * g.y * f.z, sum);
    addVoxel(first + ivec3(0, 1, 1), level, origin, face, d, weight * g.x * f.y * f.z, sum);
    addVoxel(first + ivec3(1, 1, 1), level, origin, face, d, weight * f.x * f.y * f.z, sum);
}

/// Mean radiance around `x` of a face, or of all that looks against `d`; black where there is none.
vec3 radianceAt(vec3 x, float lod, int face, vec3 d) {
    vec4 sum = vec4(0.0);
    int level = int(lod);
    float next = lod - float(level);
    addLevel(x, level, face, d, densityScale(level) * (1.0 - next), sum);
    if (next > 0.0) addLevel(x, level + 1, face, d, densityScale(level + 1) * next, sum);
    return sum.a > 0.0 ? sum.rgb / sum.a : vec3(0.0);
}

#if SIX_FACE
/// What a cone meets at one place.
struct Crossing {
    float density;  // optical density against the cone
    vec3 facing;    // densities, by axis, of the faces that look against the cone
};

/// `x` is `height` above the tangent plane of the cone's origin.
Crossing crossingAt(Cone cone, vec3 x, float height, float diameter, float lod) {
    vec3 positive, negative;
    densitiesAt(x, lod, positive, negative);
    bvec3 ascending = greaterThan(cone.direction, vec3(0.0));
    Crossing crossing;
#if START_NORMAL
    withoutOwnPlane(cone, height, diameter, positive, negative);
#endif
    crossing.facing = mix(positive, negative, ascending);
    // Net normal for surfaces of one side, so that a plane never stops a cone that leaves it, and what looks both ways.
    crossing.density = max(0.0, dot(negative - positive, cone.direction)) +
                       dot(abs(cone.direction), min(positive, negative));
    return crossing;
}
#endif

#if NEAR_FIELD
layout(std430, binding = FACE_STORAGE) readonly buffer Faces { FaceRecord b_faces[]; };
#if LEAVES
layout(std430, binding = TRACED_STORAGE) readonly buffer Traced { uvec4 b_traced[]; };
#else
layout(std430, binding = TRACED_STORAGE) readonly buffer Traced { uvec2 b_traced[]; };
#endif
#include "cone/near.glsl"
#endif

/// Up to `reach` from the origin.
ConeResult traceConeTo(Cone cone, float reach) {
    vec3 d = cone.direction;
    vec3 n = cone.normal;
    float startLevel = max(containmentLevel(cone.origin), cone.level), edge = exp2(startLevel);
#if START_NORMAL
    float offset = u_startOffset * edge * (abs(n.x) + abs(n.y) + abs(n.z));
    float t = 0.0;
#else
    // Eq. 3.4 of the thesis, after Rauwendaal 2013; kept finite at grazing angles.
    float offset = 0.0;
    float t = u_nudge * edge * sqrt(3.0) / max(dot(n, d), 1.0 / float(u_resolution));
#endif
    vec3 o = cone.origin;
    vec2 range = gridRange(o, d);
    t = max(t, range.x);
    float end = min(range.y, reach);

    ConeResult result = ConeResult(vec3(0.0), 1.0, 1.0);
    float tau = 0.0;
#if LEAVES
    float leafTau = 0.0, skipped = offset;  // leaves between surface and start: as dense as in the first segment
#endif
#if NEAR_FIELD
    float near = cone.near * edge;
    nearField(cone, startLevel, near, reach, result);
    float open = result.transmittance;
#if !LEAVES
    t = max(t, near / 3.0);  // up to here all weight is on the near field, which meets all but leaves
#endif
    if (open < 1e-3) t = end;
#else
    const float open = 1.0;
#endif
    // Steps are at least a tenth of a voxel long (the range of cone.step); 65535 iterations are all some drivers run.
    float from = t;
    int done = 0;  // steps of level 0 marched
    for (int i = 0; i < 4096 && t < end; ++i) {
        COUNT(0);
        float lod = levelAt(cone, o, offset, t);
#if START_NORMAL
        // The step is that of the whole level below, and begins at a multiple of itself: where a level begins, which moves
        // with the camera, two steps become one and the samples behind stay where they are.
        int stepLevel = done == 0 ? int(lod) : min(int(lod), findLSB(done));
        done += 1 << stepLevel;
        float ds = min(u_coneStep * exp2(float(stepLevel)), end - t);
        // The middle of the segment may lie in a coarser level already.
        vec3 x = o + d * (t + 0.5 * ds);
        // Next to the surface that the cone leaves walls end, and filtered they are half open.
        float lift = offset;
#if !SIX_FACE
        // One opacity for all directions holds the surface itself, from the middle of its voxels, which may lie half a
        // voxel above it, as far as the filter reaches: one more voxel of the level that is read.
        lift = max(lift, 1.5 * exp2(lod) * (abs(n.x) + abs(n.y) + abs(n.z)));
#endif
        x += n * max(0.0, lift - dot(x - o, n));
#if CASCADES
        lod = max(lod, containmentLevel(x));
#endif
#else
        float ds = min(u_coneStep * max(2.0 * cone.tanHalfAngle * t, exp2(lod)), end - t);
        vec3 x = o + d * t;
#endif

#if SIX_FACE
        Crossing crossing = crossingAt(cone, x, max(dot(x - o, n), offset), exp2(lod), lod);
        float density = crossing.density;
#if NEAR_FIELD
        density *= 1.0 - nearWeight(t + 0.5 * ds, near);
#endif
#else
        vec3 opacity, none;
        densitiesAt(x, lod, opacity, none);
        float density = opacity.r;
#endif
#if LEAVES
        // Leaves turned all ways: the ellipsoid of their projected areas (Heitz et al. 2015, "The SGGX microflake
        // distribution"), and what they let pass multiplies.
        vec3 leaves = leavesAt(o + n * offset + d * (t + 0.5 * ds), lod);  // above those that the cone leaves
        float leafDensity = 0.92 * length(d * leaves);
        leafTau += leafDensity * (ds + skipped);
        skipped = 0.0;
#if SIX_FACE
        crossing.facing += leaves;
#endif
        if (density > 0.0 || leafDensity > 0.0) {
#else
        if (density > 0.0) {
#endif
#if COMPOSITING_LINEAR
            tau += density * ds;
            float after = max(0.0, open - u_coneGain * tau);
#if LEAVES
            after *= exp(-leafTau);
#endif
#elif COMPOSITING_EXPONENTIAL
            tau += density * ds;
            float after = open * exp(-u_coneGain * tau);
#else
            float after = result.transmittance * (1.0 - min(density, 1.0));
#endif
            float stopped = result.transmittance - after;
#if SIX_FACE
            // Of the faces met (those that look against the cone) the one that fills most is seen: it hides what lies
            // behind it. All faces of one surface hold the same radiance, so that nothing jumps where another takes over.
            vec3 seen = abs(d) * crossing.facing;
            int axis = seen.x >= seen.y && seen.x >= seen.z ? 0 : (seen.y >= seen.z ? 1 : 2);
            if (seen[axis] > 0.0 && stopped > 0.0)
                result.radiance += stopped * radianceAt(x, lod, 2 * axis + (d[axis] > 0.0 ? 1 : 0), d);
#else
            if (stopped > 0.0) result.radiance += stopped * radianceAt(x, lod, 0, d);
#endif
            result.openness -= stopped * occluderWeight(t);
            result.transmittance = after;
        }
        RECORD(t + 0.5 * ds, ds, lod, result)
        if (result.transmittance < 1e-3) break;
#if START_NORMAL
        t = from + u_coneStep * float(done);
#else
        t += ds;
#endif
    }
    result.radiance *= u_radianceScale;
    return result;
}

ConeResult traceCone(Cone cone) { return traceConeTo(cone, u_coneMaxDistance > 0.0 ? u_coneMaxDistance : 1e30); }
