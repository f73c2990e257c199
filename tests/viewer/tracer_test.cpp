// The path tracer of one pixel sees what the whole picture has there.
#include "viewer/tracer.h"

#include <gtest/gtest.h>

#include "capture/script.h"

namespace voxcone {
namespace {

TEST(PixelCamera, SeesThePixelOfThePicture) {
    const CaptureScript script = loadCaptureScript(VOXCONE_SOURCE_DIR "/assets/captures/cornell.json");
    const Camera camera = cameraAt(script.shots[0], script.scene, 0);
    Settings settings;
    settings.output.width = 48, settings.output.height = 32;
    settings.reference.samples = 2;
    settings.reference.maxDepth = 1;
    const PathTracer tracer(script.scene);
    const ReferenceImages picture = tracer.render(camera, settings);
    settings.output.width = settings.output.height = 1;
    for (const glm::ivec2 pixel : {glm::ivec2(0, 0), glm::ivec2(20, 9), glm::ivec2(40, 30)}) {
        const ReferenceImages one = tracer.render(pixelCamera(camera, 48, 32, pixel.x, pixel.y), settings);
        for (int c = 0; c < 3; ++c)
            EXPECT_NEAR(one.position.data[static_cast<std::size_t>(c)], picture.position.pixel(pixel.x, pixel.y)[c],
                        1e-4f);
    }
}

TEST(BackgroundTracer, PassesConvergeToTheMean) {
    auto script = loadCaptureScript(VOXCONE_SOURCE_DIR "/assets/captures/cornell.json");
    const Camera camera = cameraAt(script.shots[0], script.scene, 0);
    Settings settings;
    settings.output.width = settings.output.height = 8;
    settings.reference.samples = 32;
    std::atomic<int> woken = 0;
    const auto scene = std::make_shared<Scene>(std::move(script.scene));
    BackgroundTracer tracer(scene, 0, camera, settings, 8, [&] { ++woken; });
    while (tracer.running()) std::this_thread::sleep_for(std::chrono::milliseconds(5));
    const auto traced = tracer.picture();
    ASSERT_TRUE(traced != nullptr);
    EXPECT_EQ(traced->samples, 32);
    EXPECT_EQ(traced->passes, 4);
    EXPECT_GT(traced->error, 0);
    EXPECT_GE(woken, 4);
    // The mean of the same passes, made one by one.
    const PathTracer reference(*scene);
    Image mean(8, 8, 3);
    settings.reference.samples = 8;
    for (int pass = 0; pass < 4; ++pass, ++settings.reference.seed) {
        const ReferenceImages images = reference.render(camera, settings);
        for (std::size_t i = 0; i < mean.data.size(); ++i) mean.data[i] += images.beauty.data[i] / 4;
    }
    for (std::size_t i = 0; i < mean.data.size(); ++i)
        EXPECT_NEAR(traced->beauty.data[i], mean.data[i], 1e-4f + 1e-4f * mean.data[i]);
}

}  // namespace
}  // namespace voxcone
