// Scattered leaves: openness of a floor below a canopy, and of the leaves in it, against rays.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "reference/path_tracer.h"
#include "support/shapes.h"
#include "support/voxel_lab.h"

namespace voxcone::test {
namespace {

enum class Turned { randomly, flat, upright };

/// Scattered leaves over a floor; lengths in voxels.
struct Canopy {
    const char* name;
    double size;       ///< legs of the leaves, right triangles
    double areaIndex;  ///< leaf area over floor area
    Turned turned = Turned::randomly;
    double low = 4, high = 12;
};

class Foliage : public GlTest {
  protected:
    std::mt19937 random{1};
    double uniform() { return std::uniform_real_distribution<double>(0, 1)(random); }
    glm::dvec3 direction() {
        const double z = 2 * uniform() - 1, phi = 2 * M_PI * uniform(), r = std::sqrt(1 - z * z);
        return {r * std::cos(phi), z, r * std::sin(phi)};
    }

    /// Leaves above a square of half-size `half` around the origin, and probes on either side of some in the middle.
    Mesh leaves(const Canopy& canopy, double half, std::vector<ConeProbe>& probes) {
        Mesh mesh;
        mesh.name = "leaves";
        const auto count = static_cast<int>(canopy.areaIndex * 4 * half * half / (canopy.size * canopy.size / 2));
        for (int i = 0; i < count; ++i) {
            const glm::dvec3 middle((2 * uniform() - 1) * half, canopy.low + (canopy.high - canopy.low) * uniform(),
                                    (2 * uniform() - 1) * half);
            glm::dvec3 n = direction();
            if (canopy.turned == Turned::flat) n = {0, n.y > 0 ? 1 : -1, 0};
            if (canopy.turned == Turned::upright) n = glm::normalize(glm::dvec3(n.x, 0, n.z));
            const glm::dvec3 u = glm::normalize(glm::cross(n, direction())), v = glm::cross(n, u);
            for (const auto& [a, b] : {std::pair(0, 0), std::pair(1, 0), std::pair(0, 1)}) {
                mesh.indices.push_back(static_cast<std::uint32_t>(mesh.positions.size()));
                mesh.positions.emplace_back(middle + canopy.size * ((a - 1.0 / 3) * u + (b - 1.0 / 3) * v));
                mesh.normals.emplace_back(n);
            }
            mesh.closed.push_back(0);
            if (probes.size() < 96 && std::max(std::abs(middle.x), std::abs(middle.z)) < half / 2)
                probes.push_back({middle, glm::vec3(probes.size() % 2 ? -n : n)});
        }
        return mesh;
    }
};

struct Errors {
    double truth = 0, sum = 0, squares = 0;
    int count = 0;
    void add(double value, double exact) {
        truth += exact, sum += value - exact, squares += (value - exact) * (value - exact), ++count;
    }
    double mean() const { return truth / count; }
    double bias() const { return sum / count; }
    double rms() const { return std::sqrt(squares / count); }
};

TEST_F(Foliage, OpennessBelowAndInsideACanopy) {
    const std::vector<Canopy> canopies{
        {"sparse, 0.3 voxels", 0.3, 1},
        {"dense, 0.3 voxels", 0.3, 3},
        {"sparse, 1 voxel", 1, 1},
        {"dense, 1 voxel", 1, 3},
        {"sparse, 3 voxels", 3, 1},
        {"dense, 3 voxels", 3, 3},
        {"thin, 1 voxel", 1, 0.3},
        {"level, 1 voxel", 1, 1.5, Turned::flat},
        {"upright, 1 voxel", 1, 1.5, Turned::upright},
        {"high, 1 voxel", 1, 2, Turned::randomly, 24, 40},
        {"high, 3 voxels", 3, 2, Turned::randomly, 24, 40},
    };
    for (const Canopy& canopy : canopies) {
        const double half = canopy.high > 20 ? 28 : 14;
        std::vector<ConeProbe> probes;
        const Mesh mesh = leaves(canopy, half, probes);
        const std::size_t inside = probes.size();
        for (int i = 0; i < 96; ++i)
            probes.push_back({glm::dvec3((uniform() - 0.5) * half, 0, (uniform() - 0.5) * half), glm::vec3(0, 1, 0)});
        std::vector<PathTracer::ProbeResult> truth;
        for (const Matter matter : {Matter::solid, Matter::leaves}) {
            Material material = lambert(0);
            material.matter = matter;
            const Scene scene = SceneBuilder()
                                    .add(mesh, material)
                                    .add(box({2 * half, 1, 2 * half}), lambert(0), translation({0, -0.5, 0}))
                                    .sky(glm::vec3(1))
                                    .build();
            Settings settings;
            settings.voxel.resolution = 64;
            settings.light.bounces = 0;
            settings.reference.samples = 256;
            if (truth.empty()) {
                std::vector<PathTracer::Probe> at;
                for (const ConeProbe& p : probes) at.push_back({p.position, p.normal});
                truth = PathTracer(scene).probe(at, settings);
            }
            VoxelLab lab(glContext(), scene, settings, 1);
            const auto results = lab.gather(probes);
            Errors leaf, floor;
            for (std::size_t i = 0; i < results.size(); ++i)
                (i < inside ? leaf : floor)
                    .add(static_cast<double>(results[i].openness), static_cast<double>(truth[i].openness));
            fmt::print("{:<18} as {}: floor {:.3f} {:+.3f} (RMSE {:.3f}), leaves {:.3f} {:+.3f} (RMSE {:.3f})\n",
                       canopy.name, matter == Matter::leaves ? "leaves" : "solid ", floor.mean(), floor.bias(),
                       floor.rms(), leaf.mean(), leaf.bias(), leaf.rms());
            if (matter == Matter::solid) continue;
            EXPECT_LE(std::abs(floor.bias()), 0.05) << canopy.name;
            EXPECT_LE(std::abs(leaf.bias()), 0.05) << canopy.name;
        }
    }
}

// A screen hides nothing from itself, and what lies behind it by its opacity a: it lets pass 1 - a. What is nearly
// opaque and wider than a voxel stops too little as leaves: that is reported, not promised.
TEST_F(Foliage, AScreenLetsPassWhatItsOpacitySays) {
    for (const float opacity : {0.25f, 0.5f, 0.9f})
        for (const double degrees : {0.0, 30.0}) {
            Material material = lambert(0);
            material.baseColor.a = opacity;
            material.alphaMode = AlphaMode::blend;
            const glm::dmat4 place = translation({0.3, 0.4, 0.1}) * rotation(degrees, {0, 0, 1});
            const Scene scene = oneObject(quad(60, 60, 8), material, place, glm::vec3(1));
            Settings settings;
            settings.voxel.resolution = 64;
            settings.light.bounces = 0;
            VoxelLab lab(glContext(), scene, settings, 1);
            std::vector<ConeProbe> probes;
            for (int i = 0; i < 64; ++i)
                for (const double below : {0.0, 4.0})
                    probes.push_back(
                        {glm::dvec3(place * glm::dvec4((uniform() - 0.5) * 4, -below, (uniform() - 0.5) * 4, 1)),
                         glm::vec3(glm::dvec3(place * glm::dvec4(0, 1, 0, 0)))});
            Errors above, behind;
            const auto results = lab.gather(probes);
            for (std::size_t i = 0; i < results.size(); ++i)
                (i % 2 ? behind : above)
                    .add(static_cast<double>(results[i].openness), i % 2 ? 1 - static_cast<double>(opacity) : 1.0);
            fmt::print(
                "screen of opacity {:.2f} at {:2.0f} degrees: on it {:+.3f} (RMSE {:.3f}), behind {:+.3f} (RMSE "
                "{:.3f})\n",
                opacity, degrees, above.bias(), above.rms(), behind.bias(), behind.rms());
            EXPECT_LE(above.rms(), 0.05) << opacity << " " << degrees;
            if (opacity <= 0.5f) {
                EXPECT_LE(std::abs(behind.bias()), 0.1) << opacity << " " << degrees;
            }
        }
}

}  // namespace
}  // namespace voxcone::test
