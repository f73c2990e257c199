// Cones that together cover the lobe of a GGX reflector: visible normals, each with the solid angle that falls to it. In a
// frame with the normal along +z.
#include "shared/brdf.glsl"

/// A normal that `v` (unit, z > 0) sees: Dupuy and Benyoub 2023, "Sampling Visible GGX Normals with Spherical Caps". `u` in
/// (0,1) leads from the middle of the lobe outwards, `azimuth` around it.
vec3 visibleNormal(vec3 v, float alpha, float u, float azimuth) {
    vec3 stretched = normalize(vec3(alpha * v.xy, v.z));
    float z = 1.0 - u * (1.0 + stretched.z);
    float r = sqrt(clamp(1.0 - z * z, 0.0, 1.0));
    vec3 h = vec3(r * cos(azimuth), r * sin(azimuth), z) + stretched;
    return normalize(vec3(alpha * h.xy, max(h.z, 0.0)));
}

/// Smith's masking for a direction at cosine `c`.
float smithMasking(float alpha, float c) {
    float a2 = alpha * alpha;
    return 2.0 * c / (c + sqrt(a2 + (1.0 - a2) * c * c));
}

struct LobeSample {
    vec3 direction;    // unit
    float weight;      // f cosθ / density, by the strongest colour of f; its mean is the directional albedo. 0 below the surface
    float solidAngle;  // 1 / density
};

LobeSample sampleLobe(Surface surface, vec3 v, float u, float azimuth) {
    LobeSample s;
    vec3 h = visibleNormal(v, surface.alpha, u, azimuth);
    float vDotH = dot(v, h);
    s.direction = 2.0 * vDotH * h - v;
    float masking = smithMasking(surface.alpha, v.z);
    s.solidAngle = 4.0 * v.z / max(masking * ggxDistribution(surface.alpha, h.z, dot(h.xy, h.xy)), 1e-20);
    float nDotL = s.direction.z;
    float f0 = maxComponent(surface.f0);
    float reflectance = f0 + (surface.f90 - f0) * schlickWeight(vDotH);
    s.weight = nDotL > 0.0 ? reflectance * smithVisibility(surface.alpha, v.z, nDotL) * 4.0 * v.z * nDotL / masking : 0.0;
    return s;
}

/// Half-angle of a cone of `solidAngle`, at most 1 rad.
float coneHalfAngle(float solidAngle) { return min(acos(max(1.0 - solidAngle / 6.28318530718, 0.0)), 1.0); }
