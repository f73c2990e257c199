// Shader includes against their C++ twins: a kernel of a few lines over random inputs, read back and compared.
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <numbers>
#include <random>

#include "cascade/buffers.h"
#include "cascade/clipmap.h"
#include "cone/cone_set.h"
#include "cone/cone_uniforms.h"
#include "core/rgb9e5.h"
#include "gl/bindings.h"
#include "gl/buffer.h"
#include "gl/shader_library.h"
#include "light/light_layout.h"
#include "light/shadow_maps.h"
#include "scene/brdf.h"
#include "scene/environment.h"
#include "scene/light_math.h"
#include "support/closed_forms.h"
#include "support/gl_context.h"

namespace voxcone {
namespace {

using test::GlTest;

/// Words in and out, so that no bit is changed on the way.
using Words = std::vector<std::uint32_t>;

class Twins : public GlTest {
  protected:
    static gl::Program compile(const std::string& includes, const std::string& body, const gl::Defines& defines = {}) {
        return gl::ShaderLibrary().computeFromText("twin.comp", includes + R"(
layout(local_size_x = 64) in;
layout(std430, binding = 0) readonly buffer In { uint b_in[]; };
layout(std430, binding = 1) writeonly buffer Out { uint b_out[]; };
uniform uint u_count, u_inWords, u_outWords;
uint g_in, g_out;
uint nextUint() { return b_in[g_in++]; }
float nextFloat() { return uintBitsToFloat(b_in[g_in++]); }
vec3 nextVec3() { float x = nextFloat(), y = nextFloat(), z = nextFloat(); return vec3(x, y, z); }
void put(uint value) { b_out[g_out++] = value; }
void put(float value) { put(floatBitsToUint(value)); }
void put(vec3 value) { put(value.x); put(value.y); put(value.z); }
void put(vec4 value) { put(value.xyz); put(value.w); }
void main() {
    if (gl_GlobalInvocationID.x >= u_count) return;
    g_in = gl_GlobalInvocationID.x * u_inWords;
    g_out = gl_GlobalInvocationID.x * u_outWords;
)" + body + "}\n",
                                                   defines);
    }

    static Words run(gl::Program& program, const Words& in, std::size_t inWords, std::size_t outWords) {
        const std::size_t count = in.size() / inWords;
        const gl::Buffer source = gl::Buffer::of(in);
        const gl::Buffer target(count * outWords * 4);
        source.bindBase(GL_SHADER_STORAGE_BUFFER, 0);
        target.bindBase(GL_SHADER_STORAGE_BUFFER, 1);
        program.set("u_count", static_cast<std::uint32_t>(count));
        program.set("u_inWords", static_cast<std::uint32_t>(inWords));
        program.set("u_outWords", static_cast<std::uint32_t>(outWords));
        gl::dispatch(program, gl::groupsFor(static_cast<int>(count), 64), 1, 1);
        gl::memoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
        return target.read<std::uint32_t>();
    }

    static void push(Words& words, float value) { words.push_back(std::bit_cast<std::uint32_t>(value)); }
    static void push(Words& words, const glm::vec3& v) { push(words, v.x), push(words, v.y), push(words, v.z); }

    float uniform(float low, float high) { return std::uniform_real_distribution<float>(low, high)(random_); }
    glm::vec3 color() { return {uniform(0, 1), uniform(0, 1), uniform(0, 1)}; }
    glm::vec3 unit() {
        glm::vec3 v;
        do v = {uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)};
        while (glm::dot(v, v) > 1 || glm::dot(v, v) < 0.01f);
        return glm::normalize(v);
    }

    std::mt19937 random_{5};
};

/// Reads results in order.
struct Results {
    const Words& words;
    std::size_t at = 0;
    std::uint32_t nextUint() { return words[at++]; }
    float next() { return std::bit_cast<float>(words[at++]); }
    glm::vec3 next3() {
        const float x = next(), y = next(), z = next();
        return {x, y, z};
    }
};

void expectNear(float shader, float twin, float relative, float absolute = 1e-6f) {
    EXPECT_NEAR(shader, twin, relative * std::abs(twin) + absolute);
}
void expectNear(const glm::vec3& shader, const glm::vec3& twin, float relative, float absolute = 1e-6f) {
    for (int c = 0; c < 3; ++c) expectNear(shader[c], twin[c], relative, absolute);
}

TEST_F(Twins, Brdf) {
    gl::Program program = compile("#include \"shared/brdf.glsl\"\n", R"(
    vec3 baseColor = nextVec3();
    float metallic = nextFloat(), roughness = nextFloat(), ior = nextFloat(), specularFactor = nextFloat();
    vec3 specularColor = nextVec3(), n = nextVec3(), v = nextVec3(), l = nextVec3();
    float a = nextFloat(), b = nextFloat();
    Surface s = surfaceFromMaterial(baseColor, metallic, roughness, ior, specularFactor, specularColor);
    put(s.diffuseColor); put(s.f0); put(s.f90); put(s.alpha);
    put(maxComponent(baseColor)); put(schlickWeight(a)); put(fresnel(s, a)); put(diffuseTransmission(s, a));
    put(ggxDistribution(s.alpha, a, b)); put(smithVisibility(s.alpha, a, b));
    put(evaluateDiffuse(s, n, v, l)); put(evaluateSpecular(s, n, v, l));
    put(diffuseAlbedoScale(s, a)); put(voxelAlbedo(s));
)");
    struct Input {
        glm::vec3 baseColor;
        float metallic, roughness, ior, specularFactor;
        glm::vec3 specularColor, n, v, l;
        float a, b;
    };
    std::vector<Input> inputs;
    Words words;
    for (int i = 0; i < 4000; ++i) {
        Input in{color(), uniform(0, 1), uniform(0, 1), uniform(1, 2.5f), uniform(0, 1), color(),
                 unit(),  unit(),        unit(),        uniform(0, 1),    uniform(0, 1)};
        // A third near the mirror direction, where the lobe is narrow; some at the ends of the ranges.
        if (i % 3 == 0) in.l = glm::normalize(glm::reflect(-in.v, in.n) + 0.1f * unit());
        if (i % 7 == 0) in.metallic = static_cast<float>(i % 2), in.roughness = static_cast<float>(i / 7 % 2);
        if (i % 11 == 0) in.a = static_cast<float>(i / 11 % 2);
        if (i % 13 == 0) in.specularFactor = 0;
        inputs.push_back(in);
        push(words, in.baseColor);
        for (const float f : {in.metallic, in.roughness, in.ior, in.specularFactor}) push(words, f);
        for (const glm::vec3& p : {in.specularColor, in.n, in.v, in.l}) push(words, p);
        push(words, in.a), push(words, in.b);
    }
    const Words out = run(program, words, 21, 26);
    Results results{out};
    int lit = 0;
    for (const Input& in : inputs) {
        const Surface s =
            surfaceFromMaterial(in.baseColor, in.metallic, in.roughness, in.ior, in.specularFactor, in.specularColor);
        const float e = 2e-6f;
        expectNear(results.next3(), s.diffuseColor, e);
        expectNear(results.next3(), s.f0, e);
        expectNear(results.next(), s.f90, e);
        expectNear(results.next(), s.alpha, e);
        EXPECT_EQ(results.next(), maxComponent(in.baseColor));
        expectNear(results.next(), schlickWeight(in.a), e);
        expectNear(results.next3(), fresnel(s, in.a), e);
        expectNear(results.next(), diffuseTransmission(s, in.a), e);
        expectNear(results.next(), ggxDistribution(s.alpha, in.a, in.b), 1e-5f);
        expectNear(results.next(), smithVisibility(s.alpha, in.a, in.b), 1e-5f);
        expectNear(results.next3(), evaluateDiffuse(s, in.n, in.v, in.l), 1e-5f);
        // |n × h|² loses digits where it is small.
        const glm::vec3 specular = evaluateSpecular(s, in.n, in.v, in.l);
        expectNear(results.next3(), specular, 2e-4f);
        lit += specular.x > 0;
        expectNear(results.next(), diffuseAlbedoScale(s, in.a), e);
        expectNear(results.next3(), voxelAlbedo(s), e);
    }
    EXPECT_EQ(results.at, out.size());
    EXPECT_GT(lit, 500);
}

TEST_F(Twins, LightMath) {
    gl::Program program = compile("#include \"shared/light_math.glsl\"\n", R"(
    float a = nextFloat(), b = nextFloat(), c = nextFloat(), d = nextFloat(), r = nextFloat();
    put(spotFalloff(a, b, c)); put(rangeWindow(d, r));
)");
    std::vector<std::array<float, 5>> inputs;
    for (int i = 0; i < 2000; ++i) {
        const float outer = uniform(-0.2f, 1), inner = i % 5 == 0 ? outer : uniform(outer, 1);
        inputs.push_back({uniform(-1, 1), inner, outer, uniform(0, 20), i % 4 == 0 ? 0.0f : uniform(0.1f, 15)});
    }
    Words words;
    for (const auto& in : inputs)
        for (const float f : in) push(words, f);
    const Words out = run(program, words, 5, 2);
    Results results{out};
    for (const auto& [a, b, c, d, r] : inputs) {
        // The slope of a hard edge is 1/1e-3.
        expectNear(results.next(), spotFalloff(a, b, c), 1e-5f, 1e-4f);
        expectNear(results.next(), rangeWindow(d, r), 1e-5f, 1e-5f);
    }
}

TEST_F(Twins, BindingPoints) {
    gl::Program program = compile("#include \"shared/bindings.glsl\"\n#include \"light/lights.glsl\"\n", R"(
    put(uint(BASE_COLOR_UNIT)); put(uint(METALLIC_ROUGHNESS_UNIT)); put(uint(NORMAL_UNIT)); put(uint(EMISSION_UNIT));
    put(uint(ENVIRONMENT_UNIT)); put(uint(PASS_TEXTURE_UNIT)); put(uint(OBJECT_STORAGE)); put(uint(MATERIAL_BLOCK));
    put(uint(POSITION_LOCATION)); put(uint(NORMAL_LOCATION)); put(uint(TANGENT_LOCATION));
    put(uint(TEX_COORD_0_LOCATION)); put(uint(TEX_COORD_1_LOCATION)); put(uint(COLOR_LOCATION));
    put(uint(OBJECT_INDEX_LOCATION)); put(uint(LIGHT_STORAGE)); put(uint(SHADOW_VIEW_STORAGE));
    put(uint(SHADOW_DEPTH_UNIT));
    put(LIGHT_DIRECTIONAL); put(LIGHT_POINT); put(LIGHT_SPOT); put(LIGHT_SPHERE); put(LIGHT_RECTANGLE);
)");
    Words expected;
    for (const int value : {int{gl::kBaseColorUnit},
                            int{gl::kMetallicRoughnessUnit},
                            int{gl::kNormalUnit},
                            int{gl::kEmissionUnit},
                            gl::kEnvironmentUnit,
                            gl::kPassTextureUnit,
                            gl::kObjectStorage,
                            gl::kMaterialBlock,
                            int{gl::kPositionLocation},
                            int{gl::kNormalLocation},
                            int{gl::kTangentLocation},
                            int{gl::kTexCoord0Location},
                            int{gl::kTexCoord1Location},
                            int{gl::kColorLocation},
                            int{gl::kObjectIndexLocation},
                            kLightStorage,
                            kShadowViewStorage,
                            kShadowDepthUnit,
                            int(LightType::directional),
                            int(LightType::point),
                            int(LightType::spot),
                            int(LightType::sphere),
                            int(LightType::rectangle)})
        expected.push_back(static_cast<std::uint32_t>(value));
    EXPECT_EQ(run(program, {0}, 1, expected.size()), expected);
}

TEST_F(Twins, LightAndShadowRecords) {
    // Each field is read as the word that stands where C++ puts it; every word of the second record is different.
    gl::Program program = compile("#include \"light/lights.glsl\"\n", R"(
    Light a = b_lights[1];
    put(a.position); put(a.type); put(a.direction); put(a.range); put(a.intensity); put(a.radius); put(a.right);
    put(a.halfWidth); put(a.up); put(a.halfHeight); put(a.cosInnerCone); put(a.cosOuterCone); put(a.stratumSize);
    put(a.firstView); put(a.faces); put(a.samples);
    ShadowView v = b_shadowViews[1];
    put(v.origin); put(v.texel); put(v.right); put(v.scale); put(v.up); put(v.perspective); put(v.forward);
    put(v.maxKernel); put(v.tileCenter.x); put(v.tileCenter.y); put(v.tileHalfSize.x); put(v.tileHalfSize.y);
    put(v.depth.x); put(v.depth.y); put(v.filterRadius);
)");
    const auto words = [&](std::size_t bytes) {
        Words w;
        for (std::size_t i = 0; i < 2 * bytes / 4; ++i) push(w, 1.0f + static_cast<float>(i));
        return w;
    };
    const Words lights = words(sizeof(LightRecord)), views = words(sizeof(ShadowViewRecord));
    const gl::Buffer lightBuffer = gl::Buffer::of(lights), viewBuffer = gl::Buffer::of(views);
    lightBuffer.bindBase(GL_SHADER_STORAGE_BUFFER, kLightStorage);
    viewBuffer.bindBase(GL_SHADER_STORAGE_BUFFER, kShadowViewStorage);
    Words expected;
    const auto field = [&](const Words& from, std::size_t size, std::size_t offset, std::size_t count) {
        for (std::size_t i = 0; i < count; ++i) expected.push_back(from[(size + offset) / 4 + i]);
    };
    for (const auto& [offset, count] :
         std::initializer_list<std::pair<std::size_t, std::size_t>>{{offsetof(LightRecord, position), 3},
                                                                    {offsetof(LightRecord, type), 1},
                                                                    {offsetof(LightRecord, direction), 3},
                                                                    {offsetof(LightRecord, range), 1},
                                                                    {offsetof(LightRecord, intensity), 3},
                                                                    {offsetof(LightRecord, radius), 1},
                                                                    {offsetof(LightRecord, right), 3},
                                                                    {offsetof(LightRecord, halfWidth), 1},
                                                                    {offsetof(LightRecord, up), 3},
                                                                    {offsetof(LightRecord, halfHeight), 1},
                                                                    {offsetof(LightRecord, cosInnerCone), 1},
                                                                    {offsetof(LightRecord, cosOuterCone), 1},
                                                                    {offsetof(LightRecord, stratumSize), 1},
                                                                    {offsetof(LightRecord, firstView), 1},
                                                                    {offsetof(LightRecord, faces), 1},
                                                                    {offsetof(LightRecord, samples), 1}})
        field(lights, sizeof(LightRecord), offset, count);
    for (const auto& [offset, count] :
         std::initializer_list<std::pair<std::size_t, std::size_t>>{{offsetof(ShadowViewRecord, origin), 3},
                                                                    {offsetof(ShadowViewRecord, texel), 1},
                                                                    {offsetof(ShadowViewRecord, right), 3},
                                                                    {offsetof(ShadowViewRecord, scale), 1},
                                                                    {offsetof(ShadowViewRecord, up), 3},
                                                                    {offsetof(ShadowViewRecord, perspective), 1},
                                                                    {offsetof(ShadowViewRecord, forward), 3},
                                                                    {offsetof(ShadowViewRecord, maxKernel), 1},
                                                                    {offsetof(ShadowViewRecord, tileCenter), 2},
                                                                    {offsetof(ShadowViewRecord, tileHalfSize), 2},
                                                                    {offsetof(ShadowViewRecord, depth), 2},
                                                                    {offsetof(ShadowViewRecord, filterRadius), 1}})
        field(views, sizeof(ShadowViewRecord), offset, count);
    EXPECT_EQ(run(program, {0}, 1, expected.size()), expected);
}

// Not twins in code, but the same laws: form factors by which the device lights, and by which the tests judge it.
TEST_F(Twins, FormFactors) {
    gl::Program program = compile("#include \"light/lights.glsl\"\n", R"(
    vec3 center = nextVec3(), n = nextVec3(), direction = nextVec3(), right = nextVec3(), up = nextVec3();
    put(sphereFormFactorOverRadius2(center, n, nextFloat()));
    put(rectangleFormFactor(center, direction, right, up, n));
)");
    struct Input {
        glm::vec3 center, n, direction, right, up;
        float radius;
    };
    std::vector<Input> inputs;
    Words words;
    for (int i = 0; i < 5000; ++i) {
        Input in{uniform(0.5f, 4) * unit(), unit(), unit(), {}, {}, 0};
        in.right = uniform(0.05f, 2) * glm::normalize(glm::cross(in.direction, unit()));
        in.up = uniform(0.05f, 2) * glm::normalize(glm::cross(in.direction, in.right));
        in.radius = uniform(0.02f, 0.95f) * glm::length(in.center);
        inputs.push_back(in);
        for (const glm::vec3& v : {in.center, in.n, in.direction, in.right, in.up}) push(words, v);
        push(words, in.radius);
    }
    const Words out = run(program, words, 16, 2);
    Results results{out};
    const double kAngles = 1e-4;  // the device's acos and atan are polynomials
    int cut = 0;
    for (const Input& in : inputs) {
        const glm::dvec3 n = glm::normalize(glm::dvec3(in.n)), center(in.center), right(in.right), up(in.up);
        const double radius = static_cast<double>(in.radius);
        const double sphere = test::sphereFactor(glm::dvec3(0), n, center, radius);
        EXPECT_NEAR(static_cast<double>(results.next()) * radius * radius, sphere, kAngles);
        const double height = glm::dot(center, n);
        cut += std::abs(height) < radius;
        const double rectangle =
            glm::dot(center, glm::dvec3(in.direction)) >= 0
                ? 0
                : test::rectangleFactor(glm::dvec3(0), n, center - right - up, 2.0 * right, 2.0 * up);
        EXPECT_NEAR(static_cast<double>(results.next()), rectangle, kAngles);
    }
    EXPECT_GT(cut, 500);
}

TEST_F(Twins, EnvironmentUv) {
    gl::Program program = compile("#include \"shared/environment.glsl\"\n", R"(
    vec3 d = nextVec3();
    vec2 uv = environmentUv(d, nextFloat());
    put(uv.x); put(uv.y);
)");
    std::vector<std::pair<glm::vec3, float>> inputs;
    for (int i = 0; i < 3000; ++i) inputs.emplace_back(unit(), uniform(-400, 400));
    for (const float rotation : {0.0f, 90.0f})
        for (int axis = 0; axis < 3; ++axis)
            for (const float sign : {1.0f, -1.0f}) {
                glm::vec3 d(0);
                d[axis] = sign;
                inputs.emplace_back(d, rotation);
            }
    Words words;
    for (const auto& [d, degrees] : inputs) {
        push(words, d);
        push(words, static_cast<float>(static_cast<double>(degrees) * std::numbers::pi / 180));
    }
    const Words out = run(program, words, 4, 2);
    Results results{out};
    double worstU = 0, worstV = 0;
    for (const auto& [d, degrees] : inputs) {
        Environment environment;
        environment.rotationDeg = static_cast<double>(degrees);
        const glm::vec2 twin = environmentUv(environment, d);
        const float u = results.next(), v = results.next();
        EXPECT_TRUE(u >= 0 && u < 1 && v >= 0 && v < 1) << u << " " << v;
        const double du = std::abs(static_cast<double>(u - twin.x));
        if (std::abs(d.y) < 1) worstU = std::max(worstU, std::min(du, 1 - du));  // at the poles any column will do
        worstV = std::max(worstV, std::abs(static_cast<double>(v - twin.y)));
    }
    std::printf("environmentUv: u off by %.1e, v by %.1e\n", worstU, worstV);
    // A tenth of a texel of a panorama of 2048×1024; the device's atan and acos are polynomials.
    EXPECT_LT(worstU, 0.1 / 2048);
    EXPECT_LT(worstV, 0.1 / 1024);
}

TEST_F(Twins, Rgb9e5) {
    gl::Program program = compile("#include \"shared/rgb9e5.glsl\"\n", R"(
    vec3 c = nextVec3();
    uint bits = packRgb9e5(c);
    put(bits); put(unpackRgb9e5(bits)); put(unpackRgb9e5(nextUint()));
)");
    std::vector<glm::vec3> colors;
    const float infinity = std::numeric_limits<float>::infinity();
    const float special[] = {0.0f,   1e-30f,     1e30f,    infinity, -1.0f,    1.0f,     0.5f,     511.0f,   511.5f,
                             512.0f, kMaxRgb9e5, 65280.0f, 65536.0f, 0x1p-24f, 0x1p-25f, 0x1p-15f, 0x1p-16f, 1e-5f};
    for (const float a : special)
        for (const float b : special) colors.emplace_back(a, b, special[colors.size() % std::size(special)]);
    for (int k = -26; k <= 17; ++k)
        for (const int ulp : {-1, 0, 1}) {
            const float power = std::exp2(static_cast<float>(k));
            colors.emplace_back(ulp == 0 ? power : std::nextafter(power, ulp < 0 ? 0.0f : infinity), power * 0.3f,
                                0.0f);
        }
    for (int i = 0; i < 20000; ++i) {
        const float scale = std::exp2(uniform(-30, 20));
        colors.push_back(scale * color());
    }
    Words words, bits;
    for (const glm::vec3& c : colors) {
        push(words, c);
        bits.push_back(static_cast<std::uint32_t>(random_()));
        words.push_back(bits.back());
    }
    const Words out = run(program, words, 4, 7);
    Results results{out};
    for (std::size_t i = 0; i < colors.size(); ++i) {
        const glm::vec3& c = colors[i];
        const std::uint32_t packed = results.nextUint();
        ASSERT_EQ(packed, packRgb9e5(c)) << c.x << " " << c.y << " " << c.z;
        const glm::vec3 back = results.next3();
        ASSERT_EQ(back, unpackRgb9e5(packed));
        ASSERT_EQ(results.next3(), unpackRgb9e5(bits[i]));
        // The format's own law: nearest of steps that are 1/256 of the largest component at most.
        const glm::vec3 clamped = glm::clamp(c, glm::vec3(0), glm::vec3(kMaxRgb9e5));
        const float largest = std::max(clamped.x, std::max(clamped.y, clamped.z));
        for (int k = 0; k < 3; ++k) ASSERT_NEAR(back[k], clamped[k], 1.0001f * std::max(largest / 511, 0x1p-25f));
    }
}

TEST_F(Twins, Records) {
    for (const bool cas : {false, true})
        for (const bool emission : {false, true})
            for (const bool leaves : {false, true}) {
                gl::Program sizes = compile("#include \"voxelize/sums.glsl\"\n", "put(uint(kFaceWords));",
                                            {{"COMPARE_AND_SWAP", cas ? "1" : "0"},
                                             {"EMISSION", emission ? "1" : "0"},
                                             {"LEAVES", leaves ? "1" : "0"}});
                EXPECT_EQ(run(sizes, {0}, 1, 1)[0], static_cast<std::uint32_t>(faceWords(cas, emission, leaves)));
            }
    gl::Program program = compile("#include \"cascade/records.glsl\"\n", R"(
    vec3 a = nextVec3();
    uint x = nextUint(), y = nextUint(), z = nextUint(), level = nextUint(), moving = nextUint();
    uint bits = nextUint(), other = nextUint();
    put(packAlbedo(a)); put(unpackAlbedo(bits)); put(packPosition(a)); put(unpackPosition(bits));
    put(packCoverage(a)); put(unpackCoverage(bits));
    for (int f = 0; f < 6; ++f) put(faceCoverage(uvec2(bits, other), f));
    uvec2 both = addCoverage(uvec2(bits, other), uvec2(other, packCoverage(a)));
    put(both.x); put(both.y);
    put(packPlace(ivec3(x, y, z), int(level), int(moving)));
    ivec3 texel = placeTexel(bits);
    put(uint(texel.x)); put(uint(texel.y)); put(uint(texel.z));
    put(uint(placeLevel(bits))); put(uint(placeMoves(bits))); put(uint(placeInUse(bits)));
    put(uint(faceHoldsSurface(FaceRecord(0u, 0u, bits))));
)",
                                  {{"COMPARE_AND_SWAP", "0"}, {"EMISSION", "0"}});
    struct Input {
        glm::vec3 a;
        glm::uvec3 texel;
        std::uint32_t level, moving, bits, other;
    };
    std::vector<Input> inputs{{glm::vec3(0), {0, 0, 0}, 0, 0, 0, 0},
                              {glm::vec3(1), {255, 255, 255}, 15, 1, ~0u, ~0u},
                              {glm::vec3(-1, 2, 0.5f), {127, 0, 255}, 7, 0, 0x80000000u, 1}};
    const auto word = [&](std::uint32_t count) { return static_cast<std::uint32_t>(random_()) % count; };
    for (int i = 0; i < 10000; ++i)
        inputs.push_back({1.1f * color() - 0.05f,
                          {word(256), word(256), word(256)},
                          word(16),
                          word(2),
                          static_cast<std::uint32_t>(random_()),
                          static_cast<std::uint32_t>(random_())});
    Words words;
    for (const Input& in : inputs) {
        push(words, in.a);
        words.insert(words.end(), {in.texel.x, in.texel.y, in.texel.z, in.level, in.moving, in.bits, in.other});
    }
    const Words out = run(program, words, 10, 28);
    Results results{out};
    for (const Input& in : inputs) {
        ASSERT_EQ(results.nextUint(), packAlbedo(in.a));
        expectNear(results.next3(), unpackAlbedo(in.bits), 2e-7f, 0);
        ASSERT_EQ(results.nextUint(), packPosition(in.a));
        expectNear(results.next3(), unpackPosition(in.bits), 2e-7f, 0);
        const glm::vec3 inside = glm::clamp(in.a, glm::vec3(0), glm::vec3(1));
        const std::uint32_t coverage = results.nextUint();
        for (int k = 0; k < 3; ++k) ASSERT_NEAR(unpackCoverage(coverage)[k], inside[k], 1.0001 / 2046);
        expectNear(results.next3(), unpackCoverage(in.bits), 2e-7f, 0);
        for (int f = 0; f < 6; ++f) expectNear(results.next(), faceCoverage({in.bits, in.other}, f), 2e-7f, 0);
        for (const auto& [a, b] : {std::pair(in.bits, in.other), std::pair(in.other, coverage)}) {
            // Whole steps, so that the sum is exact up to the clamp.
            const std::uint32_t sum = results.nextUint();
            for (int k = 0; k < 3; ++k) {
                const int shift = 10 * k;
                ASSERT_EQ(sum >> shift & 1023u, std::min((a >> shift & 1023u) + (b >> shift & 1023u), 1023u));
            }
        }
        const glm::ivec3 texel(in.texel);
        const int level = static_cast<int>(in.level);
        const std::uint32_t place = results.nextUint();
        ASSERT_EQ(place, packPlace(texel, level, in.moving != 0));
        EXPECT_EQ(placeTexel(place), texel);
        EXPECT_EQ(placeLevel(place), level);
        EXPECT_EQ(placeMoves(place), in.moving != 0);
        EXPECT_TRUE(placeInUse(place));
        for (int k = 0; k < 3; ++k) ASSERT_EQ(static_cast<int>(results.nextUint()), placeTexel(in.bits)[k]);
        ASSERT_EQ(static_cast<int>(results.nextUint()), placeLevel(in.bits));
        ASSERT_EQ(results.nextUint() != 0, placeMoves(in.bits));
        ASSERT_EQ(results.nextUint() != 0, placeInUse(in.bits));
        FaceRecord face;
        face.position = in.bits;
        ASSERT_EQ(results.nextUint() != 0, faceHoldsSurface(face));
        EXPECT_LT(glm::distance(unpackAlbedo(packAlbedo(in.a)), inside), 1e-3f);
        EXPECT_LT(glm::distance(unpackPosition(packPosition(in.a)), inside), 1e-3f);
    }
    EXPECT_EQ(results.at, out.size());
}

TEST_F(Twins, Counters) {
    gl::Program program = compile(
        "#include \"cascade/buffers.glsl\"\n"
        "layout(std430, binding = COUNTER_STORAGE) buffer Counters { VOXEL_COUNTERS };\n",
        "b_fresh = 1u; b_freshOfLayer[0] = 2u; b_freshOfLayer[1] = 3u; b_freeCount = 4u; b_saturated = 5u;"
        "b_fragments = 6u; b_clamped = 7u; b_brightest = 8u; b_activeFaces = 9u;"
        "for (int i = 0; i < 6; ++i) b_added[i] = uint(10 + i);");
    gl::Buffer counters(sizeof(VoxelCounters));
    counters.clear();
    counters.bindBase(GL_SHADER_STORAGE_BUFFER, kCounterStorage);
    run(program, {0}, 1, 1);
    const VoxelCounters c = counters.read<VoxelCounters>()[0];
    EXPECT_EQ(c.fresh, 1u);
    EXPECT_EQ(c.freshOfLayer[0], 2u);
    EXPECT_EQ(c.freshOfLayer[1], 3u);
    EXPECT_EQ(c.freeCount, 4u);
    EXPECT_EQ(c.saturated, 5u);
    EXPECT_EQ(c.fragments, 6u);
    EXPECT_EQ(c.clamped, 7u);
    EXPECT_EQ(c.brightest, 8u);
    EXPECT_EQ(c.activeFaces, 9u);
    for (std::uint32_t i = 0; i < 6; ++i) EXPECT_EQ(c.added[i], 10 + i);
}

TEST_F(Twins, StorageBlocks) {
    // The block of each macro, by the names that the headers share.
    gl::Program program = compile("#include \"cascade/buffers.glsl\"\n", R"(
    put(uint(COUNTER_STORAGE)); put(uint(PLACE_STORAGE)); put(uint(FACE_STORAGE)); put(uint(COVERAGE_STORAGE));
    put(uint(FREE_STORAGE)); put(uint(EMISSION_STORAGE)); put(uint(FRESH_STORAGE)); put(uint(SUM_STORAGE));
    put(uint(LIST_STORAGE)); put(uint(DIRECT_STORAGE)); put(uint(RADIANCE_STORAGE)); put(uint(LIT_STORAGE));
    put(uint(GATHERED_STORAGE)); put(uint(SAMPLE_STORAGE));
)");
    const Words expected{kCounterStorage,  kPlaceStorage, kFaceStorage,    kCoverageStorage, kFreeStorage,
                         kEmissionStorage, kFreshStorage, kSumStorage,     kListStorage,     kDirectStorage,
                         kRadianceStorage, kLitStorage,   kGatheredStorage, kSampleStorage};
    EXPECT_EQ(run(program, {0}, 1, expected.size()), expected);
}

TEST_F(Twins, ClipmapVolumes) {
    gl::Program program = compile("#include \"cascade/clipmap.glsl\"\n", R"(
    ivec3 i = ivec3(int(nextUint()), int(nextUint()), int(nextUint()));
    int level = int(nextUint());
    ivec3 texel = levelTexel(i, level), plain = levelOrigin(level, 0), bordered = levelOrigin(level, 1);
    for (int k = 0; k < 3; ++k) { put(uint(texel[k])); put(uint(plain[k])); put(uint(bordered[k])); }
    put(uint(levelResolution(level)));
)");
    int columns = 0;
    for (const int resolution : {16, 32, 64, 128, 256})
        for (int levels = 1; levels <= 8; ++levels)
            for (const bool fixedLast : {true, false}) {
                ClipmapLayout layout;
                layout.resolution = resolution;
                layout.levels = levels;
                layout.mips = fixedLast ? std::countr_zero(static_cast<unsigned>(resolution)) - 2 : 3;
                if (resolution >> layout.mips < 1) continue;
                const ClipmapVolume plain(layout, 0), bordered(layout, 1);
                columns = std::max(columns, plain.rows < levels ? 2 : 1);
                ASSERT_EQ(plain.rows, bordered.rows) << resolution << " " << levels << ": one uniform serves both";
                program.set("u_resolution", resolution);
                program.set("u_levels", levels);
                program.set("u_firstFixed", layout.firstFixed());
                program.set("u_rows", plain.rows);
                std::vector<std::pair<glm::ivec3, int>> inputs;
                std::uniform_int_distribution<int> index(-2'000'000, 2'000'000), nearby(-3, resolution + 3);
                for (int level = 0; level < layout.count(); ++level)
                    for (int k = 0; k < 40; ++k) {
                        auto& from = k % 2 ? index : nearby;
                        inputs.emplace_back(glm::ivec3(from(random_), from(random_), from(random_)), level);
                    }
                Words words;
                for (const auto& [i, level] : inputs)
                    for (const int value : {i.x, i.y, i.z, level}) words.push_back(static_cast<std::uint32_t>(value));
                const Words out = run(program, words, 4, 10);
                Results results{out};
                for (const auto& [i, level] : inputs) {
                    const glm::ivec3 texel = plain.texel(i, level);
                    for (int k = 0; k < 3; ++k) {
                        ASSERT_EQ(static_cast<int>(results.nextUint()), texel[k]);
                        ASSERT_EQ(static_cast<int>(results.nextUint()), plain.levelOrigin(level)[k]);
                        ASSERT_EQ(static_cast<int>(results.nextUint()), bordered.levelOrigin(level)[k]);
                        ASSERT_GE(texel[k], 0);
                        ASSERT_LT(texel[k], plain.size()[k]);
                        ASSERT_LT(bordered.texel(i, level)[k] + 1, bordered.size()[k]);
                    }
                    ASSERT_EQ(static_cast<int>(results.nextUint()), layout.resolutionOf(level));
                }
            }
    EXPECT_EQ(columns, 2) << "no layout needs a second column";
}

TEST_F(Twins, ContainmentLevel) {
    gl::Program program =
        compile("#include \"cascade/containment.glsl\"\n", "put(containmentLevel(nextVec3()));", {{"CASCADES", "1"}});
    for (const int levels : {2, 3, 8})
        for (const float band : {0.001f, 0.1f, 0.4f}) {
            const glm::vec3 center(uniform(-50, 50), uniform(-50, 50), uniform(-50, 50));
            const float radius = uniform(5, 60);
            program.set("u_levels", levels);
            program.set("u_cascadeCenter", center);
            program.set("u_cascadeRadius", radius);
            program.set("u_cascadeBand", band);
            program.set("u_cascadeBlend", 1.0f);
            std::vector<glm::vec3> points{center};
            for (int i = 0; i < 4000; ++i) points.push_back(center + radius * std::exp2(uniform(-2, 9)) * unit());
            Words words;
            for (const glm::vec3& p : points) push(words, p);
            const Words out = run(program, words, 3, 1);
            Results results{out};
            int blended = 0;
            for (const glm::vec3& p : points) {
                const float twin = containmentLevel(p - center, radius, band, levels);
                // The slope in the band is its inverse, and a division may be off by some units in the last place.
                ASSERT_NEAR(results.next(), twin, 1e-6f / band) << p.x << " " << p.y << " " << p.z;
                blended += twin != std::floor(twin);
            }
            EXPECT_GT(blended, band > 0.01f ? 20 : 0) << levels << " " << band;
        }
}

TEST_F(Twins, ConeSets) {
    for (const int count : {1, 5, 6, 9, 16, 32}) {
        const ConeSet set = coneSet(count);
        gl::Program program = compile("#include \"cone/cone_set.glsl\"\n", R"(
    int i = int(nextUint());
    float turn = nextFloat(), shift = nextFloat();
    put(coneOfSet(i, turn, shift)); put(u_coneTanHalfAngle);
)",
                                      {{"CONES", std::to_string(count)}, {"SPIRAL", set.spiral ? "1" : "0"}});
        setConeSetUniforms(program, count);
        Words words;
        std::vector<std::array<float, 2>> turns{{0, 0}};
        for (int k = 0; k < 20; ++k) turns.push_back({uniform(0, 1), uniform(-0.5f, 0.5f)});
        for (const auto& [turn, shift] : turns)
            for (int i = 0; i < count; ++i) {
                words.push_back(static_cast<std::uint32_t>(i));
                push(words, turn), push(words, shift);
            }
        const Words out = run(program, words, 3, 5);
        Results results{out};
        for (const auto& [turn, shift] : turns)
            for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
                glm::dvec3 twin = set.directions[i];
                if (set.spiral) {  // the shift moves cos²θ by a part of a stratum
                    const double u = (static_cast<double>(i) + 0.5 + static_cast<double>(shift)) / count;
                    const double grow = std::sqrt(u) / std::hypot(twin.x, twin.y);
                    twin = {grow * twin.x, grow * twin.y, std::sqrt(1 - u)};
                }
                const double angle = 2 * std::numbers::pi * static_cast<double>(turn);
                twin = {std::cos(angle) * twin.x - std::sin(angle) * twin.y,
                        std::sin(angle) * twin.x + std::cos(angle) * twin.y, twin.z};
                const glm::vec3 d = results.next3();
                EXPECT_LT(glm::distance(glm::dvec3(d), twin), 3e-5) << count << ": " << i;
                EXPECT_NEAR(glm::length(d), 1, 1e-5);
                EXPECT_NEAR(results.next(), set.weights[i], 1e-6);
                EXPECT_NEAR(results.next(), set.tanHalfAngle, 1e-6);
            }
    }
}

TEST_F(Twins, TurnsAndShiftsOfASpiralIntegrateTogether) {
    for (const int count : {16, 32}) {
        gl::Program program = compile("#include \"cone/cone_set.glsl\"\n", R"(
    int i = int(nextUint()), k = int(nextUint());
    put(coneOfSet(i, turnOf(k, 16), shiftOf(k, 16)));
)",
                                      {{"CONES", std::to_string(count)}, {"SPIRAL", "1"}});
        setConeSetUniforms(program, count);
        Words words;
        for (std::uint32_t k = 0; k < 16; ++k)
            for (std::uint32_t i = 0; i < static_cast<std::uint32_t>(count); ++i) words.insert(words.end(), {i, k});
        const Words out = run(program, words, 2, 4);
        Results results{out};
        glm::dvec3 mean(0);
        double cosine2 = 0, highest = 0;
        for (int j = 0; j < 16 * count; ++j) {
            const glm::dvec3 d(results.next3());
            const double weight = static_cast<double>(results.next()) / 16;
            mean += weight * d;
            cosine2 += weight * d.z * d.z;
            highest = std::max(highest, d.z);
            EXPECT_GT(d.z, 0);
        }
        EXPECT_NEAR(mean.z, 2.0 / 3, 1e-4);
        EXPECT_NEAR(cosine2, 0.5, 1e-6);
        EXPECT_LT(std::hypot(mean.x, mean.y), 0.02) << "no side of the sky is favoured";
        EXPECT_GT(highest, 0.999);
        std::printf("%d cones in 16 turns: mean cosine 2/3 %+.1e, lean %.1e\n", count, mean.z - 2.0 / 3,
                    std::hypot(mean.x, mean.y));
    }
}

TEST_F(Twins, FramesAreOrthonormal) {
    gl::Program program = compile("#include \"cone/cone_set.glsl\"\n", R"(
    mat3 frame = frameAround(nextVec3());
    put(frame[0]); put(frame[1]); put(frame[2]);
)",
                                  {{"CONES", "16"}, {"SPIRAL", "1"}});
    Words words;
    std::vector<glm::vec3> normals{
        {0, 0, 1}, {0, 0, -1}, {1, 0, 0}, {0, -1, 0}, glm::normalize(glm::vec3(1e-4f, 1e-4f, -1))};
    for (int i = 0; i < 2000; ++i) normals.push_back(unit());
    for (const glm::vec3& n : normals) push(words, n);
    const Words out = run(program, words, 3, 9);
    Results results{out};
    for (const glm::vec3& n : normals) {
        const glm::vec3 t = results.next3(), b = results.next3(), third = results.next3();
        EXPECT_EQ(third, n);
        EXPECT_NEAR(glm::length(t), 1, 1e-5);
        EXPECT_NEAR(glm::length(b), 1, 1e-5);
        EXPECT_NEAR(glm::dot(t, n), 0, 1e-5);
        EXPECT_NEAR(glm::dot(t, b), 0, 1e-5);
        EXPECT_LT(glm::distance(glm::cross(t, b), n), 2e-5f);
    }
}

}  // namespace
}  // namespace voxcone
