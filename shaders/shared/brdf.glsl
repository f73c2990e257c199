// The glTF 2.0 metallic-roughness BRDF (appendix B) with KHR_materials_ior and KHR_materials_specular. Twin of
// src/scene/brdf.h: same names, same arithmetic; the reasons stand there.
#ifndef VOXCONE_BRDF_GLSL
#define VOXCONE_BRDF_GLSL

const float kMinAlpha = 0.002;
const float kInvPi = 0.318309886;

struct Surface {
    vec3 diffuseColor;  // albedo of the Lambert lobe before Fresnel takes its share
    vec3 f0;
    float f90;
    float alpha;  // GGX width, kMinAlpha to 1
};

float maxComponent(vec3 v) { return max(v.x, max(v.y, v.z)); }

Surface surfaceFromMaterial(vec3 baseColor, float metallic, float roughness, float ior, float specularFactor,
                            vec3 specularColor) {
    float r = (ior - 1.0) / (ior + 1.0);
    vec3 dielectricF0 = min(r * r * specularColor, vec3(1.0)) * specularFactor;
    Surface surface;
    surface.diffuseColor = baseColor * (1.0 - metallic);
    surface.f0 = mix(dielectricF0, baseColor, metallic);
    surface.f90 = mix(specularFactor, 1.0, metallic);
    surface.alpha = clamp(roughness * roughness, kMinAlpha, 1.0);
    return surface;
}

float schlickWeight(float vDotH) {
    float m = clamp(1.0 - vDotH, 0.0, 1.0);
    float m2 = m * m;
    return m2 * m2 * m;
}

vec3 fresnel(Surface surface, float vDotH) {
    return surface.f0 + (vec3(surface.f90) - surface.f0) * schlickWeight(vDotH);
}

// Share of light that the specular lobe leaves to the diffuse one.
float diffuseTransmission(Surface surface, float vDotH) {
    float f0 = maxComponent(surface.f0);
    return 1.0 - (f0 + (surface.f90 - f0) * schlickWeight(vDotH));
}

// GGX distribution of normals; nCrossH2 = |n × h|².
float ggxDistribution(float alpha, float nDotH, float nCrossH2) {
    float a2 = alpha * alpha;
    float d = nDotH * nDotH * a2 + nCrossH2;
    return a2 * kInvPi / (d * d);
}

// Height-correlated Smith visibility G2 / (4 n·l n·v) (Heitz 2014, eq. 99).
float smithVisibility(float alpha, float nDotV, float nDotL) {
    float a2 = alpha * alpha;
    float v = nDotL * sqrt(nDotV * nDotV * (1.0 - a2) + a2);
    float l = nDotV * sqrt(nDotL * nDotL * (1.0 - a2) + a2);
    return 0.5 / max(v + l, 1e-20);
}

// Diffuse lobe in 1/sr, without the cosine. Unit n, v (to the eye), l (to the light).
vec3 evaluateDiffuse(Surface surface, vec3 n, vec3 v, vec3 l) {
    if (dot(n, l) <= 0.0 || dot(n, v) <= 0.0) return vec3(0.0);
    float vDotH = 0.5 * length(v + l);
    return surface.diffuseColor * (diffuseTransmission(surface, vDotH) * kInvPi);
}

// Specular lobe in 1/sr, without the cosine.
vec3 evaluateSpecular(Surface surface, vec3 n, vec3 v, vec3 l) {
    float nDotL = dot(n, l), nDotV = dot(n, v);
    if (nDotL <= 0.0 || nDotV <= 0.0) return vec3(0.0);
    vec3 h = normalize(v + l);
    vec3 nCrossH = cross(n, h);
    float d = ggxDistribution(surface.alpha, dot(n, h), dot(nCrossH, nCrossH));
    return fresnel(surface, dot(v, h)) * (d * smithVisibility(surface.alpha, nDotV, nDotL));
}

// ∫ (1 − F(v·h)) cosθ/π dω over light directions, for indirect diffuse light by gathering: multiply with diffuseColor and
// the gathered irradiance/π. Polynomial fit of the Schlick weight's integral, off by less than 1e-5.
float diffuseAlbedoScale(Surface surface, float nDotV) {
    float m = clamp(nDotV, 0.0, 1.0);
    float weight = 0.028165 + m * (-0.079854 + m * (0.086457 + m * (-0.043665 + m * 0.008979)));
    float f0 = maxComponent(surface.f0);
    return 1.0 - (f0 + (surface.f90 - f0) * weight);
}

// Share of uniform incoming power that the whole BRDF reflects: the albedo of the Lambert surface that a voxel stores.
// The fits in roughness are off by less than 0.003 per unit of f0 and 0.0005 per unit of f90. At most 1, though glTF's mix
// of lobes gains up to 0.04 on white dielectrics.
vec3 voxelAlbedo(Surface surface) {
    float r = sqrt(surface.alpha);
    float scale = 0.953858 + r * (-0.067320 + r * (0.790232 + r * (-2.812090 + r * 1.544472)));
    float bias = 0.045981 + r * (0.054017 + r * (-0.459332 + r * (0.609982 + r * -0.248351)));
    const float meanSchlickWeight = 0.003685;
    float f0 = maxComponent(surface.f0);
    float transmission = 1.0 - (f0 + (surface.f90 - f0) * meanSchlickWeight);
    return min(surface.diffuseColor * transmission + surface.f0 * scale + vec3(surface.f90 * bias), vec3(1.0));
}

#endif
