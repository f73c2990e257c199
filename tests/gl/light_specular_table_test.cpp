// The split-sum table against brute force with the renderer's own BRDF, and against laws.
#include "light/specular_table.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "scene/brdf.h"
#include "support/gl_context.h"

namespace voxcone {
namespace {

using test::GlTest;

/// ∫ evaluateSpecular n·l dl over the hemisphere, by a fine grid in polar angle around the half-vector's pole.
double bruteForce(double cosTheta, double alpha, float f0, float f90) {
    Surface surface;
    surface.f0 = glm::vec3(f0);
    surface.f90 = f90;
    surface.alpha = static_cast<float>(alpha);
    const glm::vec3 n(0, 0, 1);
    const glm::vec3 v(static_cast<float>(std::sqrt(1 - cosTheta * cosTheta)), 0, static_cast<float>(cosTheta));
    const int rings = 600, sectors = 600;
    double sum = 0;
    for (int i = 0; i < rings; ++i) {
        const double theta = 0.5 * std::numbers::pi * (i + 0.5) / rings;
        for (int k = 0; k < sectors; ++k) {
            const double phi = 2 * std::numbers::pi * (k + 0.5) / sectors;
            const glm::vec3 l(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta));
            sum += static_cast<double>(evaluateSpecular(surface, n, v, l).x) * std::cos(theta) * std::sin(theta);
        }
    }
    return sum * (0.5 * std::numbers::pi / rings) * (2 * std::numbers::pi / sectors);
}

TEST(SpecularTable, AgreesWithTheBrdf) {
    for (const double cosTheta : {0.15, 0.5, 0.95}) {
        for (const double alpha : {0.1, 0.36, 1.0}) {
            const glm::dvec2 ab = specularAlbedo(cosTheta, alpha, 4096);
            EXPECT_NEAR(ab.x + ab.y, bruteForce(cosTheta, alpha, 1, 1), 2e-3) << cosTheta << " " << alpha;
            EXPECT_NEAR(0.04 * ab.x + ab.y, bruteForce(cosTheta, alpha, 0.04f, 1), 2e-3) << cosTheta << " " << alpha;
        }
    }
}

TEST(SpecularTable, MirrorReflectsFresnelAlone) {
    for (const double cosTheta : {0.1, 0.4, 0.8}) {
        const glm::dvec2 ab = specularAlbedo(cosTheta, kMinAlpha, 1024);
        const double schlick = std::pow(1 - cosTheta, 5);
        EXPECT_NEAR(ab.y, schlick, 2e-3);
        EXPECT_NEAR(ab.x, 1 - schlick, 2e-3);
    }
}

TEST(SpecularTable, NeverMoreThanAllLight) {
    for (const glm::vec2& ab : specularAlbedoTable(kSpecularTableSize)) {
        EXPECT_GE(ab.x, 0);
        EXPECT_GE(ab.y, 0);
        EXPECT_LE(ab.x + ab.y, 1 + 1e-6f);
    }
}

class SpecularTexture : public GlTest {};

TEST_F(SpecularTexture, HoldsTheTable) {
    const gl::Texture texture = specularAlbedoTexture();
    const std::vector<float> texels = texture.readFloats();
    const std::vector<glm::vec2> table = specularAlbedoTable(kSpecularTableSize);
    ASSERT_EQ(texels.size(), 2 * table.size());
    for (std::size_t i = 0; i < table.size(); ++i) {
        EXPECT_EQ(texels[2 * i], table[i].x);
        EXPECT_EQ(texels[2 * i + 1], table[i].y);
    }
}

}  // namespace
}  // namespace voxcone
