// Soft shadows by cones (channel `soft_shadow`) against the exact visibility of a light past a straight edge
// (docs/accuracy.md, rows K1 and K2).

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "frame/renderer.h"
#include "support/gl_context.h"
#include "support/shapes.h"

namespace voxcone::test {
namespace {

constexpr double kPi = 3.14159265358979323846;

struct Errors {
    double squares = 0, sum = 0, worst = 0;
    int count = 0;
    void add(double error) {
        squares += error * error, sum += error, ++count;
        worst = std::max(worst, std::abs(error));
    }
    double rms() const { return std::sqrt(squares / count); }
    double mean() const { return sum / count; }
};

/// A floor, and a sheet at height `edgeHeight` over its half x < 0, whose edge x = 0 shades it.
Scene edgeScene(const Light& light, double edgeHeight) {
    return SceneBuilder()
        .add(quad(8, 8), lambert(0.5f))
        .add(quad(3, 8), lambert(0.5f), translation({-1.5, edgeHeight, 0}))
        .light(light)
        .build();
}

Light sphereLight(const glm::dvec3& position, double radius) {
    Light light;
    light.type = LightType::sphere;
    light.position = position;
    light.radius = radius;
    return light;
}

/// Visibility and place of the floor's pixels seen from between floor and sheet.
template <class Visit>
void eachFloorPixel(const Scene& scene, const Settings& settings, Visit visit) {
    Renderer renderer(glContext(), scene, settings);
    renderer.render(camera({2.0, 0.7, 0}, {-0.2, 0, 0}, 60));
    const Image shadow = renderer.channel("soft_shadow"), place = renderer.channel("position");
    for (int y = 0; y < shadow.height; ++y)
        for (int x = 0; x < shadow.width; ++x) {
            const float* p = place.pixel(x, y);
            if (p[0] != 0 && std::abs(p[1]) < 1e-3 && std::abs(p[0]) < 1.5 && std::abs(p[2]) < 1.5)
                visit(glm::dvec3(p[0], p[1], p[2]), *shadow.pixel(x, y));
        }
}

Settings softShadows(int resolution) {
    Settings settings;
    settings.output.width = settings.output.height = 48;
    settings.voxel.resolution = resolution;
    settings.light.bounces = 0;
    settings.light.shadowResolution = 128;
    settings.cone.diffuse = 1;
    settings.shadow.cones = true;
    return settings;
}

class SoftShadow : public GlTest {};

/// Share of a disc that is seen past a straight edge, which is `t` of its radius beyond the centre.
double pastEdge(double t) {
    t = std::clamp(t, -1.0, 1.0);
    return 0.5 + (t * std::sqrt(1 - t * t) + std::asin(t)) / kPi;
}

TEST_F(SoftShadow, EdgeBeforeASphereIsK1) {
    for (const double radius : {0.25, 0.5, 1.0}) {
        const glm::dvec3 center(0, 3, 0);
        Errors errors;
        eachFloorPixel(edgeScene(sphereLight(center, radius), 1), softShadows(128),
                       [&](const glm::dvec3& p, double seen) {
                           // The plane through p and the edge cuts the sphere's outline at its distance to the centre.
                           const glm::dvec3 normal = glm::normalize(glm::dvec3(1, p.x, 0));
                           errors.add(seen - pastEdge(glm::dot(normal, center - p) / radius));
                       });
        fmt::print("K1, radius {}: RMSE {:.4f} bias {:+.4f} worst {:.3f} of {} pixels\n", radius, errors.rms(),
                   errors.mean(), errors.worst, errors.count);
        EXPECT_GT(errors.count, 500);
        EXPECT_LE(errors.rms(), 0.05) << radius;
    }
}

TEST_F(SoftShadow, PenumbraIsAsWideAsK2) {
    for (const double radius : {0.25, 0.5}) {
        // Light 2 above the edge, floor 1 below it: the penumbra is half as wide as the light. What is seen on the dark
        // side and what is missing on the bright side are each 2/(3π) of its half-width, by the disc's profile.
        double dark = 0, bright = 0;
        constexpr int kBins = 4;
        double sums[2 * kBins] = {};
        int counts[2 * kBins] = {};
        Settings settings = softShadows(128);
        settings.output.width = settings.output.height = 128;
        eachFloorPixel(edgeScene(sphereLight({0, 3, 0}, radius), 1), settings, [&](const glm::dvec3& p, double seen) {
            const int bin = static_cast<int>(std::floor(p.x * 10)) + kBins;
            if (bin < 0 || bin >= 2 * kBins) return;
            sums[bin] += seen, ++counts[bin];
        });
        for (int bin = 0; bin < 2 * kBins; ++bin) {
            ASSERT_GT(counts[bin], 0) << bin;
            (bin < kBins ? dark : bright) +=
                0.1 * (bin < kBins ? sums[bin] / counts[bin] : 1 - sums[bin] / counts[bin]);
        }
        const double width = 2 * (dark + bright) / 2 * (3 * kPi / 2);
        fmt::print("K2, light of size {}: penumbra {:.3f} of {:.3f}\n", 2 * radius, width, radius);
        EXPECT_NEAR(width / radius, 1, 0.15) << radius;
    }
}

TEST_F(SoftShadow, LightsCountByTheirIrradiance) {
    // Two points of light: one is hidden by the sheet, the other shines below it.
    Light hidden = sphereLight({-1, 3, 0}, 0), open = sphereLight({3, 0.8, 0}, 0);
    hidden.type = open.type = LightType::point;
    Scene scene = edgeScene(hidden, 1);
    scene.lights.push_back(open);
    int count = 0;
    eachFloorPixel(scene, softShadows(64), [&](const glm::dvec3& p, double seen) {
        if (p.x > -0.4 || std::abs(p.z) > 0.5) return;
        const auto irradiance = [&](const Light& light) {
            const glm::dvec3 d = light.position - p;
            return d.y / std::pow(glm::length(d), 3);
        };
        EXPECT_NEAR(seen, irradiance(open) / (irradiance(open) + irradiance(hidden)), 0.05);
        ++count;
    });
    EXPECT_GT(count, 20);
}

}  // namespace
}  // namespace voxcone::test
