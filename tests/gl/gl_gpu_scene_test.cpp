#include "gl/gpu_scene.h"

#include <gmock/gmock.h>

#include <random>
#include <set>

#include "core/atomic_file.h"
#include "gl/framebuffer.h"
#include "gl/shader_library.h"
#include "support/gl_context.h"
#include "support/shapes.h"

namespace voxcone {
namespace {

using gl::Batch;
using gl::GpuScene;
using test::GlTest;

Bounds boxOf(const glm::dvec3& low, const glm::dvec3& high) {
    Bounds box;
    box.add(low);
    box.add(high);
    return box;
}

/// Draws what lies in a box of the world, seen along an axis without perspective: every pixel holds world position
/// and object.
class BoxPicture {
  public:
    BoxPicture() {
        const auto folder = std::filesystem::temp_directory_path() / ("voxcone_box" + std::to_string(getpid()));
        std::filesystem::create_directories(folder);
        writeTextFile(folder / "box.vert", R"(
            #include "shared/objects.glsl"
            uniform mat4 u_clipFromWorld;
            out vec4 v_color;
            void main() {
                vec3 p = objectWorldPosition();
                v_color = vec4(p, float(a_objectIndex));
                gl_Position = u_clipFromWorld * vec4(p, 1.0);
            })");
        writeTextFile(folder / "box.frag",
                      "in vec4 v_color; layout(location = 0) out vec4 o_color; void main() { o_color = v_color; }");
        program_ = gl::ShaderLibrary(folder).graphics({"box.vert", "box.frag"});
        std::filesystem::remove_all(folder);
        framebuffer_.attachColor(0, color_);
        framebuffer_.attachDepth(depth_);
    }

    gl::Program& program() { return program_; }

    /// The picture of `box` along `axis`; `draw` issues the draw. No texel of the background is met by a scene.
    std::vector<float> of(const GpuScene& scene, const Bounds& box, int axis, const std::function<void()>& draw) {
        framebuffer_.clearColor(0, glm::vec4(-1));
        framebuffer_.clearDepth(1);
        const glm::dvec3 center = box.center() - scene.origin(), half = 0.5 * box.size();
        glm::dmat4 clip(0);
        for (int row = 0; row < 3; ++row) {
            const int from = (axis + 1 + row) % 3;
            clip[from][row] = 1 / half[from];
            clip[3][row] = -center[from] / half[from];
        }
        clip[3][3] = 1;
        program_.set("u_clipFromWorld", glm::mat4(clip));
        framebuffer_.bind();
        gl::DrawState state;
        state.depthTest = state.depthWrite = true;
        state.apply();
        draw();
        return color_.readFloats();
    }

  private:
    gl::Texture color_ = gl::Texture::create2D(GL_RGBA32F, 64, 64);
    gl::Texture depth_ = gl::Texture::create2D(GL_DEPTH_COMPONENT32F, 64, 64);
    gl::Framebuffer framebuffer_;
    gl::Program program_;
};

/// Turns node `node` by `degrees` about z in one second, from time 0 on.
void animateRotation(Scene& scene, int node, double degrees) {
    scene.nodes[static_cast<std::size_t>(node)].hasMatrix = false;
    const auto half = static_cast<float>(glm::radians(degrees) / 2);
    AnimationChannel channel;
    channel.node = node;
    channel.property = AnimatedProperty::rotation;
    channel.times = {0, 1};
    channel.values = {glm::vec4(0, 0, 0, 1), glm::vec4(0, 0, std::sin(half), std::cos(half))};
    scene.animations.push_back({"", {channel}});
}

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

/// Spheres, an open sheet and a mirrored box, small and large, around `center`.
Scene mixedScene(const glm::dvec3& center) {
    const auto at = [&](const glm::dvec3& p) { return test::translation(center + p); };
    test::SceneBuilder builder;
    builder.add(test::sphere(1, 4), test::lambert(0.5f), at({-1, 0.5, 0}))
        .add(test::sphere(0.25, 3), test::lambert(0.5f), at({1, 1, 1}) * test::rotation(33, {1, 2, 3}))
        .add(test::quad(6, 6, 24), test::lambert(0.5f), at({0, -1, 0}) * test::rotation(7, {1, 0, 0}))
        .add(test::merged(test::box(glm::dvec3(0.5)), test::room({2, 1, 2})), test::lambert(0.2f),
             at({1.5, 0, -1}) * test::scaling({-1, 2, 1}));
    return builder.build();
}

TEST_F(GlTest, ABoxAroundTheSceneDrawsAllOfIt) {
    BoxPicture picture;
    for (const glm::dvec3& center : {glm::dvec3(0), glm::dvec3(1e6, -2e6, 5e5)}) {
        const Scene scene = mixedScene(center);
        GpuScene gpu(scene);
        gpu.setOrigin(center);
        const Bounds box = gpu.bounds();
        std::uint64_t drawn = 0;
        for (const bool reversed : {false, true}) {
            if (reversed) gpu.reverseDrawOrder();
            for (int axis = 0; axis < 3; ++axis) {
                const auto all = picture.of(gpu, box, axis, [&] { gpu.draw(picture.program()); });
                const auto inside = picture.of(gpu, box, axis, [&] { drawn = gpu.drawInside(picture.program(), box); });
                EXPECT_EQ(all, inside);
                EXPECT_EQ(drawn, gpu.triangleCount());
            }
        }
    }
}

TEST_F(GlTest, WhatABoxShowsIsDrawnWithFewerTriangles) {
    BoxPicture picture;
    std::mt19937 random(5);
    std::uniform_real_distribution<double> uniform(-1, 1);
    for (const glm::dvec3& center : {glm::dvec3(0), glm::dvec3(1e6, -2e6, 5e5)}) {
        const Scene scene = mixedScene(center);
        GpuScene gpu(scene);
        gpu.setOrigin(center);
        std::uint64_t drawnOverall = 0;
        const int boxes = 20;
        for (int i = 0; i < boxes; ++i) {
            const glm::dvec3 middle = center + glm::dvec3(2 * uniform(random), uniform(random), 2 * uniform(random));
            const glm::dvec3 half =
                glm::dvec3(0.3) + 0.2 * glm::dvec3(uniform(random), uniform(random), uniform(random));
            const Bounds box = boxOf(middle - half, middle + half);
            std::uint64_t drawn = 0;
            for (int axis = 0; axis < 3; ++axis) {
                const auto all = picture.of(gpu, box, axis, [&] { gpu.draw(picture.program()); });
                EXPECT_EQ(all, picture.of(gpu, box, axis, [&] { drawn = gpu.drawInside(picture.program(), box); }));
            }
            drawnOverall += drawn;

            std::uint64_t touching = 0;
            for (const Instance& instance : scene.instances) {
                const Mesh& mesh = scene.meshes[static_cast<std::size_t>(instance.mesh)];
                const glm::dmat4& matrix = gpu.worldMatrices()[static_cast<std::size_t>(instance.node)];
                for (std::size_t k = 0; k < mesh.indices.size(); k += 3) {
                    Bounds triangle;
                    for (std::size_t c = 0; c < 3; ++c)
                        triangle.add(glm::dvec3(matrix * glm::dvec4(mesh.positions[mesh.indices[k + c]], 1)));
                    touching += glm::all(glm::lessThanEqual(triangle.min, box.max)) &&
                                glm::all(glm::lessThanEqual(box.min, triangle.max));
                }
            }
            EXPECT_GE(drawn, touching);
        }
        EXPECT_LT(drawnOverall, boxes * gpu.triangleCount() / 4);
    }
}

TEST_F(GlTest, ABoxDrawsOnlyTheObjectsNearIt) {
    Scene scene;
    scene.meshes = {test::box(glm::dvec3(1))};
    scene.materials = {test::lambert(0.5f)};
    for (int i = 0; i < 27; ++i) {
        Node node;
        node.translation = 3.0 * glm::dvec3(i % 3, i / 3 % 3, i / 9);
        scene.nodes.push_back(node);
        scene.instances.push_back({0, i});
    }
    const GpuScene gpu(scene);
    BoxPicture picture;
    const auto drawn = [&](const Bounds& box) {
        std::uint64_t count = 0;
        picture.of(gpu, box, 0, [&] { count = gpu.drawInside(picture.program(), box); });
        return count;
    };
    EXPECT_EQ(drawn(boxOf(glm::dvec3(2), glm::dvec3(4))), 12u);
    EXPECT_EQ(drawn(boxOf(glm::dvec3(0.5, 0, 0), glm::dvec3(1))), 12u);  // in touch
    EXPECT_EQ(drawn(boxOf(glm::dvec3(0), {6, 1, 1})), 36u);
    EXPECT_EQ(drawn(boxOf(glm::dvec3(1), glm::dvec3(2))), 0u);
    EXPECT_EQ(drawn(boxOf(glm::dvec3(-1), glm::dvec3(7))), 27 * 12u);
    EXPECT_EQ(gpu.drawInside(picture.program(), Bounds()), 0u);
    EXPECT_EQ(gpu.drawInside(picture.program(), gpu.bounds(), [](const Batch& batch) { return !batch.closed; }), 0u);
}

TEST_F(GlTest, MovingObjectsHaveBatchesOfTheirOwn) {
    Scene scene;
    scene.meshes = {test::box(glm::dvec3(1))};
    scene.materials = {test::lambert(0.5f)};
    scene.nodes.resize(4);
    scene.nodes[2].parent = 1;
    for (int i = 0; i < 4; ++i) scene.instances.push_back({0, i});
    EXPECT_FALSE(GpuScene(scene).anyMoving());
    animateRotation(scene, 1, 90);
    const GpuScene gpu(scene);
    EXPECT_TRUE(gpu.anyMoving());
    ASSERT_EQ(gpu.batches().size(), 2u);
    for (const Batch& batch : gpu.batches()) {
        EXPECT_EQ(batch.objectCount, 2u);
        for (std::uint32_t k = 0; k < batch.objectCount; ++k) {
            const int node = gpu.objectInstance(batch.firstObject + k).node;
            EXPECT_EQ(batch.moving, node == 1 || node == 2);
        }
    }
}

TEST_F(GlTest, MovedBoxesAreThoseLeftAndEntered) {
    Scene scene = test::SceneBuilder()
                      .add(test::box({2, 1, 1}), test::lambert(0.5f))
                      .add(test::box(glm::dvec3(1)), test::lambert(0.5f))
                      .build();
    animateRotation(scene, 0, 90);
    GpuScene gpu(scene);
    EXPECT_TRUE(gpu.takeMoved().moving.empty());
    gpu.setTime(0);
    EXPECT_TRUE(gpu.takeMoved().moving.empty());
    gpu.setTime(0.5);
    gpu.setTime(1);
    const std::vector<Bounds> moved = gpu.takeMoved().moving;
    ASSERT_EQ(moved.size(), 2u);
    for (int axis = 0; axis < 3; ++axis) {
        EXPECT_NEAR(moved[0].max[axis], glm::dvec3(1, 0.5, 0.5)[axis], 1e-6);
        EXPECT_NEAR(moved[1].max[axis], glm::dvec3(0.5, 1, 0.5)[axis], 1e-6);
        EXPECT_NEAR(moved[1].min[axis], -moved[1].max[axis], 1e-6);
    }
    gpu.setTime(2);  // the animation has ended
    EXPECT_TRUE(gpu.takeMoved().moving.empty());
}

TEST_F(GlTest, WhatWasPutElsewhereIsToldApartFromWhatMoves) {
    Scene scene = test::SceneBuilder()
                      .add(test::box(glm::dvec3(1)), test::lambert(0.5f))
                      .add(test::box(glm::dvec3(1)), test::lambert(0.5f))
                      .build();
    animateRotation(scene, 0, 90);
    GpuScene gpu(scene);
    scene.nodes[1].hasMatrix = false;
    scene.nodes[1].translation = {3, 0, 0};
    EXPECT_TRUE(gpu.takeMoved().fixed.empty());
    gpu.setTime(1);
    const GpuScene::Moved moved = gpu.takeMoved();
    EXPECT_EQ(moved.moving.size(), 2u);
    ASSERT_EQ(moved.fixed.size(), 2u);
    EXPECT_NEAR(moved.fixed[0].max.x, 0.5, 1e-6);
    EXPECT_NEAR(moved.fixed[1].max.x, 3.5, 1e-6);
    EXPECT_NEAR(gpu.bounds().max.x, 3.5, 1e-6);
}

TEST_F(GlTest, DeformedInstancesAreDrawnWhereTheirJointsAre) {
    // Two fields of one mesh, the second hung on a joint that moves sideways, and a floor that does not move.
    Scene scene = test::SceneBuilder()
                      .add(test::quad(1, 1, 16), test::lambert(0.5f))
                      .add(test::quad(1, 1), test::lambert(0.5f), test::translation({0, -3, 0}))
                      .build();
    Mesh& mesh = scene.meshes[0];
    mesh.joints.assign(mesh.positions.size(), {0, 0, 0, 0});
    mesh.jointWeights.assign(mesh.positions.size(), glm::vec4(1, 0, 0, 0));
    // The skin's first joint carries nothing and stays, so that vertices move and not the instance's space.
    for (auto& joints : mesh.joints) joints[0] = 1;
    scene.nodes.resize(4);
    scene.skins.push_back({"", {2, 3}, {glm::dmat4(1), glm::dmat4(1)}});
    scene.instances.push_back({0, 0, 0});
    AnimationChannel channel;
    channel.node = 3;
    channel.times = {0, 1, 2};
    channel.values = {glm::vec4(0), glm::vec4(10, 0, 0, 0), glm::vec4(10, 0, 0, 0)};
    scene.animations.push_back({"", {channel}});

    GpuScene gpu(scene);
    BoxPicture picture;
    const Bounds left = boxOf(glm::dvec3(-1), glm::dvec3(1)), right = boxOf({9, -1, -1}, {11, 1, 1});
    const auto drawn = [&](const Bounds& box) {
        std::uint64_t count = 0;
        const auto all = picture.of(gpu, box, 1, [&] { gpu.draw(picture.program()); });
        EXPECT_EQ(all, picture.of(gpu, box, 1, [&] { count = gpu.drawInside(picture.program(), box); }));
        EXPECT_EQ(count > 0, std::any_of(all.begin(), all.end(), [](float texel) { return texel != -1; }));
        return count;
    };
    const std::uint64_t quadTriangles = 2 * 16 * 16;
    EXPECT_EQ(gpu.triangleCount(), 2 * quadTriangles + 2);
    EXPECT_EQ(drawn(left), 2 * quadTriangles);
    EXPECT_EQ(drawn(right), 0u);
    EXPECT_EQ(std::count_if(gpu.batches().begin(), gpu.batches().end(), [](const Batch& b) { return b.moving; }), 1);

    gpu.setTime(1);
    EXPECT_EQ(drawn(left), quadTriangles);
    EXPECT_EQ(drawn(right), quadTriangles);
    EXPECT_NEAR(gpu.bounds().max.x, 10.5, 1e-6);
    const std::vector<Bounds> moved = gpu.takeMoved().moving;
    ASSERT_EQ(moved.size(), 2u);
    EXPECT_NEAR(moved[0].max.x, 0.5, 1e-6);
    EXPECT_NEAR(moved[1].min.x, 9.5, 1e-6);
    gpu.reverseDrawOrder();
    EXPECT_EQ(drawn(right), quadTriangles);
    gpu.setTime(2);
    EXPECT_TRUE(gpu.takeMoved().moving.empty());
}

}  // namespace
}  // namespace voxcone
