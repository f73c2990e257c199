// Cones through the voxels. Needs the defines SIX_FACE, COMPOSITING_{LINEAR,EXPONENTIAL,ALPHA}, START_NORMAL, FOOTPRINT_CAP
// and AO_DISTANCE.
//
// All lengths are in voxels of the finest level, and positions are in [0, resolution].

uniform int u_resolution;
uniform int u_levels;            // mip levels of the volumes
uniform float u_coneStep;        // footprints
uniform float u_coneGain;        // g
uniform float u_footprintCap;    // K
uniform float u_startOffset;     // voxels, times |n|_1
uniform float u_headStart;      // voxels
uniform float u_nudge;           // voxel diagonals
uniform float u_coneMaxDistance; // voxels
uniform float u_radianceScale;   // stored radiance times this is W/(m² sr)
#if AO_DISTANCE
uniform float u_aoDistance;      // voxels
uniform int u_aoFalloff;         // 0 none, 1 linear, 2 square root
#endif

#if SIX_FACE
uniform sampler3D u_coveragePositive;  // density of surfaces that look along +x, +y, +z
uniform sampler3D u_coverageNegative;  // … along -x, -y, -z
#endif
uniform sampler3D u_radiance;

struct Cone {
    vec3 origin;     // of the surface, not yet offset
    vec3 normal;     // geometric
    vec3 direction;
    float tanHalfAngle;
};

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

/// Distances along `d` from `o` to where it enters the grid (0 from inside) and leaves it; it leaves before it enters when
/// it never meets the grid.
vec2 gridRange(vec3 o, vec3 d) {
    vec3 inverse = 1.0 / mix(d, vec3(1e-20), equal(d, vec3(0.0)));
    vec3 a = -o * inverse, b = (float(u_resolution) - o) * inverse;
    vec3 near = min(a, b), far = max(a, b);
    return vec2(max(max(near.x, near.y), max(near.z, 0.0)), min(far.x, min(far.y, far.z)));
}

/// Footprint at distance t: the cone's diameter, but no more than the height above the tangent plane over K, so that a
/// sample never reaches down into the surface that the cone leaves.
float footprint(Cone cone, float offset, float t) {
    float diameter = 2.0 * cone.tanHalfAngle * t;
#if FOOTPRINT_CAP
    diameter = min(diameter, (offset + t * dot(cone.normal, cone.direction)) / u_footprintCap);
#endif
    return max(diameter, 1.0);
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

vec3 textureCoordinates(vec3 x, float lod, int face) {
    // Trilinear filtering must not reach the neighbouring face in the stack: stay half a texel of the coarser level inside.
    float halfTexel = 0.5 * exp2(ceil(lod));
    float size = float(u_resolution);
    float z = clamp(x.z, halfTexel, size - halfTexel);
    return vec3(x.xy, float(face) * size + z) / vec3(size, size, 6.0 * size);
}
#endif

#if SIX_FACE
/// What a cone meets at one place.
struct Crossing {
    float density;  // optical density against the cone
    vec3 facing;    // densities, by axis, of the faces that look against the cone, without the cone's own surface
    vec3 stored;    // the same with it, as the stored radiance is weighted
};

/// `x` is `height` above the tangent plane of the cone's origin.
Crossing crossingAt(Cone cone, vec3 x, float height, float diameter, float lod) {
    vec3 unit = x / float(u_resolution);
    vec3 positive = textureLod(u_coveragePositive, unit, lod).xyz;
    vec3 negative = textureLod(u_coverageNegative, unit, lod).xyz;
    bvec3 ascending = greaterThan(cone.direction, vec3(0.0));
    Crossing crossing;
    crossing.stored = mix(positive, negative, ascending);
#if START_NORMAL
    withoutOwnPlane(cone, height, diameter, positive, negative);
#endif
    crossing.facing = mix(positive, negative, ascending);
    // Net normal for surfaces of one side, so that a plane never stops a cone that leaves it, and what looks both ways.
    crossing.density = max(0.0, dot(negative - positive, cone.direction)) +
                       dot(abs(cone.direction), min(positive, negative));
    return crossing;
}

/// Optical depth of a wall whose filtered profile reaches behind the start of the cone: without it, a start within a voxel
/// of a wall beside it would cross only a part of that wall. The part behind is as deep for a steep cone as for a flat one,
/// so it is looked for along the tangent plane; but a cone along the normal never meets such a wall.
float depthBehind(Cone cone, vec3 o, float offset) {
    vec3 along = cone.direction - cone.normal * dot(cone.normal, cone.direction);
    float sine = length(along);
    if (sine < 0.05) return 0.0;
    along /= sine;
    Cone level = cone;
    level.direction = along;
    float density = crossingAt(level, o - 0.5 * u_headStart * along, offset, 1.0, 0.0).density;
    return u_headStart * density * min(1.0, 3.0 * sine);
}
#endif

/// Up to `reach` voxels from the origin.
ConeResult traceConeTo(Cone cone, float reach) {
    vec3 d = cone.direction;
    vec3 n = cone.normal;
#if START_NORMAL
    float offset = u_startOffset * (abs(n.x) + abs(n.y) + abs(n.z));
    vec3 o = cone.origin + n * offset;
    float t = 0.0;
#else
    // Eq. 3.4 of the thesis, after Rauwendaal 2013; kept finite at grazing angles.
    float offset = 0.0;
    vec3 o = cone.origin;
    float t = u_nudge * sqrt(3.0) / max(dot(n, d), 1.0 / float(u_resolution));
#endif
    vec2 range = gridRange(o, d);
    t = max(t, range.x);
    float end = min(range.y, reach);

    ConeResult result = ConeResult(vec3(0.0), 1.0, 1.0);
    float tau = 0.0, maxLod = float(u_levels - 1);
#if SIX_FACE && START_NORMAL && !COMPOSITING_ALPHA
    tau = depthBehind(cone, o, offset);
#endif
    // Steps are at least a tenth of a voxel long (the range of cone.step); 65535 iterations are all some drivers run.
    for (int i = 0; i < 4096 && t < end; ++i) {
        float diameter = footprint(cone, offset, t);
#if START_NORMAL
        float ds = u_coneStep * diameter;
        vec3 x = o + d * (t + 0.5 * ds);
        float lod = min(log2(diameter), maxLod);
#else
        float ds = u_coneStep * diameter;
        vec3 x = o + d * t;
        float lod = clamp(log2(diameter / sqrt(3.0)), 0.0, maxLod);
#endif

#if SIX_FACE
        Crossing crossing = crossingAt(cone, x, offset + dot(x - o, n), diameter, lod);
        float density = crossing.density;
#else
        vec4 voxel = textureLod(u_radiance, x / float(u_resolution), lod);
        float density = voxel.a;
#endif
        if (density > 0.0) {
#if COMPOSITING_LINEAR
            tau += density * ds;
            float after = max(0.0, 1.0 - u_coneGain * tau);
#elif COMPOSITING_EXPONENTIAL
            tau += density * ds;
            float after = exp(-u_coneGain * tau);
#else
            float after = result.transmittance * (1.0 - min(density, 1.0));
#endif
            float stopped = result.transmittance - after;
#if SIX_FACE
            // Of the faces met (those that look against the cone) the one that fills most is seen: it hides what lies
            // behind it. All faces of one surface hold the same radiance, so that nothing jumps where another takes over.
            vec3 seen = abs(d) * crossing.facing;
            int axis = seen.x >= seen.y && seen.x >= seen.z ? 0 : (seen.y >= seen.z ? 1 : 2);
            if (seen[axis] > 0.0 && stopped > 0.0) {
                vec3 stored = textureLod(u_radiance, textureCoordinates(x, lod, 2 * axis + (d[axis] > 0.0 ? 1 : 0)), lod).rgb;
                result.radiance += stored * (stopped / crossing.stored[axis]);
            }
#else
            result.radiance += stopped * voxel.rgb / voxel.a;
#endif
            result.openness -= stopped * occluderWeight(t);
            result.transmittance = after;
            if (after < 1e-3) break;
        }
        t += ds;
    }
    result.radiance *= u_radianceScale;
    return result;
}

ConeResult traceCone(Cone cone) { return traceConeTo(cone, u_coneMaxDistance > 0.0 ? u_coneMaxDistance : 1e30); }
