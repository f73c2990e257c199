// Which shadow views lights get, and where they lie in the atlas.
#include "light/light_layout.h"

#include <gtest/gtest.h>

#include "core/error.h"

namespace voxcone {
namespace {

Bounds cube(double halfEdge) {
    Bounds bounds;
    bounds.add(glm::dvec3(-halfEdge));
    bounds.add(glm::dvec3(halfEdge));
    return bounds;
}

Light light(LightType type) {
    Light l;
    l.type = type;
    l.radius = 0.5;
    l.width = 1;
    l.height = 0.5;
    return l;
}

const std::vector<Light> kAll = {light(LightType::directional), light(LightType::point), light(LightType::spot),
                                 light(LightType::sphere), light(LightType::rectangle)};

TEST(LightLayout, ViewsOfEachType) {
    const LightLayout layout = layoutLights(kAll, cube(2), glm::dvec3(0), 1024, 1.5, 16384);
    ASSERT_EQ(layout.lights.size(), 5u);
    const auto expect = [&](std::size_t i, unsigned samples, unsigned faces, int tile) {
        EXPECT_EQ(layout.lights[i].samples, samples) << i;
        EXPECT_EQ(layout.lights[i].faces, faces) << i;
        EXPECT_EQ(layout.tiles[layout.lights[i].firstView].size, tile) << i;
    };
    expect(0, 1, 1, 1024);
    expect(1, 1, 6, 512);
    expect(2, 1, 1, 1024);
    expect(3, 12, 6, 256);
    expect(4, 10, 5, 256);
    EXPECT_EQ(layout.views.size(), 1u + 6u + 1u + 72u + 50u);
    EXPECT_EQ(layout.shrunk, 0);
}

TEST(LightLayout, TilesDoNotOverlap) {
    const LightLayout layout = layoutLights(kAll, cube(2), glm::dvec3(0), 512, 1.5, 16384);
    for (std::size_t a = 0; a < layout.tiles.size(); ++a) {
        const ShadowTile& s = layout.tiles[a];
        EXPECT_TRUE(s.x >= 0 && s.y >= 0 && s.x + s.size <= layout.atlasWidth && s.y + s.size <= layout.atlasHeight);
        for (std::size_t b = 0; b < a; ++b) {
            const ShadowTile& t = layout.tiles[b];
            EXPECT_TRUE(s.x + s.size <= t.x || t.x + t.size <= s.x || s.y + s.size <= t.y || t.y + t.size <= s.y)
                << a << " meets " << b;
        }
    }
}

TEST(LightLayout, SmallAreaLightsHaveOneSample) {
    Light small = light(LightType::sphere);
    small.radius = 0.01;
    EXPECT_EQ(layoutLights({small}, cube(2), glm::dvec3(0), 1024, 1.5, 16384).lights[0].samples, 1u);
    small.radius = 0;  // a point
    const LightLayout point = layoutLights({small}, cube(2), glm::dvec3(0), 1024, 1.5, 16384);
    EXPECT_EQ(point.lights[0].type, static_cast<unsigned>(LightType::point));
}

TEST(LightLayout, SampleTheRectangleEvenly) {
    Light panel = light(LightType::rectangle);
    panel.position = {1, 2, 3};
    const LightLayout layout = layoutLights({panel}, cube(4), glm::dvec3(0), 1024, 1.5, 16384);
    const LightRecord& record = layout.lights[0];
    glm::dvec3 mean(0);
    for (unsigned i = 0; i < record.samples; ++i) {
        const glm::dvec3 p = layout.views[record.firstView + i * record.faces].origin;
        mean += p / static_cast<double>(record.samples);
        EXPECT_NEAR(p.y, 2, 1e-6);
        EXPECT_LT(std::abs(p.x - 1), 0.5);
        EXPECT_LT(std::abs(p.z - 3), 0.25);
    }
    EXPECT_LT(glm::distance(mean, panel.position), 1e-6);
}

TEST(LightLayout, ShrinksToFitThenRefuses) {
    const std::vector<Light> many(40, light(LightType::point));  // 240 faces
    const LightLayout fits = layoutLights(many, cube(2), glm::dvec3(0), 2048, 1.5, 4096);
    EXPECT_EQ(fits.shrunk, 2);
    EXPECT_LE(fits.atlasWidth, 4096);
    EXPECT_LE(fits.atlasHeight, 4096);
    EXPECT_THROW(layoutLights(many, cube(2), glm::dvec3(0), 2048, 1.5, 512), DeviceError);
}

TEST(LightLayout, NothingToCastNoViews) {
    const LightLayout layout = layoutLights(kAll, Bounds(), glm::dvec3(0), 1024, 1.5, 16384);
    EXPECT_EQ(layout.lights.size(), 5u);
    EXPECT_TRUE(layout.views.empty());
    EXPECT_EQ(layout.atlasWidth, 0);
}

}  // namespace
}  // namespace voxcone
