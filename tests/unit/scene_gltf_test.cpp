// What valid glTF means once loaded.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <numbers>

#include "scene/gltf.h"
#include "scene/tangents.h"
#include "scene/topology.h"
#include "unit/gltf_builder.h"
#include "unit/near.h"

namespace voxcone {
namespace {

using nlohmann::json;
using test::expectNear;
using test::GltfBuilder;
using testing::Each;
using testing::ElementsAre;

constexpr double kPi = std::numbers::pi;

void expectNear(const glm::vec4& a, const glm::vec4& b, float tolerance = 1e-6f) {
    EXPECT_LE(glm::length(a - b), tolerance) << "(" << a.x << " " << a.y << " " << a.z << " " << a.w << ")";
}

/// Unit quad in z = 0 facing +z, with the image upright on it (v downwards).
const std::vector<float> kQuad = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};
const std::vector<float> kQuadUv = {0, 1, 1, 1, 1, 0, 0, 0};
const std::vector<std::uint16_t> kQuadIndices = {0, 1, 2, 0, 2, 3};

class GltfTest : public testing::Test {
  protected:
    Scene load() { return loadGltf(builder.write(folder)); }
    test::TemporaryFolder folder{"voxcone_gltf_test"};
    GltfBuilder builder;
};

TEST_F(GltfTest, TriangleListGetsFlatNormalsFromItsFaces) {
    builder.show(
        {{"attributes", {{"POSITION", builder.positions(kQuad)}}}, {"indices", builder.indices(kQuadIndices)}});
    const Scene scene = load();
    ASSERT_EQ(scene.meshes.size(), 1u);
    EXPECT_EQ(scene.triangleCount(), 2u);
    EXPECT_EQ(scene.meshes[0].positions.size(), 6u) << "faces without NORMAL do not share vertices";
    EXPECT_THAT(scene.meshes[0].normals, Each(glm::vec3(0, 0, 1)));
    EXPECT_TRUE(scene.meshes[0].tangents.empty());
    ASSERT_EQ(scene.materials.size(), 1u) << "the default material";
    EXPECT_EQ(scene.meshes[0].material, 0);
}

TEST_F(GltfTest, AllIndexTypesGiveTheSameTriangles) {
    const int p = builder.positions(kQuad), n = builder.positions({0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1});
    const json attributes = {{"POSITION", p}, {"NORMAL", n}};
    const int bytes = builder.accessor(std::vector<std::uint8_t>{0, 1, 2, 0, 2, 3}, "SCALAR", test::kUByte, 6);
    const int words = builder.accessor(std::vector<std::uint32_t>{0, 1, 2, 0, 2, 3}, "SCALAR", test::kUInt, 6);
    for (const int indices : {bytes, builder.indices(kQuadIndices), words})
        builder.show({{"attributes", attributes}, {"indices", indices}});
    const Scene scene = load();
    ASSERT_EQ(scene.meshes.size(), 3u);
    for (const Mesh& mesh : scene.meshes) {
        EXPECT_THAT(mesh.indices, ElementsAre(0, 1, 2, 0, 2, 3));
        EXPECT_EQ(mesh.positions.size(), 4u);
    }
}

TEST_F(GltfTest, StripsAndFansKeepTheirFacing) {
    const int strip = builder.positions({0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 0, 2, 0});
    const int fan = builder.positions({0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, -1, 0, 0});
    builder.show({{"attributes", {{"POSITION", strip}}}, {"mode", 5}});
    builder.show({{"attributes", {{"POSITION", fan}}}, {"mode", 6}});
    builder.show({{"attributes", {{"POSITION", fan}}}, {"mode", 1}});  // lines make no triangles
    const Scene scene = load();
    ASSERT_EQ(scene.meshes.size(), 2u);
    for (const Mesh& mesh : scene.meshes) {
        EXPECT_EQ(mesh.indices.size(), 9u);
        EXPECT_THAT(mesh.normals, Each(glm::vec3(0, 0, 1)));
    }
}

TEST_F(GltfTest, InterleavedViewsAreReadWithTheirStride) {
    const int view = builder.view(std::vector<float>{0, 0, 0, 0, 0, 1, 1, 0, 0, 0, 0, 1, 0, 1, 0, 0, 0, 1});
    builder.json["bufferViews"][0]["byteStride"] = 24;
    const json common = {{"bufferView", view}, {"componentType", test::kFloat}, {"count", 3}, {"type", "VEC3"}};
    const int p = builder.append("accessors", common);
    json normals = common;
    normals["byteOffset"] = 12;
    const int n = builder.append("accessors", normals);
    builder.show({{"attributes", {{"POSITION", p}, {"NORMAL", n}}}});
    const Scene scene = load();
    EXPECT_THAT(scene.meshes.at(0).positions, ElementsAre(glm::vec3(0, 0, 0), glm::vec3(1, 0, 0), glm::vec3(0, 1, 0)));
    EXPECT_THAT(scene.meshes[0].normals, Each(glm::vec3(0, 0, 1)));
}

TEST_F(GltfTest, SparseAccessorsReplaceElements) {
    const json sparse = {
        {"count", 1},
        {"indices", {{"bufferView", builder.view(std::vector<std::uint16_t>{2})}, {"componentType", test::kUShort}}},
        {"values", {{"bufferView", builder.view(std::vector<float>{7, 8, 9})}}}};
    const int p =
        builder.accessor(std::vector<float>{0, 0, 0, 1, 0, 0, 0, 1, 0}, "VEC3", test::kFloat, 3, {{"sparse", sparse}});
    // Without a view of its own the rest is zero.
    const int zero = builder.append(
        "accessors", {{"componentType", test::kFloat}, {"count", 3}, {"type", "VEC3"}, {"sparse", sparse}});
    builder.show({{"attributes", {{"POSITION", p}}}});
    builder.show({{"attributes", {{"POSITION", zero}}}});
    const Scene scene = load();
    EXPECT_THAT(scene.meshes.at(0).positions, ElementsAre(glm::vec3(0), glm::vec3(1, 0, 0), glm::vec3(7, 8, 9)));
    EXPECT_THAT(scene.meshes.at(1).positions, ElementsAre(glm::vec3(0), glm::vec3(0), glm::vec3(7, 8, 9)));
}

TEST_F(GltfTest, VertexColoursOfAllTypesAreLinearFractions) {
    const int p = builder.positions({0, 0, 0, 1, 0, 0, 0, 1, 0});
    const json norm = {{"normalized", true}};
    // VEC3 of bytes is padded to four-byte steps by byteStride.
    const int rgb8 = builder.accessor(std::vector<std::uint8_t>{255, 51, 0, 0, 0, 0, 255, 0, 0, 0, 0, 0}, "VEC3",
                                      test::kUByte, 3, norm);
    builder.json["bufferViews"].back()["byteStride"] = 4;
    const int rgba16 = builder.accessor(std::vector<std::uint16_t>{65535, 13107, 0, 32768, 0, 0, 0, 0, 0, 0, 0, 0},
                                        "VEC4", test::kUShort, 3, norm);
    const int rgbaf =
        builder.accessor(std::vector<float>{1, 0.2f, 0, 0.5f, 2, -1, 0, 1, 0, 0, 0, 0}, "VEC4", test::kFloat, 3);
    for (const int c : {rgb8, rgba16, rgbaf}) builder.show({{"attributes", {{"POSITION", p}, {"COLOR_0", c}}}});
    const Scene scene = load();
    expectNear(scene.meshes.at(0).colors.at(0), glm::vec4(1, 0.2, 0, 1));
    expectNear(scene.meshes.at(1).colors.at(0), glm::vec4(1, 0.2, 0, 32768.0 / 65535));
    expectNear(scene.meshes.at(2).colors.at(0), glm::vec4(1, 0.2, 0, 0.5));
    expectNear(scene.meshes.at(2).colors.at(1), glm::vec4(1, 0, 0, 1));
}

TEST_F(GltfTest, TwoUvSetsOfAMaterialBecomeSlotsZeroAndOne) {
    const int red = builder.redTexture();
    const json transform = {{"KHR_texture_transform",
                             {{"offset", {0.25, 0.5}}, {"rotation", kPi / 2}, {"scale", {2, 3}}, {"texCoord", 2}}}};
    builder.append("materials", {{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", red}, {"texCoord", 1}}}}},
                                 {"emissiveTexture", {{"index", red}, {"texCoord", 0}, {"extensions", transform}}}});
    const int p = builder.positions({0, 0, 0, 1, 0, 0, 0, 1, 0});
    const int bytes = builder.accessor(std::vector<std::uint8_t>{255, 0, 0, 0, 0, 255, 0, 0, 51, 0, 0, 0}, "VEC2",
                                       test::kUByte, 3, {{"normalized", true}});
    builder.json["bufferViews"].back()["byteStride"] = 4;
    const int words = builder.accessor(std::vector<std::uint16_t>{65535, 0, 0, 65535, 13107, 0}, "VEC2", test::kUShort,
                                       3, {{"normalized", true}});
    builder.show({{"attributes", {{"POSITION", p}, {"TEXCOORD_1", bytes}, {"TEXCOORD_2", words}}}, {"material", 0}});
    const Scene scene = load();
    const Material& material = scene.materials.at(0);
    EXPECT_EQ(material.baseColorTexture.texCoord, 0);
    EXPECT_EQ(material.emissionTexture.texCoord, 1) << "the transform's texCoord overrides";
    EXPECT_EQ(material.baseColorTexture.texture, material.emissionTexture.texture);
    ASSERT_EQ(scene.textures.size(), 1u);
    EXPECT_THAT(scene.textures[0].rgba8, ElementsAre(255, 0, 0, 255));
    const Mesh& mesh = scene.meshes.at(0);
    for (const auto& set : mesh.texCoords) {
        ASSERT_EQ(set.size(), 3u);
        EXPECT_EQ(set[0], glm::vec2(1, 0));
        EXPECT_EQ(set[1], glm::vec2(0, 1));
        EXPECT_FLOAT_EQ(set[2].x, 0.2f);
    }
    // A quarter turn takes (u, v) = scaled (2, 0) to (0, −2): counter-clockwise with v downwards.
    const glm::vec2 moved = material.emissionTexture.uvTransform * glm::vec3(1, 0, 1);
    EXPECT_NEAR(moved.x, 0.25, 1e-6);
    EXPECT_NEAR(moved.y, 0.5 - 2, 1e-6);
}

TEST_F(GltfTest, ImageAlphaIsNotMultipliedIn) {
    const char* png =
        "data:image/"
        "png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR4nGM4kWLkAAAE9QGfhM72PAAAAABJRU5ErkJggg==";
    const int texture = builder.append("textures", {{"source", builder.append("images", {{"uri", png}})}});
    builder.append("materials", {{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", texture}}}}}});
    EXPECT_THAT(load().textures.at(0).rgba8, ElementsAre(200, 100, 50, 64));
}

TEST_F(GltfTest, MaterialsWithTheirExtensions) {
    builder.json["extensionsRequired"] = {"KHR_materials_unlit", "KHR_materials_specular", "KHR_lights_punctual"};
    builder.append(
        "materials",
        {{"name", "everything"},
         {"pbrMetallicRoughness",
          {{"baseColorFactor", {0.1, 0.2, 0.3, 0.4}}, {"metallicFactor", 0.5}, {"roughnessFactor", 0.6}}},
         {"emissiveFactor", {0.5, 1, 0}},
         {"alphaMode", "MASK"},
         {"alphaCutoff", 0.7},
         {"doubleSided", true},
         {"extensions",
          {{"KHR_materials_emissive_strength", {{"emissiveStrength", 10}}},
           {"KHR_materials_unlit", json::object()},
           {"KHR_materials_transmission", {{"transmissionFactor", 0.8}}},
           {"KHR_materials_volume",
            {{"thicknessFactor", 0.5}, {"attenuationDistance", 2}, {"attenuationColor", {1, 0.5, 0}}}},
           {"KHR_materials_diffuse_transmission",
            {{"diffuseTransmissionFactor", 0.3}, {"diffuseTransmissionColorFactor", {0.2, 0.4, 0.6}}}},
           {"KHR_materials_ior", {{"ior", 1.33}}},
           {"KHR_materials_specular", {{"specularFactor", 0.25}, {"specularColorFactor", {1, 0.5, 0.25}}}}}}});
    builder.append("materials", {{"alphaMode", "BLEND"}});
    const Scene scene = load();
    const Material& m = scene.materials.at(0);
    EXPECT_EQ(m.name, "everything");
    expectNear(m.baseColor, glm::vec4(0.1, 0.2, 0.3, 0.4));
    EXPECT_FLOAT_EQ(m.metallic, 0.5f);
    EXPECT_FLOAT_EQ(m.roughness, 0.6f);
    EXPECT_EQ(m.emission, glm::vec3(5, 10, 0));
    EXPECT_EQ(m.alphaMode, AlphaMode::mask);
    EXPECT_FLOAT_EQ(m.alphaCutoff, 0.7f);
    EXPECT_TRUE(m.doubleSided);
    EXPECT_TRUE(m.unlit);
    EXPECT_FLOAT_EQ(m.transmission, 0.8f);
    EXPECT_FLOAT_EQ(m.thickness, 0.5f);
    EXPECT_EQ(m.attenuationColor, glm::vec3(1, 0.5, 0));
    EXPECT_FLOAT_EQ(m.absorption().x, 0);
    EXPECT_FLOAT_EQ(m.absorption().y, std::log(2.0f) / 2) << "half is left after two metres";
    EXPECT_TRUE(std::isfinite(m.absorption().z));
    EXPECT_FLOAT_EQ(m.diffuseTransmission, 0.3f);
    expectNear(m.diffuseTransmissionColor, glm::vec3(0.2, 0.4, 0.6));
    EXPECT_FLOAT_EQ(m.ior, 1.33f);
    EXPECT_FLOAT_EQ(m.specularFactor, 0.25f);
    EXPECT_EQ(m.specularColor, glm::vec3(1, 0.5, 0.25));
    EXPECT_EQ(scene.materials.at(1).alphaMode, AlphaMode::blend);
    EXPECT_EQ(scene.materials[1].metallic, 1.0f);
    EXPECT_EQ(scene.materials[1].absorption(), glm::vec3(0));
    EXPECT_FALSE(scene.materials[1].transmits());
}

TEST_F(GltfTest, TransmissionHasItsTextures) {
    const json red = builder.redTexture();
    const json turned = {{"KHR_texture_transform", {{"offset", {0.25, 0.5}}}}};
    builder.append(
        "materials",
        {{"extensions",
          {{"KHR_materials_transmission",
            {{"transmissionFactor", 1}, {"transmissionTexture", {{"index", red}, {"extensions", turned}}}}},
           {"KHR_materials_volume", {{"thicknessFactor", 1}, {"thicknessTexture", {{"index", red}, {"texCoord", 1}}}}},
           {"KHR_materials_diffuse_transmission",
            {{"diffuseTransmissionTexture", {{"index", red}}},
             {"diffuseTransmissionColorTexture", {{"index", red}}}}}}}});
    const Material m = load().materials.at(0);
    EXPECT_EQ(m.transmissionTexture.texture, 0);
    EXPECT_EQ(m.transmissionTexture.uvTransform[2], glm::vec2(0.25, 0.5));
    EXPECT_EQ(m.transmissionTexture.texCoord, 0);
    EXPECT_EQ(m.thicknessTexture.texture, 0);
    EXPECT_EQ(m.thicknessTexture.texCoord, 1);
    EXPECT_EQ(m.diffuseTransmissionTexture.texture, 0);
    EXPECT_EQ(m.diffuseTransmissionColorTexture.texture, 0);
    EXPECT_EQ(m.metallic, 1) << "the default, which no light passes through";
    EXPECT_FALSE(m.transmits());
}

TEST_F(GltfTest, ExtrasSayWhatLeavesAre) {
    for (const auto& extras :
         {nlohmann::json{{"voxcone_matter", "leaves"}, {"other", 1}}, nlohmann::json{{"voxcone_matter", "solid"}},
          nlohmann::json{{"other", 1}}, nlohmann::json(7)})
        builder.append("materials", {{"extras", extras}});
    const Scene scene = load();
    EXPECT_EQ(scene.materials.at(0).matter, Matter::leaves);
    EXPECT_EQ(scene.materials.at(1).matter, Matter::solid);
    EXPECT_EQ(scene.materials.at(2).matter, Matter::automatic);
    EXPECT_EQ(scene.materials.at(3).matter, Matter::automatic);
}

TEST(Leaves, AreWhatLetsLightThroughByItsAlpha) {
    Scene scene;
    Texture texture;
    texture.width = 2, texture.height = 1;
    texture.rgba8 = {9, 9, 9, 255, 9, 9, 9, 100};
    scene.textures.push_back(texture);
    const auto leaves = [&](AlphaMode mode, float factor, float cutoff, bool textured,
                            Matter matter = Matter::automatic) {
        Material material;
        material.alphaMode = mode;
        material.baseColor.a = factor;
        material.alphaCutoff = cutoff;
        material.baseColorTexture.texture = textured ? 0 : -1;
        material.matter = matter;
        return scene.isLeaves(material);
    };
    EXPECT_FALSE(leaves(AlphaMode::opaque, 0.5f, 0.5f, true));
    EXPECT_TRUE(leaves(AlphaMode::mask, 1, 0.5f, true));
    EXPECT_FALSE(leaves(AlphaMode::mask, 1, 0.3f, true)) << "nothing is cut out";
    EXPECT_FALSE(leaves(AlphaMode::mask, 1, 0.5f, false));
    EXPECT_TRUE(leaves(AlphaMode::blend, 1, 0.5f, true));
    EXPECT_TRUE(leaves(AlphaMode::blend, 0.9f, 0.5f, false));
    EXPECT_FALSE(leaves(AlphaMode::blend, 1, 0.5f, false)) << "opaque everywhere";
    EXPECT_TRUE(leaves(AlphaMode::opaque, 1, 0.5f, false, Matter::leaves));
    EXPECT_FALSE(leaves(AlphaMode::mask, 1, 0.5f, true, Matter::solid));
}

TEST_F(GltfTest, HierarchiesWithMirrorsAreMultipliedInDouble) {
    const int child = builder.show(
        {{"attributes", {{"POSITION", builder.positions(kQuad)}}}, {"indices", builder.indices(kQuadIndices)}},
        {{"scale", {-2, 1, 1}}, {"translation", {1e6, 0, 0.125}}});
    const int parent =
        builder.append("nodes", {{"children", {child}}, {"matrix", {0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}}});
    builder.append("nodes", {{"mesh", 0}});  // outside the scene
    builder.json["scenes"] = json::array({{{"nodes", {parent}}}});
    const Scene scene = load();
    ASSERT_EQ(scene.nodes.size(), 2u);
    ASSERT_EQ(scene.instances.size(), 1u);
    EXPECT_LT(scene.nodes[1].parent, 1);
    const auto world = scene.worldMatrices();
    const glm::dmat4& m = world[static_cast<std::size_t>(scene.instances[0].node)];
    // The parent turns x into y: (1, 0, 0) → child (1e6 − 2, 0, 1/8) → (0, 1e6 − 2, 1/8), exact.
    EXPECT_EQ(glm::dvec3(m * glm::dvec4(1, 0, 0, 1)), glm::dvec3(0, 1e6 - 2, 0.125));
    EXPECT_LT(glm::determinant(m), 0);
    const Bounds bounds = scene.bounds();
    EXPECT_EQ(bounds.min, glm::dvec3(-1, 1e6 - 2, 0.125));
    EXPECT_EQ(bounds.max, glm::dvec3(0, 1e6, 0.125));
}

TEST_F(GltfTest, LightsAndCamerasFollowTheirNodes) {
    builder.json["extensions"]["KHR_lights_punctual"]["lights"] = {
        {{"type", "spot"},
         {"color", {1, 0.5, 0}},
         {"intensity", 8},
         {"range", 20},
         {"spot", {{"innerConeAngle", 0.1}, {"outerConeAngle", 0.2}}}},
        {{"type", "directional"}, {"intensity", 3}},
        {{"type", "point"}}};
    auto light = [](int i) { return json{{"KHR_lights_punctual", {{"light", i}}}}; };
    const double half = std::sqrt(0.5);
    // A quarter turn about −x: −z looks down.
    builder.append("nodes", {{"rotation", {-half, 0, 0, half}}, {"translation", {1, 2, 3}}, {"extensions", light(0)}});
    builder.append("nodes", {{"scale", {2, 2, 2}}, {"extensions", light(1)}});
    builder.append("nodes", {{"extensions", light(2)}});
    builder.append("cameras",
                   {{"type", "perspective"}, {"perspective", {{"yfov", kPi / 3}, {"znear", 0.1}, {"zfar", 50}}}});
    builder.append("nodes", {{"camera", 0}, {"rotation", {0, half, 0, half}}, {"translation", {0, 1, 5}}});
    const Scene scene = load();
    const auto world = scene.worldMatrices();
    ASSERT_EQ(scene.lights.size(), 3u);
    const Light spot = worldLight(scene.lights[0], world);
    EXPECT_EQ(spot.type, LightType::spot);
    EXPECT_EQ(spot.intensity, glm::vec3(8, 4, 0));
    expectNear(spot.position, {1, 2, 3});
    expectNear(spot.direction, {0, -1, 0});
    EXPECT_EQ(spot.range, 20);
    EXPECT_EQ(spot.innerConeAngle, 0.1);
    EXPECT_EQ(spot.outerConeAngle, 0.2);
    EXPECT_EQ(spot.node, -1);
    expectNear(worldLight(scene.lights[1], world).direction, {0, 0, -1});
    EXPECT_EQ(scene.lights[1].intensity, glm::vec3(3));
    EXPECT_EQ(scene.lights[2].intensity, glm::vec3(1));

    const Camera camera = worldCamera(scene.cameras.at(0), world);
    EXPECT_NEAR(camera.verticalFovDeg, 60, 1e-9);
    EXPECT_EQ(camera.near, 0.1);
    EXPECT_EQ(camera.far, 50);
    expectNear(camera.position, {0, 1, 5});
    expectNear(camera.target, {-1, 1, 5});  // a quarter turn about y takes −z to −x
    const glm::dvec4 seen = viewMatrix(camera) * glm::dvec4(-7, 1, 5, 1);
    expectNear(glm::dvec3(seen), {0, 0, -7});
}

TEST(Camera, LooksStraightUpAndDown) {
    for (const double y : {-1.0, 1.0}) {
        Camera camera;
        camera.position = {3, 4, 5};
        camera.target = camera.position + glm::dvec3(0, y, 0);
        expectNear(glm::dvec3(viewMatrix(camera) * glm::dvec4(3, 4 + 2 * y, 5, 1)), {0, 0, -2});
    }
}

TEST(Light, SizesScaleWithTheNodeAndIntensityDoesNot) {
    Light light;
    light.type = LightType::rectangle;
    light.node = 0;
    light.direction = {0, 0, -1};
    light.up = {0, 1, 0};
    light.width = 1;
    light.height = 2;
    light.radius = 0.5;
    const Light world = worldLight(light, {glm::scale(glm::dmat4(1), {3, 3, 3})});
    EXPECT_DOUBLE_EQ(world.width, 3);
    EXPECT_DOUBLE_EQ(world.height, 6);
    EXPECT_DOUBLE_EQ(world.radius, 1.5);
    EXPECT_EQ(world.intensity, light.intensity);
}

class AnimationTest : public GltfTest {
  protected:
    void animate(const char* path, const char* interpolation, const std::vector<float>& times,
                 const std::vector<float>& values, const char* type, std::size_t count) {
        builder.append("nodes", {{"translation", {9, 9, 9}}});
        const int input = builder.accessor(times, "SCALAR", test::kFloat, times.size());
        const int output = builder.accessor(values, type, test::kFloat, count);
        builder.append(
            "animations",
            {{"samplers", json::array({{{"input", input}, {"output", output}, {"interpolation", interpolation}}})},
             {"channels", json::array({{{"sampler", 0}, {"target", {{"node", 0}, {"path", path}}}}})}});
        scene = load();
    }
    glm::dmat4 at(double time) { return scene.worldMatrices(time).at(0); }
    glm::dvec3 placeAt(double time) { return glm::dvec3(at(time)[3]); }
    Scene scene;
};

TEST_F(AnimationTest, LinearIsClampedAtItsEnds) {
    animate("translation", "LINEAR", {1, 3}, {0, 0, 0, 2, 4, 6}, "VEC3", 2);
    expectNear(placeAt(0), {0, 0, 0});
    expectNear(placeAt(1.5), {0.5, 1, 1.5});
    expectNear(placeAt(3), {2, 4, 6});
    expectNear(placeAt(100), {2, 4, 6});
}

TEST_F(AnimationTest, StepHoldsUntilTheNextKey) {
    animate("scale", "STEP", {0, 1, 2}, {1, 1, 1, 2, 2, 2, 3, 3, 3}, "VEC3", 3);
    EXPECT_EQ(at(0.999)[0][0], 1);
    EXPECT_EQ(at(1)[0][0], 2);
    EXPECT_EQ(at(1.999)[0][0], 2);
    EXPECT_EQ(at(2)[0][0], 3);
}

TEST_F(AnimationTest, RotationsTakeTheShorterWay) {
    // 0° and 90° about y, the second with the sign flipped: the same rotation the long way round.
    const auto c = static_cast<float>(std::cos(kPi / 4)), s = static_cast<float>(std::sin(kPi / 4));
    animate("rotation", "LINEAR", {0, 1}, {0, 0, 0, 1, 0, -s, 0, -c}, "VEC4", 2);
    for (const double t : {0.25, 0.5, 1.0}) {
        const double angle = t * kPi / 2;
        expectNear(glm::dvec3(at(t) * glm::dvec4(0, 0, 1, 0)), {std::sin(angle), 0, std::cos(angle)});
    }
}

TEST_F(AnimationTest, CubicSplinesAreExactForCubics) {
    // x(t) = t³ on [0, 2]: values 0 and 8, tangents 0 and 12. y(t) = 5 − t is linear.
    animate("translation", "CUBICSPLINE", {0, 2}, {0, 0, 0, 0, 5, 0, 0, -1, 0, 12, -1, 0, 8, 3, 0, 0, 0, 0}, "VEC3", 6);
    for (const double t : {0.0, 0.3, 1.0, 1.7, 2.0}) expectNear(placeAt(t), {t * t * t, 5 - t, 0});
}

// ---- solids

/// Cube of side 2 about the origin, its faces with vertices of their own, outward.
Mesh cube() {
    Mesh mesh;
    for (int axis = 0; axis < 3; ++axis) {
        for (const float side : {-1.0f, 1.0f}) {
            glm::vec3 n(0), a(0), b(0);
            n[axis] = side;
            a[(axis + 1) % 3] = 1;
            b = glm::cross(n, a);
            const auto base = static_cast<std::uint32_t>(mesh.positions.size());
            for (const auto& [x, y] : {std::pair(-1.f, -1.f), {1.f, -1.f}, {1.f, 1.f}, {-1.f, 1.f}}) {
                mesh.positions.push_back(n + x * a + y * b);
                mesh.normals.push_back(n);
            }
            for (const std::uint32_t k : {0u, 1u, 2u, 0u, 2u, 3u}) mesh.indices.push_back(base + k);
        }
    }
    return mesh;
}

TEST(ClosedTriangles, CubeIsClosedAndQuadIsNot) {
    const Mesh solid = cube();
    EXPECT_THAT(closedTriangles(solid.positions, solid.indices), testing::AllOf(testing::SizeIs(12), Each(1)));
    const std::vector<glm::vec3> quad = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    EXPECT_THAT(closedTriangles(quad, {0, 1, 2, 0, 2, 3}), ElementsAre(0, 0));
    // The same quad seen from both sides encloses nothing.
    EXPECT_THAT(closedTriangles(quad, {0, 1, 2, 0, 2, 3, 0, 2, 1, 0, 3, 2}), Each(0));
}

TEST(DegenerateTriangles, AreThoseOnALine) {
    const std::vector<glm::vec3> p{{0, 0, 0}, {1, 1, 1}, {3, 3, 3}, {0, 1, 0}};
    EXPECT_EQ(degenerateTriangles(p, {0, 1, 2, 0, 0, 3, 1, 1, 1, 0, 1, 3, 2, 3, 0}), 3u);
    EXPECT_EQ(degenerateTriangles({}, {}), 0u);
}

TEST(ClosedTriangles, InsideOutOpenAndMisorientedCubesAreNotClosed) {
    Mesh room = cube();
    for (std::size_t i = 0; i < room.indices.size(); i += 3) std::swap(room.indices[i], room.indices[i + 1]);
    EXPECT_THAT(closedTriangles(room.positions, room.indices), Each(0));
    Mesh open = cube();
    open.indices.resize(33);
    EXPECT_THAT(closedTriangles(open.positions, open.indices), Each(0));
    Mesh flipped = cube();
    std::swap(flipped.indices[0], flipped.indices[1]);
    EXPECT_THAT(closedTriangles(flipped.positions, flipped.indices), Each(0));
}

TEST(ClosedTriangles, PartsAreJudgedApart) {
    Mesh mesh = cube();
    const auto base = static_cast<std::uint32_t>(mesh.positions.size());
    for (const glm::vec3& p : {glm::vec3(5, 0, 0), {6, 0, 0}, {5, 1, 0}}) mesh.positions.push_back(p);
    for (std::uint32_t k = 0; k < 3; ++k) mesh.indices.push_back(base + k);
    const auto closed = closedTriangles(mesh.positions, mesh.indices);
    EXPECT_EQ(std::count(closed.begin(), closed.end(), 1), 12);
    EXPECT_EQ(closed.back(), 0);
}

TEST(ClosedTriangles, CollapsedTrianglesDoNotOpenASolid) {
    Mesh mesh = cube();
    for (const std::uint32_t k : {0u, 0u, 1u}) mesh.indices.push_back(k);
    EXPECT_THAT(closedTriangles(mesh.positions, mesh.indices), testing::AllOf(testing::SizeIs(13), Each(1)));
}

// ---- tangents

TEST_F(GltfTest, TangentsOfAKnownQuad) {
    builder.append("materials", {{"normalTexture", {{"index", builder.redTexture()}}}});
    builder.show({{"attributes",
                   {{"POSITION", builder.positions(kQuad)},
                    {"NORMAL", builder.positions({0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1})},
                    {"TEXCOORD_0", builder.accessor(kQuadUv, "VEC2", test::kFloat, 4)}}},
                  {"indices", builder.indices(kQuadIndices)},
                  {"material", 0}});
    const Scene scene = load();
    // u runs along +x; the bitangent cross(n, t)·w is +y, up the image.
    ASSERT_EQ(scene.meshes.at(0).tangents.size(), 4u);
    for (const glm::vec4& t : scene.meshes[0].tangents) expectNear(t, glm::vec4(1, 0, 0, 1));
}

TEST_F(GltfTest, TangentsOfTheFileAreKept) {
    builder.append("materials", {{"normalTexture", {{"index", builder.redTexture()}}}});
    builder.show({{"attributes",
                   {{"POSITION", builder.positions({0, 0, 0, 1, 0, 0, 0, 1, 0})},
                    {"NORMAL", builder.positions({0, 0, 1, 0, 0, 1, 0, 0, 1})},
                    {"TANGENT", builder.accessor(std::vector<float>{0, 2, 0, -1, 0, 1, 0, -1, 0, 1, 0, -1}, "VEC4",
                                                 test::kFloat, 3)},
                    {"TEXCOORD_0", builder.accessor(std::vector<float>{0, 1, 1, 1, 0, 0}, "VEC2", test::kFloat, 3)}}},
                  {"material", 0}});
    const Scene scene = load();
    EXPECT_THAT(scene.meshes.at(0).tangents, Each(glm::vec4(0, 1, 0, -1)));
}

TEST(MakeTangents, MirroredUvSplitsTheSharedEdge) {
    // Two quads left and right of x = 0 whose u runs outwards on both: handedness differs across the seam.
    Mesh mesh;
    mesh.positions = {{-1, 0, 0}, {0, 0, 0}, {1, 0, 0}, {-1, 1, 0}, {0, 1, 0}, {1, 1, 0}};
    mesh.normals.assign(6, {0, 0, 1});
    mesh.texCoords[0] = {{1, 1}, {0, 1}, {1, 1}, {1, 0}, {0, 0}, {1, 0}};
    mesh.indices = {0, 1, 4, 0, 4, 3, 1, 2, 5, 1, 5, 4};
    makeTangents(mesh, mesh.texCoords[0]);
    EXPECT_EQ(mesh.positions.size(), 8u);
    EXPECT_EQ(mesh.texCoords[0].size(), 8u);
    for (std::size_t corner = 0; corner < mesh.indices.size(); ++corner) {
        const bool left = corner < 6;
        expectNear(mesh.tangents[mesh.indices[corner]], left ? glm::vec4(-1, 0, 0, -1) : glm::vec4(1, 0, 0, 1));
    }
}

TEST(MakeTangents, SmoothVerticesWeightFacesByTheirAngle) {
    // Roof of two faces that meet in the y axis at 90° to each other, smooth normals there, u across.
    Mesh mesh;
    const float h = std::sqrt(0.5f);
    mesh.positions = {{-1, 0, -1}, {0, 0, 0}, {1, 0, -1}, {-1, 1, -1}, {0, 1, 0}, {1, 1, -1}};
    mesh.normals = {{-h, 0, h}, {0, 0, 1}, {h, 0, h}, {-h, 0, h}, {0, 0, 1}, {h, 0, h}};
    mesh.indices = {0, 1, 4, 0, 4, 3, 1, 2, 5, 1, 5, 4};
    const std::vector<glm::vec2> uv = {{0, 1}, {0.5, 1}, {1, 1}, {0, 0}, {0.5, 0}, {1, 0}};
    makeTangents(mesh, uv);
    EXPECT_EQ(mesh.positions.size(), 6u) << "one group: nothing is split";
    expectNear(mesh.tangents[0], glm::vec4(h, 0, h, 1), 1e-5f);
    expectNear(mesh.tangents[1], glm::vec4(1, 0, 0, 1), 1e-5f);
    expectNear(mesh.tangents[5], glm::vec4(h, 0, -h, 1), 1e-5f);
}

TEST(MakeTangents, FacesWithoutUvAreaStillGetUnitTangentsAcrossTheNormal) {
    Mesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {2, 2, 2}};
    mesh.normals.assign(4, {0, 0, 1});
    mesh.indices = {0, 1, 2};
    makeTangents(mesh, std::vector<glm::vec2>(4, glm::vec2(0.5f)));
    for (const glm::vec4& t : mesh.tangents) {
        EXPECT_NEAR(glm::length(glm::vec3(t)), 1, 1e-6);
        EXPECT_NEAR(t.z, 0, 1e-6);
        EXPECT_EQ(std::abs(t.w), 1);
    }
}

}  // namespace
}  // namespace voxcone
