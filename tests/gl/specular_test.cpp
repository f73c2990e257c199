// Indirect specular light against numeric integration: the sky over cones, the cones of a lobe, and glossy spheres
// under a sky, whose reflections are known.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include "frame/renderer.h"
#include "gl/buffer.h"
#include "gl/gpu_environment.h"
#include "gl/shader_library.h"
#include "light/specular_table.h"
#include "scene/brdf.h"
#include "scene/environment.h"
#include "support/gl_context.h"
#include "support/shapes.h"

namespace voxcone::test {
namespace {

constexpr double kPi = std::numbers::pi;

/// A smooth sky with a bright half and a narrow sun: `width` x width/2.
Environment panorama(int width) {
    Environment e;
    e.color = glm::vec3(1);
    e.width = width;
    e.height = width / 2;
    const glm::dvec3 sun = glm::normalize(glm::dvec3(0.4, 0.5, 0.8)), half = glm::normalize(glm::dvec3(0.3, 0.2, -0.9));
    for (int y = 0; y < e.height; ++y)
        for (int x = 0; x < e.width; ++x) {
            const double polar = kPi * (y + 0.5) / e.height, around = 2 * kPi * ((x + 0.5) / e.width - 0.5);
            const glm::dvec3 d(std::sin(polar) * std::sin(around), std::cos(polar),
                               -std::sin(polar) * std::cos(around));
            const double step = 1 / (1 + std::exp(-20 * glm::dot(d, half)));
            const double peak = 8 * std::exp(-40 * (1 - glm::dot(d, sun)));
            e.radiance.emplace_back(0.2 + step + peak, 0.3 + 0.5 * d.y * d.y + peak, 0.2 + step);
        }
    return e;
}

/// Unit vectors spread evenly over the cap around `axis`.
std::vector<glm::dvec3> cap(const glm::dvec3& axis, double halfAngle, int count) {
    const glm::dmat4 turn = yTo(axis);
    std::vector<glm::dvec3> out;
    for (int i = 0; i < count; ++i) {
        const double y = 1 - (1 - std::cos(halfAngle)) * (i + 0.5) / count, r = std::sqrt(1 - y * y);
        const double azimuth = i * kPi * (3 - std::sqrt(5.0));
        out.emplace_back(turn * glm::dvec4(r * std::cos(azimuth), y, r * std::sin(azimuth), 0));
    }
    return out;
}

/// Runs the kernel `text` once for each `inWidth` floats of `in`; it writes `outWidth` floats each.
std::vector<float> compute(const std::string& text, const gl::Defines& defines, const std::vector<float>& in,
                           std::size_t inWidth, std::size_t outWidth, const std::function<void(gl::Program&)>& bind) {
    gl::Program program = gl::ShaderLibrary().computeFromText("specular_test.comp", text, defines);
    const std::size_t count = in.size() / inWidth;
    const gl::Buffer source = gl::Buffer::of(in), target(count * outWidth * sizeof(float));
    source.bindBase(GL_SHADER_STORAGE_BUFFER, 0);
    target.bindBase(GL_SHADER_STORAGE_BUFFER, 1);
    program.set("u_count", static_cast<std::uint32_t>(count));
    bind(program);
    gl::dispatch(program, gl::groupsFor(static_cast<int>(count), 64), 1, 1);
    gl::memoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    return target.read<float>();
}

const std::string kHead = R"(
layout(local_size_x = 64) in;
layout(std430, binding = 0) readonly buffer In { float b_in[]; };
layout(std430, binding = 1) writeonly buffer Out { float b_out[]; };
uniform uint u_count;
void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= u_count) return;
)";

using SpecularSky = GlTest;

TEST_F(SpecularSky, IsTheMeanOverTheCone) {
    Environment environment = panorama(128);
    environment.rotationDeg = 30;
    const gl::GpuEnvironment gpu(environment);
    std::mt19937 random(3);
    std::uniform_real_distribution<double> uniform(-1, 1);
    std::vector<glm::dvec3> directions{{0, 1, 0}, {0, -1, 0}, {0.02, 0.9998, 0.01}, {0, -0.999, 0.045}};
    while (directions.size() < 24) {
        const glm::dvec3 d(uniform(random), uniform(random), uniform(random));
        if (glm::length(d) > 0.1 && glm::length(d) < 1) directions.push_back(glm::normalize(d));
    }
    const std::vector<double> angles{0, 0.003, 0.05, 0.098, 0.15, 0.2, 0.3, 0.39, 0.6, 0.785, 1.0, 1.5};
    std::vector<float> in;
    for (const glm::dvec3& d : directions)
        for (const double angle : angles)
            for (const double v : {d.x, d.y, d.z, std::tan(angle)}) in.push_back(static_cast<float>(v));
    const std::vector<float> out =
        compute("#include \"cone/sky.glsl\"\n" + kHead +
                    "vec3 c = skyRadiance(normalize(vec3(b_in[4u * i], b_in[4u * i + 1u], b_in[4u * i + 2u])), b_in[4u "
                    "* i + 3u]);"
                    "b_out[3u * i] = c.r; b_out[3u * i + 1u] = c.g; b_out[3u * i + 2u] = c.b; }",
                {{"SKY", "2"}}, in, 4, 3, [&](gl::Program& program) {
                    gpu.panorama.bindTo(5);
                    program.set("u_environment", 5);
                    program.set("u_environmentColor", gpu.color);
                    program.set("u_environmentRotation", gpu.rotation);
                });
    std::vector<double> squares(angles.size()), worst(angles.size()), truths(angles.size());
    for (std::size_t i = 0; i < directions.size(); ++i)
        for (std::size_t k = 0; k < angles.size(); ++k) {
            glm::dvec3 truth(0);
            const auto samples = cap(directions[i], angles[k], angles[k] == 0 ? 1 : 3000);
            for (const glm::dvec3& d : samples) truth += glm::dvec3(environmentRadiance(environment, d));
            truth /= static_cast<double>(samples.size());
            for (int c = 0; c < 3; ++c) {
                const double error = static_cast<double>(out[3 * (i * angles.size() + k) + c]) - truth[c];
                squares[k] += error * error;
                worst[k] = std::max(worst[k], std::abs(error));
                truths[k] += truth[c];
            }
        }
    const double n = 3.0 * static_cast<double>(directions.size());
    for (std::size_t k = 0; k < angles.size(); ++k) {
        std::printf("sky over a cone of %5.1f degrees: RMSE %.4f, worst %.4f of mean %.3f\n", angles[k] * 180 / kPi,
                    std::sqrt(squares[k] / n), worst[k], truths[k] / n);
        // Texture units weigh with eight bits. Mips that are as wide as the sky have few texels.
        EXPECT_LT(std::sqrt(squares[k] / n), angles[k] < 0.4 ? 0.01 : 0.035) << angles[k];
        EXPECT_LT(worst[k], angles[k] < 0.4 ? 0.025 : 0.12) << angles[k];
    }
}

using SpecularLobe = GlTest;

/// Every weight is the BRDF's over the density, and their mean is the directional albedo.
TEST_F(SpecularLobe, ConesAddUpToTheBrdf) {
    constexpr int kSamples = 4096;
    for (const double alpha : {0.02, 0.25, 0.5, 1.0})
        for (const double cosine : {0.2, 0.6, 1.0}) {
            const glm::vec3 v(static_cast<float>(std::sqrt(1 - cosine * cosine)), 0, static_cast<float>(cosine));
            std::vector<float> in;
            for (int i = 0; i < kSamples; ++i) {
                in.push_back((static_cast<float>(i) + 0.5f) / kSamples);
                in.push_back(static_cast<float>(std::fmod(i * 2.399963229728653, 2 * kPi)));
            }
            const std::vector<float> out =
                compute("#include \"cone/specular_lobe.glsl\"\nuniform vec3 u_v; uniform float u_alpha;\n" + kHead +
                            "Surface s = Surface(vec3(0.0), vec3(0.3, 0.5, 0.1), 1.0, u_alpha);"
                            "LobeSample l = sampleLobe(s, u_v, b_in[2u * i], b_in[2u * i + 1u]);"
                            "b_out[5u * i] = l.direction.x; b_out[5u * i + 1u] = l.direction.y; b_out[5u * i + 2u] = "
                            "l.direction.z;"
                            "b_out[5u * i + 3u] = l.weight; b_out[5u * i + 4u] = l.solidAngle; }",
                        {}, in, 2, 5, [&](gl::Program& program) {
                            program.set("u_v", v);
                            program.set("u_alpha", static_cast<float>(alpha));
                        });
            Surface surface;
            surface.f0 = glm::vec3(0.5f);
            surface.f90 = 1;
            surface.alpha = static_cast<float>(alpha);
            double albedo = 0;
            for (std::size_t i = 0; i < kSamples; ++i) {
                const glm::vec3 l(out[5 * i], out[5 * i + 1], out[5 * i + 2]);
                const double weight = static_cast<double>(out[5 * i + 3]);
                albedo += weight / kSamples;
                if (weight > 0) {
                    const double f = static_cast<double>(evaluateSpecular(surface, {0, 0, 1}, v, l).x * l.z);
                    ASSERT_NEAR(f * static_cast<double>(out[5 * i + 4]), weight, 0.01 * weight + 1e-4)
                        << alpha << " " << cosine;
                }
            }
            const glm::dvec2 parts = specularAlbedo(cosine, alpha, 4096);
            EXPECT_NEAR(albedo, 0.5 * parts.x + parts.y, 0.004) << alpha << " " << cosine;
        }
}

class SpecularSphere : public GlTest {
  protected:
    struct Pixel {
        glm::dvec3 normal, toEye;
        glm::vec3 radiance;
    };

    /// The pixels of a sphere of `material` under the sky, but for its rim, where a pixel's normal is not the mean of
    /// what it covers.
    std::vector<Pixel> render(const Material& material, const Environment& sky) {
        Scene scene = SceneBuilder().add(sphere(1, 4), material).build();
        scene.environment = sky;
        Settings settings;
        settings.output.width = settings.output.height = kSize;
        settings.voxel.resolution = 32;
        settings.light.bounces = 1;
        settings.cone.diffuse = 1;
        const Camera eye = camera({0.6, 0.8, 6}, {0, 0, 0}, 20);
        Renderer renderer(glContext(), scene, settings);
        renderer.render(eye);
        const Image specular = renderer.channel("indirect_specular"), normals = renderer.channel("normal"),
                    positions = renderer.channel("position"), depth = renderer.channel("depth");
        std::vector<Pixel> out;
        for (std::size_t i = 0; i < depth.data.size(); ++i) {
            if (depth.data[i] <= 0) continue;
            const auto at = [&](const Image& image) {
                return glm::vec3(image.data[3 * i], image.data[3 * i + 1], image.data[3 * i + 2]);
            };
            const Pixel pixel{glm::normalize(glm::dvec3(at(normals))),
                              glm::normalize(eye.position - glm::dvec3(at(positions))), at(specular)};
            if (glm::dot(pixel.normal, pixel.toEye) > 0.15) out.push_back(pixel);
        }
        return out;
    }

    static constexpr int kSize = 48;
};

Environment uniformSky() {
    Environment e;
    e.color = glm::vec3(1);
    return e;
}

/// In a uniform sky a sphere reflects its directional albedo. A black one shows what of its own voxels it reflects.
TEST_F(SpecularSphere, WhiteFurnace) {
    for (const float roughness : {0.0f, 0.1f, 0.25f, 0.5f, 0.75f, 1.0f})
        for (const bool metal : {true, false}) {
            const Material material = metal ? glossy(glm::vec3(1), 1, roughness) : glossy(glm::vec3(0), 0, roughness);
            const double alpha = std::max(static_cast<double>(roughness * roughness), static_cast<double>(kMinAlpha));
            double sum = 0, truths = 0, worst = 0;
            for (const Pixel& pixel : render(material, uniformSky())) {
                const glm::dvec2 parts = specularAlbedo(glm::dot(pixel.normal, pixel.toEye), alpha, 256);
                const double truth = metal ? parts.x + parts.y : 0.04 * parts.x + parts.y;
                sum += static_cast<double>(pixel.radiance.x);
                truths += truth;
                worst = std::max(worst, std::abs(static_cast<double>(pixel.radiance.x) / truth - 1));
            }
            std::printf("%s of roughness %.2f: mean %+.2f %%, worst %.1f %%\n", metal ? "metal" : "dielectric",
                        static_cast<double>(roughness), 100 * (sum / truths - 1), 100 * worst);
            EXPECT_NEAR(sum / truths, 1, 0.003) << roughness << metal;
            EXPECT_LT(worst, metal ? 0.005 : 0.03) << roughness << metal;
        }
}

TEST_F(SpecularSphere, MirrorShowsTheSky) {
    const Environment sky = panorama(256);
    double squares = 0, truths = 0;
    std::size_t count = 0;
    for (const Pixel& pixel : render(glossy(glm::vec3(1), 1, 0), sky)) {
        const glm::dvec3 mirrored = 2 * glm::dot(pixel.normal, pixel.toEye) * pixel.normal - pixel.toEye;
        const glm::dvec3 truth = environmentRadiance(sky, mirrored);
        const glm::dvec3 error = glm::dvec3(pixel.radiance) - truth;
        squares += glm::dot(error, error);
        truths += glm::dot(truth, truth);
        ++count;
    }
    EXPECT_GT(count, 800u);
    std::printf("mirror: relative RMSE %.4f\n", std::sqrt(squares / truths));
    EXPECT_LT(std::sqrt(squares / truths), 0.01);
}

/// The whole way of a rough lobe under a sky with a sun: cones, filter, table.
TEST_F(SpecularSphere, RoughOnesShowTheSkyThroughTheBrdf) {
    const Environment sky = panorama(128);
    for (const float roughness : {0.1f, 0.25f, 0.5f, 0.75f, 1.0f}) {
        Surface surface;
        surface.f0 = glm::vec3(1);
        surface.f90 = 1;
        surface.alpha = roughness * roughness;
        double squares = 0, truths = 0, bias = 0, means = 0;
        const std::vector<Pixel> pixels = render(glossy(glm::vec3(1), 1, roughness), sky);
        for (std::size_t i = 0; i < pixels.size(); i += 17) {
            const Pixel& pixel = pixels[i];
            glm::dvec3 truth(0);
            const glm::dmat3 frame(yTo(pixel.normal));
            const glm::dvec3 v = glm::transpose(frame) * pixel.toEye;
            constexpr int kSamples = 2048;
            for (int k = 0; k < kSamples; ++k) {
                // Half-vectors with density D n·h: p(l) = D n·h / (4 v·h).
                const double u = (k + 0.5) / kSamples, a2 = static_cast<double>(surface.alpha) * surface.alpha;
                const double tan2 = a2 * u / (1 - u), c = 1 / std::sqrt(1 + tan2), s = std::sqrt(1 - c * c);
                const double azimuth = k * kPi * (3 - std::sqrt(5.0));
                const glm::dvec3 h(s * std::cos(azimuth), c, s * std::sin(azimuth));
                const double vDotH = glm::dot(v, h);
                if (vDotH <= 0) continue;
                const glm::dvec3 l = 2 * vDotH * h - v;
                if (l.y <= 0) continue;
                const double g = static_cast<double>(
                    smithVisibility(surface.alpha, static_cast<float>(v.y), static_cast<float>(l.y)));
                truth += glm::dvec3(environmentRadiance(sky, frame * l)) * (g * 4 * vDotH * l.y / c / kSamples);
            }
            const glm::dvec3 error = glm::dvec3(pixel.radiance) - truth;
            squares += glm::dot(error, error);
            truths += glm::dot(truth, truth);
            bias += error.x + error.y + error.z;
            means += truth.x + truth.y + truth.z;
        }
        std::printf("roughness %.2f: relative RMSE %.3f, bias %+.2f %%\n", static_cast<double>(roughness),
                    std::sqrt(squares / truths), 100 * bias / means);
        EXPECT_LT(std::sqrt(squares / truths), roughness < 1 ? 0.07 : 0.13) << roughness;
        EXPECT_LT(std::abs(bias / means), 0.01) << roughness;
    }
}

}  // namespace
}  // namespace voxcone::test
