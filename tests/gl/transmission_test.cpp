// Light through matter in the renderer, against closed forms and the path tracer's conventions.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/gtc/constants.hpp>

#include "frame/renderer.h"
#include "light/specular_table.h"
#include "support/gl_context.h"
#include "support/shapes.h"

namespace voxcone::test {
namespace {

using TransmissionTest = GlTest;

constexpr double kPi = glm::pi<double>();

Settings small() {
    Settings settings;
    settings.output.width = settings.output.height = 48;
    settings.voxel.resolution = 32;
    settings.light.shadowResolution = 256;
    settings.light.bounces = 0;
    settings.cone.diffuse = 9;
    return settings;
}

/// Passes all light that its specular lobe does not reflect.
Material glass(float roughness, float thickness = 0) {
    Material material = glossy(glm::vec3(1), 0, roughness);
    material.transmission = 1;
    material.thickness = thickness;
    return material;
}

/// Mean over the window [low, high)² in parts of the picture.
glm::dvec3 mean(const Image& image, double low = 0.4, double high = 0.6) {
    glm::dvec3 sum(0);
    int count = 0;
    for (int y = static_cast<int>(low * image.height); y < high * image.height; ++y) {
        for (int x = static_cast<int>(low * image.width); x < high * image.width; ++x, ++count) {
            for (int c = 0; c < 3; ++c) sum[c] += static_cast<double>(image.pixel(x, y)[c]);
        }
    }
    return sum / static_cast<double>(count);
}

struct Picture {
    Renderer renderer;
    Picture(const Scene& scene, const Camera& camera, const Settings& settings = small())
        : renderer(glContext(), scene, settings) {
        renderer.render(camera);
    }
    glm::dvec3 mean(const std::string& channel) { return test::mean(renderer.channel(channel)); }
};

const Camera kDown = camera({0, 5, 0}, {0, 0, 0}, 10, {0, 0, -1});

TEST_F(TransmissionTest, PanePassesWhatItsFacetsDoNotReflect) {
    for (const float roughness : {0.05f, 0.4f}) {
        for (const double degrees : {60.0, 80.0}) {
            const Scene scene = oneObject(quad(16, 16), glass(roughness), rotation(degrees, {1, 0, 0}), glm::vec3(1));
            Picture picture(scene, kDown);
            const glm::dvec2 parts =
                specularAlbedo(std::cos(glm::radians(degrees)), static_cast<double>(roughness) * roughness, 1 << 14);
            const Image image = picture.renderer.channel("transmission");
            const double seen = mean(image, 0.45, 0.55).x;
            EXPECT_NEAR(seen, 0.96 * parts.x, 0.004) << roughness << ", " << degrees;
        }
    }
}

TEST_F(TransmissionTest, GlassUnderUniformLightCanHardlyBeSeen) {
    for (const float roughness : {0.0f, 0.3f}) {
        const auto look = [&](const Mesh& mesh, float thickness) {
            const Scene scene = oneObject(mesh, glass(roughness, thickness), rotation(20, {1, 0, 0}), glm::vec3(1));
            return Picture(scene, kDown).mean("beauty").x;
        };
        EXPECT_NEAR(look(quad(2, 2), 0), 1, 0.02) << roughness;
        EXPECT_NEAR(look(box({2, 2, 2}), 2), 1, 0.02) << roughness;
        EXPECT_NEAR(look(sphere(1, 4), 2), 1, 0.02) << roughness;
    }
}

TEST_F(TransmissionTest, SlabsAbsorbByBeersLaw) {
    Material slab = glass(0, 3);  // not its thickness: the way between its faces counts
    slab.attenuationColor = {0.5f, 1, 0.25f};
    slab.attenuationDistance = 1;
    const glm::dvec3 seen =
        Picture(oneObject(box({8, 2, 8}), slab, glm::dmat4(1), glm::vec3(1)), kDown).mean("transmission");
    const double r = 0.04;
    for (int c = 0; c < 3; ++c) {
        const double left = std::pow(static_cast<double>(slab.attenuationColor[c]), 2);
        const double expected = (1 - r) * (1 - r) * left / (1 - r * left);
        EXPECT_NEAR(seen[c], expected, 0.02 * expected) << c;
    }
    // Open, the same is a sheet that is crossed straight.
    const glm::dvec3 sheet =
        Picture(oneObject(quad(8, 8), slab, scaling(glm::dvec3(2)), glm::vec3(1)), kDown).mean("transmission");
    EXPECT_NEAR(sheet.x, 0.96 / 64, 0.02 / 64) << "a sheet of thickness 3 m, twice as large";
}

TEST_F(TransmissionTest, ABallTurnsWhatIsBehindItRound) {
    SceneBuilder builder;
    builder.add(sphere(1, 4), glass(0, 2));
    builder.add(box({4, 0.5, 8}), lambert(glm::vec3(0), glm::vec3(1, 0, 0)), translation({-2, -4, 0}));
    builder.add(box({4, 0.5, 8}), lambert(glm::vec3(0), glm::vec3(0, 0, 1)), translation({2, -4, 0}));
    Picture picture(builder.build(), camera({0, 8, 0}, {0, 0, 0}, 20, {0, 0, -1}));
    const Image transmission = picture.renderer.channel("transmission");
    const float* left = transmission.pixel(transmission.width * 2 / 5, transmission.height / 2);
    const float* right = transmission.pixel(transmission.width * 3 / 5, transmission.height / 2);
    EXPECT_GT(left[2], 0.8) << "left of the middle lies what is on the right";
    EXPECT_LT(left[0], 0.1);
    EXPECT_GT(right[0], 0.8);
    EXPECT_LT(right[2], 0.1);
}

TEST_F(TransmissionTest, SheetsScatterToTheOtherSide) {
    const Material leaf = greenLeaf();
    Picture lit(SceneBuilder().add(quad(4, 4), leaf).light(sunFromBelow()).build(), kDown);
    EXPECT_NEAR(lit.mean("direct").x, 2 * 0.25 * 0.5 / kPi, 1e-4);
    EXPECT_NEAR(lit.mean("direct").y, 2 * 0.25 / kPi, 1e-4);
    Picture sky(oneObject(quad(4, 4), leaf, glm::dmat4(1), glm::vec3(1)), kDown);
    EXPECT_NEAR(sky.mean("transmission").x, 0.25 * 0.5, 2e-3);
    EXPECT_NEAR(sky.mean("indirect_diffuse").x, 0.75 * 0.8, 4e-3);
}

TEST_F(TransmissionTest, LightPassesOnToWhatLiesBehind) {
    Light sun;
    sun.type = LightType::directional;
    sun.direction = {0, -1, 0};
    sun.intensity = glm::vec3(static_cast<float>(kPi));
    const auto floorBelow = [&](const Mesh& mesh, const Material& material) {
        // Seen from between the two.
        const Scene scene = SceneBuilder()
                                .add(quad(16, 16), lambert(0.5f))
                                .add(mesh, material, translation({0, 2, 0}))
                                .light(sun)
                                .sky(glm::vec3(1))
                                .build();
        Picture picture(scene, camera({0, 1, 0}, {0, 0, 0}, 30, {0, 0, -1}));
        // The screen door repeats after four texels: over the whole picture it is averaged.
        return glm::dvec2(mean(picture.renderer.channel("direct"), 0, 1).x, picture.mean("indirect_diffuse").x);
    };
    Material half = glass(0);
    half.baseColor = {0.5f, 0.5f, 0.5f, 1};
    // The screen door has sixteen steps.
    EXPECT_NEAR(floorBelow(quad(16, 16), glass(0)).x, 0.5 * 0.96, 0.5 / 16);
    EXPECT_NEAR(floorBelow(quad(16, 16), half).x, 0.5 * 0.48, 0.5 / 16);
    EXPECT_NEAR(floorBelow(box({16, 0.5, 16}), half).x, 0.5 * 0.48 * 0.48, 0.5 / 16);
    // A sheet that reflects nothing and fills F of the hemisphere (row C1) takes away the half of F.
    Material beam = lambert(0.5f), leaf = lambert(0.0f);
    beam.transmission = 1;
    leaf.diffuseTransmission = 0.5f;
    const double factor = 0.951424, open = floorBelow(quad(0.01, 0.01), beam).y;
    EXPECT_NEAR(floorBelow(quad(16, 16), beam).y / open, 1 - 0.5 * factor, 0.04);
    EXPECT_NEAR(floorBelow(quad(16, 16), leaf).y / open, 1 - 0.5 * factor, 0.04);
    EXPECT_NEAR(floorBelow(box({16, 0.1, 16}), beam).y / open, 1 - 0.75 * factor, 0.05) << "two walls";
}

}  // namespace
}  // namespace voxcone::test
