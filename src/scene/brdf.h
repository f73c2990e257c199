// The glTF 2.0 metallic-roughness BRDF (appendix B) with KHR_materials_ior and KHR_materials_specular. Twin of
// shaders/shared/brdf.glsl: same names, same arithmetic; but for Transmission, whose rays only the path tracer follows.
#pragma once

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>

namespace voxcone {

/// Smallest GGX α = roughness². A mirror is rendered as α = 0.002 (roughness 0.045), below which a float's N·H no
/// longer resolves the lobe.
inline constexpr float kMinAlpha = 0.002f;
inline constexpr float kInvPi = 0.318309886f;

/// What of a material reflects, at one point. Fresnel is Schlick's, from f0 at normal incidence to f90 at grazing.
struct Surface {
    glm::vec3 diffuseColor{0};  ///< albedo of the Lambert lobe before Fresnel takes its share
    glm::vec3 f0{0};
    float f90 = 0;
    float alpha = 1;  ///< GGX width, kMinAlpha to 1
};

/// What of a material lets light through to its other side (KHR_materials_transmission, _volume and
/// _diffuse_transmission), at one point.
struct Transmission {
    glm::vec3 color{0};         ///< share of the light that enters the surface and goes on as a beam
    glm::vec3 diffuseColor{0};  ///< share that leaves on the other side as from a Lambert surface
    float ior = 1;              ///< of the medium inside a solid; 1 for thin sheets, which bend nothing
    glm::vec3 absorption{0};    ///< of the medium, 1/m
};

inline float maxComponent(const glm::vec3& v) {
    return std::max(v.x, std::max(v.y, v.z));
}

/// `baseColor`, `metallic`, `roughness` after textures; `ior`, `specularFactor`, `specularColor` of the material.
inline Surface surfaceFromMaterial(const glm::vec3& baseColor, float metallic, float roughness, float ior,
                                   float specularFactor, const glm::vec3& specularColor) {
    const float r = (ior - 1) / (ior + 1);
    const glm::vec3 dielectricF0 = glm::min(r * r * specularColor, glm::vec3(1)) * specularFactor;
    Surface surface;
    surface.diffuseColor = baseColor * (1 - metallic);
    surface.f0 = glm::mix(dielectricF0, baseColor, metallic);
    surface.f90 = glm::mix(specularFactor, 1.0f, metallic);
    surface.alpha = std::clamp(roughness * roughness, kMinAlpha, 1.0f);
    return surface;
}

inline float schlickWeight(float vDotH) {
    const float m = std::clamp(1 - vDotH, 0.0f, 1.0f);
    const float m2 = m * m;
    return m2 * m2 * m;
}

inline glm::vec3 fresnel(const Surface& surface, float vDotH) {
    return surface.f0 + (glm::vec3(surface.f90) - surface.f0) * schlickWeight(vDotH);
}

/// Share of light that the specular lobe leaves to the diffuse one: 1 − max over RGB of F (KHR_materials_specular).
inline float diffuseTransmission(const Surface& surface, float vDotH) {
    const float f0 = maxComponent(surface.f0);
    return 1 - (f0 + (surface.f90 - f0) * schlickWeight(vDotH));
}

/// Fresnel reflectance for an eye at cosine `vDotH` inside a medium of index `ior`: that of the refracted direction,
/// and 1 where there is none (total reflection).
inline glm::vec3 fresnelFromInside(const Surface& surface, float ior, float vDotH) {
    const float sine2 = ior * ior * (1 - vDotH * vDotH);
    return sine2 >= 1 ? glm::vec3(1) : fresnel(surface, std::sqrt(1 - sine2));
}

/// Light of an analytic light that passes straight through a surface: neither bent nor scattered, by convention of both
/// renderers. `cosine` between the light and the surface's normal.
inline glm::vec3 straightTransmittance(const Surface& surface, const Transmission& transmission, float cosine) {
    return transmission.color * diffuseTransmission(surface, cosine);
}

/// GGX distribution of normals. `nCrossH2` = |n × h|² keeps the precision that 1 − (n·h)² would lose on narrow lobes.
inline float ggxDistribution(float alpha, float nDotH, float nCrossH2) {
    const float a2 = alpha * alpha;
    const float d = nDotH * nDotH * a2 + nCrossH2;
    return a2 * kInvPi / (d * d);
}

/// Height-correlated Smith visibility G2 / (4 n·l n·v) (Heitz 2014, eq. 99).
inline float smithVisibility(float alpha, float nDotV, float nDotL) {
    const float a2 = alpha * alpha;
    const float v = nDotL * std::sqrt(nDotV * nDotV * (1 - a2) + a2);
    const float l = nDotV * std::sqrt(nDotL * nDotL * (1 - a2) + a2);
    return 0.5f / std::max(v + l, 1e-20f);
}

/// Diffuse lobe in 1/sr, without the cosine. Unit `n`, `v` (to the eye), `l` (to the light); zero below the surface.
inline glm::vec3 evaluateDiffuse(const Surface& surface, const glm::vec3& n, const glm::vec3& v, const glm::vec3& l) {
    if (glm::dot(n, l) <= 0 || glm::dot(n, v) <= 0) return glm::vec3(0);
    const glm::vec3 sum = v + l;
    const float vDotH = 0.5f * glm::length(sum);  // cosine of half the angle between v and l
    return surface.diffuseColor * (diffuseTransmission(surface, vDotH) * kInvPi);
}

/// Specular lobe in 1/sr, without the cosine.
inline glm::vec3 evaluateSpecular(const Surface& surface, const glm::vec3& n, const glm::vec3& v, const glm::vec3& l) {
    const float nDotL = glm::dot(n, l), nDotV = glm::dot(n, v);
    if (nDotL <= 0 || nDotV <= 0) return glm::vec3(0);
    const glm::vec3 h = glm::normalize(v + l);
    const glm::vec3 nCrossH = glm::cross(n, h);
    const float d = ggxDistribution(surface.alpha, glm::dot(n, h), glm::dot(nCrossH, nCrossH));
    return fresnel(surface, glm::dot(v, h)) * (d * smithVisibility(surface.alpha, nDotV, nDotL));
}

/// ∫ (1 − F(v·h)) cosθ/π dω over light directions: what of the diffuse colour an eye at cosine `nDotV` sees under
/// uniform light. The Schlick weight's integral is a polynomial fit, off by less than 1e-5.
inline float diffuseAlbedoScale(const Surface& surface, float nDotV) {
    const float m = std::clamp(nDotV, 0.0f, 1.0f);
    const float weight = 0.028165f + m * (-0.079854f + m * (0.086457f + m * (-0.043665f + m * 0.008979f)));
    const float f0 = maxComponent(surface.f0);
    return 1 - (f0 + (surface.f90 - f0) * weight);
}

/// Share of uniform incoming power that the whole BRDF reflects, diffuse and specular: the albedo of the Lambert
/// surface that a voxel stores in the material's place. Single-scattering GGX; the fits in roughness are off by less
/// than 0.003 per unit of f0 and 0.0005 per unit of f90. At most 1, though glTF's mix of lobes gains up to 0.04 on
/// white dielectrics.
inline glm::vec3 voxelAlbedo(const Surface& surface) {
    const float r = std::sqrt(surface.alpha);
    const float scale = 0.953858f + r * (-0.067320f + r * (0.790232f + r * (-2.812090f + r * 1.544472f)));
    const float bias = 0.045981f + r * (0.054017f + r * (-0.459332f + r * (0.609982f + r * -0.248351f)));
    const float meanSchlickWeight = 0.003685f;  // mean over both directions, as seen by the diffuse lobe
    const float f0 = maxComponent(surface.f0);
    const float transmission = 1 - (f0 + (surface.f90 - f0) * meanSchlickWeight);
    return glm::min(surface.diffuseColor * transmission + surface.f0 * scale + glm::vec3(surface.f90 * bias),
                    glm::vec3(1));
}

}  // namespace voxcone
