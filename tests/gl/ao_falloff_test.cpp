// Ambient occlusion with falloffs against numeric integration: openness 1 − (1/π)∫ w(t/d) cosθ dω, t the distance of
// the occluder along ω, d ao.distance, w 1, 1 − x or 1 − √x below x = 1 (docs/accuracy.md, rows B2 and B4).

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

#include "support/shapes.h"
#include "support/voxel_lab.h"

namespace voxcone::test {
namespace {

constexpr double kPi = 3.14159265358979323846;

/// `hit`: distance of the occluder along a unit direction from the point, infinite without one. Normal +y.
double openness(AoFalloff falloff, double distance, const std::function<double(const glm::dvec3&)>& hit) {
    constexpr int kSteps = 96;
    double open = 0;
    for (int i = 0; i < kSteps; ++i)
        for (int k = 0; k < 2 * kSteps; ++k) {
            const double u = (i + 0.5) / kSteps, phi = kPi * (k + 0.5) / kSteps;
            const double x =
                hit({std::sqrt(u) * std::cos(phi), std::sqrt(1 - u), std::sqrt(u) * std::sin(phi)}) / distance;
            const double weight = x >= 1                         ? 0
                                  : falloff == AoFalloff::none   ? 1
                                  : falloff == AoFalloff::linear ? 1 - x
                                                                 : 1 - std::sqrt(x);
            open += (1 - weight) / (2.0 * kSteps * kSteps);
        }
    return open;
}

class AmbientOcclusion : public GlTest {
  protected:
    /// RMSE over points (x, 0, z) of a floor in `scene`, x from `low` to `high`.
    double rmse(const char* row, const Scene& scene, AoFalloff falloff, double distance, double low, double high,
                const std::function<double(double x, const glm::dvec3&)>& hit) {
        Settings settings;
        settings.voxel.resolution = 128;
        settings.light.bounces = 0;
        settings.ao.distance = distance;
        settings.ao.falloff = falloff;
        VoxelLab lab(glContext(), scene, settings, 10.0 / 128);
        std::mt19937 random(3);
        std::vector<ConeProbe> probes;
        for (int i = 0; i < 64; ++i)
            probes.push_back({{std::uniform_real_distribution<double>(low, high)(random), 0.013,
                               std::uniform_real_distribution<double>(-0.5, 0.5)(random)},
                              {0, 1, 0}});
        const auto results = lab.gather(probes);
        double squares = 0, sum = 0;
        for (std::size_t i = 0; i < results.size(); ++i) {
            const double x = probes[i].position.x;
            const double error =
                results[i].openness - openness(falloff, distance, [&](const glm::dvec3& d) { return hit(x, d); });
            squares += error * error, sum += error;
        }
        const auto n = static_cast<double>(results.size());
        fmt::print("{}, falloff {}, distance {}: RMSE {:.4f} bias {:+.4f}\n", row, static_cast<int>(falloff), distance,
                   std::sqrt(squares / n), sum / n);
        return std::sqrt(squares / n);
    }
};

TEST_F(AmbientOcclusion, FalloffsOfAWallAndOfAHalfPlaneOverhead) {
    const glm::dmat4 up = translation({0, 0.013, 0});  // planes lie inside of voxels
    const Scene wall = SceneBuilder()
                           .add(box({7, 1, 8}), lambert(0.5f), up * translation({0, -0.5, 0}))
                           .add(box({1, 2, 8}), lambert(0.5f), up * translation({-0.5, 1, 0}))
                           .sky(glm::vec3(1))
                           .build();
    const Scene overhead = SceneBuilder()
                               .add(box({8, 1, 8}), lambert(0.5f), up * translation({0, -0.5, 0}))
                               .add(box({4, 0.5, 8}), lambert(0.5f), up * translation({-2, 1.25, 0}))
                               .sky(glm::vec3(1))
                               .build();
    const auto toWall = [](double x, const glm::dvec3& d) {
        const double t = d.x < 0 ? -x / d.x : INFINITY;
        return t * d.y < 2 ? t : INFINITY;
    };
    const auto toOverhead = [](double x, const glm::dvec3& d) {
        if (x + d.x / d.y < 0) return 1 / d.y;
        const double t = d.x < 0 ? -x / d.x : INFINITY;  // the slab's end
        return t * d.y > 1 && t * d.y < 1.5 ? t : INFINITY;
    };
    for (const AoFalloff falloff : {AoFalloff::none, AoFalloff::linear, AoFalloff::square_root}) {
        EXPECT_LE(rmse("B2", wall, falloff, 1.5, 0.1, 1.8, toWall), 0.05);
        EXPECT_LE(rmse("B4", overhead, falloff, 2.5, -1, 1.5, toOverhead), 0.05);
    }
}

/// Whatever a storage knows of directions, and however the floor lies in the grid.
TEST_F(AmbientOcclusion, AFloorHidesNothingFromItself) {
    for (const VoxelStorage storage : {VoxelStorage::isotropic, VoxelStorage::sh1, VoxelStorage::six_face}) {
        for (const double degrees : {0.0, 20.0, 45.0}) {
            const glm::dmat4 turn = translation({0.02, 0.013, -0.01}) * rotation(degrees, {1, 0, 0.6});
            const Scene floor = SceneBuilder()
                                    .add(box({6, 0.6, 6}), lambert(0.5f), turn * translation({0, -0.3, 0}))
                                    .sky(glm::vec3(1))
                                    .build();
            Settings settings;
            settings.voxel.resolution = 64;
            settings.voxel.storage = storage;
            settings.light.bounces = 0;
            VoxelLab lab(glContext(), floor, settings, 8.0 / 64);
            std::mt19937 random(5);
            std::uniform_real_distribution<double> place(-1.2, 1.2);
            std::vector<ConeProbe> probes;
            for (int i = 0; i < 64; ++i)
                probes.push_back({glm::dvec3(turn * glm::dvec4(place(random), 0, place(random), 1)),
                                  glm::vec3(turn * glm::dvec4(0, 1, 0, 0))});
            double least = 1, sum = 0;
            for (const auto& result : lab.gather(probes)) {
                least = std::min(least, static_cast<double>(result.openness));
                sum += result.openness;
            }
            fmt::print("storage {}, {} degrees: openness {:.4f}, least {:.4f}\n", static_cast<int>(storage), degrees,
                       sum / 64, least);
            EXPECT_GT(least, 0.98) << static_cast<int>(storage) << ", " << degrees;
        }
    }
}

}  // namespace
}  // namespace voxcone::test
