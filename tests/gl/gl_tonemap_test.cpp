#include "frame/tonemap.h"

#include <gmock/gmock.h>

#include "frame/tone_curve.h"
#include "scene/environment.h"
#include "support/gl_context.h"
#include "support/shapes.h"

namespace voxcone {
namespace {

using test::GlTest;

TEST(ToneCurve, KnownValues) {
    for (const ToneMap curve : {ToneMap::linear, ToneMap::reinhard, ToneMap::aces}) {
        EXPECT_EQ(toneCurve(curve, glm::vec3(0)), glm::vec3(0));
        EXPECT_EQ(toneCurve(curve, glm::vec3(-1)), glm::vec3(0));
        EXPECT_NEAR(toneCurve(curve, glm::vec3(1e30f)).x, 1, 1e-6);
        float before = 0;
        for (float x = 0; x < 100; x += 0.37f) {
            const float y = toneCurve(curve, glm::vec3(x)).x;
            EXPECT_GE(y, before);
            EXPECT_LE(y, 1);
            before = y;
        }
    }
    EXPECT_EQ(toneCurve(ToneMap::linear, glm::vec3(0.5f)).x, 0.5f);
    EXPECT_EQ(toneCurve(ToneMap::reinhard, glm::vec3(1)).x, 0.5f);
    EXPECT_NEAR(toneCurve(ToneMap::aces, glm::vec3(1)).x, 2.54 / 3.16, 1e-6);
}

TEST_F(GlTest, ToneCurveTwinsAgreeAfterTheMean) {
    constexpr int kSize = 16;
    std::vector<glm::vec4> texels;
    for (int i = 0; i < kSize * kSize; ++i) {
        const float v = std::exp2(static_cast<float>(i) / 8 - 12);
        texels.emplace_back(v, 0.5f * v, 3 * v, 1);
    }
    texels[0] = glm::vec4(0, 1e30f, 1e-30f, 1);
    gl::Texture source = gl::Texture::create2D(GL_RGBA32F, kSize, kSize);
    source.upload(0, GL_RGBA, GL_FLOAT, texels.data());
    Readout readout{gl::ShaderLibrary()};
    for (const ToneMap curve : {ToneMap::linear, ToneMap::reinhard, ToneMap::aces}) {
        for (const int supersample : {1, 2}) {
            const Image mean = readout.read(source, 4, supersample),
                        shown = readout.display(source, curve, supersample);
            ASSERT_EQ(shown.width, kSize / supersample);
            for (int y = 0; y < shown.height; ++y) {
                for (int x = 0; x < shown.width; ++x) {
                    glm::vec4 sum(0);
                    for (int i = 0; i < supersample * supersample; ++i) {
                        // Row 0 of an image is on top, row 0 of a texture at the bottom.
                        const int tx = x * supersample + i % supersample;
                        const int ty = (shown.height - 1 - y) * supersample + i / supersample;
                        sum += texels[static_cast<std::size_t>(ty * kSize + tx)];
                    }
                    sum /= static_cast<float>(supersample * supersample);
                    const glm::vec3 expected = toneCurve(curve, glm::vec3(sum));
                    for (int k = 0; k < 3; ++k) {
                        ASSERT_NEAR(mean.pixel(x, y)[k], sum[k], 1e-6f * sum[k]);
                        // Shaders may flush the smallest numbers to zero.
                        ASSERT_NEAR(shown.pixel(x, y)[k], expected[k], 1e-6f);
                    }
                }
            }
        }
    }
}

/// The composite of a floor under an environment, with `layers`.
Image beautyOf(const Environment& environment, const Camera& camera, double exposure, int layerCount) {
    const Scene scene = test::oneObject(test::quad(2, 2), test::lambert(0.5f, 0.25f));
    const gl::GpuScene gpu(scene);
    const gl::ShaderLibrary library;
    GBuffer gbuffer(library, gpu, 64, 48);
    gl::PassTimers timers(gl::TimerMode::finish);
    gbuffer.draw(gpu, cameraView(camera, glm::dvec3(0), gpu.bounds(), 64, 48), timers);
    const gl::GpuEnvironment gpuEnvironment(environment);
    const Sky sky = skyOf(gpuEnvironment);
    Composite composite(library, gbuffer, sky);
    std::vector<gl::Texture> textures;
    std::vector<const gl::Texture*> layers;
    for (int i = 0; i < layerCount; ++i) {
        gl::Texture& texture = textures.emplace_back(gl::Texture::create2D(GL_RGBA32F, 64, 48));
        const glm::vec4 value(std::exp2(static_cast<float>(i)));
        texture.clear(0, GL_RGBA, GL_FLOAT, &value.x);
    }
    for (const gl::Texture& texture : textures) layers.push_back(&texture);
    composite.run(gbuffer, sky, layers, exposure, timers);
    return Readout(library).read(composite.beauty(), 3, 1);
}

TEST_F(GlTest, CompositeAddsLayersEmissionAndSky) {
    Environment environment;
    environment.color = glm::vec3(0.125f);
    const Camera camera = test::camera({0, 1, 3}, {0, 0, 0});
    for (int layers = 0; layers <= 3; ++layers) {
        const Image beauty = beautyOf(environment, camera, 1, layers);
        EXPECT_EQ(beauty.pixel(32, 24)[0], 2 * (0.25f + std::exp2(static_cast<float>(layers)) - 1)) << layers;
        EXPECT_EQ(beauty.pixel(0, 0)[0], 0.25f) << "sky";
    }
    environment.color = glm::vec3(0);
    EXPECT_EQ(beautyOf(environment, camera, 1, 0).pixel(0, 0)[0], 0);
}

TEST_F(GlTest, ThePanoramaBehindTheSceneIsTheCpuLookUp) {
    Environment environment;
    environment.color = glm::vec3(1, 2, 0.5f);
    environment.rotationDeg = 25;
    environment.width = 32;
    environment.height = 16;
    for (int i = 0; i < 32 * 16; ++i) {
        const float u = static_cast<float>(i % 32), v = static_cast<float>(i / 32);
        environment.radiance.emplace_back(1 + std::sin(u * 0.3f), v, 1e5f);
    }
    // Level, upwards and backwards: the seam of the panorama is behind.
    for (const glm::dvec3& direction : {glm::dvec3(0.2, 0.1, -1), glm::dvec3(0.3, 1, 0.1), glm::dvec3(-0.1, 0.3, 1)}) {
        const Camera camera = test::camera({0, 50, 0}, glm::dvec3(0, 50, 0) + direction, 60);
        const Image beauty = beautyOf(environment, camera, 0, 0);
        const CameraView view = cameraView(camera, glm::dvec3(0), Bounds{}, 64, 48);
        for (int y = 1; y < 48; y += 7) {
            for (int x = 1; x < 64; x += 7) {
                const glm::vec3 ray =
                    view.rays * glm::vec3(static_cast<float>(x) + 0.5f, static_cast<float>(47 - y) + 0.5f, 1);
                const glm::vec3 expected = environmentRadiance(environment, glm::normalize(ray));
                for (int k = 0; k < 3; ++k) {
                    ASSERT_NEAR(beauty.pixel(x, y)[k], expected[k], 1e-2f + 5e-3f * expected[k]) << x << ' ' << y;
                }
            }
        }
    }
}

}  // namespace
}  // namespace voxcone
