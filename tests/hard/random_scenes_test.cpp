// Random scenes through the whole renderer: where they are, how large they are, which axis is which and in which order
// they are drawn changes their picture no more than arithmetic makes it.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <random>

#include "frame/renderer.h"
#include "support/shapes.h"
#include "support/voxel_lab.h"

namespace voxcone::test {
namespace {

using glm::dmat4;
using glm::dvec3;

const std::vector<std::string> kChannels{"beauty", "direct",         "indirect_diffuse", "indirect_specular",
                                         "ao",     "voxel_radiance", "voxel_opacity"};
using Pictures = std::map<std::string, Image>;

/// A scene of bodies and sheets within 4 m, sky, and lights of several types.
class RandomScene {
  public:
    explicit RandomScene(unsigned seed) : random_(seed) {
        for (int i = 0; i < 6; ++i) {
            const dmat4 place =
                translation(point(1.5)) * rotation(uniform(0, 360), {uniform(0.1, 1), uniform(-1, 1), 1});
            const int kind = i % 3;
            const double size = uniform(0.3, 1);
            Mesh mesh = kind == 0   ? box({size, size * 0.7, size * 1.3})
                        : kind == 1 ? sphere(size / 2, 2)
                                    : quad(2, 1, 2);
            const glm::vec3 color(uniform(0.2, 0.9), uniform(0.2, 0.9), uniform(0.2, 0.9));
            Material material = i == 3   ? lambert(color, glm::vec3(2, 1, 0.5))
                                : i == 4 ? glossy(color, 0.5f, 0.4f)
                                         : lambert(color);
            material.doubleSided = i == 5;
            objects_.push_back({std::move(mesh), material, place});
        }
        objects_.push_back({quad(4, 4, 3), lambert(0.6f), translation({0, -1.5, 0})});
        Light sun;
        sun.type = LightType::directional;
        sun.direction = glm::normalize(dvec3(uniform(-1, 1), -1, uniform(-1, 1)));
        sun.intensity = glm::vec3(2, 1.8f, 1.5f);
        Light lamp;
        lamp.type = LightType::point;
        lamp.position = {0.25, 1.75, -0.5};
        lamp.intensity = glm::vec3(3);
        Light bulb;
        bulb.type = LightType::sphere;
        bulb.position = {-1, 1.5, 1};
        bulb.radius = 0.125;
        bulb.intensity = glm::vec3(1, 2, 3);
        lights_ = {sun, lamp, bulb};
    }

    /// `order` shuffles objects and their triangles, unless it is 0.
    SceneBuilder builder(unsigned order = 0, bool lights = true) const {
        std::vector<std::size_t> objects(objects_.size());
        std::iota(objects.begin(), objects.end(), std::size_t{0});
        std::mt19937 random(order);
        if (order) std::shuffle(objects.begin(), objects.end(), random);
        SceneBuilder scene;
        for (const std::size_t i : objects) {
            Mesh mesh = objects_[i].mesh;
            if (order) {
                std::vector<std::size_t> triangles(mesh.indices.size() / 3);
                std::iota(triangles.begin(), triangles.end(), std::size_t{0});
                std::shuffle(triangles.begin(), triangles.end(), random);
                for (std::size_t t = 0; t < triangles.size(); ++t) {
                    for (std::size_t k = 0; k < 3; ++k)
                        mesh.indices[3 * t + k] = objects_[i].mesh.indices[3 * triangles[t] + k];
                    mesh.closed[t] = objects_[i].mesh.closed[triangles[t]];
                }
            }
            scene.add(mesh, objects_[i].material, objects_[i].place);
        }
        if (lights)
            for (const Light& light : lights_) scene.light(light);
        return scene.sky({0.2f, 0.3f, 0.4f});
    }

  private:
    struct Object {
        Mesh mesh;
        Material material;
        dmat4 place;
    };
    double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
    /// Multiples of 1/4096, so that moves far away leave nothing to rounding in double.
    dvec3 point(double reach) {
        return glm::round(dvec3(uniform(-reach, reach), uniform(-1.2, reach), uniform(-reach, reach)) * 4096.0) /
               4096.0;
    }

    std::mt19937 random_;
    std::vector<Object> objects_;
    std::vector<Light> lights_;
};

class RandomScenes : public GlTest {
  protected:
    static Settings settings() {
        Settings settings;
        settings.output.width = settings.output.height = 40;
        settings.voxel.resolution = 32;
        settings.light.shadowResolution = 256;
        settings.light.bounces = 2;
        settings.cone.diffuse = 6;
        return settings;
    }
    static Pictures render(const Scene& scene, const dvec3& eye, const dvec3& target, const Settings& settings) {
        Renderer renderer(glContext(), scene, settings);
        renderer.render(camera(eye, target, 60));
        Pictures pictures;
        for (const std::string& name : kChannels) pictures[name] = renderer.channel(name);
        return pictures;
    }
    static void expectSameBits(const Pictures& a, const Pictures& b, const std::string& what) {
        for (const std::string& name : kChannels) {
            const Image& x = a.at(name);
            const Image& y = b.at(name);
            std::size_t different = 0;
            for (std::size_t i = 0; i < x.data.size(); ++i) different += x.data[i] != y.data[i];
            EXPECT_EQ(different, 0u) << name << " of " << x.data.size() << ": " << what;
        }
    }
};

const dvec3 kEye(3, 2, 3.5), kTarget(0, -0.5, 0);

TEST_F(RandomScenes, MovedByWholeVoxelsTheyAreTheSameBitForBit) {
    Settings settings = RandomScenes::settings();
    settings.voxel.size = 0.25;
    for (const int levels : {1, 2}) {
        settings.cascade.levels = levels;
        if (levels == 2) settings.voxel.size = 0.125;
        const RandomScene random(static_cast<unsigned>(levels));
        const Pictures here = render(random.builder().build(), kEye, kTarget, settings);
        for (const dvec3 move : {dvec3(7, -3, 11), dvec3(1 << 17, -(1 << 17), 4096)}) {
            // By voxels of the coarsest mip, which is what levels snap to.
            const dvec3 by = move * 32.0 * 0.25;
            const Scene moved = random.builder().transform(translation(by)).build();
            expectSameBits(here, render(moved, kEye + by, kTarget + by, settings),
                           fmt::format("{} levels, moved by {}", levels, by.x));
        }
    }
}

TEST_F(RandomScenes, ScaledByPowersOfTwoTheyAreTheSameBitForBit) {
    const RandomScene random(3);
    const Pictures one = render(random.builder().build(), kEye, kTarget, settings());
    for (const int power : {-14, -5, 9}) {  // 2^-14 is below 1e-4
        const double scale = std::ldexp(1.0, power);
        Scene scaled = random.builder().transform(scaling(dvec3(scale))).build();
        // What arrives falls with the square of the distance.
        for (Light& light : scaled.lights)
            if (light.type != LightType::directional) light.intensity *= static_cast<float>(scale * scale);
        expectSameBits(one, render(scaled, scale * kEye, scale * kTarget, settings()), fmt::format("2^{}", power));
    }
}

TEST_F(RandomScenes, DrawnInAnyOrderTheyAreTheSameBitForBit) {
    for (const unsigned seed : {4u, 5u}) {
        const RandomScene random(seed);
        const Pictures one = render(random.builder().build(), kEye, kTarget, settings());
        for (const unsigned order : {1u, 2u})
            expectSameBits(one, render(random.builder(order).build(), kEye, kTarget, settings()),
                           fmt::format("scene {}, order {}", seed, order));
    }
}

TEST_F(RandomScenes, WithAxesPermutedAndMirroredTheyHoldTheSameLight) {
    const RandomScene random(6);
    Settings settings = RandomScenes::settings();
    settings.cone.diffuse = 16;
    settings.light.bounces = 1;
    settings.light.extrapolate = false;
    settings.light.bounceCones = 16;
    // Half-open cells are not symmetric for what lies in the faces of voxels, so nothing may.
    const dmat4 aside = translation({0.0137, 0.0071, 0.0219});
    const auto placedProbes = [](const dmat4& place) {
        std::vector<ConeProbe> probes;
        for (int i = 0; i < 64; ++i)
            probes.push_back({dvec3(place * glm::dvec4(-1.8 + 0.5 * (i % 8), -1.5, -1.8 + 0.5 * (i / 8), 1)),
                              glm::vec3(dvec3(place * glm::dvec4(0, 1, 0, 0)))});
        return probes;
    };
    const auto gather = [&](const dmat4& place, VoxelMap& voxels) {
        VoxelLab lab(glContext(), random.builder(0, false).transform(place).build(), settings, 0.15);
        voxels = readVoxels(lab.voxels());
        return lab.gather(placedProbes(place));
    };
    VoxelMap voxels, turnedVoxels;
    const auto base = gather(aside, voxels);
    double light = 0;
    for (const ConeProbeResult& r : base) light += static_cast<double>(r.radiance.y) / 64;
    EXPECT_GT(voxels.voxels.size(), 500u);
    double worst = 0, squares = 0;
    int count = 0;
    for (const glm::ivec3 axis : {glm::ivec3(1, 2, 0), glm::ivec3(2, 1, 0), glm::ivec3(0, 1, 2)})
        for (const int signs : {1, 6, 7}) {
            dmat4 matrix(0);
            matrix[3][3] = 1;
            for (int a = 0; a < 3; ++a) matrix[axis[a]][a] = signs >> a & 1 ? -1 : 1;
            const auto turned = gather(matrix * aside, turnedVoxels);
            EXPECT_EQ(turnedVoxels.voxels.size(), voxels.voxels.size()) << signs;
            for (std::size_t i = 0; i < base.size(); ++i) {
                const double difference = static_cast<double>(turned[i].radiance.y - base[i].radiance.y) / light;
                worst = std::max(worst, std::abs(difference));
                squares += difference * difference;
                ++count;
            }
        }
    const double rms = std::sqrt(squares / count);
    fmt::print("permuted and mirrored: light differs by {:.4f} RMS, {:.4f} at most, of its mean\n", rms, worst);
    // The frame that cone sets are laid in and their sense of rotation do not turn along with the axes: cones of
    // another azimuth see the edges of things differently. Sixteen cones in sixteen turns integrate the sky to about 1
    // %.
    EXPECT_LT(rms, 0.02);
    EXPECT_LT(worst, 0.1);
}

}  // namespace
}  // namespace voxcone::test
