// Skins, morph targets, lights and bounds over time, against closed forms.
#include <gmock/gmock.h>

#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <numbers>

#include "core/error.h"
#include "scene/deform.h"
#include "scene/gltf.h"
#include "unit/gltf_builder.h"
#include "unit/near.h"

namespace voxcone {
namespace {

using nlohmann::json;
using test::expectNear;
using test::GltfBuilder;
using testing::Each;
using testing::ElementsAre;
using testing::HasSubstr;

constexpr double kPi = std::numbers::pi;

class MotionTest : public testing::Test {
  protected:
    Scene load() { return loadGltf(builder.write(folder)); }
    void refused(const std::string& place, const std::string& reason) {
        const std::filesystem::path file = builder.write(folder);
        try {
            loadGltf(file);
            ADD_FAILURE() << "loaded, though " << place << " " << reason;
        } catch (const InputError& error) {
            EXPECT_THAT(error.what(), HasSubstr(file.string() + ": " + place + ": "));
            EXPECT_THAT(error.what(), HasSubstr(reason));
        }
    }

    json& primitive() { return builder.json["meshes"][0]["primitives"][0]; }
    json& attributes() { return primitive()["attributes"]; }
    int floats(const std::vector<float>& values, const char* type, std::size_t count) {
        return builder.accessor(values, type, test::kFloat, count);
    }
    void animate(int node, const char* path, const std::vector<float>& times, const std::vector<float>& values,
                 const char* type, std::size_t count, const char* interpolation = "LINEAR") {
        builder.append("animations",
                       {{"samplers", json::array({{{"input", floats(times, "SCALAR", times.size())},
                                                   {"output", floats(values, type, count)},
                                                   {"interpolation", interpolation}}})},
                        {"channels", json::array({{{"sampler", 0}, {"target", {{"node", node}, {"path", path}}}}})}});
    }

    /// An arm along x from 0 to 2, its elbow at (1, 0, 0), whose lower half turns by 90° about z from second 0 to 1.
    /// Node 0 shows the mesh and is far away; node 1 is the shoulder with `root`, node 2 its child, the elbow.
    void arm(const json& root = json::object()) {
        const std::vector<float> positions = {0, 0, 0, 1, 0, 0, 1, 0.5, 0, 2, 0, 0};
        const std::vector<float> normals = {0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0};
        const std::vector<std::uint8_t> joints = {0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 1, 0, 0, 0};
        const std::vector<float> weights = {1, 0, 0, 0, 1, 0, 0, 0, 2, 2, 0, 0, 1, 0, 0, 0};
        builder.show({{"attributes",
                       {{"POSITION", builder.positions(positions)},
                        {"NORMAL", floats(normals, "VEC3", 4)},
                        {"JOINTS_0", builder.accessor(joints, "VEC4", test::kUByte, 4)},
                        {"WEIGHTS_0", floats(weights, "VEC4", 4)}}},
                      {"indices", builder.indices({0, 1, 2, 1, 3, 2})}},
                     {{"skin", 0}, {"translation", {100, 200, 300}}});
        json shoulder = root;
        shoulder["children"] = {2};
        builder.append("nodes", shoulder);
        builder.append("nodes", {{"translation", {1, 0, 0}}});
        std::vector<float> inverseBind(32, 0);
        for (std::size_t k = 0; k < 4; ++k) inverseBind[5 * k] = inverseBind[16 + 5 * k] = 1;
        inverseBind[16 + 12] = -1;
        builder.append("skins", {{"joints", {1, 2}}, {"inverseBindMatrices", floats(inverseBind, "MAT4", 2)}});
        const auto half = static_cast<float>(std::sqrt(0.5));
        animate(2, "rotation", {0, 1}, {0, 0, 0, 1, 0, 0, half, half}, "VEC4", 2);
    }
    /// A triangle in z = 0 with one morph target for each of `targets`.
    void morphed(const std::vector<json>& targets) {
        builder.show(
            {{"attributes", {{"POSITION", builder.positions({0, 0, 0, 1, 0, 0, 0, 1, 0})}}}, {"targets", targets}});
    }

    test::TemporaryFolder folder{"voxcone_motion_test"};
    GltfBuilder builder;
};

struct WorldVertices {
    std::vector<glm::dvec3> positions;
    std::vector<glm::vec3> normals;
};
WorldVertices worldVertices(const Scene& scene, double time) {
    const Pose pose = scene.pose(time);
    const DeformedVertices deformed = deform(scene.meshes[0], pose.deformations[0]);
    WorldVertices result;
    for (const glm::vec3& p : deformed.positions)
        result.positions.emplace_back(pose.instances[0] * glm::dvec4(glm::dvec3(p), 1));
    const glm::dmat3 normalMatrix = glm::transpose(glm::inverse(glm::dmat3(pose.instances[0])));
    for (const glm::vec3& n : deformed.normals)
        result.normals.emplace_back(glm::normalize(normalMatrix * glm::dvec3(n)));
    return result;
}

// ---- skins

TEST_F(MotionTest, ASkinnedArmBendsAtItsElbow) {
    arm();
    const Scene scene = load();
    EXPECT_THAT(scene.movingInstances(), ElementsAre(1));
    expectNear(worldVertices(scene, 0).positions[3], {2, 0, 0});
    const WorldVertices bent = worldVertices(scene, 1);
    expectNear(bent.positions[0], {0, 0, 0});
    expectNear(bent.positions[1], {1, 0, 0});
    expectNear(bent.positions[3], {1, 1, 0});
    // Half way between (1, 0.5), where the upper half has it, and (0.5, 0), where the lower half has it.
    expectNear(bent.positions[2], {0.75, 0.25, 0});
    expectNear(bent.normals[0], {0, 1, 0});
    expectNear(bent.normals[1], {-1, 0, 0});
    expectNear(bent.normals[3], {-1, 0, 0});
    expectNear(bent.normals[2], {-std::sqrt(0.5), std::sqrt(0.5), 0});
    const Bounds bounds = scene.bounds(1);
    expectNear(bounds.min, {0, 0, 0});
    expectNear(bounds.max, {1, 1, 0});
    expectNear(scene.motionBounds().min, {0, 0, 0});
    expectNear(scene.motionBounds().max, {2, 1, 0});
}

TEST_F(MotionTest, AnArmFollowsItsSkeletonAndNotItsNode) {
    arm({{"translation", {1e6, 0, -2e6}}, {"scale", {-2, 2, 2}}});
    const Scene scene = load();
    const WorldVertices bent = worldVertices(scene, 1);
    expectNear(bent.positions[0], {1e6, 0, -2e6});
    expectNear(bent.positions[3], {1e6 - 2, 2, -2e6});
    expectNear(bent.normals[3], {1, 0, 0});
    // Front faces wind the other way, which the instance's matrix has to say.
    EXPECT_LT(glm::determinant(glm::dmat3(scene.pose(1).instances[0])), 0);
}

TEST_F(MotionTest, WithoutInverseBindMatricesTheyAreTheIdentity) {
    arm();
    builder.json["skins"][0].erase("inverseBindMatrices");
    expectNear(worldVertices(load(), 0).positions[3], {3, 0, 0});
}

TEST_F(MotionTest, ASecondSetOfJointsIsIgnored) {
    arm();
    attributes()["JOINTS_1"] = attributes()["JOINTS_0"];
    attributes()["WEIGHTS_1"] = attributes()["WEIGHTS_0"];
    expectNear(worldVertices(load(), 1).positions[3], {1, 1, 0});
}

TEST_F(MotionTest, ASkeletonThatNothingDrivesDoesNotMove) {
    arm();
    builder.json.erase("animations");
    const Scene scene = load();
    EXPECT_THAT(scene.movingInstances(), ElementsAre(0));
    EXPECT_EQ(scene.motionBounds().max, scene.bounds().max);
}

TEST_F(MotionTest, MalformedSkinsAreRefused) {
    const auto damaged = [&](const std::function<void()>& damage, const std::string& place, const std::string& reason) {
        builder = GltfBuilder();
        arm();
        damage();
        refused(place, reason);
    };
    const std::string attributesPath = "meshes[0].primitives[0].attributes";
    json& document = builder.json;
    damaged([&] { document["skins"][0]["joints"] = {1}; }, attributesPath + ".JOINTS_0",
            "element 1 names joint 1, but skins[0] has 1");
    damaged([&] { document["skins"][0]["joints"] = json::array(); }, "skins[0].joints", "is empty");
    damaged([&] { document["skins"][0]["joints"] = {1, 9}; }, "skins[0].joints[1]", "is 9");
    damaged([&] { document["skins"][0]["joints"] = {1, 1}; }, "skins[0].joints[1]", "stands twice");
    damaged([&] { document["skins"][0]["skeleton"] = 7; }, "skins[0].skeleton", "is 7");
    damaged([&] { document["nodes"][0]["skin"] = 1; }, "nodes[0].skin", "is 1");
    damaged(
        [&] {
            document["scenes"] = {{{"nodes", {0}}}};
        },
        "skins[0].joints[0]", "nodes[1] is not in the scene that is shown");
    damaged([&] { attributes().erase("WEIGHTS_0"); }, attributesPath + ".JOINTS_0", "stands without WEIGHTS_0");
    damaged([&] { attributes().erase("JOINTS_0"); }, attributesPath + ".WEIGHTS_0", "stands without JOINTS_0");
    damaged([&] { attributes()["JOINTS_0"] = attributes()["WEIGHTS_0"]; }, attributesPath + ".JOINTS_0",
            "not allowed here");
    damaged([&] { attributes()["WEIGHTS_0"] = attributes()["NORMAL"]; }, attributesPath + ".WEIGHTS_0",
            "not allowed here");
    damaged(
        [&] {
            attributes()["WEIGHTS_0"] = floats({1, 0, 0, 0}, "VEC4", 1);
        },
        attributesPath + ".WEIGHTS_0", "has 1 elements, but POSITION has 4");
    for (const float bad : {-1.f, NAN, INFINITY}) {
        std::vector<float> weights(16, 0.25f);
        weights[9] = bad;
        damaged([&] { attributes()["WEIGHTS_0"] = floats(weights, "VEC4", 4); }, attributesPath + ".WEIGHTS_0",
                "element 2 is negative, NaN or infinite");
    }
    damaged([&] { document["skins"][0]["inverseBindMatrices"] = floats(std::vector<float>(16, 0), "MAT4", 1); },
            "skins[0].inverseBindMatrices", "has 1 matrices for 2 joints");
    damaged([&] { document["skins"][0]["inverseBindMatrices"] = attributes()["POSITION"]; },
            "skins[0].inverseBindMatrices", "not float MAT4");
    damaged([&] { document["skins"][0]["inverseBindMatrices"] = floats(std::vector<float>(32, NAN), "MAT4", 2); },
            "skins[0].inverseBindMatrices", "matrix 0 is not finite");
}

// ---- morph targets

TEST_F(MotionTest, MorphTargetsAddWhatTheirWeightsSay) {
    morphed({{{"POSITION", floats({0, 0, 1, 0, 0, 1, 0, 0, 1}, "VEC3", 3)}},
             {{"POSITION", floats({0, 0, 0, 0, 0, 2, 0, 0, 0}, "VEC3", 3)}}});
    builder.json["meshes"][0]["weights"] = {0.25, 0.0};
    builder.json["nodes"][0]["translation"] = {0, 0, 10};
    // Two numbers a key.
    animate(0, "weights", {1, 3}, {0, 0, 1, 1}, "SCALAR", 4);
    const Scene scene = load();
    EXPECT_THAT(scene.movingInstances(), ElementsAre(1));
    const auto vertices = worldVertices(scene, 2);
    expectNear(vertices.positions[0], {0, 0, 10.5});
    expectNear(vertices.positions[1], {1, 0, 11.5});
    expectNear(vertices.positions[2], {0, 1, 10.5});
    // The file has no normals, so they are those of the tilted face.
    for (const glm::vec3& normal : vertices.normals) expectNear(normal, {-std::sqrt(0.5), 0, std::sqrt(0.5)});
}

TEST_F(MotionTest, NodesWeightsGoBeforeThoseOfTheMesh) {
    morphed({{{"POSITION", floats({0, 0, 1, 0, 0, 1, 0, 0, 1}, "VEC3", 3)}}});
    builder.json["meshes"][0]["weights"] = {0.25};
    EXPECT_EQ(load().bounds().min.z, 0.25);
    builder.json["nodes"][0]["weights"] = {-0.5};
    const Scene scene = load();
    EXPECT_EQ(scene.bounds().min.z, -0.5);
    EXPECT_THAT(scene.movingInstances(), ElementsAre(0));
}

TEST_F(MotionTest, ATargetOfNothingChangesNothing) {
    morphed({json::object()});
    builder.json["meshes"][0]["weights"] = {1};
    expectNear(worldVertices(load(), 0).positions[1], {1, 0, 0});
}

TEST_F(MotionTest, MorphedNormalsKeepUnitLength) {
    morphed({{{"NORMAL", floats({1, 0, 0, 1, 0, 0, 1, 0, 0}, "VEC3", 3)}}});
    attributes()["NORMAL"] = floats({0, 0, 1, 0, 0, 1, 0, 0, 1}, "VEC3", 3);
    builder.json["meshes"][0]["weights"] = {1};
    for (const glm::vec3& normal : worldVertices(load(), 0).normals)
        expectNear(normal, {std::sqrt(0.5), 0, std::sqrt(0.5)});
}

TEST_F(MotionTest, WeightsOnSplinesAreExactForCubics) {
    morphed({{{"POSITION", floats({0, 0, 1, 0, 0, 1, 0, 0, 1}, "VEC3", 3)}},
             {{"POSITION", floats({1, 0, 0, 1, 0, 0, 1, 0, 0}, "VEC3", 3)}}});
    // t³ and 5 − t on [0, 2].
    animate(0, "weights", {0, 2}, {0, 0, 0, 5, 0, -1, 12, -1, 8, 3, 0, 0}, "SCALAR", 12, "CUBICSPLINE");
    const Scene scene = load();
    for (const double t : {0.0, 0.3, 1.0, 1.7, 2.0})
        expectNear(worldVertices(scene, t).positions[0], {5 - t, 0, t * t * t}, 1e-5);
}

TEST_F(MotionTest, MalformedMorphTargetsAreRefused) {
    const std::string primitivePath = "meshes[0].primitives[0]";
    const auto damaged = [&](const std::function<void()>& damage, const std::string& place, const std::string& reason) {
        builder = GltfBuilder();
        morphed({{{"POSITION", floats({0, 0, 1, 0, 0, 1, 0, 0, 1}, "VEC3", 3)}}});
        animate(0, "weights", {1, 3}, {0, 1}, "SCALAR", 2);
        damage();
        refused(place, reason);
    };
    json& document = builder.json;
    damaged(
        [&] {
            primitive()["targets"][0]["POSITION"] = floats({1, 2, 3}, "VEC3", 1);
        },
        primitivePath + ".targets[0].POSITION", "has 1 elements, but POSITION has 3");
    damaged(
        [&] {
            primitive()["targets"][0]["NORMAL"] = floats({1, 2, 3}, "SCALAR", 3);
        },
        primitivePath + ".targets[0].NORMAL", "not allowed here");
    damaged([&] { primitive()["targets"][0]["TANGENT"] = 99; }, primitivePath + ".targets[0].TANGENT", "is 99");
    damaged(
        [&] {
            primitive()["targets"][0]["POSITION"] = floats({0, 0, 0, 0, NAN, 0, 0, 0, 0}, "VEC3", 3);
        },
        primitivePath + ".targets[0].POSITION", "element 1 is NaN or infinite");
    damaged([&] { primitive()["targets"] = {1}; }, primitivePath + ".targets[0]", "is not an object");
    damaged(
        [&] {
            json other = primitive();
            other.erase("targets");
            document["meshes"][0]["primitives"].push_back(other);
        },
        "meshes[0].primitives[1].targets", "are 0 morph targets, but primitives[0] has 1");
    damaged([&] { document["meshes"][0]["weights"] = {1, 2}; }, "meshes[0].weights", "are 2 numbers for 1 morph");
    damaged([&] { document["nodes"][0]["weights"] = {1, 2}; }, "nodes[0].weights", "are 2 numbers for 1 morph");
    damaged([&] { document["nodes"][0]["weights"] = {"x"}; }, "nodes[0].weights[0]", "is not a number");
    damaged(
        [&] {
            document["animations"][0]["samplers"][0]["output"] = floats({0, 1, 2}, "SCALAR", 3);
        },
        "animations[0].channels[0].sampler", "has 3 values, 2 keys need 2");
    damaged([&] { primitive().erase("targets"); }, "animations[0].channels[0].target.node", "no morph targets");
}

TEST_F(MotionTest, TargetsOfOneAccessorDoNotGrowOutOfProportion) {
    morphed({{{"POSITION", floats({0, 0, 1, 0, 0, 1, 0, 0, 1}, "VEC3", 3)}}});
    const int many =
        builder.append("accessors", {{"componentType", test::kFloat}, {"count", 5000000}, {"type", "VEC3"}});
    attributes() = {{"POSITION", many}};
    primitive()["targets"] = json::array();
    for (int k = 0; k < 100; ++k) primitive()["targets"].push_back({{"POSITION", many}});
    refused("meshes[0].primitives[0].targets[2].POSITION", "too many");
}

// ---- bounds

Scene spinningBar(double length, double width) {
    Scene scene;
    Mesh mesh;
    const auto x = static_cast<float>(length / 2), y = static_cast<float>(width / 2);
    mesh.positions = {{-x, -y, 0}, {x, -y, 0}, {x, y, 0}, {-x, y, 0}};
    mesh.indices = {0, 1, 2, 0, 2, 3};
    scene.meshes = {mesh};
    scene.materials.emplace_back();
    scene.nodes.emplace_back();
    scene.instances.push_back({0, 0});
    AnimationChannel channel;
    channel.property = AnimatedProperty::rotation;
    for (int k = 0; k <= 4; ++k) {
        channel.times.push_back(k);
        channel.values.emplace_back(0, 0, std::sin(k * kPi / 4), std::cos(k * kPi / 4));
    }
    scene.animations.push_back({"", {channel}});
    return scene;
}

TEST(MotionBounds, OfASpinningBarAreThoseOfItsCircle) {
    const Bounds bounds = spinningBar(6, 0.8).motionBounds();
    const double radius = 0.5 * std::hypot(6, 0.8);
    for (int axis = 0; axis < 2; ++axis) {
        // A corner passes its farthest point within half a step of 90°/16, where it is lower by the versed sine.
        const double lowest = radius * std::cos(kPi / 64);
        EXPECT_LE(bounds.max[axis], radius + 1e-6);
        EXPECT_GE(bounds.max[axis], lowest);
        EXPECT_GE(bounds.min[axis], -radius - 1e-6);
        EXPECT_LE(bounds.min[axis], -lowest);
    }
}

TEST(MotionBounds, AreTheBoundsWhereNothingMoves) {
    Scene scene = spinningBar(6, 0.8);
    scene.animations.clear();
    EXPECT_EQ(scene.motionBounds().min, scene.bounds().min);
    EXPECT_EQ(scene.motionBounds().max, scene.bounds().max);
    EXPECT_TRUE(Scene().motionBounds().empty());
}

TEST(MotionBounds, HoldEveryKeyOfALongAnimation) {
    Scene scene = spinningBar(1, 1);
    AnimationChannel& channel = scene.animations[0].channels[0];
    channel.property = AnimatedProperty::translation;
    channel.times.clear();
    channel.values.clear();
    for (int k = 0; k < 3000; ++k) {
        channel.times.push_back(0.01 * k);
        channel.values.emplace_back(k == 1234 ? 9 : 0, 0, 0, 0);
    }
    EXPECT_DOUBLE_EQ(scene.motionBounds().max.x, 9.5);
}

// ---- lights

TEST(Lights, TracksMoveThemInTheirNodesSpace) {
    Scene scene;
    scene.nodes.emplace_back();
    scene.nodes[0].translation = {0, 10, 0};
    Light light;
    light.node = 0;
    light.track.position = {Interpolation::linear, {0, 2}, {{0, 0, 0}, {4, 0, 0}}};
    light.track.intensity = {Interpolation::catmull_rom, {0, 1, 2}, {{1, 1, 1}, {0, 2, 4}, {0, 3, 7}}};
    scene.lights = {light, Light()};
    AnimationChannel channel;
    channel.times = {0, 2};
    channel.values = {glm::vec4(0), glm::vec4(0, 0, 8, 0)};
    scene.animations.push_back({"", {channel}});
    const std::vector<Light> lights = scene.lightsAt(1);
    ASSERT_EQ(lights.size(), 2u);
    expectNear(lights[0].position, {2, 0, 4});
    EXPECT_EQ(lights[0].intensity, glm::vec3(0, 2, 4));
    EXPECT_EQ(lights[0].node, -1);
    EXPECT_EQ(lights[1].position, glm::dvec3(0));
    // Splines overshoot; light does not become negative.
    EXPECT_EQ(lightAt(light, 1.5).intensity.x, 0);
}

TEST(Lights, TurningLightsKeepTheirUpAcross) {
    Light light;
    light.type = LightType::rectangle;
    light.track.direction = {Interpolation::linear, {0, 1, 2}, {{0, -3, 0}, {3, 0, 0}, {0, 3, 0}}};
    for (double time = 0; time <= 2; time += 0.125) {
        const Light at = lightAt(light, time);
        EXPECT_NEAR(glm::length(at.direction), 1, 1e-12);
        EXPECT_NEAR(glm::length(at.up), 1, 1e-12);
        EXPECT_NEAR(glm::dot(at.direction, at.up), 0, 1e-12);
    }
    // Turning about z leaves z alone.
    expectNear(lightAt(light, 1).up, {0, 0, 1});
    expectNear(lightAt(light, 1).direction, {1, 0, 0});
    expectNear(lightAt(light, 2).direction, {0, 1, 0});
}

}  // namespace
}  // namespace voxcone
