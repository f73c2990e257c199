#include "light/specular_table.h"

#include <bit>
#include <cmath>
#include <cstdint>
#include <numbers>

#include "scene/brdf.h"

namespace voxcone {
namespace {

using glm::dvec3;

/// Van der Corput sequence in base 2.
double radicalInverse(std::uint32_t i) {
    std::uint32_t reversed = 0;
    for (int bit = 0; bit < 32; ++bit) reversed |= ((i >> bit) & 1u) << (31 - bit);
    return reversed * 0x1p-32;
}

/// Smith's Λ of GGX for a direction at cosine `c`.
double lambda(double c, double alpha) {
    const double tan2 = (1 - c * c) / (c * c);
    return 0.5 * (std::sqrt(1 + alpha * alpha * tan2) - 1);
}

/// A normal that is visible from `v` (Heitz 2018, "Sampling the GGX distribution of visible normals"), z up.
dvec3 visibleNormal(const dvec3& v, double alpha, double u1, double u2) {
    const dvec3 stretched = glm::normalize(dvec3(alpha * v.x, alpha * v.y, v.z));
    const double length2 = stretched.x * stretched.x + stretched.y * stretched.y;
    const dvec3 t1 = length2 > 0 ? dvec3(-stretched.y, stretched.x, 0) / std::sqrt(length2) : dvec3(1, 0, 0);
    const dvec3 t2 = glm::cross(stretched, t1);
    const double r = std::sqrt(u1), phi = 2 * std::numbers::pi * u2;
    const double x = r * std::cos(phi);
    const double s = 0.5 * (1 + stretched.z);
    const double y = (1 - s) * std::sqrt(1 - x * x) + s * r * std::sin(phi);
    const dvec3 h = x * t1 + y * t2 + std::sqrt(std::max(0.0, 1 - x * x - y * y)) * stretched;
    return glm::normalize(dvec3(alpha * h.x, alpha * h.y, std::max(0.0, h.z)));
}

}  // namespace

glm::dvec2 specularAlbedo(double cosTheta, double alpha, int samples) {
    const dvec3 v(std::sqrt(1 - cosTheta * cosTheta), 0, cosTheta);
    const double lambdaV = lambda(cosTheta, alpha);
    double a = 0, b = 0;
    for (int i = 0; i < samples; ++i) {
        const dvec3 h = visibleNormal(v, alpha, (i + 0.5) / samples, radicalInverse(static_cast<std::uint32_t>(i)));
        const double vDotH = glm::dot(v, h);
        const dvec3 l = 2 * vDotH * h - v;
        if (l.z <= 0) continue;
        // f·cos/pdf for visible normals is F·G2/G1.
        const double weight = (1 + lambdaV) / (1 + lambdaV + lambda(l.z, alpha));
        const double m = 1 - std::min(vDotH, 1.0);
        const double schlick = m * m * m * m * m;
        a += weight * (1 - schlick);
        b += weight * schlick;
    }
    return glm::dvec2(a, b) / static_cast<double>(samples);
}

std::vector<glm::vec2> specularAlbedoTable(int size) {
    constexpr int kSamples = 1024;
    std::vector<glm::vec2> table;
    for (int y = 0; y < size; ++y) {
        const double roughness = static_cast<double>(y) / (size - 1);
        for (int x = 0; x < size; ++x) {
            table.push_back(specularAlbedo(std::max(static_cast<double>(x) / (size - 1), 1e-3),
                                           std::max<double>(roughness * roughness, kMinAlpha), kSamples));
        }
    }
    return table;
}

gl::Texture specularAlbedoTexture() {
    gl::Texture texture = gl::Texture::create2D(GL_RG32F, kSpecularTableSize, kSpecularTableSize);
    texture.upload(0, GL_RG, GL_FLOAT, specularAlbedoTable(kSpecularTableSize).data());
    texture.filter(GL_LINEAR, GL_LINEAR);
    return texture;
}

}  // namespace voxcone
