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
            if (std::abs(p[1]) < 1e-3 && std::abs(p[0]) < 1.5 && std::abs(p[2]) < 1.5)
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

TEST_F(SoftShadow, Measure) {
    for (const int cones : {1, 4, 8, 16})
        for (const double cap : {12.0, 1.0})
            for (const double gain : {1.65}) {
                fmt::print("cones {:2} cap {} gain {}:", cones, cap, gain);
                for (const double radius : {0.25, 0.5, 1.0}) {
                    Settings settings = softShadows(128);
                    settings.shadow.coneCount = cones;
                    settings.cone.footprintCap = cap;
                    settings.cone.gain = gain;
                    Errors errors;
                    eachFloorPixel(
                        edgeScene(sphereLight({0, 3, 0}, radius), 1), settings, [&](const glm::dvec3& p, double seen) {
                            const glm::dvec3 normal = glm::normalize(glm::dvec3(1, p.x, 0));
                            const double t = std::clamp(glm::dot(normal, glm::dvec3(0, 3, 0) - p) / radius, -1.0, 1.0);
                            errors.add(seen - (0.5 + (t * std::sqrt(1 - t * t) + std::asin(t)) / kPi));
                        });
                    fmt::print("  r {} ({} px): rmse {:.4f} bias {:+.4f} worst {:.3f}", radius, errors.count,
                               errors.rms(), errors.mean(), errors.worst);
                }
                fmt::print("\n");
                fflush(stdout);
            }
}

}  // namespace
}  // namespace voxcone::test
