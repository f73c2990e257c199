// The G-buffer against geometry that can be computed by hand.
#include "frame/gbuffer.h"

#include <gmock/gmock.h>

#include <cmath>
#include <random>

#include "core/octahedral.h"
#include "support/gl_context.h"
#include "support/shapes.h"

namespace voxcone {
namespace {

using test::GlTest;
using testing::Each;
using testing::FloatEq;

constexpr int kWidth = 96, kHeight = 64;

/// One drawn G-buffer.
struct Drawn {
    gl::GpuScene scene;
    GBuffer gbuffer;

    Drawn(const Scene& source, const Camera& camera, const glm::dvec3& origin = glm::dvec3(0), int supersample = 1,
          bool reversed = false)
        : scene(source), gbuffer(gl::ShaderLibrary(), scene, kWidth * supersample, kHeight * supersample) {
        scene.setOrigin(origin);
        if (reversed) scene.reverseDrawOrder();
        gl::PassTimers timers(gl::TimerMode::finish);
        gbuffer.draw(scene, cameraView(camera, origin, scene.bounds(), kWidth * supersample, kHeight * supersample),
                     timers);
    }
};

glm::vec3 at(const Image& image, int x, int y) {
    const float* p = image.pixel(x, y);
    return {p[0], p[1], p[2]};
}

/// World-space ray of length 1 along the view through the centre of a pixel, rows counted from the top.
glm::dvec3 rayThrough(const Camera& camera, int x, int y) {
    const glm::dvec3 forward = glm::normalize(camera.target - camera.position);
    const glm::dvec3 right = glm::normalize(glm::cross(forward, camera.up)), up = glm::cross(right, forward);
    const double tangent = std::tan(glm::radians(camera.verticalFovDeg / 2));
    return forward + right * (tangent * kWidth / kHeight * (2 * (x + 0.5) / kWidth - 1)) -
           up * (tangent * (2 * (y + 0.5) / kHeight - 1));
}

TEST_F(GlTest, AFloorIsWhereItIs) {
    const Camera camera = test::camera({1, 2, 5}, {0, 0, 0}, 60);
    Drawn drawn(test::oneObject(test::quad(40, 40), test::lambert(glm::vec3(0.25f, 0.5f, 0.75f))), camera);
    const Image position = drawn.gbuffer.channel("position", 1), normal = drawn.gbuffer.channel("normal", 1),
                depth = drawn.gbuffer.channel("depth", 1), albedo = drawn.gbuffer.channel("albedo", 1);
    int hits = 0, misses = 0;
    for (int y = 0; y < kHeight; ++y) {
        for (int x = 0; x < kWidth; ++x) {
            const glm::dvec3 ray = rayThrough(camera, x, y);
            const double t = ray.y < 0 ? -camera.position.y / ray.y : -1;
            const glm::dvec3 expected = camera.position + t * ray;
            const double outside = std::max(std::abs(expected.x), std::abs(expected.z)) - 20;
            if (t > 0 && std::abs(outside) < 0.5) continue;  // the floor's edge
            if (t < 0 || outside > 0) {
                ++misses;
                ASSERT_EQ(*depth.pixel(x, y), 0) << x << ' ' << y;
                ASSERT_EQ(at(position, x, y), glm::vec3(0));
                continue;
            }
            ++hits;
            ASSERT_NEAR(*depth.pixel(x, y), t, 1e-4 * t) << x << ' ' << y;
            for (int k = 0; k < 3; ++k) ASSERT_NEAR(at(position, x, y)[k], expected[k], 2e-4 * t) << x << ' ' << y;
            ASSERT_NEAR(glm::distance(at(normal, x, y), glm::vec3(0, 1, 0)), 0, 1e-4);
            ASSERT_NEAR(glm::distance(at(albedo, x, y), glm::vec3(0.25f, 0.5f, 0.75f)), 0, 1e-4);
        }
    }
    EXPECT_GT(hits, 1000);
    EXPECT_GT(misses, 500);
}

TEST_F(GlTest, ASphereHasItsNormals) {
    const Camera camera = test::camera({0, 0, 4}, {0, 0, 0}, 40);
    Drawn drawn(test::oneObject(test::sphere(1, 5), test::lambert(0.5f)), camera);
    const Image position = drawn.gbuffer.channel("position", 1), normal = drawn.gbuffer.channel("normal", 1);
    for (const glm::ivec2 pixel : {glm::ivec2(48, 32), {40, 28}, {56, 40}, {48, 20}}) {
        const glm::vec3 p = at(position, pixel.x, pixel.y);
        EXPECT_NEAR(glm::length(p), 1, 2e-3);
        EXPECT_NEAR(glm::distance(at(normal, pixel.x, pixel.y), glm::normalize(p)), 0, 5e-3);
    }
}

TEST_F(GlTest, GeometricNormalsFromDerivativesAreThoseOfTheTriangles) {
    // A tilted plane whose shading normals say something else.
    Mesh mesh = test::quad(60, 60);
    for (glm::vec3& n : mesh.normals) n = glm::normalize(glm::vec3(0.3f, 1, 0.2f));
    const glm::dvec3 truth = glm::normalize(glm::dvec3(0.2, 1, 0.5));
    const Camera camera = test::camera({0, 2, 6}, {0, 0, 0}, 50);
    Drawn drawn(test::oneObject(mesh, test::lambert(0.5f), test::yTo(truth)), camera);
    const gl::ShaderLibrary library;
    gl::Program program = library.computeFromText("normals.comp", R"(
#include "frame/gbuffer.glsl"
layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32f, binding = 0) uniform writeonly image2D u_output;
void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    GBufferSample s = loadGBuffer(pixel);
    imageStore(u_output, pixel, s.hit ? vec4(s.geometricNormal, 1.0) : vec4(0.0));
})",
                                                  drawn.gbuffer.defines());
    const gl::Texture output = gl::Texture::create2D(GL_RGBA32F, kWidth, kHeight);
    drawn.gbuffer.bind(program, 5);
    output.bindImage(0, 0, GL_WRITE_ONLY);
    gl::dispatch(program, kWidth / 8, kHeight / 8, 1);
    const Image normals = imageFromTexture(output, 4);
    double worst = 0;
    int hits = 0;
    for (int y = 0; y < kHeight; ++y) {
        for (int x = 0; x < kWidth; ++x) {
            if (normals.pixel(x, y)[3] == 0) continue;
            ++hits;
            worst = std::max(worst, glm::distance(glm::dvec3(at(normals, x, y)), truth));
        }
    }
    RecordProperty("worst", std::to_string(worst));
    EXPECT_GT(hits, 1000);
    EXPECT_LT(worst, 2e-3);
}

TEST_F(GlTest, BackFacesOfSingleSidedMaterialsAreNotSeen) {
    const Camera below = test::camera({0, -3, 0.001}, {0, 0, 0});
    Material material = test::lambert(0.5f);
    Drawn single(test::oneObject(test::quad(4, 4), material), below);
    EXPECT_EQ(*single.gbuffer.channel("depth", 1).pixel(kWidth / 2, kHeight / 2), 0);
    material.doubleSided = true;
    Drawn doubled(test::oneObject(test::quad(4, 4), material), below);
    EXPECT_NEAR(*doubled.gbuffer.channel("depth", 1).pixel(kWidth / 2, kHeight / 2), 3, 1e-3);
    EXPECT_NEAR(at(doubled.gbuffer.channel("normal", 1), kWidth / 2, kHeight / 2).y, -1, 1e-4);
}

TEST_F(GlTest, AMirroredInstanceShowsItsFront) {
    const Camera above = test::camera({0, 3, 0.001}, {0, 0, 0});
    Drawn drawn(test::oneObject(test::quad(4, 4), test::lambert(0.5f), test::scaling({-1, 1, 1})), above);
    EXPECT_NEAR(*drawn.gbuffer.channel("depth", 1).pixel(kWidth / 2, kHeight / 2), 3, 1e-3);
    EXPECT_NEAR(at(drawn.gbuffer.channel("normal", 1), kWidth / 2, kHeight / 2).y, 1, 1e-4);
}

TEST_F(GlTest, AMirroredNormalMapLeansTheMirroredWay) {
    // Texel (255, 128, 180): leans along the tangent, +x; under scale (−1, 1, 1) along −x.
    Material material = test::lambert(0.5f);
    material.normalTexture.texture = 0;
    Mesh mesh = test::quad(4, 4);
    mesh.tangents.assign(mesh.positions.size(), glm::vec4(1, 0, 0, 1));
    Texture image;
    image.width = image.height = 1;
    image.rgba8 = {230, 150, 210, 255};
    const Camera above = test::camera({0, 3, 0.001}, {0, 0, 0});
    const auto normalUnder = [&](const glm::dvec3& scale) {
        Scene scene = test::oneObject(mesh, material, test::scaling(scale));
        scene.textures.push_back(image);
        Drawn drawn(scene, above);
        return at(drawn.gbuffer.channel("normal", 1), kWidth / 2, kHeight / 2);
    };
    const glm::vec3 map = glm::normalize(glm::vec3(230, 150, 210) / 127.5f - 1.0f);
    const glm::vec3 straight = normalUnder({1, 1, 1}), mirrored = normalUnder({-1, 1, 1});
    // bitangent = n × t = y × x = −z
    EXPECT_NEAR(glm::distance(straight, glm::vec3(map.x, map.z, -map.y)), 0, 2e-3);
    EXPECT_NEAR(glm::distance(mirrored, glm::vec3(-straight.x, straight.y, straight.z)), 0, 2e-3);
}

TEST_F(GlTest, AlphaIsTestedByCutoffAndByChance) {
    const Camera above = test::camera({0, 3, 0.001}, {0, 0, 0}, 30);
    Material material = test::lambert(0.5f);
    const auto share = [&](AlphaMode mode, float alpha) {
        material.alphaMode = mode;
        material.baseColor.a = alpha;
        Drawn drawn(test::oneObject(test::quad(40, 40), material), above);
        const Image depth = drawn.gbuffer.channel("depth", 1);
        return static_cast<double>(std::count_if(depth.data.begin(), depth.data.end(), [](float d) { return d > 0; })) /
               (kWidth * kHeight);
    };
    EXPECT_EQ(share(AlphaMode::opaque, 0.3f), 1);
    EXPECT_EQ(share(AlphaMode::mask, 0.4f), 0);
    EXPECT_EQ(share(AlphaMode::mask, 0.6f), 1);
    EXPECT_NEAR(share(AlphaMode::blend, 0.3f), 0.3, 4 * std::sqrt(0.21 / (kWidth * kHeight)));
    EXPECT_EQ(share(AlphaMode::blend, 0), 0);
    EXPECT_EQ(share(AlphaMode::blend, 1), 1);
}

TEST_F(GlTest, AnUnlitMaterialEmitsItsColour) {
    Material material = test::lambert(glm::vec3(0.2f, 0.4f, 0.6f));
    material.unlit = true;
    Drawn drawn(test::oneObject(test::quad(4, 4), material), test::camera({0, 3, 0.001}, {0, 0, 0}));
    const int x = kWidth / 2, y = kHeight / 2;
    EXPECT_NEAR(glm::distance(at(drawn.gbuffer.channel("emission", 1), x, y), glm::vec3(0.2f, 0.4f, 0.6f)), 0, 1e-6);
    EXPECT_NEAR(glm::distance(at(drawn.gbuffer.channel("albedo", 1), x, y), glm::vec3(0.2f, 0.4f, 0.6f)), 0, 1e-4);
}

TEST_F(GlTest, StrongEmissionIsExact) {
    Drawn drawn(test::oneObject(test::quad(4, 4), test::lambert(glm::vec3(0), glm::vec3(1e6f, 1, 0.001f))),
                test::camera({0, 3, 0.001}, {0, 0, 0}));
    EXPECT_EQ(at(drawn.gbuffer.channel("emission", 1), kWidth / 2, kHeight / 2), glm::vec3(1e6f, 1, 0.001f));
}

TEST_F(GlTest, TheCamerasNearAndFarCutTheScene) {
    Camera above = test::camera({0, 3, 0.001}, {0, 0, 0});
    const Scene scene = test::oneObject(test::quad(4, 4), test::lambert(0.5f));
    const auto depth = [&] {
        Drawn drawn(scene, above);
        return *drawn.gbuffer.channel("depth", 1).pixel(kWidth / 2, kHeight / 2);
    };
    above.near = 2.9;
    above.far = 3.1;
    EXPECT_NEAR(depth(), 3, 1e-3);
    above.near = 3.05;
    EXPECT_EQ(depth(), 0);
    above.near = 0;
    above.far = 2.95;
    EXPECT_EQ(depth(), 0);
}

TEST_F(GlTest, WhatTouchesTheCameraIsDrawn) {
    // Far nearer than a thousandth of the scene's depth.
    const Scene scene = test::SceneBuilder()
                            .add(test::quad(1, 1), test::lambert(0.25f), test::translation({0, -0.0005, 0}))
                            .add(test::quad(100, 100), test::lambert(0.75f), test::translation({0, -100, 0}))
                            .build();
    Drawn drawn(scene, test::camera({0, 0, 0}, {0, -1, 0}, 45, {0, 0, -1}));
    EXPECT_NEAR(*drawn.gbuffer.channel("depth", 1).pixel(kWidth / 2, kHeight / 2), 0.0005, 1e-6);
}

TEST_F(GlTest, SupersamplesAreAveragedOverPixels) {
    const Camera camera = test::camera({0, 0, 4}, {0, 0, 0}, 40);
    Drawn drawn(test::oneObject(test::sphere(1, 4), test::lambert(0.5f)), camera, glm::dvec3(0), 4);
    const Image albedo = drawn.gbuffer.channel("albedo", 4), depth = drawn.gbuffer.channel("depth", 4);
    ASSERT_EQ(albedo.width, kWidth);
    int partly = 0;
    for (int i = 0; i < kWidth * kHeight; ++i) {
        const auto k = static_cast<std::size_t>(i);
        const float a = albedo.data[3 * k];
        partly += a > 0.01f && a < 0.49f;
        if (a > 0) {
            ASSERT_GT(depth.data[k], 2.9f) << "background counted into the mean distance";
        }
    }
    EXPECT_GT(partly, 50);
}

TEST_F(GlTest, MinifiedMaskKeepsItsShare) {
    // Three texels of eight are there, and dozens of them in every pixel: cut at the filtered opacity nothing would be
    // left.
    constexpr int kTexels = 256;
    Texture image;
    image.width = image.height = kTexels;
    for (int i = 0; i < kTexels * kTexels; ++i) {
        const auto alpha = static_cast<std::uint8_t>((i + i / kTexels * 3) % 8 < 3 ? 255 : 0);
        for (int c = 0; c < 4; ++c) image.rgba8.push_back(alpha);
    }
    Material material = test::lambert(1.0f);
    material.baseColorTexture.texture = 0;
    material.baseColorTexture.uvTransform = glm::mat3x2(8, 0, 0, 8, 0, 0);
    material.alphaMode = AlphaMode::mask;
    Scene scene = test::oneObject(test::quad(40, 40), material);
    scene.textures.push_back(image);
    Drawn drawn(scene, test::camera({0, 10, 0.01}, {0, 0, 0}));
    const Image albedo = drawn.gbuffer.channel("albedo", 1);
    int there = 0;
    for (int y = 0; y < kHeight; ++y) {
        for (int x = 0; x < kWidth; ++x) {
            const float value = at(albedo, x, y).r;
            if (value == 0) continue;
            ++there;
            // Black texels that are not there do not darken the others.
            ASSERT_NEAR(value, 1, 1e-2) << x << ' ' << y;
        }
    }
    const double pixels = kWidth * kHeight, share = there / pixels;
    EXPECT_NEAR(share, 0.375, 4 * std::sqrt(0.25 / pixels));
}

TEST_F(GlTest, TexelsAreTheOnesUnderThePixelAlsoAtEdgesOfTriangles) {
    // Magnified texels on many small triangles: a pixel that took its derivatives from nowhere would show a coarse mip.
    constexpr int kTexels = 8;
    Texture image;
    image.width = image.height = kTexels;
    image.nearest = true;
    image.wrapS = Wrap::mirrored_repeat;
    for (int i = 0; i < kTexels * kTexels; ++i) {
        const int hash = (i * 97 + i / kTexels * 31) % 256;
        for (const int value : {hash, 255 - hash, (hash * 7) % 256, 255})
            image.rgba8.push_back(static_cast<std::uint8_t>(value));
    }
    Material material = test::lambert(1.0f, 2.0f);
    material.baseColorTexture.texture = material.emissionTexture.texture = 0;
    material.emissionTexture.uvTransform = glm::mat3x2(0, 1, -1, 0, 0.25f, -0.5f);  // a quarter turn, moved
    Scene scene = test::oneObject(test::quad(4, 4, 24), material);
    scene.textures.push_back(image);
    const Camera camera = test::camera({0.1, 3, 1.0}, {0, 0, 0});
    Drawn drawn(scene, camera);
    const Image albedo = drawn.gbuffer.channel("albedo", 1), emission = drawn.gbuffer.channel("emission", 1);
    const auto texel = [&](glm::vec2 uv) {
        const float mirrored = std::abs(uv.x - 2 * std::round(uv.x / 2));
        const int u = std::min(static_cast<int>(mirrored * kTexels), kTexels - 1);
        const int v = static_cast<int>((uv.y - std::floor(uv.y)) * kTexels);
        const std::uint8_t* rgba = image.rgba8.data() + 4 * (v * kTexels + u);
        return glm::vec3(linearFromSrgb(static_cast<float>(rgba[0]) / 255),
                         linearFromSrgb(static_cast<float>(rgba[1]) / 255),
                         linearFromSrgb(static_cast<float>(rgba[2]) / 255));
    };
    int compared = 0;
    for (int y = 0; y < kHeight; ++y) {
        for (int x = 0; x < kWidth; ++x) {
            const glm::dvec3 ray = rayThrough(camera, x, y);
            const glm::vec3 p(camera.position - camera.position.y / ray.y * ray);
            const glm::vec2 uv(p.x / 4 + 0.5f, p.z / 4 + 0.5f);
            const glm::vec2 place = glm::fract(uv * static_cast<float>(kTexels));
            const bool nearBorder =
                glm::any(glm::lessThan(place, glm::vec2(0.02f))) || glm::any(glm::greaterThan(place, glm::vec2(0.98f)));
            if (nearBorder || std::max(std::abs(p.x), std::abs(p.z)) > 1.99f) continue;
            ++compared;
            ASSERT_NEAR(glm::distance(at(albedo, x, y), texel(uv)), 0, 5e-3) << x << ' ' << y;
            const glm::vec2 turned = material.emissionTexture.uvTransform * glm::vec3(uv, 1);
            ASSERT_NEAR(glm::distance(at(emission, x, y), 2.0f * texel(turned)), 0, 1e-2) << x << ' ' << y;
        }
    }
    EXPECT_GT(compared, 3000);
}

/// All channels of a drawing, bit for bit.
std::vector<float> allChannels(Drawn& drawn) {
    std::vector<float> all;
    for (const char* name : {"albedo", "normal", "depth", "emission"}) {
        const Image image = drawn.gbuffer.channel(name, 1);
        all.insert(all.end(), image.data.begin(), image.data.end());
    }
    return all;
}

Scene crowd(const glm::dvec3& offset) {
    Material leaf = test::glossy(glm::vec3(0.1f, 0.6f, 0.2f), 0, 0.8f);
    leaf.alphaMode = AlphaMode::blend;
    leaf.baseColor.a = 0.5f;
    leaf.doubleSided = true;
    test::SceneBuilder builder;
    builder.add(test::sphere(1, 3), test::lambert(0.5f, 3.0f), test::translation(offset + glm::dvec3(0.5, 1, 0)));
    builder.add(test::quad(8, 8), test::lambert(0.25f), test::translation(offset));
    builder.add(test::box({1, 2, 1}), test::glossy(glm::vec3(0.9f), 1, 0.2f),
                test::translation(offset + glm::dvec3(-2, 1, 0.25)) * test::rotation(30, {0, 1, 0}));
    builder.add(test::quad(3, 3), leaf,
                test::translation(offset + glm::dvec3(0, 1.5, 1)) * test::rotation(70, {1, 0, 0}));
    return builder.build();
}

TEST_F(GlTest, ASceneAMillionMetresAwayIsTheSameBitForBit) {
    const glm::dvec3 far(1048576, -2097152, 4194304);
    Drawn here(crowd(glm::dvec3(0)), test::camera({1, 3, 6}, {0, 1, 0}));
    Drawn there(crowd(far), test::camera(far + glm::dvec3(1, 3, 6), far + glm::dvec3(0, 1, 0)), far);
    EXPECT_EQ(allChannels(here), allChannels(there));
}

TEST_F(GlTest, TheOrderOfDrawingDoesNotMatter) {
    const Camera camera = test::camera({1, 3, 6}, {0, 1, 0});
    Drawn forwards(crowd(glm::dvec3(0)), camera);
    Drawn backwards(crowd(glm::dvec3(0)), camera, glm::dvec3(0), 1, true);
    EXPECT_EQ(allChannels(forwards), allChannels(backwards));
}

TEST_F(GlTest, AnEmptySceneIsBackground) {
    const Scene empty;
    Drawn drawn(empty, test::camera({0, 0, 4}, {0, 0, 0}));
    EXPECT_THAT(drawn.gbuffer.channel("depth", 1).data, Each(FloatEq(0)));
}

TEST_F(GlTest, OctahedralTwinsAgree) {
    std::mt19937 random(7);
    std::normal_distribution<float> gauss;
    std::vector<glm::vec4> vectors = {{1, 0, 0, 0},  {-1, 0, 0, 0}, {0, 1, 0, 0},
                                      {0, -1, 0, 0}, {0, 0, 1, 0},  {0, 0, -1, 0}};
    while (vectors.size() < 100000) {
        const glm::vec3 v(gauss(random), gauss(random), gauss(random));
        if (glm::length(v) > 1e-3f) vectors.emplace_back(glm::normalize(v), 0);
    }
    gl::Program program = gl::ShaderLibrary().computeFromText("octahedral.comp", R"(
#include "shared/octahedral.glsl"
layout(local_size_x = 64) in;
layout(std430, binding = 2) readonly buffer In { vec4 b_in[]; };
layout(std430, binding = 3) writeonly buffer Out { uvec4 b_out[]; };
uniform int u_count;
void main() {
    int i = int(gl_GlobalInvocationID.x);
    if (i >= u_count) return;
    uint bits = packOctahedral(b_in[i].xyz);
    b_out[i] = uvec4(bits, floatBitsToUint(unpackOctahedral(bits)));
})");
    const gl::Buffer in = gl::Buffer::of(vectors), out(vectors.size() * 16);
    in.bindBase(GL_SHADER_STORAGE_BUFFER, 2);
    out.bindBase(GL_SHADER_STORAGE_BUFFER, 3);
    program.set("u_count", static_cast<int>(vectors.size()));
    gl::dispatch(program, gl::groupsFor(static_cast<int>(vectors.size()), 64), 1, 1);
    const auto words = out.read<glm::uvec4>();
    float worstShader = 0, worstCpu = 0;
    int worstStep = 0;
    for (std::size_t i = 0; i < vectors.size(); ++i) {
        const glm::vec3 unit(vectors[i]);
        const glm::vec3 decoded = glm::uintBitsToFloat(glm::uvec3(words[i].y, words[i].z, words[i].w));
        const std::uint32_t bits = packOctahedral(unit);
        worstShader = std::max(worstShader, glm::distance(decoded, unit));
        worstCpu = std::max(worstCpu, glm::distance(unpackOctahedral(bits), unit));
        for (const int shift : {0, 16}) {
            const auto field = [&](std::uint32_t word) { return static_cast<std::int16_t>(word >> shift); };
            worstStep = std::max(worstStep, std::abs(field(words[i].x) - field(bits)));
        }
    }
    EXPECT_LT(worstShader, 7e-5f);
    EXPECT_LT(worstCpu, 7e-5f);
    EXPECT_LE(worstStep, 1);  // the two divisions may round apart
}

}  // namespace
}  // namespace voxcone
