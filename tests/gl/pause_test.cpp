// Updates of voxels and light that are interrupted wherever they may be, against those in one go.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <map>
#include <random>

#include "frame/renderer.h"
#include "support/gl_context.h"
#include "support/shapes.h"

namespace voxcone::test {
namespace {

using Pause = GlTest;

const std::vector<std::string> kChannels{"beauty", "indirect_diffuse", "direct", "voxel_radiance", "voxel_opacity"};

/// A room with a lamp that has a near wall, a box that an animation moves, and a sun.
Scene animated() {
    Light lamp;
    lamp.type = LightType::point;
    lamp.position = {0.5, 1.2, 0.4};
    lamp.intensity = glm::vec3(1, 0.8f, 0.5f);
    Light sun;
    sun.type = LightType::directional;
    sun.direction = glm::normalize(glm::dvec3(-1, -2, -0.5));
    sun.intensity = glm::vec3(2);
    Scene scene = SceneBuilder()
                      .add(quad(4, 4), lambert(glm::vec3(0.8f, 0.7f, 0.6f)))
                      .add(box({0.2, 2, 4}), lambert(glm::vec3(0.8f, 0.2f, 0.1f)), translation({-1.5, 1, 0}))
                      .add(box({0.5, 0.5, 0.5}), lambert(glm::vec3(0.2f, 0.6f, 0.8f)), translation({0.3, 0.3, 0}))
                      .light(lamp)
                      .light(sun)
                      .sky(glm::vec3(0.1f, 0.15f, 0.2f))
                      .build();
    AnimationChannel channel;
    channel.node = scene.instances[2].node;
    channel.property = AnimatedProperty::translation;
    channel.times = {0, 1};
    channel.values = {glm::vec4(0.3f, 0.3f, 0, 0), glm::vec4(1.1f, 0.6f, 0.5f, 0)};
    scene.animations.push_back({"", {channel}});
    return scene;
}

Settings small(int levels) {
    Settings settings;
    settings.output.width = 48, settings.output.height = 32;
    settings.voxel.resolution = 16;
    settings.cascade.levels = levels;
    settings.cascade.snap = 1;
    settings.light.shadowResolution = 64;
    settings.light.bounces = 3;
    settings.light.bounceCones = 5;
    settings.cone.diffuse = 5;
    settings.cone.nearField = 0;
    return settings;
}

Camera cameraOf(int i) {
    return camera({2.0 - 0.4 * i, 1.5 + 0.1 * i, 2.5 - 0.3 * i}, {0, 0.4, 0});
}

std::map<std::string, Image> channels(Renderer& renderer) {
    std::map<std::string, Image> images;
    for (const std::string& name : kChannels) images[name] = renderer.channel(name);
    return images;
}

void expectSame(const std::map<std::string, Image>& a, const std::map<std::string, Image>& b, const std::string& what) {
    for (const auto& [name, image] : a) {
        std::size_t different = 0;
        for (std::size_t i = 0; i < image.data.size(); ++i) different += image.data[i] != b.at(name).data[i];
        EXPECT_EQ(different, 0u) << what << ": " << name << " of " << image.data.size();
    }
}

const auto kAlways = [] { return true; };

/// Renders until all is whole, paused wherever it may be. Frames that it took.
int settle(Renderer& renderer, const Camera& view) {
    int frames = 1;
    for (renderer.render(view, {}, kAlways); !renderer.light().whole; ++frames) {
        if (frames > 2000) {
            ADD_FAILURE() << "light never becomes whole";
            return frames;
        }
        renderer.render(view, {}, kAlways);
    }
    return frames;
}

// However far an update has come when camera, light or animation go on: in the end it is what it would be in one go.
TEST_F(Pause, AnInterruptedUpdateGivesTheBitsOfOneInOneGo) {
    for (const int levels : {1, 3}) {
        for (const VoxelStorage storage : {VoxelStorage::six_face, VoxelStorage::sh1}) {
            if (levels == 1 && storage == VoxelStorage::sh1) continue;
            Settings settings = small(levels);
            settings.voxel.storage = storage;
            settings.light.tolerance = levels == 1 ? 0.02 : 0;
            Scene scene = animated();
            Renderer paused(glContext(), scene, settings), whole(glContext(), scene, settings);
            std::mt19937 random(7);
            const std::string what = fmt::format("{} levels, storage {}", levels, static_cast<int>(storage));
            int least = 1000;
            for (int i = 0; i < 3; ++i) {
                // Some frames of states that are given up: camera, light and time change at any moment of an update.
                for (int j = 0; j < 4; ++j) {
                    if (j % 3 == 0) scene.lights[0].position.x = 0.5 + 0.1 * (i + j);
                    if (j % 3 == 1) paused.setTime(0.2 * i + 0.1 * j);
                    const int frames = static_cast<int>(random() % 6);
                    for (int k = 0; k < frames; ++k) paused.render(cameraOf(i + j % 2), {}, kAlways);
                }
                scene.lights[0].position = {0.5 - 0.2 * i, 1.2, 0.4};
                for (Renderer* renderer : {&paused, &whole}) renderer->setTime(0.25 * i);
                paused.render(cameraOf(i), {}, kAlways);
                EXPECT_FALSE(paused.light().whole) << what;
                least = std::min(least, settle(paused, cameraOf(i)));
                whole.render(cameraOf(i));
                EXPECT_TRUE(whole.light().whole);
                expectSame(channels(whole), channels(paused), what);
                EXPECT_EQ(whole.stats().counts.at("light_bounces"), paused.stats().counts.at("light_bounces"));
                EXPECT_EQ(whole.stats().counts.at("voxels_occupied"), paused.stats().counts.at("voxels_occupied"));
                EXPECT_EQ(whole.stats().counts.at("radiance_clamped"), paused.stats().counts.at("radiance_clamped"));
            }
            EXPECT_GE(least, 4) << "interrupted between bounces at least";
        }
    }
}

// A frame without `pause` finishes what was left.
TEST_F(Pause, AWholeFrameFinishesWhatWasLeft) {
    Scene scene = animated();
    Renderer paused(glContext(), scene, small(3)), whole(glContext(), scene, small(3));
    whole.render(cameraOf(1));
    for (int frames = 0; frames < 8; ++frames) {
        paused.invalidate();
        for (int k = 0; k < frames; ++k) paused.render(cameraOf(k % 2), {}, kAlways);
        paused.render(cameraOf(1));
        EXPECT_TRUE(paused.light().whole);
        expectSame(channels(whole), channels(paused), fmt::format("after {} frames", frames));
    }
}

TEST_F(Pause, AnUpdateBudgetSettlesAtTheSameBits) {
    Settings settings = small(3);
    settings.cascade.update = CascadeUpdate::budget;
    settings.cascade.budget = 3;
    Scene scene = animated();
    Renderer paused(glContext(), scene, settings), whole(glContext(), scene, settings);
    for (int i = 0; i < 3; ++i) {
        if (i == 1) scene.lights[0].position.x -= 0.4;
        if (i == 2)
            for (Renderer* renderer : {&paused, &whole}) renderer->setTime(0.5);
        settle(paused, cameraOf(i));
        do whole.render(cameraOf(i));
        while (!whole.light().whole);
        expectSame(channels(whole), channels(paused), fmt::format("step {}", i));
    }
}

// What a paused frame shows: new direct light at once, then more and more bounces.
TEST_F(Pause, DirectLightComesFirstAndBouncesFollow) {
    Scene scene = animated();
    Settings settings = small(1);
    settings.light.extrapolate = false;
    Renderer renderer(glContext(), scene, settings), other(glContext(), scene, settings);
    settle(renderer, cameraOf(0));
    scene.lights[1].intensity = glm::vec3(8);
    renderer.render(cameraOf(0), {}, kAlways);
    EXPECT_FALSE(renderer.light().whole);
    other.render(cameraOf(0));
    EXPECT_EQ(renderer.channel("direct").data, other.channel("direct").data);
    std::vector<double> means;
    int bounces = -1;
    for (;;) {
        const LightProgress progress = renderer.light();
        EXPECT_LE(progress.bounces, progress.of);
        EXPECT_GE(progress.share, 0);
        EXPECT_LE(progress.share, 1);
        if (progress.whole || (progress.direct && progress.bounces != bounces)) {
            bounces = progress.bounces;
            const Image indirect = renderer.channel("indirect_diffuse");
            double sum = 0;
            for (const float v : indirect.data) sum += static_cast<double>(v);
            means.push_back(sum);
        }
        if (progress.whole) break;
        renderer.render(cameraOf(0), {}, kAlways);
    }
    ASSERT_EQ(means.size(), 4u) << "direct light and three bounces";
    for (std::size_t i = 1; i < means.size(); ++i) EXPECT_GT(means[i], means[i - 1]);
}

TEST_F(Pause, LevelsAreVoxelizedAndTimedOneByOne) {
    const Scene scene = animated();
    Renderer renderer(glContext(), scene, small(3));
    std::map<int, int> seen;
    do {
        renderer.render(cameraOf(0), {}, kAlways);
        const ClipmapState state = renderer.clipmap();
        EXPECT_LE(renderer.stats().levelMilliseconds.size(), 1u);
        for (const auto& [level, milliseconds] : renderer.stats().levelMilliseconds) {
            EXPECT_GT(milliseconds, 0);
            EXPECT_TRUE(state.update.touches(level));
            ++seen[level];
            double sum = 0;
            for (const FrameStats::Pass& pass : renderer.stats().passes)
                if (pass.name.starts_with("voxelize")) sum += pass.milliseconds;
            EXPECT_DOUBLE_EQ(milliseconds, sum);
        }
    } while (!renderer.light().whole);
    EXPECT_EQ(seen, (std::map<int, int>{{0, 1}, {1, 1}, {2, 1}}));
}

}  // namespace
}  // namespace voxcone::test
