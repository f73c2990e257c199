// Light through the visible surface: src/cone/refraction.h.
#include "frame/gbuffer.glsl"
#include "cone/sky.glsl"
#include "cone/trace.glsl"
#include "cone/cone_set.glsl"
layout(local_size_x = 8, local_size_y = 8) in;

uniform float u_inverseVoxelSize;
uniform sampler2D u_specularAlbedo;  // (A, B) over (n·v, roughness): f0 A + f90 B
uniform usampler2D u_exits;          // back faces of solids: normal, distance along the view
layout(rgba32f) uniform writeonly image2D u_transmission;

#if BEAMS
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

/// Radiance that a beam brings to the eye.
vec3 beamThrough(GBufferSample s) {
    float nDotV = max(dot(s.normal, s.toEye), 1e-3);
    float roughness = sqrt(s.surface.alpha);
    vec2 parts = textureLod(u_specularAlbedo, vec2(nDotV, roughness), 0.0).rg;
    // What the facets do not reflect.
    vec3 weight = s.beam * max((1.0 - maxComponent(s.surface.f0)) * parts.x + (1.0 - s.surface.f90) * parts.y, 0.0);
    Cone cone;
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
            float edge = exp2(containmentLevel(leaves * u_inverseVoxelSize)) / u_inverseVoxelSize;
            leaves -= 1.5 * edge * s.geometricNormal;
        }
        float below = dot(cone.direction, cone.normal);
        if (below < 0.05) cone.direction = normalize(cone.direction + cone.normal * (0.05 - below));
    }
    cone.origin = leaves * u_inverseVoxelSize;
    cone.tanHalfAngle = tan(halfAngle);
    cone.near = nearOfOne(cone.tanHalfAngle);
    ConeResult result = traceCone(cone);
    return weight * (result.radiance + result.transmittance * skyRadiance(cone.direction, cone.tanHalfAngle));
}
#endif

#if SCATTERING
/// Radiance that a sheet scatters to the eye of the light behind it.
vec3 scatteredThrough(GBufferSample s) {
    Cone cone;
    cone.origin = s.position * u_inverseVoxelSize;
    cone.normal = -s.geometricNormal;
    cone.level = 0.0;
    cone.tanHalfAngle = u_coneTanHalfAngle;
    cone.near = u_nearDistance;
    mat3 frame = frameAround(-s.normal);
    vec3 sum = vec3(0.0);
    for (int i = 0; i < CONES; ++i) {
        vec4 local = coneOfSet(i, 0.0, 0.0);
        cone.direction = frame * local.xyz;
        ConeResult result = traceCone(cone);
        sum += local.w * (result.radiance + result.transmittance * skyRadiance(cone.direction, cone.tanHalfAngle));
    }
    return sum * s.scattered * diffuseTransmission(s.surface, max(dot(s.normal, s.toEye), 0.0));
}
#endif

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(u_transmission)))) return;
    GBufferSample s = loadGBuffer(pixel);
    vec3 radiance = vec3(0.0);
    if (s.hit) {
#if BEAMS
        if (maxComponent(s.beam) > 0.0) radiance += beamThrough(s);
#endif
#if SCATTERING
        if (maxComponent(s.scattered) > 0.0) radiance += scatteredThrough(s);
#endif
    }
    storeSamples();
    imageStore(u_transmission, pixel, vec4(radiance, 1.0));
}
