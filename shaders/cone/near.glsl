// The near field of a cone: exact visibility over its first voxels. A voxel's face keeps the mean position, normal and
// coverage of the surfaces in it, which for a flat piece of surface is a plane that can be met exactly. So what stands
// within a voxel or two of a surface neither vanishes below a start offset nor is smeared over the filter's width.
//
// What a plane at distance t adds to the optical depth counts with nearWeight(t), and what the filtered volumes hold at t
// with 1 - nearWeight(t). Filtering spreads a wall symmetrically, so the two add up to the whole wall where the weight is
// linear. Needs the define NEAR_FIELD, and trace.glsl.
#include "shared/octahedral.glsl"

/// `t` and the reach of the near field in the same unit.
float nearWeight(float t, float near) { return clamp(1.5 * (1.0 - t / near), 0.0, 1.0); }

/// Area (z) and first moments (xy) of the part of the unit square where dot(slope, (u, v)) <= s. Slopes are positive. The
/// triangle below the line, less those beyond u = 1 and v = 1, plus what both took away.
vec3 momentsBelow(float s, vec2 slope) {
    vec4 q = max(vec4(s, s - slope.x, s - slope.y, s - slope.x - slope.y), vec4(0.0));
    vec4 area = q * q * vec4(1.0, -1.0, -1.0, 1.0) / (2.0 * slope.x * slope.y);
    vec4 u = q / (3.0 * slope.x) + vec4(0.0, 1.0, 0.0, 1.0), v = q / (3.0 * slope.y) + vec4(0.0, 0.0, 1.0, 1.0);
    return vec3(dot(area, u), dot(area, v), area.x + area.y + area.z + area.w);
}

/// How much of the plane through `p` with unit normal `n` is surface at its point `x`, 0 to 1, in a voxel whose surface in
/// that plane has centre of gravity `p` and `coverage` along `axis`; all relative to the voxel's lower corner. A voxel at the
/// edge of a surface is filled in part, on the side that the centre of gravity says, and up to `margin` further.
/// What is scattered over the voxel, or lets a part of the light pass, stops as much as it does when filtered.
float planeShare(vec3 n, vec3 p, vec3 x, float coverage, int axis, float margin) {
    // Seen along the plane's dominant axis, the cut of the voxel is the part of the unit square over which it is in range.
    vec3 a = abs(n), k;
    vec2 centre, at;
    float height;
    if (a.x >= a.y && a.x >= a.z) k = vec3(-n.yz / n.x, a.x), centre = p.yz, at = x.yz, height = p.x;
    else if (a.y >= a.z) k = vec3(-n.xz / n.y, a.y), centre = p.xz, at = x.xz, height = p.y;
    else k = vec3(-n.xy / n.z, a.z), centre = p.xy, at = x.xy, height = p.z;
    // Mirrored such that both slopes rise.
    bvec2 falls = lessThan(k.xy, vec2(0.0));
    centre = mix(centre, 1.0 - centre, falls), at = mix(at, 1.0 - at, falls);
    vec2 slope = max(abs(k.xy), vec2(0.02));
    float low = height - dot(slope, centre);
    vec3 cut = momentsBelow(1.0 - low, slope) - momentsBelow(-low, slope);
    float full = cut.z * a[axis] / k.z;
    // Rounding leaves a little of a full plane away.
    if (coverage >= 0.95 * full) return 1.0;
    float share = coverage / full;
    vec2 middle = cut.xy / cut.z, aside = centre - middle;
    vec2 first = max((-low - slope.yx) / slope, 0.0), last = min((1.0 - low) / slope, 1.0);
    // Half the width of the cut on that side. The centre of a part that a straight line cuts off is aside by this times
    // 1 - share, that of matter scattered over the cut not at all; a corner's is in between, and as much in its place as
    // an edge's.
    float deviation = length(aside), halfWidth = 0.5 * dot(last - first, abs(aside)) / max(deviation, 1e-6);
    float located = clamp(4.0 * deviation / max(halfWidth * (1.0 - share), 1e-6), 0.0, 1.0);
    float inside = dot(at - middle, aside) >= (halfWidth * (1.0 - 2.0 * share) - margin) * deviation ? 1.0 : 0.0;
    return mix(min(u_coneGain * share, 1.0), inside, located);
}

/// What a cone's axis meets in one voxel.
struct NearHit {
    float share;  // optical depth, 0 to 1
    float t;      // voxels of the level
    uint face;    // six a slot
};

/// Meets one face of a record. `o`: origin of the cone relative to the voxel's lower corner.
void meetFace(uint slot, int f, uvec2 coverages, vec3 o, vec3 d, vec3 ownNormal, vec2 range, inout NearHit hit) {
    float coverage = faceCoverage(coverages, f);
    if (coverage == 0.0) return;
    uint index = slot * 6u + uint(f);
    FaceRecord face = b_faces[index];
    vec3 n = unpackOctahedral(face.normal), p = unpackPosition(face.position);
    float against = -dot(n, d), height = dot(n, o - p), facing = dot(n, ownNormal), rise = dot(ownNormal, p - o);
    // Behind the surface, or on it: the plane that the cone leaves, and what lies on that. One that meets it at an angle
    // begins at the edge. Mean positions are uncertain by a hundredth of a voxel.
    if (against < 1e-3 || height < (facing > 0.7 ? 0.02 : (facing < -0.7 ? 0.1 : -0.02))) return;
    // Beyond a convex edge.
    if (height < 0.0 && rise < -0.01) return;
    // So crossings that close to a voxel's border count on both sides.
    float t = max(height, 0.0) / against, slack = min(0.01 / against, 0.1);
    if (t < range.x - slack || t > range.y + slack) return;
    // What lies below the surface that the cone leaves is not met above it, though its plane may rise over that: the other
    // side of an edge, or of a fold of the sheet; what stands upright may also go through the surface. A sheet that bends
    // inside the voxel would be met by cones that leave its other side.
    bool below = t < 2.0 && rise < -0.01;
    if (below && facing > 0.2) return;
    if ((below && facing < -0.2 || height < 0.5 && facing < -0.7) && faceCoverage(coverages, f ^ 1) > 0.0 &&
        distance(p, unpackPosition(b_faces[index ^ 1u].position)) < 0.02)
        return;
    // Surfaces that meet in an edge overlap a little, so that nothing passes between; most where a gap would be wide.
    float margin = mix(0.6, 0.01, min(t, 1.0));
    float share = planeShare(n, p, o + t * d, coverage, f >> 1, margin);
    // What stops a part must not do so twice.
    if (share < 1.0 && (t < range.x || t >= range.y)) return;
    if (share > hit.share) hit = NearHit(share, t, index);
}

void meetRecord(uint mark, vec3 o, vec3 d, vec3 ownNormal, vec2 range, inout NearHit hit) {
    if (mark == 0u) return;
    uvec2 coverages = b_traced[mark - 1u].xy;  // without leaves, which are no planes
    // Written out: see traceConeTo.
    meetFace(mark - 1u, 0, coverages, o, d, ownNormal, range, hit);
    meetFace(mark - 1u, 1, coverages, o, d, ownNormal, range, hit);
    meetFace(mark - 1u, 2, coverages, o, d, ownNormal, range, hit);
    meetFace(mark - 1u, 3, coverages, o, d, ownNormal, range, hit);
    meetFace(mark - 1u, 4, coverages, o, d, ownNormal, range, hit);
    meetFace(mark - 1u, 5, coverages, o, d, ownNormal, range, hit);
}

/// Walks through the voxels of one level along the cone's axis, up to `near`, or `reach` if that is less. `weight` of the
/// level where two blend.
void nearFieldAt(Cone cone, int level, float weight, float near, float reach, inout ConeResult result) {
    float edge = exp2(float(level));
    vec3 o = cone.origin / edge, d = cone.direction;
    vec2 range = gridRange(cone.origin, d) / edge;
    float end = min(min(near, reach) / edge, range.y);
    if (range.x > 0.0) return;
    ivec3 i = ivec3(floor(o)), origin = levelOrigin(level, 0), step_ = ivec3(greaterThan(d, vec3(0.0))) * 2 - 1;
    ivec3 mask = ivec3(levelResolution(level) - 1);
    vec3 perVoxel = 1.0 / max(abs(d), vec3(1e-20));
    vec3 next = mix(o - vec3(i), vec3(i) + 1.0 - o, greaterThan(d, vec3(0.0))) * perVoxel;
    float t = 0.0;
    for (int k = 0; k < 256 && t < end; ++k) {
        if (level >= u_firstFixed && any(notEqual(i & ~mask, ivec3(0)))) break;
        COUNT(0);
        COUNT(1);
        vec2 inside = vec2(t, min(next.x, min(next.y, next.z)));
        ivec3 texel = origin + (i & mask);
        NearHit hit = NearHit(0.0, 0.0, 0u);
        meetRecord(texelFetch(u_index, texel, 0).r, o - vec3(i), d, cone.normal, inside, hit);
#if LAYERS == 2
        meetRecord(texelFetch(u_movingIndex, texel, 0).r, o - vec3(i), d, cone.normal, inside, hit);
#endif
        if (hit.share > 0.0) {
            float stopped = min(weight * nearWeight(hit.t * edge, near) * hit.share, result.transmittance);
            result.radiance += stopped * unpackHalf4(b_radiance[hit.face]).rgb;
            result.openness -= stopped * occluderWeight(hit.t * edge);
            result.transmittance -= stopped;
            RECORD(hit.t * edge, 0.0, float(level), result)
            if (result.transmittance <= 0.0) break;
        }
        bvec3 smallest = lessThanEqual(next, min(next.yzx, next.zxy));
        t = inside.y;
        if (smallest.x) next.x += perVoxel.x, i.x += step_.x;
        else if (smallest.y) next.y += perVoxel.y, i.y += step_.y;
        else next.z += perVoxel.z, i.z += step_.z;
    }
}

/// The near field up to `near`: at the level that holds all of the way.
void nearField(Cone cone, float startLevel, float near, float reach, inout ConeResult result) {
    float level = startLevel;
#if CASCADES
    level = max(level, containmentLevel(cone.origin + near * cone.direction));
#endif
    nearFieldAt(cone, int(level), 1.0 - fract(level), near, reach, result);
#if CASCADES
    if (fract(level) > 0.0) nearFieldAt(cone, int(level) + 1, fract(level), near, reach, result);
#endif
}
