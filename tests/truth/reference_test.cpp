// The path tracer against exact answers: the rows of docs/accuracy.md's table by their names, and laws it must obey.
#include "reference/path_tracer.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <functional>
#include <glm/gtc/constants.hpp>

#include "metric/metrics.h"
#include "scene/brdf.h"
#include "scene/environment.h"
#include "scene/extract.h"
#include "support/shapes.h"

namespace voxcone {
namespace {

using namespace test;

constexpr double kPi = glm::pi<double>();
const glm::dvec3 kUp(0, 1, 0);

Settings withSamples(int samples) {
    Settings settings;
    settings.reference.samples = samples;
    settings.output.width = 16;
    settings.output.height = 16;
    return settings;
}

PathTracer::ProbeResult probeAt(const Scene& scene, const glm::dvec3& position, const glm::dvec3& normal = kUp,
                                int samples = 16384, const Settings& base = {}) {
    Settings settings = base;
    settings.reference.samples = samples;
    return PathTracer(scene).probe({{position, glm::vec3(normal)}}, settings)[0];
}

double opennessAt(const Scene& scene, const glm::dvec3& position, const glm::dvec3& normal = kUp) {
    return probeAt(scene, position, normal, 1 << 16).openness;
}

/// Irradiance from sky, emitters and bounces over π: a form factor when emitters have radiance 1 and reflect nothing.
double formFactorAt(const Scene& scene, const glm::dvec3& position, const glm::dvec3& normal = kUp) {
    return probeAt(scene, position, normal).indirectIrradiance.x / kPi;
}

glm::dvec3 meanOf(const Image& image) {
    glm::dvec3 sum(0);
    const auto pixels = image.data.size() / static_cast<std::size_t>(image.channels);
    for (std::size_t k = 0; k < image.data.size(); ++k)
        sum[static_cast<int>(k) % image.channels] += static_cast<double>(image.data[k]);
    return sum / static_cast<double>(pixels);
}

Light pointLight(const glm::dvec3& position, float intensity) {
    Light light;
    light.position = position;
    light.intensity = glm::vec3(intensity);
    return light;
}

Light sphereLight(const glm::dvec3& position, double radius, float intensity) {
    Light light = pointLight(position, intensity);
    light.type = LightType::sphere;
    light.radius = radius;
    return light;
}

/// Facing down.
Light ceilingLight(const glm::dvec3& position, double width, double height, float radiance) {
    Light light = pointLight(position, radiance);
    light.type = LightType::rectangle;
    light.width = width;
    light.height = height;
    return light;
}

const glm::dmat4 kFaceDown = rotation(180, {1, 0, 0});
const glm::dmat4 kStanding = rotation(90, {1, 0, 0});  // faces +z, its x side stays level

// A: energy in closed spaces.

TEST(ExactAnswers, A1FurnaceConvergesToGeometricSeries) {
    const Scene scene = oneObject(room({1, 2, 3}), lambert(0.5f, 0.5f));
    Settings settings;
    double expected = 0;
    for (const int bounces : {0, 1, 2}) {
        expected = 0.5 + 0.5 * expected;
        settings.reference.maxDepth = bounces + 1;  // the probe itself is the first point of the path
        const double radiance = probeAt(scene, {0.1, -1, 0.3}, kUp, 1 << 14, settings).indirectIrradiance.x / kPi;
        EXPECT_NEAR(radiance, expected, 2e-3) << bounces << " bounces";
    }
    // Roulette leaves a standard error of 0.001 here.
    EXPECT_NEAR(probeAt(scene, {0.1, -1, 0.3}, kUp, 1 << 16).indirectIrradiance.x / kPi, 1, 3e-3);
    const ReferenceImages images = PathTracer(scene).render(camera({0, 0, 0}, {0.3, 0.2, -1}, 90), withSamples(64));
    EXPECT_NEAR(meanOf(images.beauty).x, 1, 3e-3);
    EXPECT_NEAR(meanOf(images.emission).x, 0.5, 1e-6);
}

TEST(ExactAnswers, A2SphereLitFromItsCentre) {
    const Scene scene = SceneBuilder()
                            .add(inwardSphere(1, 5), lambert(0.5f))
                            .light(pointLight({0, 0, 0}, static_cast<float>(kPi)))
                            .build();
    const ReferenceImages images = PathTracer(scene).render(camera({0, 0, 0}, {0.3, 0.2, -1}, 90), withSamples(256));
    EXPECT_NEAR(meanOf(images.direct).x, 0.5, 2e-3);
    EXPECT_NEAR(meanOf(images.beauty).x, 1, 4e-3);
}

TEST(ExactAnswers, A3ParallelPlates) {
    const Scene scene = SceneBuilder()
                            .add(quad(2000, 2000), lambert(0.5f, static_cast<float>(1 / kPi)))
                            .add(quad(2000, 2000), lambert(0.5f), translation({0, 1, 0}) * kFaceDown)
                            .build();
    EXPECT_NEAR(probeAt(scene, {0, 1, 0}, -kUp, 1 << 16).indirectIrradiance.x, 4.0 / 3, 5e-3);
    EXPECT_NEAR(probeAt(scene, {0, 0, 0}, kUp, 1 << 16).indirectIrradiance.x, 2.0 / 3, 5e-3);
}

// B: openness.

TEST(ExactAnswers, B1OpenPlane) {
    const Scene scene = oneObject(quad(1e4, 1e4), lambert(0.0f), rotation(30, {1, 2, 3}), glm::vec3(1));
    const glm::dvec3 normal = glm::dmat3(rotation(30, {1, 2, 3})) * kUp;
    const auto result = probeAt(scene, {0, 0, 0}, normal);
    EXPECT_EQ(result.openness, 1);
    EXPECT_NEAR(result.indirectIrradiance.x, kPi, 1e-5);
}

TEST(ExactAnswers, B2Wall) {
    // A wall in the plane z = 0 that faces +z, its foot at y = 0.
    const auto wall = [](double height) {
        return oneObject(quad(1e4, height), lambert(0.0f), translation({0, height / 2, 0}) * kStanding);
    };
    EXPECT_NEAR(opennessAt(wall(1), {0, 0, 1}), 0.853553, 1e-3);
    EXPECT_NEAR(opennessAt(wall(1e4), {0, 0, 1}), 0.5, 1e-3);
}

TEST(ExactAnswers, B3Corners) {
    SceneBuilder edge;
    edge.add(quad(1e4, 1e4), lambert(0.0f)).add(quad(1e4, 1e4), lambert(0.0f), yTo({1, 0, 0}));
    EXPECT_NEAR(opennessAt(edge.build(), {1, 0, 1}), 0.5, 1e-3);
    edge.add(quad(1e4, 1e4), lambert(0.0f), yTo({0, 0, 1}));
    EXPECT_NEAR(opennessAt(edge.build(), {1, 0, 1}), 0.25, 1e-3);
}

TEST(ExactAnswers, B4HalfPlaneOverhead) {
    const Scene scene = oneObject(quad(1e4, 1e4), lambert(0.0f), translation({-5e3, 1, 0}) * kFaceDown);
    EXPECT_NEAR(opennessAt(scene, {0.5, 0, 0}), 0.723607, 1e-3);
    EXPECT_NEAR(opennessAt(scene, {0, 0, 0}), 0.5, 1e-3);
    EXPECT_NEAR(opennessAt(scene, {-1, 0, 0}), 0.146447, 1e-3);
}

TEST(ExactAnswers, B5AndB6Sphere) {
    const auto factor = [](double cosine) {
        const glm::dvec3 center(std::sqrt(1 - cosine * cosine), cosine, 0);
        const Scene occluder = oneObject(sphere(0.5, 5), lambert(0.0f), translation(center));
        const Scene emitter = oneObject(sphere(0.5, 5), lambert(0.0f, 1), translation(center));
        const double blocked = 1 - opennessAt(occluder, {0, 0, 0});
        EXPECT_NEAR(formFactorAt(emitter, {0, 0, 0}), blocked, 1.5e-3);
        return blocked;
    };
    EXPECT_NEAR(factor(0.8), 0.2, 1e-3);
    EXPECT_NEAR(factor(0.2), 0.0593458, 1e-3);
    EXPECT_NEAR(factor(0), 0.0288344, 1e-3);
    EXPECT_NEAR(factor(-0.2), 0.0093458, 1e-3);
}

TEST(ExactAnswers, B7OpenBox) {
    SceneBuilder box;
    for (const glm::dvec3 side : {glm::dvec3(1, 0, 0), glm::dvec3(-1, 0, 0), glm::dvec3(0, 0, 1), glm::dvec3(0, 0, -1)})
        box.add(quad(1, 1), lambert(0.0f), translation(-0.5 * side + 0.5 * kUp) * yTo(side));
    box.add(quad(1, 1), lambert(0.0f));
    EXPECT_NEAR(opennessAt(box.build(), {0, 0, 0}), 0.239456, 1e-3);
}

// C: form factors, from emitting triangles and from analytic lights.

TEST(ExactAnswers, C1ParallelRectangle) {
    const auto emitter = [](double side, double x) {
        return oneObject(quad(side, side), lambert(0.0f, 1), translation({x, 1, x}) * kFaceDown);
    };
    EXPECT_NEAR(formFactorAt(emitter(1, 0.5), {0, 0, 0}), 0.138532, 5e-4);
    EXPECT_NEAR(formFactorAt(emitter(2, 0), {0, 0, 0}), 0.554126, 1e-3);
    const Scene light = SceneBuilder().light(ceilingLight({0.5, 1, 0.5}, 1, 1, 1)).build();
    EXPECT_NEAR(probeAt(light, {0, 0, 0}).directIrradiance.x / kPi, 0.138532, 5e-4);
    EXPECT_EQ(probeAt(light, {0, 2, 0}, -kUp).directIrradiance.x, 0) << "the back of a rectangle light is dark";
}

TEST(ExactAnswers, C2PerpendicularRectangle) {
    const auto emitter = [](double low, double high, double width) {
        return oneObject(quad(width, high - low), lambert(0.0f, 1),
                         translation({width / 2, (low + high) / 2, -1}) * kStanding);
    };
    EXPECT_NEAR(formFactorAt(emitter(0, 1, 1), {0, 0, 0}), 0.0557342, 3e-4);
    EXPECT_NEAR(formFactorAt(emitter(0, 2, 0.5), {0, 0, 0}), 0.0581339, 3e-4);
    // C3: what lies below the horizon adds nothing.
    EXPECT_NEAR(formFactorAt(emitter(-3, 1, 1), {0, 0, 0}), 0.0557342, 5e-4);
}

TEST(ExactAnswers, C4Disc) {
    const Scene scene = oneObject(disc(1, 512), lambert(0.0f, 1), translation({0, 1, 0}) * kFaceDown);
    EXPECT_NEAR(formFactorAt(scene, {0, 0, 0}), 0.5, 1e-3);
    EXPECT_NEAR(formFactorAt(scene, {0.5, 0, 0}), 0.437983, 1e-3);
    EXPECT_NEAR(formFactorAt(scene, {1, 0, 0}), 0.276393, 1e-3);
}

TEST(ExactAnswers, C5Cap) {
    // A sphere light seen under a half-angle of 30°; its radiance is intensity / (π radius²).
    const Scene scene = SceneBuilder().light(sphereLight({0, 2, 0}, 1, static_cast<float>(kPi))).build();
    EXPECT_NEAR(probeAt(scene, {0, 0, 0}).directIrradiance.x, kPi / 4, 1e-3);
}

TEST(ExactAnswers, DFormFactorsInACube) {
    const auto meanOver = [](const glm::dvec3& side) {  // of a face whose normal is −side, light from the ceiling
        const Scene scene = oneObject(quad(1, 1), lambert(0.0f, 1), translation({0, 0.5, 0}) * kFaceDown);
        const glm::dmat3 frame(yTo(-side));
        std::vector<PathTracer::Probe> probes;
        for (int k = 0; k < 400; ++k) {
            const glm::dvec3 inFace((k % 20 + 0.5) / 20 - 0.5, 0, (k / 20 + 0.5) / 20 - 0.5);
            probes.push_back({0.5 * side + frame * inFace, glm::vec3(-side)});
        }
        double sum = 0;
        for (const auto& result : PathTracer(scene).probe(probes, withSamples(256))) sum += result.indirectIrradiance.x;
        return sum / 400 / kPi;
    };
    EXPECT_NEAR(meanOver({0, -1, 0}), 0.199825, 1e-3);
    EXPECT_NEAR(meanOver({1, 0, 0}), 0.200044, 1.5e-3);
}

TEST(ExactAnswers, K1LightPastAnEdge) {
    // A disc of radius 1 at height 100; the half-plane x < edge at half that height hides what lies left of 2·edge.
    const double height = 100;
    for (const auto& [t, visible] : {std::pair(-0.5, 0.195501), {0.25, 0.657481}, {0.9, 0.981307}}) {
        const double edge = -t / 2;
        SceneBuilder builder;
        builder.add(quad(20, 20), lambert(0.0f), translation({edge - 10, height / 2, 0}));
        SceneBuilder withDisc = builder;
        withDisc.add(disc(1, 512), lambert(0.0f, 1), translation({0, height, 0}) * kFaceDown);
        EXPECT_NEAR(formFactorAt(withDisc.build(), {0, 0, 0}) * height * height, visible, 3e-3);
        builder.light(sphereLight({0, height, 0}, 1, static_cast<float>(height * height)));
        EXPECT_NEAR(probeAt(builder.build(), {0, 0, 0}).directIrradiance.x, visible, 3e-3);
    }
}

TEST(ExactAnswers, K1SunPastAnEdge) {
    // The same from infinity: what is hidden lies left of the edge by the tangent of an angle.
    const double radius = 0.05;
    for (const auto& [t, visible] : {std::pair(-0.5, 0.195501), {0.25, 0.657481}, {0.9, 0.981307}}) {
        Light sun;
        sun.type = LightType::directional;
        sun.angularRadius = radius;
        const Scene scene = SceneBuilder()
                                .add(quad(20, 20), lambert(0.0f), translation({-t * std::tan(radius) - 10, 1, 0}))
                                .light(sun)
                                .build();
        // A disc in the sky is a circle of directions, so a straight edge in a plane is one as well, to second order.
        EXPECT_NEAR(probeAt(scene, {0, 0, 0}).directIrradiance.x, visible, 3e-3) << t;
    }
}

TEST(ExactAnswers, DiscInTheSkyCutByTheHorizon) {
    Light sun;
    sun.type = LightType::directional;
    sun.angularRadius = 0.3;
    sun.direction = {-1, 0, 0};
    const Scene scene = SceneBuilder().light(sun).build();
    // Half a disc in the horizon: B6 with c = 0, over what facing it gives, sin²r.
    const double h = 1 / std::sin(0.3), q = h * h - 1;
    const double half = (-std::sqrt(q) / (h * h) + std::atan(std::sqrt(1 / q))) / kPi / std::pow(std::sin(0.3), 2);
    EXPECT_NEAR(probeAt(scene, {0, 0, 0}).directIrradiance.x, half, 1e-3);
    EXPECT_NEAR(probeAt(scene, {0, 0, 0}, {1, 0, 0}).directIrradiance.x, 1, 1e-3);
}

TEST(ExactAnswers, ExtractedSourcesAreDirectAndNothingElseChanges) {
    Scene scene = SceneBuilder()
                      .add(quad(20, 20), lambert(0.5f))
                      .add(quad(1, 1), lambert(0.5f, 20), translation({0.3, 2, 0}) * kFaceDown)
                      .build();
    scene.environment.color = glm::vec3(1);
    scene.environment.width = 64, scene.environment.height = 32;
    scene.environment.radiance.assign(64 * 32, glm::vec3(0.2f));
    for (const int column : {40, 41})
        scene.environment.radiance[8 * 64 + static_cast<std::size_t>(column)] = glm::vec3(80);
    Scene extracted = scene;
    extractLights(extracted, Settings::Light{});
    ASSERT_EQ(extracted.lights.size(), 2u);
    const auto before = probeAt(scene, {0.1, 0.01, 0.2}, kUp, 1 << 15),
               after = probeAt(extracted, {0.1, 0.01, 0.2}, kUp, 1 << 15);
    EXPECT_EQ(before.directIrradiance.x, 0);
    EXPECT_NEAR(after.directIrradiance.x + after.indirectIrradiance.x, before.indirectIrradiance.x,
                1e-4 * before.indirectIrradiance.x);
    // The lights that stand for both sources, in place of them.
    Scene lights = extracted;
    for (Light& light : lights.lights) light.extracted = false;
    lights.environment = Environment{};
    for (Material& material : lights.materials) material.emission = glm::vec3(0);
    const auto analytic = probeAt(lights, {0.1, 0.01, 0.2}, kUp, 1 << 15);
    EXPECT_NEAR(after.directIrradiance.x, analytic.directIrradiance.x, 0.01 * analytic.directIrradiance.x);
}

TEST(ExactAnswers, L1SealedRoomStaysBlack) {
    const std::vector<Mesh> rooms{room({1, 1, 1}), slabRoom({1, 1, 1}, 0.01), hollowBox({1, 1, 1}, 0.01)};
    for (const Mesh& mesh : rooms) {
        const glm::dmat4 turned = translation({3, 5, 7}) * rotation(37, {1, 2, 3});
        const Scene scene = oneObject(mesh, lambert(0.5f), turned, glm::vec3(1));
        const ReferenceImages images = PathTracer(scene).render(
            camera(glm::dvec3(turned * glm::dvec4(0, 0, 0, 1)), {3.3, 5.2, 8}, 120), withSamples(256));
        EXPECT_EQ(meanOf(images.beauty).x, 0) << mesh.name;
    }
}

// The BRDF.

/// ∫ f(l) dω over the hemisphere of +z by quadrature, stretched towards the mirror direction of `v` for narrow lobes.
template <class F>
double integrateHemisphere(F&& f, int steps = 400) {
    double sum = 0;
    for (int i = 0; i < steps; ++i)
        for (int j = 0; j < 2 * steps; ++j) {
            const double z = (i + 0.5) / steps, phi = kPi * (j + 0.5) / steps, r = std::sqrt(1 - z * z);
            sum += f(glm::vec3(r * std::cos(phi), r * std::sin(phi), z));
        }
    return sum * 2 * kPi / (2.0 * steps * steps);
}

TEST(Brdf, FitsMatchTheIntegrals) {
    const glm::vec3 n(0, 0, 1);
    const Surface surface = surfaceFromMaterial(glm::vec3(0.8f, 0.5f, 0.2f), 0.3f, 0.6f, 1.7f, 0.9f, glm::vec3(1));
    double mean = 0;
    const int steps = 16;
    for (int k = 0; k < steps; ++k) {
        const float cosine = (static_cast<float>(k) + 0.5f) / steps;
        const glm::vec3 v(std::sqrt(1 - cosine * cosine), 0, cosine);
        const double diffuse = integrateHemisphere(
            [&](const glm::vec3& l) { return static_cast<double>(evaluateDiffuse(surface, n, v, l).y * l.z); }, 150);
        const double specular = integrateHemisphere(
            [&](const glm::vec3& l) { return static_cast<double>(evaluateSpecular(surface, n, v, l).y * l.z); }, 150);
        EXPECT_NEAR(diffuse / static_cast<double>(surface.diffuseColor.y), diffuseAlbedoScale(surface, cosine), 1e-4);
        mean += 2 * static_cast<double>(cosine) / steps * (diffuse + specular);
    }
    EXPECT_NEAR(mean, voxelAlbedo(surface).y, 4e-3);
}

TEST(Brdf, LobesAreReciprocal) {
    const Surface surface = surfaceFromMaterial(glm::vec3(0.8f, 0.5f, 0.2f), 0.3f, 0.4f, 1.5f, 1, glm::vec3(1));
    const glm::vec3 n(0, 0, 1), v = glm::normalize(glm::vec3(1, 2, 3)), l = glm::normalize(glm::vec3(-2, 1, 0.5f));
    EXPECT_NEAR(evaluateDiffuse(surface, n, v, l).y, evaluateDiffuse(surface, n, l, v).y, 1e-6);
    EXPECT_NEAR(evaluateSpecular(surface, n, v, l).y, evaluateSpecular(surface, n, l, v).y, 1e-6);
}

/// An open floor under sky 1, seen 22.5° above it: whatever leaves it was reflected once.
ReferenceImages floorUnderSky(const Material& material) {
    const Scene scene = oneObject(quad(1e3, 1e3), material, glm::dmat4(1), glm::vec3(1));
    return PathTracer(scene).render(camera({0, 1, 2.4142136}, {0, 0, 0}, 1), withSamples(64));
}

TEST(Brdf, WhiteFurnaceNeverGainsEnergy) {
    for (const float roughness : {0.0f, 0.2f, 0.5f, 1.0f}) {
        const double metal = meanOf(floorUnderSky(glossy(glm::vec3(1), 1, roughness)).beauty).x;
        EXPECT_LE(metal, 1 + 1e-4) << roughness;
        EXPECT_GE(metal, roughness < 0.3f ? 0.98 : 0.5) << roughness;

        // glTF's two lobes of a dielectric share the light by the half-vector, so only each of them is bounded.
        const ReferenceImages dielectric = floorUnderSky(glossy(glm::vec3(1), 0, roughness));
        const Surface s = surfaceFromMaterial(glm::vec3(1), 0, roughness, 1.5f, 1, glm::vec3(1));
        const float cosine = std::sin(glm::pi<float>() / 8);
        EXPECT_NEAR(meanOf(dielectric.indirectDiffuse).x, diffuseAlbedoScale(s, cosine), 2e-3);
        EXPECT_LE(meanOf(dielectric.indirectSpecular).x, fresnel(s, cosine).x * 1.01 + 0.01) << roughness;
        EXPECT_EQ(meanOf(dielectric.direct).x, 0);
    }
}

TEST(Brdf, LightThroughEachLobeMatchesQuadrature) {
    // A glossy floor under a rectangle: light samples and lobe samples, weighted, must give the integral for every
    // width.
    const glm::dvec3 eye(0, 1, 1.5);
    for (const float roughness : {0.1f, 0.3f, 0.6f, 1.0f}) {
        const Material material = glossy(glm::vec3(0.6f), 0.2f, roughness);
        const Surface surface = surfaceFromMaterial(glm::vec3(0.6f), 0.2f, roughness, 1.5f, 1, glm::vec3(1));
        double expectedDiffuse = 0, expectedSpecular = 0;
        const int steps = 400;
        const glm::vec3 n(0, 1, 0), v(glm::normalize(eye));
        for (int k = 0; k < steps * steps; ++k) {
            const glm::dvec3 p((k % steps + 0.5) / steps - 0.5, 1, (k / steps + 0.5) / steps - 1.5);
            const double d2 = glm::dot(p, p), cosine = p.y / std::sqrt(d2);
            const glm::vec3 l(glm::normalize(p));
            const double weight = cosine * cosine / d2 / (steps * steps);
            expectedDiffuse += weight * evaluateDiffuse(surface, n, v, l).x;
            expectedSpecular += weight * evaluateSpecular(surface, n, v, l).x;
        }
        Settings settings = withSamples(512);
        const Camera view = camera(eye, {0, 0, 0}, 0.01);
        const Scene light =
            SceneBuilder().add(quad(100, 100), material).light(ceilingLight({0, 1, -1}, 1, 1, 1)).build();
        const ReferenceImages lit = PathTracer(light).render(view, settings);
        const double tolerance = 4e-3 * (expectedDiffuse + expectedSpecular);
        EXPECT_NEAR(meanOf(lit.direct).x, expectedDiffuse + expectedSpecular, tolerance) << roughness;
        // The same from triangles: indirect light, by lobe. The emitter reflects nothing itself.
        const Scene triangles = SceneBuilder()
                                    .add(quad(100, 100), material)
                                    .add(quad(1, 1), lambert(0.0f, 1), translation({0, 1, -1}) * kFaceDown)
                                    .build();
        const ReferenceImages indirect = PathTracer(triangles).render(view, settings);
        EXPECT_NEAR(meanOf(indirect.indirectDiffuse).x, expectedDiffuse, tolerance) << roughness;
        EXPECT_NEAR(meanOf(indirect.indirectSpecular).x, expectedSpecular, tolerance) << roughness;
        EXPECT_EQ(meanOf(indirect.direct).x, 0);
    }
}

// Lights and sky.

TEST(Lights, PunctualFalloffs) {
    Light light = pointLight({0, 2, 0}, 8);
    EXPECT_NEAR(probeAt(SceneBuilder().light(light).build(), {0, 0, 0}, kUp, 16).directIrradiance.x, 2, 1e-5);
    light.range = 4;  // window 1 − (2/4)⁴
    EXPECT_NEAR(probeAt(SceneBuilder().light(light).build(), {0, 0, 0}, kUp, 16).directIrradiance.x, 2 * 0.9375, 1e-5);
    light.range = 0;
    light.type = LightType::spot;
    light.innerConeAngle = 0;
    light.outerConeAngle = kPi / 3;
    const Scene spot = SceneBuilder().light(light).build();
    EXPECT_NEAR(probeAt(spot, {0, 0, 0}, kUp, 16).directIrradiance.x, 2, 1e-5);
    EXPECT_EQ(probeAt(spot, {4, 0, 0}, kUp, 16).directIrradiance.x, 0);
    const double cosine = std::sqrt(0.5), falloff = std::pow((cosine - 0.5) / 0.5, 2);
    EXPECT_NEAR(probeAt(spot, {2, 0, 0}, kUp, 16).directIrradiance.x, 8.0 / 8 * cosine * falloff, 1e-5);
    light.type = LightType::directional;
    light.direction = glm::normalize(glm::dvec3(1, -1, 0));
    EXPECT_NEAR(probeAt(SceneBuilder().light(light).build(), {0, 0, 0}, kUp, 16).directIrradiance.x, 8 * cosine, 1e-4);
}

TEST(Lights, AreWhereTheyAreAtTheTime) {
    Light light = pointLight({0, 1, 0}, 1);
    light.track.position = {Interpolation::linear, {0, 1}, {{0, 1, 0}, {0, 2, 0}}};
    light.track.intensity = {Interpolation::linear, {0, 1}, {glm::dvec3(1), glm::dvec3(6)}};
    const Scene scene = SceneBuilder().light(light).build();
    for (const auto& [time, irradiance] : {std::pair(0.0, 1.0), {1.0, 1.5}}) {
        const PathTracer::Probe probe{{0, 0, 0}, glm::vec3(kUp)};
        EXPECT_NEAR(PathTracer(scene, time).probe({probe}, withSamples(64))[0].directIrradiance.x, irradiance, 1e-5);
    }
}

TEST(Lights, ManyLightsAddUp) {
    SceneBuilder builder;
    double expected = 0;
    for (int k = 0; k < 10; ++k) {
        const glm::dvec3 position(0.3 * k - 1, 2, 0.1 * k);
        builder.light(pointLight(position, static_cast<float>(k)));
        expected += k * position.y / std::pow(glm::length(position), 3);
    }
    EXPECT_NEAR(probeAt(builder.build(), {0, 0, 0}).directIrradiance.x, expected, 2e-3 * expected);
}

TEST(Lights, PanoramaIsSampledByItsBrightness) {
    // A dim gradient with a small bright sun, turned; checked against quadrature of the look-up itself.
    Scene scene = oneObject(quad(1, 1), lambert(0.0f), translation({0, -10, 0}));
    Environment& sky = scene.environment;
    sky.color = glm::vec3(2, 1, 0.5f);
    sky.width = 64;
    sky.height = 32;
    sky.rotationDeg = 70;
    for (int k = 0; k < 64 * 32; ++k) sky.radiance.emplace_back(0.1f + 0.01f * static_cast<float>(k % 64));
    sky.radiance[64 * 8 + 20] = glm::vec3(1000);
    const glm::dvec3 normal = glm::normalize(glm::dvec3(1, 3, 1));
    glm::dvec3 expected(0);
    const int steps = 1000;
    for (int i = 0; i < steps; ++i)
        for (int j = 0; j < 2 * steps; ++j) {
            const double y = 1 - 2 * (i + 0.5) / steps, phi = kPi * (j + 0.5) / steps, r = std::sqrt(1 - y * y);
            const glm::dvec3 d(r * std::cos(phi), y, r * std::sin(phi));
            const double cosine = glm::dot(d, normal);
            if (cosine > 0)
                expected += glm::dvec3(environmentRadiance(sky, glm::vec3(d))) * (cosine * 2 * kPi / steps / steps);
        }
    const glm::vec3 irradiance = probeAt(scene, {0, 0, 0}, normal, 4096).indirectIrradiance;
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(irradiance[c] / expected[c], 1, 5e-3);
}

// Surfaces that do not simply reflect.

Texture alphaStripes() {
    Texture texture;
    texture.width = 2;
    texture.height = 1;
    texture.nearest = true;
    texture.rgba8 = {255, 255, 255, 0, 255, 255, 255, 255};
    return texture;
}

TEST(Surfaces, MaskAndBlendLetLightThrough) {
    Material material = lambert(0.0f);
    material.alphaMode = AlphaMode::blend;
    material.baseColor.a = 0.25f;
    SceneBuilder builder;
    builder.add(quad(1e4, 1e4), material, translation({0, 1, 0})).sky(glm::vec3(1));
    EXPECT_NEAR(opennessAt(builder.build(), {0, 0, 0}), 0.75, 0.012);
    builder.add(quad(1e4, 1e4), material, translation({0, 2, 0}));
    const auto two = probeAt(builder.build(), {0, 0, 0});
    EXPECT_NEAR(two.openness, 0.5625, 0.012);
    EXPECT_NEAR(two.indirectIrradiance.x / kPi, 0.5625, 0.012);

    material.baseColor.a = 1;
    material.alphaMode = AlphaMode::mask;
    material.baseColorTexture.texture = 0;
    Scene masked = oneObject(quad(1, 1), material, translation({0, 1e-3, 0}), glm::vec3(1));
    masked.textures.push_back(alphaStripes());
    EXPECT_NEAR(opennessAt(masked, {-0.25, 0, 0}), 1, 2e-3) << "u < ½ is cut out";
    EXPECT_NEAR(opennessAt(masked, {0.25, 0, 0}), 0, 2e-3);
}

TEST(Surfaces, TransparentEmittersShineAsMuchAsTheyCover) {
    Material material = lambert(0.0f, 1);
    material.alphaMode = AlphaMode::blend;
    material.baseColor.a = 0.3f;
    const Scene scene = oneObject(quad(2, 2), material, translation({0, 1, 0}) * kFaceDown);
    EXPECT_NEAR(formFactorAt(scene, {0, 0, 0}), 0.3 * 0.554126, 2e-3);
}

TEST(Surfaces, BacksReflectButDoNotEmitAndTheCameraLooksThrough) {
    const glm::dmat4 above = translation({0, 1, 0});  // faces up, away from the probe
    Material material = lambert(0.5f, 1);
    const Scene oneSided = oneObject(quad(2, 2), material, above);
    EXPECT_NEAR(formFactorAt(oneSided, {0, 0, 0}), 0, 1e-12);
    EXPECT_NEAR(opennessAt(oneSided, {0, 0, 0}), 1 - 0.554126, 1e-3);
    const Camera below = camera({0, 0, 0}, {0, 1, 0}, 10, {0, 0, 1});
    EXPECT_EQ(meanOf(PathTracer(oneSided).render(below, withSamples(2)).depth).x, 0);
    material.doubleSided = true;
    const Scene twoSided = oneObject(quad(2, 2), material, above);
    EXPECT_NEAR(formFactorAt(twoSided, {0, 0, 0}), 0.554126, 1e-3);
    EXPECT_NEAR(meanOf(PathTracer(twoSided).render(below, withSamples(2)).emission).x, 1, 1e-6);

    // Mirroring a node turns the winding, not the side that shows.
    const Scene mirrored = oneObject(quad(2, 2), lambert(0.5f, 1), above * scaling({-1, 1, 1}) * kFaceDown);
    EXPECT_NEAR(formFactorAt(mirrored, {0, 0, 0}), 0.554126, 1e-3);
}

TEST(Surfaces, UnlitShowsItsColourAndAbsorbs) {
    Material material = lambert(0.25f);
    material.unlit = true;
    const Scene scene = SceneBuilder().add(quad(2, 2), material, kFaceDown).light(pointLight({0, -1, 0}, 10)).build();
    const ReferenceImages images =
        PathTracer(scene).render(camera({0, -1, 0}, {0, 0, 0}, 30, {0, 0, 1}), withSamples(4));
    EXPECT_NEAR(meanOf(images.beauty).x, 0.25, 1e-6);
    EXPECT_NEAR(formFactorAt(scene, {0, -1, 0}), 0.25 * 0.554126, 1e-3);
}

TEST(Surfaces, NormalMapTurnsTheNormal) {
    Mesh mesh = quad(10, 10);
    mesh.tangents.assign(mesh.positions.size(), glm::vec4(1, 0, 0, 1));
    Material material = lambert(1.0f);
    material.normalTexture.texture = 0;
    Light sun = pointLight({0, 0, 0}, static_cast<float>(kPi));
    sun.type = LightType::directional;
    sun.direction = {0, -1, 0};
    Scene scene = SceneBuilder().add(mesh, material).light(sun).build();
    Texture map;
    map.width = map.height = 1;
    map.rgba8 = {204, 128, 230, 255};  // about (0.6, 0, 0.8)
    scene.textures.push_back(map);
    const ReferenceImages images =
        PathTracer(scene).render(camera({0, 3, 0}, {0, 0, 0}, 20, {0, 0, -1}), withSamples(2));
    EXPECT_NEAR(meanOf(images.normal).x, 0.6, 5e-3);
    EXPECT_NEAR(meanOf(images.normal).y, 0.8, 5e-3);
    EXPECT_NEAR(meanOf(images.direct).x, 0.8, 5e-3);
}

// Pictures.

/// A furnished box with every kind of light, small enough to render in a blink.
SceneBuilder busyScene() {
    SceneBuilder builder;
    builder.add(room({4, 3, 4}), lambert(glm::vec3(0.7f, 0.6f, 0.5f)))
        .add(box({1, 1, 1}), glossy(glm::vec3(0.8f, 0.3f, 0.2f), 0, 0.3f), translation({-0.75, -1, 0.25}))
        .add(sphere(0.5, 3), glossy(glm::vec3(0.9f), 1, 0.25f), translation({0.75, -1, -0.5}))
        .add(quad(1, 1), lambert(0.0f, 4), translation({0, 1.25, 0}) * kFaceDown)
        .light(pointLight({1, 1, 1}, 2))
        .light(sphereLight({-1, 1, 1}, 0.25, 3))
        .light(ceilingLight({0, 1, -1}, 0.5, 1, 2));
    return builder;
}

const glm::dvec3 kBusyEye(0.25, 0, 1.75), kBusyTarget(0, -0.5, 0);

void expectClose(const Image& a, const Image& b, double tolerance) {
    double squares = 0;
    for (std::size_t k = 0; k < a.data.size(); ++k) squares += std::pow(static_cast<double>(a.data[k] - b.data[k]), 2);
    EXPECT_LE(std::sqrt(squares / static_cast<double>(a.data.size())), tolerance);
}

TEST(Pictures, ChannelsAddUp) {
    const Scene scene = busyScene().build();
    const ReferenceImages images = PathTracer(scene).render(camera(kBusyEye, kBusyTarget, 60), withSamples(16));
    for (std::size_t k = 0; k < images.beauty.data.size(); ++k)
        ASSERT_NEAR(images.beauty.data[k],
                    images.direct.data[k] + images.indirectDiffuse.data[k] + images.indirectSpecular.data[k] +
                        images.emission.data[k],
                    1e-4f * (1 + images.beauty.data[k]));
    EXPECT_GT(meanOf(images.indirectSpecular).x, 0.01);
    EXPECT_EQ(images.samples, 16);
}

TEST(Pictures, GeometryChannels) {
    const Scene scene = oneObject(quad(100, 100), lambert(0.5f), translation({0, -1, 0}), glm::vec3(3));
    const ReferenceImages images = PathTracer(scene).render(camera({0, 0, 0}, {0, 0, -1}, 90), withSamples(2));
    for (int x : {0, 15}) {
        EXPECT_EQ(*images.depth.pixel(x, 0), 0);
        EXPECT_EQ(images.position.pixel(x, 0)[1], 0);
        EXPECT_NEAR(images.beauty.pixel(x, 0)[0], 3, 1e-6) << "background is sky";
        EXPECT_EQ(*images.ao.pixel(x, 0), 1);
        // Row 12's centre looks down by (12.5 − 8)/8 at depth 1.
        EXPECT_NEAR(*images.depth.pixel(x, 12), 1 / 0.5625, 1e-5);
        EXPECT_NEAR(images.position.pixel(x, 12)[0], (x + 0.5 - 8) / 8 / 0.5625, 1e-5);
        EXPECT_NEAR(images.position.pixel(x, 12)[1], -1, 1e-6);
        EXPECT_NEAR(images.normal.pixel(x, 12)[1], 1, 1e-6);
        EXPECT_NEAR(images.albedo.pixel(x, 12)[0], 0.5, 1e-6);
    }
}

TEST(Pictures, ShowDeformedMeshesAtTheirTime) {
    // A floor that morphs into a ramp, and then rises with the one joint that carries it.
    Scene scene = oneObject(quad(4, 4), lambert(0.5f), glm::dmat4(1), glm::vec3(1));
    Mesh& mesh = scene.meshes[0];
    MorphTarget ramp;
    for (const glm::vec3& p : mesh.positions) {
        ramp.positions.emplace_back(0, p.x, 0);
        ramp.normals.emplace_back(-1, 0, 0);
    }
    mesh.morphTargets = {ramp};
    mesh.morphWeights = {0};
    mesh.joints.assign(mesh.positions.size(), {0, 0, 0, 0});
    mesh.jointWeights.assign(mesh.positions.size(), glm::vec4(1, 0, 0, 0));
    scene.nodes.emplace_back();
    scene.skins.push_back({"", {1}, {glm::dmat4(1)}});
    scene.instances[0].skin = 0;
    AnimationChannel morph, rise;
    morph.property = AnimatedProperty::morph_weights;
    morph.times = rise.times = {0, 1};
    morph.weights = {0, 1};
    rise.node = 1;
    rise.values = {glm::vec4(0), glm::vec4(0, 0.5, 0, 0)};
    scene.animations.push_back({"", {morph, rise}});

    // Upright, so that a pixel is a place on x and z: the middle pixels look down within 0.03 of the origin.
    const Camera above = camera({0, 3, 0}, {0, 0, 0}, 10, {0, 0, 1});
    const auto middle = [&](double time) {
        const ReferenceImages images = PathTracer(scene, time).render(above, withSamples(2));
        const float* p = images.position.pixel(8, 8);
        const float* n = images.normal.pixel(8, 8);
        return std::pair(glm::dvec3(p[0], p[1], p[2]), glm::dvec3(n[0], n[1], n[2]));
    };
    EXPECT_NEAR(middle(0).first.y, 0, 1e-5);
    const auto [position, normal] = middle(1);
    EXPECT_NEAR(position.y, 0.5 + position.x, 1e-5);
    EXPECT_NEAR(glm::length(normal - glm::normalize(glm::dvec3(-1, 1, 0))), 0, 1e-5);
}

TEST(Pictures, SupersamplingFiltersByTheRegularGrid) {
    // An edge through a quarter of each pixel of the bottom half's first row: grid 2 has one row of samples on each
    // side.
    const Scene scene = oneObject(quad(2, 2), lambert(0.0f, 1), translation({0, -1, -1}) * yTo({0, 0, 1}));
    Settings settings = withSamples(2);
    settings.output.height = settings.output.width = 17;
    settings.output.supersample = 2;
    const ReferenceImages images = PathTracer(scene).render(camera({0, 0, 0}, {0, 0, -1}, 90), settings);
    EXPECT_EQ(images.samples, 8);
    EXPECT_NEAR(images.emission.pixel(8, 7)[0], 0, 1e-6);
    EXPECT_NEAR(images.emission.pixel(8, 8)[0], 0.5, 1e-6);
    EXPECT_NEAR(images.emission.pixel(8, 9)[0], 1, 1e-6);
}

TEST(Pictures, OcclusionFalloffs) {
    const Scene scene = oneObject(quad(1e5, 1e5), lambert(0.0f), translation({0, 1, 0}) * kFaceDown);
    Settings settings;
    settings.ao.distance = 2;
    // Cosines above ½ meet the ceiling within 2 m: openness ¼ without falloff, and with d = 1/cos below.
    const auto open = [&](AoFalloff falloff) {
        settings.ao.falloff = falloff;
        return probeAt(scene, {0, 0, 0}, kUp, 16384, settings).openness;
    };
    EXPECT_NEAR(open(AoFalloff::none), 0.25, 1e-3);
    EXPECT_NEAR(open(AoFalloff::linear), 0.25 + 0.5, 1e-3);  // ∫ (1/2c) 2c dc over ½…1
    EXPECT_NEAR(open(AoFalloff::square_root), 0.25 + std::sqrt(2.0) * 2 / 3 * (1 - std::pow(0.5, 1.5)), 1e-3);
}

TEST(Pictures, DoNotDependOnTheNumberOfThreads) {
    const Scene scene = busyScene().build();
    const PathTracer tracer(scene);
    const auto render = [&](std::size_t threads) {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        return tracer.render(camera(kBusyEye, kBusyTarget, 60), withSamples(16));
    };
    const ReferenceImages one = render(1), two = render(2);
    EXPECT_EQ(one.beauty.data, two.beauty.data);
    EXPECT_EQ(one.ao.data, two.ao.data);
    EXPECT_EQ(one.beautyError, two.beautyError);
    Settings other = withSamples(16);
    other.reference.seed = 2;
    EXPECT_NE(tracer.render(camera(kBusyEye, kBusyTarget, 60), other).beauty.data, one.beauty.data);
}

TEST(Pictures, DoNotDependOnPlaceOrSize) {
    const Scene scene = busyScene().build();
    const Settings settings = withSamples(16);
    const ReferenceImages here = PathTracer(scene).render(camera(kBusyEye, kBusyTarget, 60), settings);
    const glm::dvec3 far(1e6, -1e6, 1e6);
    const Scene moved = busyScene().transform(translation(far)).build();
    const ReferenceImages there = PathTracer(moved).render(camera(kBusyEye + far, kBusyTarget + far, 60), settings);
    expectClose(there.beauty, here.beauty, 1e-3 * meanOf(here.beauty).x);
    expectClose(there.depth, here.depth, 1e-5);

    for (const double scale : {0x1p-13, 0x1p+20}) {
        Scene scaled = busyScene().transform(scaling(glm::dvec3(scale))).build();
        for (Light& light : scaled.lights)
            if (light.type != LightType::rectangle) light.intensity *= static_cast<float>(scale * scale);
        const ReferenceImages images =
            PathTracer(scaled).render(camera(scale * kBusyEye, scale * kBusyTarget, 60), settings);
        EXPECT_EQ(images.beauty.data, here.beauty.data) << scale;
    }
}

TEST(Pictures, ErrorIsThatOfIndependentRuns) {
    const Scene scene = busyScene().build();
    const PathTracer tracer(scene);
    const Camera view = camera(kBusyEye, kBusyTarget, 60);
    const ReferenceImages truth = tracer.render(view, withSamples(2048));
    const ReferenceImages rough = tracer.render(view, withSamples(32));
    double squares = 0;
    for (std::size_t k = 0; k < truth.beauty.data.size(); ++k)
        squares += std::pow(static_cast<double>(truth.beauty.data[k] - rough.beauty.data[k]), 2);
    const glm::dvec3 mean = meanOf(truth.beauty);
    const double actual =
        std::sqrt(squares / static_cast<double>(truth.beauty.data.size())) / ((mean.x + mean.y + mean.z) / 3);
    EXPECT_GT(rough.beautyError, 0.6 * actual);
    EXPECT_LT(rough.beautyError, 1.6 * actual);
    // What a picture without error shows against a noisy reference.
    for (const auto& [channel, pair] :
         {std::pair("beauty", std::pair(&truth.beauty, &rough.beauty)),
          std::pair("indirect_diffuse", std::pair(&truth.indirectDiffuse, &rough.indirectDiffuse))}) {
        const double shown = linearError(*pair.second, *pair.first).relMse;
        EXPECT_GT(rough.noise.at(channel), 0.7 * shown) << channel;
        EXPECT_LT(rough.noise.at(channel), 1.4 * shown) << channel;
    }
    EXPECT_EQ(rough.noise.at("transmission"), 0);

    Settings adaptive = withSamples(1 << 14);
    adaptive.reference.error = 0.03;
    const ReferenceImages stopped = tracer.render(view, adaptive);
    EXPECT_LE(stopped.beautyError, 0.03);
    EXPECT_LT(stopped.samples, 1 << 14);
}

TEST(Pictures, EmptySceneShowsTheSky) {
    Scene scene;
    scene.environment.color = glm::vec3(0.5f);
    double last = 0;
    const ReferenceImages images =
        PathTracer(scene).render(camera({0, 0, 0}, {0, 0, -1}), withSamples(2), [&](double done) { last = done; });
    EXPECT_NEAR(meanOf(images.beauty).x, 0.5, 1e-6);
    EXPECT_EQ(last, 1);
}

// T: light through matter.

/// Passes all light that its specular lobe does not reflect.
Material glass(float roughness, float ior, float thickness = 0) {
    Material material = glossy(glm::vec3(1), 0, roughness);
    material.transmission = 1;
    material.ior = ior;
    material.thickness = thickness;
    return material;
}

/// Straight down at the origin from a height of 5, within a degree.
ReferenceImages lookDown(const Scene& scene, int samples = 64) {
    return PathTracer(scene).render(camera({0, 5, 0}, {0, 0, 0}, 1, {0, 0, -1}), withSamples(samples));
}

TEST(Transmission, GlassUnderUniformLightCannotBeSeen) {
    const auto beauty = [](const Mesh& mesh, const Material& material) {
        const Scene scene = oneObject(mesh, material, rotation(30, {1, 2, 3}), glm::vec3(1));
        return meanOf(PathTracer(scene).render(camera({0, 0, 4}, {0, 0, 0}, 30), withSamples(256)).beauty).x;
    };
    EXPECT_NEAR(beauty(box({1, 1, 1}), glass(0, 1.5f, 1)), 1, 3e-3);
    EXPECT_NEAR(beauty(box({1, 1, 1}), glass(0, 2.4f, 1)), 1, 1e-2) << "much is totally reflected";
    EXPECT_NEAR(beauty(sphere(1, 5), glass(0, 1.5f, 1)), 1, 1e-2);
    EXPECT_NEAR(beauty(quad(2, 2), glass(0, 1.5f)), 1, 3e-3);
    // Light that a rough surface scatters twice is lost to the model.
    const double rough = beauty(sphere(1, 5), glass(0.3f, 1.5f, 1));
    EXPECT_LT(rough, 1.005);
    EXPECT_GT(rough, 0.95);
}

TEST(Transmission, FresnelAtNormalIncidence) {
    Material sheet = glass(0, 2.0f);  // reflects 1/9
    sheet.baseColor = {0.5f, 0.25f, 1, 1};
    const ReferenceImages images = lookDown(oneObject(quad(2, 2), sheet, glm::dmat4(1), glm::vec3(1)), 1024);
    EXPECT_NEAR(meanOf(images.transmission).x, 0.5 * 8 / 9, 4e-3);
    EXPECT_NEAR(meanOf(images.transmission).y, 0.25 * 8 / 9, 4e-3);
    EXPECT_NEAR(meanOf(images.transmission).z, 8.0 / 9, 6e-3);
    EXPECT_NEAR(meanOf(images.indirectSpecular).x, 1.0 / 9, 4e-3);
    EXPECT_EQ(meanOf(images.indirectDiffuse).x, 0);
}

TEST(Transmission, SlabsAbsorbByBeersLaw) {
    // After a metre half is left, so after 2 m a quarter; between the faces light goes to and fro.
    Material slab = glass(0, 1.5f, 2);
    slab.attenuationColor = {0.5f, 1, 0};
    slab.attenuationDistance = 1;
    for (const double far : {20.0, 20000.0}) {  // in a larger scene the unit of tracing is another
        const Scene scene = SceneBuilder()
                                .add(box({8, 2, 8}), slab)
                                .add(quad(1, 1), lambert(0.0f), translation({far, 0, 0}))
                                .sky(glm::vec3(1))
                                .build();
        const glm::dvec3 transmission = meanOf(lookDown(scene, 1024).transmission);
        const double r = 0.04;
        const auto expected = [&](double left) { return (1 - r) * (1 - r) * left / (1 - r * left); };
        EXPECT_NEAR(transmission.x, expected(0.25), 4e-3);
        EXPECT_NEAR(transmission.y, expected(1), 4e-3);
        EXPECT_NEAR(transmission.z, 0, 1e-3);
    }
    const Scene open = oneObject(quad(8, 8), slab, scaling({2, 2, 2}), glm::vec3(1));
    EXPECT_NEAR(meanOf(lookDown(open, 1024).transmission).x, 0.96 / 16, 1e-3)
        << "a sheet of thickness 2 m, twice as large";
}

TEST(Transmission, RefractionFollowsSnell) {
    // A dark plate below a slab is seen where refraction puts it, and not where the straight way leads.
    const double tilt = 45, ior = 1.5, thickness = 1;
    const double inside = std::asin(std::sin(glm::radians(tilt)) / ior);
    const double there = std::tan(inside) * thickness;  // from where the ray enters, one below
    const auto seen = [&](double place) {
        SceneBuilder builder;
        builder.add(box({20, thickness, 20}), glass(0, 1.5f, 1), translation({0, -thickness / 2, 0}))
            .add(quad(0.1, 0.1), lambert(0.0f, 1.0f), translation({place, -thickness - 1e-3, 0}));
        const Camera oblique = camera({-3, 3, 0}, {0, 0, 0}, 0.5);
        return meanOf(PathTracer(builder.build()).render(oblique, withSamples(64)).transmission).x;
    };
    EXPECT_GT(seen(there), 0.8);
    EXPECT_NEAR(seen(thickness), 0, 0.02);
}

TEST(Transmission, SheetsScatterToTheOtherSide) {
    const Material leaf = greenLeaf();
    const Light sun = sunFromBelow();
    const Scene lit = SceneBuilder().add(quad(4, 4), leaf).light(sun).build();
    EXPECT_NEAR(meanOf(lookDown(lit).direct).x, 2 * 0.25 * 0.5 / kPi, 1e-4);
    EXPECT_NEAR(meanOf(lookDown(lit).direct).y, 2 * 0.25 / kPi, 1e-4);
    EXPECT_EQ(meanOf(lookDown(lit).transmission).x, 0);
    const ReferenceImages sky = lookDown(oneObject(quad(4, 4), leaf, glm::dmat4(1), glm::vec3(1)), 1024);
    EXPECT_NEAR(meanOf(sky.transmission).x, 0.25 * 0.5, 2e-3);
    EXPECT_NEAR(meanOf(sky.indirectDiffuse).x, 0.75 * 0.8, 4e-3);
    // An emitter behind, found by its own samples and by the lobe's: form factor of row C4.
    const Scene lamp =
        SceneBuilder().add(quad(4, 4), leaf).add(disc(1), lambert(0.0f, 1.0f), translation({0, -1, 0})).build();
    EXPECT_NEAR(meanOf(lookDown(lamp, 4096).transmission).y, 0.25 * 0.5, 2e-3);
}

TEST(Transmission, AnalyticLightsShineStraightThrough) {
    Light sun;
    sun.type = LightType::directional;
    sun.direction = {0, -1, 0};
    sun.intensity = glm::vec3(1);
    Material tinted = glass(0.5f, 1.5f);
    tinted.baseColor = {0.5f, 1, 1, 1};
    const auto below = [&](const Mesh& mesh, const Material& material, const Light& light) {
        const Scene scene = SceneBuilder().add(mesh, material, translation({0, 1, 0})).light(light).build();
        return probeAt(scene, {0, 0, 0}).directIrradiance;
    };
    EXPECT_NEAR(below(quad(4, 4), tinted, sun).x, 0.96 * 0.5, 1e-4);
    EXPECT_NEAR(below(quad(4, 4), tinted, sun).y, 0.96, 1e-4);
    tinted.thickness = 1;
    tinted.attenuationColor = {1, 0.5f, 1};
    tinted.attenuationDistance = 1;
    EXPECT_NEAR(below(box({4, 0.5, 4}), tinted, sun).x, 0.96 * 0.96 * 0.25, 1e-4);
    EXPECT_NEAR(below(box({4, 0.5, 4}), tinted, sun).y, 0.96 * 0.96 * std::sqrt(0.5), 1e-4);
    // The same of an area light as of its samples alone: no lobe counts it again.
    const Light lamp = ceilingLight({0, 3, 0}, 0.2, 0.2, 25);
    const double open =
        probeAt(SceneBuilder().add(quad(0.01, 0.01), lambert(0.0f), translation({9, 0, 0})).light(lamp).build(),
                {0, 0, 0})
            .directIrradiance.x;
    EXPECT_NEAR(below(quad(4, 4), glass(0, 1.5f), lamp).x, 0.96 * open, 2e-3 * open);
}

}  // namespace
}  // namespace voxcone
