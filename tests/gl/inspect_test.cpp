// The cones of a pixel, asked for one by one, against the picture that they make.
#include "cone/inspect.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "frame/renderer.h"
#include "support/gl_context.h"
#include "support/shapes.h"

namespace voxcone::test {
namespace {

using InspectTest = GlTest;

Settings small(bool rotate) {
    Settings settings;
    settings.output.width = 48, settings.output.height = 32;
    settings.voxel.resolution = 32;
    settings.light.shadowResolution = 128;
    settings.light.bounces = 1;
    settings.cone.diffuse = 6;
    settings.cone.rotate = rotate;
    settings.specular.cones = 4;
    return settings;
}

/// Glossy floor, rough and smooth metal, glass, a leaf and a pane under a sky and a lamp.
Scene everything() {
    Light bulb;
    bulb.type = LightType::point;
    bulb.position = {0.8, 1.2, 0.4};
    bulb.intensity = glm::vec3(0.5f, 0.4f, 0.3f);
    return SceneBuilder()
        .add(sphere(0.3, 3), tintedGlass(), translation({-0.3, 0.3, 0.9}))
        .add(quad(0.7, 0.7), greenLeaf(), translation({0.2, 0.9, 0.3}) * rotation(50, {1, 0, 0}))
        .add(quad(4, 4), glossy({0.7f, 0.6f, 0.5f}, 0, 0.5f))
        .add(box({0.8, 0.8, 0.8}), glossy({0.8f, 0.3f, 0.2f}, 1, 0.05f),
             translation({-0.9, 0.4, 0}) * rotation(30, {0, 1, 0}))
        .add(sphere(0.4, 3), glossy({0.9f, 0.8f, 0.3f}, 1, 0.4f), translation({0.6, 0.4, 0.5}))
        .light(bulb)
        .sky(glm::vec3(0.2f, 0.3f, 0.5f))
        .build();
}

glm::vec3 pixel(const Image& image, int x, int y) {
    const float* p = image.pixel(x, y);
    return {p[0], p[1], p[2]};
}

TEST_F(InspectTest, LobesAddUpToTheirChannels) {
    const Scene scene = everything();
    const Settings settings = small(false);  // no mean over neighbours
    Renderer renderer(glContext(), scene, settings);
    renderer.render(camera({0.4, 1.3, 2.6}, {0, 0.4, 0.3}));
    std::map<std::string, Image> channels;
    for (const char* name : {"indirect_diffuse", "indirect_specular", "transmission"})
        channels[name] = renderer.channel(name);
    std::map<ConeLobe, int> met;
    for (int y = 1; y < settings.output.height; y += 3) {
        for (int x = 1; x < settings.output.width; x += 3) {
            std::map<std::string, glm::vec3> sums;
            for (const PixelCones& lobe : renderer.inspect(x, y)) {
                ++met[lobe.lobe];
                sums[channelOf(lobe.lobe)] += lobe.outgoing();
                double weights = 0;
                for (const InspectedCone& cone : lobe.cones) {
                    weights += cone.weight;
                    EXPECT_GT(cone.weight, 0);
                    EXPECT_NEAR(glm::length(cone.direction), 1, 1e-5);
                    EXPECT_FALSE(cone.truncated);
                    double before = 1;
                    for (const ConeSample& sample : cone.samples) {
                        EXPECT_LE(sample.transmittance, before);
                        before = sample.transmittance;
                    }
                    if (cone.samples.empty()) continue;
                    EXPECT_EQ(cone.samples.back().transmittance, cone.transmittance);
                    EXPECT_LT(glm::length(cone.samples.back().radiance - cone.radiance), 1e-5f);
                }
                EXPECT_NEAR(weights, 1, 1e-5);
            }
            for (const auto& [name, image] : channels) {
                const glm::vec3 shown = pixel(image, x, y), sum = sums.contains(name) ? sums[name] : glm::vec3(0);
                EXPECT_LT(glm::length(sum - shown), 1e-5f + 1e-4f * glm::length(shown)) << name << " " << x << " " << y;
            }
        }
    }
    // All of them were in the picture.
    EXPECT_EQ(met.size(), 4u);
    for (const auto& [lobe, count] : met) EXPECT_GT(count, 2) << nameOf(lobe);
}

TEST_F(InspectTest, SmoothLobesTakeOneConeAndRoughOnesSeveral) {
    const Scene scene = everything();
    Renderer renderer(glContext(), scene, small(true));
    renderer.render(camera({0.4, 1.3, 2.6}, {0, 0.4, 0.3}));
    const Image base = renderer.channel("albedo");
    std::map<std::size_t, int> counts;
    for (int y = 0; y < 32; y += 2)
        for (int x = 0; x < 48; x += 2)
            for (const PixelCones& lobe : renderer.inspect(x, y)) {
                if (lobe.lobe != ConeLobe::specular) continue;
                ++counts[lobe.cones.size()];
                // Metals reflect by it alone; the glass has a base colour of 1.
                const float red = pixel(base, x, y).x;
                if (red > 0.75f && red < 0.95f) {
                    EXPECT_GT(lobe.share.x, 0.5f);
                }
            }
    EXPECT_GT(counts[1], 0);
    EXPECT_GT(counts[4] + counts[3], 0);
}

TEST_F(InspectTest, TheBackgroundHasNoCones) {
    const Scene scene = everything();
    Renderer renderer(glContext(), scene, small(false));
    renderer.render(camera({0, 1, 3}, {0, 3, 0}));
    EXPECT_TRUE(renderer.inspect(24, 2).empty());
}

}  // namespace
}  // namespace voxcone::test
