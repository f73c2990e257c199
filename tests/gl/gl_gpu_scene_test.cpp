#include "gl/gpu_scene.h"

#include <gmock/gmock.h>

#include <set>

#include "support/gl_context.h"
#include "support/shapes.h"

namespace voxcone {
namespace {

using gl::Batch;
using gl::GpuScene;
using test::GlTest;

TEST_F(GlTest, AnEmptySceneHasNothingToDraw) {
    const Scene scene;
    const GpuScene gpu(scene);
    EXPECT_TRUE(gpu.empty());
    EXPECT_TRUE(gpu.bounds().empty());
    EXPECT_EQ(gpu.triangleCount(), 0u);
    EXPECT_EQ(gpu.textureBytes(), 0u);
}

TEST_F(GlTest, ClosedAndOpenTrianglesAreBatchesOfTheirOwn) {
    const Mesh mesh = test::merged(test::box(glm::dvec3(1)), test::room(glm::dvec3(3)));
    const Scene scene = test::oneObject(mesh, test::lambert(0.5f));
    const GpuScene gpu(scene);
    ASSERT_EQ(gpu.batches().size(), 2u);
    EXPECT_NE(gpu.batches()[0].closed, gpu.batches()[1].closed);
    for (const Batch& batch : gpu.batches()) EXPECT_EQ(batch.indexCount, 36u);
    EXPECT_EQ(gpu.triangleCount(), 24u);
}

TEST_F(GlTest, InstancesShareABatchUnlessTheirTransformMirrors) {
    Scene scene = test::oneObject(test::box(glm::dvec3(1)), test::lambert(0.5f));
    for (const double x : {2.0, 4.0, -6.0}) {
        Node node;
        node.translation = glm::dvec3(std::abs(x), 0, 0);
        node.scale = glm::dvec3(x < 0 ? -1 : 1, 1, 1);
        scene.nodes.push_back(node);
        scene.instances.push_back({0, static_cast<int>(scene.nodes.size()) - 1});
    }
    const GpuScene gpu(scene);
    ASSERT_EQ(gpu.batches().size(), 2u);
    EXPECT_EQ(gpu.objectCount(), 4u);
    std::set<std::uint32_t> drawn;
    for (const Batch& batch : gpu.batches()) {
        EXPECT_EQ(batch.objectCount, batch.mirrored ? 1u : 3u);
        for (std::uint32_t k = 0; k < batch.objectCount; ++k) drawn.insert(batch.firstObject + k);
    }
    EXPECT_EQ(drawn.size(), 4u);
    EXPECT_EQ(gpu.triangleCount(), 48u);
    EXPECT_EQ(gpu.bounds().min, glm::dvec3(-.5));
    EXPECT_EQ(gpu.bounds().max, glm::dvec3(6.5, .5, .5));
}

TEST_F(GlTest, BatchesAreSortedByMaterialAndSayWhatTheyAre) {
    Material masked = test::lambert(0.5f);
    masked.alphaMode = AlphaMode::mask;
    const Scene scene = test::SceneBuilder()
                            .add(test::quad(1, 1), test::lambert(0.5f, 2.0f))
                            .add(test::quad(1, 1), masked)
                            .add(test::quad(1, 1), test::lambert(0.1f))
                            .build();
    const GpuScene gpu(scene);
    ASSERT_EQ(gpu.batches().size(), 3u);
    EXPECT_TRUE(gpu.batches()[0].emits);
    EXPECT_FALSE(gpu.batches()[1].emits);
    EXPECT_EQ(gpu.batches()[1].alphaMode, AlphaMode::mask);
    EXPECT_TRUE(gpu.anyAlphaTest());
    EXPECT_TRUE(gpu.anyEmission());
}

TEST_F(GlTest, OnlyTexturesThatMaterialsUseAreUploadedOncePerEncoding) {
    Material material = test::lambert(0.5f);
    material.baseColorTexture.texture = 0;
    material.emissionTexture.texture = 0;
    material.normalTexture.texture = 0;
    Scene scene = test::oneObject(test::quad(1, 1), material);
    Texture image;
    image.width = image.height = 4;
    image.rgba8.assign(64, 200);
    scene.textures = {image, image};
    const GpuScene gpu(scene);
    EXPECT_EQ(gpu.textureBytes(), 2u * (16 + 4 + 1) * 4);
}

TEST_F(GlTest, AnimatedMirroringMakesNewBatches) {
    Scene scene = test::oneObject(test::box(glm::dvec3(1)), test::lambert(0.5f));
    scene.nodes[0].hasMatrix = false;
    Animation animation;
    AnimationChannel channel;
    channel.node = 0;
    channel.property = AnimatedProperty::scale;
    channel.times = {0, 1};
    channel.values = {glm::vec4(1, 1, 1, 0), glm::vec4(-2, 1, 1, 0)};
    animation.channels.push_back(channel);
    scene.animations.push_back(animation);
    GpuScene gpu(scene);
    EXPECT_FALSE(gpu.batches()[0].mirrored);
    gpu.setTime(1);
    EXPECT_TRUE(gpu.batches()[0].mirrored);
    EXPECT_DOUBLE_EQ(gpu.bounds().max.x, 1);
}

}  // namespace
}  // namespace voxcone
