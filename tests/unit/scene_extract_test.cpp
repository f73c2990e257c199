// Lights taken out of panoramas and emitting meshes: nothing is lost, nothing stays that was taken.
#include "scene/extract.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <numbers>
#include <random>

#include "scene/environment.h"
#include "support/shapes.h"

namespace voxcone {
namespace {

using glm::dvec3;

constexpr double kPi = std::numbers::pi;

dvec3 directionOf(const Environment& sky, int x, int y) {
    const double polar = kPi * (y + 0.5) / sky.height;
    const double longitude = 2 * kPi * ((x + 0.5) / sky.width - 0.5) - glm::radians(sky.rotationDeg);
    return {std::sin(polar) * std::sin(longitude), std::cos(polar), -std::sin(polar) * std::cos(longitude)};
}

/// Σ texel · solid angle · weight(direction).
template <class Weight>
dvec3 integral(const Environment& sky, const std::vector<glm::vec3>& texels, Weight&& weight) {
    dvec3 sum(0);
    for (int y = 0; y < sky.height; ++y) {
        const double solidAngle =
            2 * kPi / sky.width * (std::cos(kPi * y / sky.height) - std::cos(kPi * (y + 1) / sky.height));
        for (int x = 0; x < sky.width; ++x)
            sum += dvec3(sky.color) * dvec3(texels[static_cast<std::size_t>(y * sky.width + x)]) *
                   (solidAngle * weight(directionOf(sky, x, y)));
    }
    return sum;
}

Environment flatSky(int width, const glm::vec3& radiance) {
    Environment sky;
    sky.color = glm::vec3(1);
    sky.width = width, sky.height = width / 2;
    sky.radiance.assign(static_cast<std::size_t>(sky.width * sky.height), radiance);
    return sky;
}

/// Adds `radiance` where the direction is within `radius` of `center`.
void addDisc(Environment& sky, const dvec3& center, double radius, const glm::vec3& radiance) {
    for (int y = 0; y < sky.height; ++y) {
        for (int x = 0; x < sky.width; ++x) {
            if (glm::dot(directionOf(sky, x, y), center) > std::cos(radius))
                sky.radiance[static_cast<std::size_t>(y * sky.width + x)] += radiance;
        }
    }
}

/// Fluence over the sphere and irradiance on planes that see every source as a whole or not at all, before and after.
void expectConserved(const Scene& before, const Scene& after) {
    const auto& sky = before.environment;
    const std::vector<glm::vec3>& left = after.environment.residual.empty() ? sky.radiance : after.environment.residual;
    const auto one = [](const dvec3&) { return 1.0; };
    const dvec3 fluence = integral(sky, sky.radiance, one);
    dvec3 kept = integral(sky, left, one);
    for (const Light& light : after.lights)  // a disc's radiance is E/(π sin²r), its solid angle 2π(1 − cos r)
        kept += dvec3(light.intensity) * 2.0 / (1 + std::cos(light.angularRadius));
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(kept[c], fluence[c], 0.01 * fluence[c]) << "channel " << c;

    for (const dvec3& axis : {dvec3(0, 1, 0), dvec3(0, -1, 0), dvec3(1, 0, 0), dvec3(0, 0, 1), dvec3(-1, 0, 0),
                              dvec3(1, 1, 1), dvec3(-1, 2, -3)}) {
        const dvec3 n = glm::normalize(axis);
        const auto cosine = [&](const dvec3& d) { return std::max(glm::dot(d, n), 0.0); };
        const dvec3 irradiance = integral(sky, sky.radiance, cosine);
        dvec3 split = integral(sky, left, cosine);
        bool cut = false;
        for (const Light& light : after.lights) {
            split += dvec3(light.intensity) * std::max(-glm::dot(light.direction, n), 0.0);
            cut = cut || std::abs(glm::dot(light.direction, n)) < std::sin(light.angularRadius);
        }
        if (cut) continue;
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(split[c], irradiance[c], 0.01 * irradiance[c]) << "channel " << c;
    }
}

TEST(ExtractEnvironment, ASunBecomesADirectionalLightOfItsSize) {
    for (const double rotation : {0.0, 77.0}) {
        Scene scene;
        scene.environment = flatSky(1024, {0.2f, 0.3f, 0.5f});
        scene.environment.color = {2, 1, 1};
        scene.environment.rotationDeg = rotation;
        const dvec3 sun = glm::normalize(dvec3(0.3, 0.8, -0.4));
        const double radius = glm::radians(3.0);
        addDisc(scene.environment, sun, radius, glm::vec3(400, 300, 200));
        Scene after = scene;
        extractEnvironment(after, 4);
        ASSERT_EQ(after.lights.size(), 1u);
        const Light& light = after.lights[0];
        EXPECT_EQ(light.type, LightType::directional);
        EXPECT_TRUE(light.extracted);
        EXPECT_LT(std::acos(-glm::dot(light.direction, sun)), glm::radians(0.1));
        EXPECT_NEAR(light.angularRadius, radius, 0.05 * radius);
        const double expected = 300 * kPi * std::pow(std::sin(radius), 2);
        EXPECT_NEAR(light.intensity.y, expected, 0.02 * expected);
        EXPECT_NEAR(light.intensity.x / light.intensity.y, 2 * 400.2 / 300.3, 1e-4);
        // What is left is as bright as the sky around, and nothing else has changed.
        const glm::vec3 left = environmentResidual(after.environment, glm::vec3(sun));
        EXPECT_NEAR(left.x + left.y + left.z, 2 * 0.2 + 0.3 + 0.5, 1e-3);
        EXPECT_NEAR(environmentRadiance(after.environment, glm::vec3(sun)).y, 300.3, 0.1);
        EXPECT_EQ(environmentResidual(after.environment, {0, -1, 0}),
                  environmentRadiance(scene.environment, {0, -1, 0}));
        expectConserved(scene, after);
    }
}

TEST(ExtractEnvironment, ConservesRandomPanoramas) {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> uniform(0, 1);
    std::size_t lights = 0;
    for (int k = 0; k < 12; ++k) {
        Scene scene;
        scene.environment = flatSky(256, glm::vec3(0.1f));
        scene.environment.rotationDeg = 360 * uniform(random);
        for (glm::vec3& texel : scene.environment.radiance)
            texel *= glm::vec3(uniform(random), uniform(random), uniform(random));
        // Apart from each other, since a source has one direction for all channels.
        std::vector<dvec3> centers;
        for (int source = 0; source < 20; ++source) {
            const double z = 2 * uniform(random) - 1, phi = 2 * kPi * uniform(random), r = std::sqrt(1 - z * z);
            const dvec3 center(r * std::cos(phi), z, r * std::sin(phi));
            const double radius = glm::radians(1 + 12 * uniform(random));
            bool apart = true;
            for (const dvec3& other : centers) apart = apart && glm::dot(other, center) < std::cos(glm::radians(28.0));
            if (!apart) continue;
            centers.push_back(center);
            addDisc(scene.environment, center, radius,
                    glm::vec3(uniform(random), uniform(random), uniform(random)) * 200.0f);
        }
        Scene after = scene;
        extractEnvironment(after, 1 + k % 5);
        EXPECT_LE(after.lights.size(), static_cast<std::size_t>(1 + k % 5));
        lights += after.lights.size();
        for (std::size_t i = 0; i < after.environment.residual.size(); ++i) {
            for (int c = 0; c < 3; ++c) {
                EXPECT_GE(after.environment.residual[i][c], 0);
                EXPECT_LE(after.environment.residual[i][c], scene.environment.radiance[i][c]);
            }
        }
        expectConserved(scene, after);
    }
    EXPECT_GT(lights, 12u);
}

TEST(ExtractEnvironment, ConservesPanoramasOfTheWorld) {
    const std::filesystem::path folder = std::filesystem::path(VOXCONE_SOURCE_DIR) / "../shared/assets/env";
    if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no " << folder.string();
    int panoramas = 0;
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
        if (entry.path().extension() != ".hdr") continue;
        Scene scene;
        scene.environment = loadEnvironment(entry.path());
        Scene after = scene;
        extractEnvironment(after, 8);
        expectConserved(scene, after);
        ++panoramas;
    }
    if (panoramas == 0) GTEST_SKIP() << "no .hdr in " << folder.string();
}

TEST(ExtractEnvironment, LeavesWhatConesSeeAsWell) {
    const auto lightsOf = [](const Environment& sky, int most) {
        Scene scene;
        scene.environment = sky;
        extractEnvironment(scene, most);
        EXPECT_EQ(scene.environment.residual.empty(), scene.lights.empty());
        return scene.lights.size();
    };
    Environment wide = flatSky(256, glm::vec3(0.1f));
    EXPECT_EQ(lightsOf(wide, 8), 0u) << "uniform";
    addDisc(wide, {0, 1, 0}, glm::radians(25.0), glm::vec3(50));
    EXPECT_EQ(lightsOf(wide, 8), 0u) << "wide";
    Environment faint = flatSky(256, glm::vec3(1));
    addDisc(faint, {0, 0, 1}, glm::radians(1.0), glm::vec3(20));
    EXPECT_EQ(lightsOf(faint, 8), 0u) << "faint";
    Environment bright = flatSky(256, glm::vec3(0.1f));
    addDisc(bright, {1, 0, 0}, glm::radians(2.0), glm::vec3(500));
    addDisc(bright, {0, 0, 1}, glm::radians(2.0), glm::vec3(300));
    EXPECT_EQ(lightsOf(bright, 8), 2u);
    EXPECT_EQ(lightsOf(bright, 1), 1u);
    EXPECT_EQ(lightsOf(bright, 0), 0u) << "off";
    bright.color = glm::vec3(0);
    EXPECT_EQ(lightsOf(bright, 8), 0u) << "black";
}

/// A floor of 10 m and a lamp of one mesh above it.
Scene roomWith(const Mesh& lamp, const Material& material, const glm::dmat4& placement) {
    return test::SceneBuilder().add(test::quad(10, 10), test::lambert(0.5f)).add(lamp, material, placement).build();
}

TEST(ExtractEmitters, AQuadBecomesARectangleLight) {
    const glm::dmat4 placement = test::translation({1, 3, 2}) * test::rotation(30, {0, 1, 0}) *
                                 test::rotation(180, {1, 0, 0}) * test::scaling({2, 2, 2});
    Scene scene = roomWith(test::quad(0.5, 0.25), test::lambert(0.1f, 7), placement);
    extractEmitters(scene, 8);
    ASSERT_EQ(scene.lights.size(), 1u);
    const Light light = scene.lightsAt()[0];
    EXPECT_EQ(light.type, LightType::rectangle);
    EXPECT_TRUE(light.extracted);
    EXPECT_EQ(light.intensity, glm::vec3(7));
    EXPECT_LT(glm::distance(light.position, dvec3(1, 3, 2)), 1e-9);
    EXPECT_LT(glm::distance(light.direction, dvec3(0, -1, 0)), 1e-6);
    EXPECT_NEAR(std::max(light.width, light.height), 1, 1e-6);
    EXPECT_NEAR(std::min(light.width, light.height), 0.5, 1e-6);
    EXPECT_TRUE(scene.materials[static_cast<std::size_t>(scene.meshes[1].material)].extracted);
    EXPECT_FALSE(scene.materials[static_cast<std::size_t>(scene.meshes[0].material)].extracted);
}

TEST(ExtractEmitters, KeepsPowerOfBoxesSheetsAndMirrorImages) {
    const auto power = [](const Scene& scene) {
        double sum = 0;
        for (const Light& light : scene.lightsAt())
            sum += kPi * light.width * light.height * static_cast<double>(light.intensity.x);
        return sum;
    };
    Scene box = roomWith(test::box({0.5, 1, 0.25}), test::lambert(0.0f, 3), test::translation({0, 2, 0}));
    extractEmitters(box, 8);
    ASSERT_EQ(box.lights.size(), 6u);
    EXPECT_NEAR(power(box), 3 * kPi * 2 * (0.5 + 0.125 + 0.25), 1e-5);
    for (const Light& light : box.lightsAt())
        EXPECT_GT(glm::dot(light.direction, light.position - dvec3(0, 2, 0)), 0) << "shines outwards";

    Material sheet = test::lambert(0.0f, 3);
    sheet.doubleSided = true;
    Scene both = roomWith(test::quad(1, 1), sheet, test::translation({0, 2, 0}));
    extractEmitters(both, 8);
    ASSERT_EQ(both.lights.size(), 2u);
    EXPECT_NEAR(power(both), 2 * 3 * kPi, 1e-5);

    Scene mirrored =
        roomWith(test::quad(1, 0.5), test::lambert(0.0f, 3), test::translation({0, 2, 0}) * test::scaling({-1, 2, 1}));
    extractEmitters(mirrored, 8);
    ASSERT_EQ(mirrored.lights.size(), 1u);
    EXPECT_GT(mirrored.lightsAt()[0].direction.y, 0.999) << "front stays front";
}

TEST(ExtractEmitters, LeavesTheRestToCones) {
    const auto lightsOf = [](Scene scene, int most = 8) {
        const std::size_t materials = scene.materials.size();
        extractEmitters(scene, most);
        bool any = false;
        for (const Material& material : scene.materials) any = any || material.extracted;
        EXPECT_EQ(any, !scene.lights.empty());
        EXPECT_EQ(scene.materials.size(), materials);
        return scene.lights.size();
    };
    const Material bright = test::lambert(0.0f, 3);
    const glm::dmat4 up = test::translation({0, 2, 0});
    EXPECT_EQ(lightsOf(roomWith(test::quad(1, 1), bright, up), 0), 0u) << "off";
    EXPECT_EQ(lightsOf(roomWith(test::quad(9, 9), bright, up)), 0u) << "large";
    EXPECT_EQ(lightsOf(roomWith(test::sphere(0.3, 1), bright, up)), 0u) << "no rectangle";
    EXPECT_EQ(lightsOf(roomWith(test::box(dvec3(0.3)), bright, up), 5), 0u) << "all of a mesh or nothing";
    glm::dmat4 shear(1);
    shear[2][0] = 0.5;
    EXPECT_EQ(lightsOf(roomWith(test::quad(1, 1), bright, up * shear)), 0u) << "sheared";
    Material unlit = test::lambert(1.0f);
    unlit.unlit = true;
    EXPECT_EQ(lightsOf(roomWith(test::quad(1, 1), unlit, up)), 0u) << "unlit";
    Material textured = bright;
    textured.emissionTexture.texture = 0;
    EXPECT_EQ(lightsOf(roomWith(test::quad(1, 1), textured, up)), 0u) << "textured";
    Material blended = bright;
    blended.alphaMode = AlphaMode::blend;
    EXPECT_EQ(lightsOf(roomWith(test::quad(1, 1), blended, up)), 0u) << "blended";
}

TEST(ExtractEmitters, MeshesThatStayKeepTheirMaterial) {
    Scene scene = roomWith(test::quad(1, 1), test::lambert(0.0f, 3), test::translation({0, 2, 0}));
    Scene ball = roomWith(test::sphere(0.3, 1), test::lambert(0.0f, 3), test::translation({2, 2, 0}));
    scene.meshes.push_back(ball.meshes[1]);
    scene.meshes.back().material = scene.meshes[1].material;
    scene.nodes.push_back(ball.nodes[1]);
    scene.instances.push_back({2, 2});
    extractEmitters(scene, 8);
    ASSERT_EQ(scene.lights.size(), 1u);
    EXPECT_TRUE(scene.materials[static_cast<std::size_t>(scene.meshes[1].material)].extracted);
    EXPECT_FALSE(scene.materials[static_cast<std::size_t>(scene.meshes[2].material)].extracted);
}

TEST(ExtractEmitters, TheStrongestComeFirst) {
    test::SceneBuilder builder;
    builder.add(test::quad(10, 10), test::lambert(0.5f));
    for (const float radiance : {1.0f, 5.0f, 3.0f})
        builder.add(test::quad(0.5, 0.5), test::lambert(0.0f, radiance),
                    test::translation({static_cast<double>(radiance), 2, 0}));
    Scene scene = builder.build();
    extractEmitters(scene, 2);
    ASSERT_EQ(scene.lights.size(), 2u);
    EXPECT_EQ(scene.lights[0].intensity.x, 5);
    EXPECT_EQ(scene.lights[1].intensity.x, 3);
}

}  // namespace
}  // namespace voxcone
