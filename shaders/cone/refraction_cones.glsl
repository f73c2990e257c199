// The cones of what a pixel's surface lets through: of cone/refraction.comp, and of whoever asks what they meet. Needs
// frame/gbuffer.glsl, cone/trace.glsl and cone/cone_set.glsl, and the defines BEAMS and SCATTERING.

#if BEAMS
#include "cone/specular_albedo.glsl"
uniform usampler2D u_exits;  // back faces of solids: normal, distance along the view
mat3 g_pixelFromWorld;  // of an offset from the eye: distance along the view times (place in pixels, 1)

/// How far `p` lies before the nearest back face in its pixel, along the view; negative behind it or where there is none.
float depthInside(vec3 p, out ivec2 pixel) {
    vec3 place = g_pixelFromWorld * (p - u_cameraPosition);
    pixel = ivec2(floor(place.xy / place.z));
    if (place.z <= 0.0 || any(lessThan(pixel, ivec2(0))) || any(greaterThanEqual(pixel, gbufferSize()))) return -1e30;
    float back = uintBitsToFloat(texelFetch(u_exits, pixel, 0).y);
    return back > 0.0 ? back - place.z : -1e30;
}

/// Length of the way from `p` along `d` to the back faces, within `reach`, and the normal there; 0 when it meets none.
float wayInside(vec3 p, vec3 d, float reach, out vec3 normal) {
    const int kSteps = 24, kHalvings = 8;
    ivec2 pixel, last;
    normal = -d;
    float inside = 0.0, outside = 0.0;
    // Not from p itself, which lies on the surface.
    for (int i = 1; i <= kSteps && outside == 0.0; ++i) {
        float t = reach * float(i) / float(kSteps);
        if (depthInside(p + d * t, pixel) < 0.0) outside = t;
        else inside = t;
    }
    if (outside == 0.0) return 0.0;
    bool found = false;
    for (int i = 0; i < kHalvings; ++i) {
        float t = 0.5 * (inside + outside);
        if (depthInside(p + d * t, pixel) < 0.0) {
            outside = t;
        } else {
            inside = t;
            last = pixel;
            found = true;
        }
    }
    if (!found) depthInside(p + d * inside, last);
    uvec2 exit_ = texelFetch(u_exits, last, 0).xy;
    if (exit_.y == 0u) return 0.0;
    normal = unpackOctahedral(exit_.x);
    return inside;
}

/// Sets the cone of the beam that comes to the eye. Answers what share of its radiance arrives there.
vec3 beamCone(GBufferSample s, float inverseVoxelSize, out Cone cone) {
    float nDotV = max(dot(s.normal, s.toEye), 1e-3);
    vec2 parts = specularAlbedoParts(nDotV, s.surface.alpha);
    // What the facets do not reflect.
    vec3 weight = s.beam * max((1.0 - maxComponent(s.surface.f0)) * parts.x + (1.0 - s.surface.f90) * parts.y, 0.0);
    cone.level = 0.0;
    float halfAngle = min(2.0 * atan(s.surface.alpha), 1.0);  // as for reflection: shaders/cone/specular.comp
    vec3 leaves = s.position;
    if (s.solid) {
        g_pixelFromWorld = inverse(u_cameraRays);
        vec3 d = refract(-s.toEye, s.normal, 1.0 / s.ior), normal;
        ivec2 pixel;
        float behind = depthInside(s.position, pixel);
        float reach = 2.0 * (s.thickness + max(behind, 0.0)), way = 0.0;
        vec3 last = -s.normal;
        bool out_ = false;
        // Total reflection turns the ray back inside, a few times at most.
        for (int i = 0; i < 3 && !out_; ++i) {
            float length_ = wayInside(leaves, d, reach, normal);
            if (length_ == 0.0) break;
            way += length_;
            leaves += length_ * d;
            last = normal;
            vec3 refracted = refract(d, -normal, s.ior);
            out_ = dot(refracted, refracted) > 0.0;
            d = out_ ? refracted : reflect(d, normal);
        }
        if (way == 0.0) {
            // No back face in the picture: a slab of the thickness that the material gives.
            way = s.thickness;
            leaves += way * d;
        }
        if (!out_) d = -s.toEye;
        // Beams between two faces: of what arrives at the exit a part is reflected, and comes back after two more ways.
        vec3 left = exp(-s.opticalDepth * (way / s.thickness));
        float c = clamp(dot(d, last), 0.0, 1.0);
        float reflected = min(1.0 - diffuseTransmission(s.surface, c), 0.999);
        weight *= s.beam * left * (1.0 - reflected) / (1.0 - reflected * left);
        cone.direction = d;
        cone.normal = dot(last, d) > 0.05 ? last : d;
        // Two refractions bend a ray by (ior − 1) times what their facets are tilted by, a reflection by twice that.
        halfAngle *= min(sqrt(0.5) * (s.ior - 1.0), 1.0);
    } else {
        float lean = (1.0 - s.surface.alpha) * (sqrt(1.0 - s.surface.alpha) + s.surface.alpha);
        cone.direction = normalize(mix(-s.normal, -s.toEye, lean));
        cone.normal = -s.geometricNormal;
        if (s.closed) {
            // The wall of a hollow body: the one behind dims once more, and this one must not.
            weight *= s.beam * diffuseTransmission(s.surface, nDotV);
            float edge = exp2(containmentLevel(leaves * inverseVoxelSize)) / inverseVoxelSize;
            leaves -= 1.5 * edge * s.geometricNormal;
        }
        float below = dot(cone.direction, cone.normal);
        if (below < 0.05) cone.direction = normalize(cone.direction + cone.normal * (0.05 - below));
    }
    cone.origin = leaves * inverseVoxelSize;
    cone.tanHalfAngle = tan(halfAngle);
    cone.near = nearOfOne(cone.tanHalfAngle);
    return weight;
}
#endif

#if SCATTERING
/// Sets cone `i` of those that gather the light behind a sheet. Answers its weight.
float scatteredCone(GBufferSample s, float inverseVoxelSize, int i, out Cone cone) {
    vec4 local = coneOfSet(i, 0.0, 0.0);
    cone.origin = s.position * inverseVoxelSize;
    cone.normal = -s.geometricNormal;
    cone.direction = frameAround(-s.normal) * local.xyz;
    cone.tanHalfAngle = u_coneTanHalfAngle;
    cone.level = 0.0;
    cone.near = u_nearDistance;
    return local.w;
}

/// Share of that light which arrives at the eye.
vec3 scatteredShare(GBufferSample s) {
    return s.scattered * diffuseTransmission(s.surface, max(dot(s.normal, s.toEye), 0.0));
}
#endif
