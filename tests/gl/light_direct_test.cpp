// Light of every type against closed forms (the rows are those of docs/accuracy.md), and its shadows against geometry.
#include <gmock/gmock.h>

#include <cmath>
#include <numbers>

#include "light_lab.h"
#include "scene/extract.h"
#include "scene/light_math.h"
#include "support/shapes.h"

namespace voxcone {
namespace {

using glm::dvec3;
using test::GlTest;
using test::LightLab;
using test::Receiver;

constexpr double kPi = std::numbers::pi;

Light directional(const dvec3& direction, float irradiance = 1) {
    Light light;
    light.type = LightType::directional;
    light.direction = glm::normalize(direction);
    light.intensity = glm::vec3(irradiance);
    return light;
}

Light at(LightType type, const dvec3& position, float intensity = 1) {
    Light light;
    light.type = type;
    light.position = position;
    light.intensity = glm::vec3(intensity);
    return light;
}

Light sphereLight(const dvec3& position, double radius, float intensity = 1) {
    Light light = at(LightType::sphere, position, intensity);
    light.radius = radius;
    return light;
}

/// Faces down, up = +z.
Light panel(const dvec3& position, double width, double height, float radiance = 1) {
    Light light = at(LightType::rectangle, position, radiance);
    light.width = width;
    light.height = height;
    return light;
}

/// A floor of 20 m whose casting nothing hides, so that every answer is the unshadowed one.
Scene floorWith(const Light& light) {
    return test::SceneBuilder().add(test::quad(20, 20), test::lambert(0.5f)).light(light).build();
}

/// The same, with a box of edge 1 that stands on the floor's middle.
Scene boxOnFloor(const Light& light) {
    return test::SceneBuilder()
        .add(test::quad(20, 20), test::lambert(0.5f))
        .add(test::box(dvec3(1)), test::lambert(0.5f), test::translation({0, 0.5, 0}))
        .light(light)
        .build();
}

const glm::vec3 kUp(0, 1, 0);

class LightDirect : public GlTest {};

// ------------------------------------------------------------------------------------------------------------ closed
// forms

TEST_F(LightDirect, DirectionalIsLamberts) {
    LightLab lab(floorWith(directional({0.6, -0.8, 0}, 3)));
    EXPECT_NEAR(lab.irradiance({{{1, 0, 2}, kUp}})[0].x, 3 * 0.8, 1e-5);
    EXPECT_EQ(lab.irradiance({{{1, 0, 2}, -kUp}})[0].x, 0);
}

Light sun(const dvec3& direction, double angularRadius) {
    Light light = directional(direction);
    light.angularRadius = angularRadius;
    return light;
}

TEST_F(LightDirect, DiscInTheSkyIsCutByTheHorizon) {  // B6 at infinity, over sin²r
    for (const double radius : {0.01, 0.3}) {
        LightLab lab(floorWith(sun({0.6, -0.8, 0}, radius)));
        EXPECT_NEAR(lab.unshadowed({{{1, 0, 2}, kUp}})[0].x, 0.8, 1e-5);
        const double h = 1 / std::sin(radius), q = h * h - 1;
        const double half =
            (-std::sqrt(q) / (h * h) + std::atan(std::sqrt(1 / q))) / kPi / std::pow(std::sin(radius), 2);
        EXPECT_NEAR(lab.unshadowed({{{1, 0, 2}, {0.8f, 0.6f, 0}}})[0].x, half, 0.01 * half);
        EXPECT_EQ(lab.unshadowed({{{1, 0, 2}, {0.6f, -0.8f, 0}}})[0].x, 0);
    }
}

TEST_F(LightDirect, EdgeUnderASunIsK1AndAsWideAsK2) {
    // One map for a small sun and several for a large one. The edge lies at x = 0, `height` above the floor.
    for (const auto& [radius, height, bound] : {std::tuple(0.0047, 4.0, 0.05), {0.015, 3.0, 0.05}, {0.1, 1.0, 0.06}}) {
        const Scene scene = test::SceneBuilder()
                                .add(test::quad(8, 8), test::lambert(0.5f))
                                .add(test::quad(3, 6), test::lambert(0.5f), test::translation({-1.5, height, 0}))
                                .light(sun({0, -1, 0}, radius))
                                .build();
        LightLab lab(scene);
        const double unit = height * std::tan(radius);
        std::vector<Receiver> receivers;
        for (double t = -1.5; t <= 1.5; t += 0.05) receivers.push_back({{t * unit, 0, 0.013}, kUp});
        const std::vector<double> visible = lab.visibility(receivers);
        double squares = 0;
        for (std::size_t i = 0; i < receivers.size(); ++i) {
            const double t = std::clamp(receivers[i].position.x / unit, -1.0, 1.0);
            const double expected = 0.5 + (t * std::sqrt(1 - t * t) + std::asin(t)) / kPi;
            squares += std::pow(visible[i] - expected, 2);
        }
        EXPECT_LT(std::sqrt(squares / static_cast<double>(receivers.size())), bound) << radius;
        EXPECT_LT(visible.front(), 0.02) << radius;
        EXPECT_GT(visible.back(), 0.98) << radius;
    }
}

TEST_F(LightDirect, AnExtractedPanelIsC1) {
    // The panel itself lies in the plane of its light, and is no shadow.
    Scene scene = test::SceneBuilder()
                      .add(test::quad(20, 20), test::lambert(0.5f))
                      .add(test::quad(2, 2), test::lambert(0.5f, 3),
                           test::translation({0, 1, 0}) * test::rotation(180, {1, 0, 0}))
                      .build();
    extractLights(scene, Settings::Light{});
    ASSERT_EQ(scene.lights.size(), 1u);
    LightLab lab(scene);
    EXPECT_NEAR(lab.irradiance({{{0, 0, 0}, kUp}})[0].x, 3 * kPi * 0.554126, 1e-3);
    // From below a corner it is a rectangle of A = B = 2.
    const double corner = 2 / std::sqrt(5) * std::atan(2 / std::sqrt(5)) / kPi;
    EXPECT_NEAR(lab.irradiance({{{1, 0, 1}, kUp}})[0].x, 3 * kPi * corner, 1e-3);
}

TEST_F(LightDirect, TheBackOfAPanelDoesNotSeeItsOwnLight) {
    // A voxel knows its surface to half an edge: its back may seem to lie before the light.
    LightLab lab(floorWith(panel({0, 2, 0}, 1, 1)));
    EXPECT_EQ(lab.irradiance({{{0.1, 1.98, 0.1}, kUp}}, 0.05f)[0].x, 0);
    EXPECT_GT(lab.irradiance({{{0.1, 1.9, 0.1}, kUp}}, 0.05f)[0].x, 3);
}

TEST_F(LightDirect, PointFallsWithTheSquare) {
    LightLab lab(floorWith(at(LightType::point, {0, 2, 0}, 5)));
    const std::vector<glm::vec3> e = lab.irradiance({{{0, 0, 0}, kUp}, {{1.5, 0, 0}, kUp}, {{-3, 0, 4}, kUp}});
    EXPECT_NEAR(e[0].x, 5 / 4.0, 1e-5);
    EXPECT_NEAR(e[1].x, 5 * 2 / std::pow(2.5, 3), 1e-5);
    EXPECT_NEAR(e[2].x, 5 * 2 / std::pow(29, 1.5), 1e-5);
}

TEST_F(LightDirect, PointInASphereLightsItEvenly) {  // A2: E = I/R²
    const Scene scene = test::SceneBuilder()
                            .add(test::inwardSphere(1, 4), test::lambert(0.5f))
                            .light(at(LightType::point, dvec3(0), static_cast<float>(kPi)))
                            .build();
    LightLab lab(scene);
    std::vector<Receiver> receivers;
    for (int i = 0; i < 500; ++i) {
        // Points of the tessellated sphere: centroids of its triangles.
        const Mesh& mesh = scene.meshes[0];
        const std::size_t t = static_cast<std::size_t>(i * 7) * 3 % mesh.indices.size();
        const auto corner = [&](std::size_t k) { return dvec3(mesh.positions[mesh.indices[t + k]]); };
        const dvec3 p = (corner(0) + corner(1) + corner(2)) / 3.0;
        receivers.push_back({p, -glm::normalize(p)});
    }
    for (const glm::vec3& e : lab.irradiance(receivers)) EXPECT_NEAR(e.x, kPi, 0.01 * kPi);
}

TEST_F(LightDirect, RangeAndSpotFalloffAreThoseOfTheReference) {
    Light light = at(LightType::spot, {0, 2, 0}, 4);
    light.direction = {0, -1, 0};
    light.range = 5;
    light.innerConeAngle = 0.3;
    light.outerConeAngle = 0.7;
    LightLab lab(floorWith(light));
    for (const double x : {0.0, 0.5, 0.8, 1.0, 1.3, 1.6, 1.75}) {
        const double d2 = x * x + 4, d = std::sqrt(d2);
        const double expected = 4 * 2 / (d2 * d) * rangeWindow(static_cast<float>(d), 5) *
                                spotFalloff(static_cast<float>(2 / d), static_cast<float>(std::cos(0.3)),
                                            static_cast<float>(std::cos(0.7)));
        EXPECT_NEAR(lab.irradiance({{{x, 0, 0}, kUp}})[0].x, expected, 1e-4) << x;
    }
}

TEST_F(LightDirect, SphereAboveTheHorizon) {  // B5; E = I cosθ / D²
    LightLab lab(floorWith(sphereLight({0, 4, 0}, 1, 10)));
    EXPECT_NEAR(lab.irradiance({{{3, 0, 0}, kUp}})[0].x, 10 * 0.8 / 25, 1e-4);
    EXPECT_NEAR(lab.irradiance({{{0, 0, 0}, kUp}})[0].x, 10.0 / 16, 1e-4);
}

TEST_F(LightDirect, SphereAtItsZenithIsACap) {  // C5: E = πL sin²θ, L = I/(πr²)
    LightLab lab(floorWith(sphereLight({0, 2, 0}, 1, static_cast<float>(kPi))));
    EXPECT_NEAR(lab.irradiance({{{0, 0, 0}, kUp}})[0].x, kPi * 0.25, 1e-4);
}

TEST_F(LightDirect, SphereCutByTheHorizon) {  // B6 with D/r = 2: E = I·F/r²
    LightLab lab(floorWith(sphereLight({0, 6, 0}, 1)));
    for (const auto& [c, expected] : {std::pair{0.2, 0.0593458}, {0.0, 0.0288344}, {-0.2, 0.0093458}}) {
        // A receiver in free space at distance 2 below the light, its normal turned to make the cosine.
        const glm::vec3 n(std::sqrt(1 - c * c), c, 0);
        EXPECT_NEAR(lab.irradiance({{{0, 4, 0}, n}})[0].x, expected, 2e-5) << c;
    }
}

TEST_F(LightDirect, RectangleFormFactors) {
    LightLab lab(floorWith(panel({0, 1, 0}, 2, 2)));
    const std::vector<glm::vec3> e = lab.irradiance({{{0, 0, 0}, kUp}, {{1, 0, 1}, kUp}, {{0, 2, 0}, -kUp}});
    EXPECT_NEAR(e[0].x, kPi * 0.554126, 1e-4);  // C1, centre
    EXPECT_NEAR(lab.unshadowed({{{1, 0, 1}, kUp}})[0].x, e[1].x, 1e-5);
    EXPECT_EQ(e[2].x, 0) << "one-sided";

    LightLab corner(floorWith(panel({0.5, 1, 0.5}, 1, 1)));
    EXPECT_NEAR(corner.irradiance({{{0, 0, 0}, kUp}})[0].x, kPi * 0.138532, 1e-4);  // C1 below a corner

    // C2: perpendicular, standing on the receiver's plane, which its horizon only touches; then sunk by half, which the
    // horizon must cut off.
    Light wall = at(LightType::rectangle, {0.5, 0.5, 1});
    wall.direction = {0, 0, -1};
    wall.up = {0, 1, 0};
    wall.width = 1;
    wall.height = 1;
    LightLab standing(floorWith(wall));
    EXPECT_NEAR(standing.unshadowed({{{0, 0, 0}, kUp}})[0].x, kPi * 0.0557342, 1e-4);
    wall.position = {0.5, 0, 1};
    wall.height = 2;
    LightLab sunk(floorWith(wall));
    EXPECT_NEAR(sunk.unshadowed({{{0, 0, 0}, kUp}})[0].x, kPi * 0.0557342, 1e-4);
    wall.position = {0.25, 1, 1};
    wall.width = 0.5;
    LightLab tall(floorWith(wall));
    EXPECT_NEAR(tall.unshadowed({{{0, 0, 0}, kUp}})[0].x, kPi * 0.0581339, 1e-4);
}

// ----------------------------------------------------------------------------------------------------------------
// shadows

/// Whether the segment from `p` to `q` meets the inside of the box of boxOnFloor.
bool boxBetween(const dvec3& p, const dvec3& q) {
    const dvec3 low(-0.5, 0, -0.5), high(0.5, 1, 0.5), d = q - p;
    double enter = 0, leave = 1;
    for (int a = 0; a < 3; ++a) {
        if (d[a] == 0) {
            if (p[a] <= low[a] || p[a] >= high[a]) return false;
            continue;
        }
        const double t0 = (low[a] - p[a]) / d[a], t1 = (high[a] - p[a]) / d[a];
        enter = std::max(enter, std::min(t0, t1));
        leave = std::min(leave, std::max(t0, t1));
    }
    return enter < leave;
}

/// Points of the floor around the box, on both sides of every shadow edge.
std::vector<Receiver> floorGrid(double halfSize, int count) {
    std::vector<Receiver> receivers;
    for (int z = 0; z < count; ++z) {
        for (int x = 0; x < count; ++x) {
            const double step = 2 * halfSize / count;
            receivers.push_back({{-halfSize + (x + 0.371) * step, 0, -halfSize + (z + 0.618) * step}, kUp});
        }
    }
    return receivers;
}

/// Width of a texel on the floor, stretched by the light's slant, at the farthest receiver.
double texelOnFloor(const LightLab& lab, double distance, double cosine) {
    const ShadowViewRecord& view = lab.maps().layout().views[0];
    return static_cast<double>(view.texel) * (view.perspective > 0 ? distance : 1) / cosine;
}

/// Every receiver farther than `tolerance` from a shadow edge is exactly lit or exactly dark.
void expectSharpShadow(LightLab& lab, const std::function<dvec3(const dvec3&)>& lightFrom, double tolerance) {
    const std::vector<Receiver> receivers = floorGrid(3, 200);
    const std::vector<double> seen = lab.visibility(receivers);
    int dark = 0, lit = 0, wrong = 0;
    for (std::size_t i = 0; i < receivers.size(); ++i) {
        const dvec3& p = receivers[i].position;
        bool near = false;
        const bool blocked = boxBetween(p, lightFrom(p));
        for (int k = 0; k < 16 && !near; ++k) {
            const double angle = 2 * kPi * k / 16;
            const dvec3 q = p + tolerance * dvec3(std::cos(angle), 0, std::sin(angle));
            near = boxBetween(q, lightFrom(q)) != blocked;
        }
        if (near) continue;
        (blocked ? dark : lit)++;
        if (seen[i] != (blocked ? 0.0 : 1.0)) {
            if (++wrong <= 5) {
                ADD_FAILURE() << "at " << p.x << ", " << p.z << (blocked ? " blocked " : " lit ") << seen[i];
            }
        }
    }
    EXPECT_EQ(wrong, 0) << "of " << dark + lit;
    EXPECT_GT(dark, 1500);
    EXPECT_GT(lit, 20000);
}

TEST_F(LightDirect, ShadowOfTheSun) {
    const dvec3 direction = glm::normalize(dvec3(1, -1, 0.3));
    LightLab lab(boxOnFloor(directional(direction)));
    const double tolerance = (1.5 + 1) * texelOnFloor(lab, 0, -direction.y);
    EXPECT_LT(tolerance, 0.06);
    expectSharpShadow(
        lab, [&](const dvec3& p) { return p - 100.0 * direction; }, tolerance);
}

TEST_F(LightDirect, ShadowOfASpot) {
    const dvec3 position(-3, 4, 0.5);
    Light light = at(LightType::spot, position);
    light.direction = glm::normalize(-position);
    light.innerConeAngle = 0.8;
    light.outerConeAngle = 0.9;
    LightLab lab(boxOnFloor(light));
    // The cone reaches only a part of the grid: narrow it to receivers whose answer is defined.
    const double tolerance = (1.5 + 1) * texelOnFloor(lab, 6, 0.55);
    EXPECT_LT(tolerance, 0.06);
    for (const Receiver& r : floorGrid(1.2, 60)) {
        const double seen = lab.visibility({r})[0];
        const bool blocked = boxBetween(r.position, position);
        bool near = false;
        for (int k = 0; k < 16; ++k) {
            const double angle = 2 * kPi * k / 16;
            near |=
                boxBetween(r.position + tolerance * dvec3(std::cos(angle), 0, std::sin(angle)), position) != blocked;
        }
        if (!near) {
            ASSERT_EQ(seen, blocked ? 0.0 : 1.0) << r.position.x << ", " << r.position.z;
        }
    }
}

TEST_F(LightDirect, ShadowOfAPoint) {
    const dvec3 position(-2, 3, 0.5);
    LightLab lab(boxOnFloor(at(LightType::point, position)));
    const double tolerance = (1.5 + 1) * texelOnFloor(lab, 6, 0.5);
    EXPECT_LT(tolerance, 0.08);
    expectSharpShadow(
        lab, [&](const dvec3&) { return position; }, tolerance);
}

TEST_F(LightDirect, WideSpotSeesAllSides) {
    Light light = at(LightType::spot, {-2, 3, 0.5});
    light.direction = {0, -1, 0};
    light.innerConeAngle = 1.5;
    light.outerConeAngle = kPi / 2;
    LightLab lab(boxOnFloor(light));
    EXPECT_EQ(lab.maps().layout().views.size(), 6u);
    EXPECT_EQ(lab.visibility({{{1.0, 0, 0}, kUp}})[0], 0);
    EXPECT_EQ(lab.visibility({{{-1.5, 0, 0}, kUp}})[0], 1);
}

/// Part of the irradiance of `light` at a floor point that the box leaves, from `count`² points on its visible side.
double visibleFraction(const Light& light, const dvec3& p, int count) {
    double all = 0, seen = 0;
    for (int i = 0; i < count * count; ++i) {
        const double u = (i % count + 0.5) / count, w = (i / count + 0.5) / count;
        dvec3 q;
        double weight;
        if (light.type == LightType::rectangle) {
            q = light.position + dvec3((u - 0.5) * light.width, 0, (w - 0.5) * light.height);
            const dvec3 d = q - p;
            weight = d.y * d.y / (glm::dot(d, d) * glm::dot(d, d));
        } else {
            // Directions uniform in the cone that the sphere fills.
            const dvec3 axis = glm::normalize(light.position - p);
            const double sin2 = light.radius * light.radius / glm::dot(light.position - p, light.position - p);
            const double cosine = 1 - u * (1 - std::sqrt(1 - sin2)), sine = std::sqrt(1 - cosine * cosine);
            const dvec3 a = glm::normalize(glm::cross(axis, dvec3(0.3, 0.1, 0.9))), b = glm::cross(axis, a);
            const dvec3 d = cosine * axis + sine * (std::cos(2 * kPi * w) * a + std::sin(2 * kPi * w) * b);
            q = p + d * (glm::distance(light.position, p) - light.radius);
            weight = std::max(d.y, 0.0);
        }
        all += weight;
        if (!boxBetween(p, q)) seen += weight;
    }
    return seen / all;
}

/// Compares the soft shadow on the floor with brute force: RMS and 99th percentile of the error. (The worst points are
/// next to the box, where the first surface that the light meets is not the one whose edge casts the penumbra.)
void expectSoftShadow(const Light& light, double rmsBound, double p99Bound) {
    LightLab lab(boxOnFloor(light));
    std::vector<Receiver> receivers = floorGrid(3, 100);
    // Not below the box.
    std::erase_if(receivers,
                  [](const Receiver& r) { return std::abs(r.position.x) < 0.55 && std::abs(r.position.z) < 0.55; });
    const std::vector<double> seen = lab.visibility(receivers);
    double sum = 0;
    int penumbra = 0;
    std::vector<double> errors;
    for (std::size_t i = 0; i < receivers.size(); ++i) {
        const double expected = visibleFraction(light, receivers[i].position, 24);
        if (expected > 0.02 && expected < 0.98) ++penumbra;
        const double error = std::abs(seen[i] - expected);
        sum += error * error;
        errors.push_back(error);
    }
    const double rms = std::sqrt(sum / static_cast<double>(receivers.size()));
    std::sort(errors.begin(), errors.end());
    const double p99 = errors[errors.size() * 99 / 100];
    testing::Test::RecordProperty("rms", std::to_string(rms));
    testing::Test::RecordProperty("p99", std::to_string(p99));
    EXPECT_GT(penumbra, 300);
    EXPECT_LT(rms, rmsBound);
    EXPECT_LT(p99, p99Bound);
}

TEST_F(LightDirect, SoftShadowOfASphere) {
    expectSoftShadow(sphereLight({-2, 3, 0.5}, 0.5), 0.015, 0.08);
}

TEST_F(LightDirect, SoftShadowOfASmallSphere) {  // one sample point and a blocker search
    const Light light = sphereLight({-2, 3, 0.5}, 0.2);
    EXPECT_EQ(LightLab(boxOnFloor(light)).maps().layout().lights[0].samples, 1u);
    expectSoftShadow(light, 0.02, 0.1);
}

TEST_F(LightDirect, SoftShadowOfARectangle) {
    expectSoftShadow(panel({-1.5, 3, 0.5}, 1.2, 0.8), 0.015, 0.06);
}

TEST_F(LightDirect, EdgeOfADiscIsK1) {
    // A half-plane at height 1 below a sphere light at height 3: seen from the floor its edge crosses the disc.
    const Light light = sphereLight({0, 3, 0}, 0.5);
    const Scene scene = test::SceneBuilder()
                            .add(test::quad(20, 20), test::lambert(0.5f))
                            .add(test::quad(10, 20), test::lambert(0.5f), test::translation({-5, 1, 0}))
                            .light(light)
                            .build();
    LightLab lab(scene);
    for (const double t : {-0.9, -0.5, -0.25, 0.0, 0.25, 0.5, 0.9}) {
        // Through (0,1) the floor point x looks at the light's plane at -2x: offset/radius = t.
        const double x = 0.5 * t * 0.5;
        const double expected = 0.5 + (t * std::sqrt(1 - t * t) + std::asin(t)) / kPi;
        EXPECT_NEAR(lab.visibility({{{x, 0, 0.1}, kUp}})[0], expected, 0.06) << t;
    }
}

TEST_F(LightDirect, ThinWallShadesUpToItsFoot) {
    // Grazing light from behind a sheet. At the place whose ray passes the sheet 1.2 texels above the floor no more
    // than the filter's lower half looks past its foot; from 4 texels on nothing does.
    const Light light = directional(glm::normalize(dvec3(1, -0.1, 0)));
    LightLab lab(test::SceneBuilder()
                     .add(test::quad(20, 20), test::lambert(0.5f))
                     .add(test::box(dvec3(1e-3, 1, 10)), test::lambert(0.5f), test::translation({0, 0.5, 0}))
                     .light(light)
                     .build());
    const double texel = lab.maps().layout().views[0].texel;
    double leaked = 0;
    for (int i = 0; i < 16; ++i) {
        const double z = 0.1 * i - 0.8;
        leaked += lab.visibility({{{(1.2 + 0.02 * i) * texel / 0.1, 0, z}, kUp}})[0] / 16;
        EXPECT_EQ(lab.visibility({{{4 * texel / 0.1, 0, z}, kUp}})[0], 0);
    }
    EXPECT_LT(leaked, 0.5);
}

TEST_F(LightDirect, NoAcne) {
    // Planes turned at random, and grazing light: nothing is in the way, so everything is exactly visible.
    std::vector<Light> lights = {directional({std::sin(80 * kPi / 180), -std::cos(80 * kPi / 180), 0}),
                                 directional({-0.1, -1, 0.05}), at(LightType::point, {-9, 1, 3}),
                                 sphereLight({-5, 1, 2}, 0.4), panel({2, 2, 1}, 2, 1)};
    Light spot = at(LightType::spot, {-9, 1.5, 0});
    spot.direction = glm::normalize(dvec3(9, -1.5, 0));
    spot.innerConeAngle = 0.5;
    spot.outerConeAngle = 0.6;
    lights.push_back(spot);
    for (const Light& light : lights) {
        for (const double degrees : {0.0, 17.0, 45.0, 133.0}) {
            const glm::dmat4 turn = test::rotation(degrees, glm::normalize(dvec3(1, 2, -0.7)));
            const Scene scene = test::SceneBuilder()
                                    .add(test::quad(20, 20, 5), test::lambert(0.5f))
                                    .light(light)
                                    .transform(turn)
                                    .build();
            LightLab lab(scene);
            std::vector<Receiver> receivers = floorGrid(9, 60);
            for (Receiver& r : receivers) {
                r.position = dvec3(turn * glm::dvec4(r.position, 1));
                r.normal = glm::vec3(turn * glm::dvec4(r.normal, 0));
            }
            const std::vector<glm::vec3> lit = lab.irradiance(receivers), bare = lab.unshadowed(receivers);
            int acne = 0;
            for (std::size_t i = 0; i < lit.size(); ++i) acne += std::abs(lit[i].x - bare[i].x) > 1e-5f * bare[i].x;
            EXPECT_EQ(acne, 0) << "light type " << static_cast<int>(light.type) << " at " << degrees << " degrees";
        }
    }
}

TEST_F(LightDirect, NoAcneOnASphere) {
    // Tessellated and round: receivers lie on the triangles, geometric normals are the triangles'.
    const Scene scene = test::SceneBuilder()
                            .add(test::sphere(1, 3), test::lambert(0.5f))
                            .light(at(LightType::point, {2, 3, 1}))
                            .build();
    LightLab lab(scene);
    const Mesh& mesh = scene.meshes[0];
    std::vector<Receiver> receivers;
    for (std::size_t t = 0; t < mesh.indices.size(); t += 3) {
        const auto corner = [&](std::size_t k) { return dvec3(mesh.positions[mesh.indices[t + k]]); };
        receivers.push_back({(corner(0) + corner(1) + corner(2)) / 3.0,
                             glm::normalize(glm::cross(corner(1) - corner(0), corner(2) - corner(0)))});
    }
    const std::vector<glm::vec3> lit = lab.irradiance(receivers), bare = lab.unshadowed(receivers);
    for (std::size_t i = 0; i < lit.size(); ++i) EXPECT_NEAR(lit[i].x, bare[i].x, 1e-5f * bare[i].x) << i;
}

TEST_F(LightDirect, NoLeakUnderABox) {
    // Nothing reaches the floor below a box that stands on it, from as near to its edge as the filter looks: the corner
    // of its square, a texel further, along the floor.
    struct Case {
        Light light;
        double distance, cosine;
    };
    for (const auto& [light, distance, cosine] :
         {Case{directional({0.5, -1, 0.2}), 0, 0.88}, Case{directional({1, -0.3, 0.2}), 0, 0.28},
          Case{at(LightType::point, {-2, 3, 0.5}), 4, 0.75}, Case{sphereLight({-2, 3, 0.5}, 0.3), 4, 0.65},
          Case{panel({-1, 3, 0}, 1, 1), 3.6, 0.8}}) {
        LightLab lab(boxOnFloor(light));
        const double inside = 0.5 - std::sqrt(2) * (1.5 + 1) * texelOnFloor(lab, distance, cosine);
        EXPECT_GT(inside, 0.3);
        for (const glm::vec3& e : lab.irradiance(floorGrid(inside, 60))) {
            ASSERT_EQ(e.x, 0) << "light type " << static_cast<int>(light.type);
        }
    }
}

// ---------------------------------------------------------------------------------------------------------------
// invariance

std::vector<Light> oneOfEach() {
    Light spot = at(LightType::spot, {-3, 4, 0.5}, 8);
    spot.direction = glm::normalize(dvec3(3, -4, -0.5));
    spot.innerConeAngle = 0.5;
    spot.outerConeAngle = 0.7;
    return {directional({0.5, -1, 0.2}), at(LightType::point, {-2, 3, 0.5}, 8), spot, sphereLight({-2, 3, 0.5}, 0.5, 8),
            panel({-1, 3, 0.25}, 1, 0.5)};
}

TEST_F(LightDirect, ScaledSceneIsIdentical) {
    for (const Light& light : oneOfEach()) {
        const std::vector<Receiver> receivers = floorGrid(3, 40);
        const std::vector<glm::vec3> expected = LightLab(boxOnFloor(light)).irradiance(receivers);
        for (const double scale : {0x1p-13, 0x1p20}) {
            Light scaled = light;
            if (light.type == LightType::point || light.type == LightType::spot || light.type == LightType::sphere) {
                scaled.intensity *= static_cast<float>(scale * scale);
            }
            const Scene scene = test::SceneBuilder()
                                    .add(test::quad(20, 20), test::lambert(0.5f))
                                    .add(test::box(dvec3(1)), test::lambert(0.5f), test::translation({0, 0.5, 0}))
                                    .light(scaled)
                                    .transform(test::scaling(dvec3(scale)))
                                    .build();
            std::vector<Receiver> moved = receivers;
            for (Receiver& r : moved) r.position *= scale;
            const std::vector<glm::vec3> answer = LightLab(scene).irradiance(moved);
            EXPECT_TRUE(answer == expected) << "light type " << static_cast<int>(light.type) << " scale " << scale;
        }
    }
}

TEST_F(LightDirect, TranslatedSceneIsIdentical) {
    const dvec3 offset(1e6, -2e6, 3e6);
    for (const Light& light : oneOfEach()) {
        std::vector<Receiver> receivers = floorGrid(3, 40);
        const std::vector<glm::vec3> expected = LightLab(boxOnFloor(light)).irradiance(receivers);
        const Scene scene = test::SceneBuilder()
                                .add(test::quad(20, 20), test::lambert(0.5f))
                                .add(test::box(dvec3(1)), test::lambert(0.5f), test::translation({0, 0.5, 0}))
                                .light(light)
                                .transform(test::translation(offset))
                                .build();
        // Positions that a double holds exactly on both sides.
        for (Receiver& r : receivers) r.position = glm::round(r.position * 0x1p20) * 0x1p-20;
        const std::vector<glm::vec3> rounded = LightLab(boxOnFloor(light)).irradiance(receivers);
        for (Receiver& r : receivers) r.position += offset;
        EXPECT_TRUE(LightLab(scene, offset).irradiance(receivers) == rounded)
            << "light type " << static_cast<int>(light.type);
    }
}

// -------------------------------------------------------------------------------------------------------------- the
// maps

TEST_F(LightDirect, AlphaCastsItsPartOfAShadow) {
    const auto seenThrough = [](AlphaMode mode, float alpha) {
        Material material = test::lambert(0.5f);
        material.alphaMode = mode;
        material.baseColor.a = alpha;
        LightLab lab(test::SceneBuilder()
                         .add(test::quad(20, 20), test::lambert(0.5f))
                         .add(test::quad(4, 4), material, test::translation({0, 1, 0}))
                         .light(directional({0, -1, 0}))
                         .build());
        double sum = 0;
        const std::vector<double> seen = lab.visibility(floorGrid(1, 30));
        for (const double v : seen) sum += v;
        return sum / static_cast<double>(seen.size());
    };
    EXPECT_EQ(seenThrough(AlphaMode::opaque, 0.2f), 0);
    EXPECT_DOUBLE_EQ(seenThrough(AlphaMode::mask, 0.2f), 1);
    EXPECT_EQ(seenThrough(AlphaMode::mask, 0.7f), 0);
    EXPECT_NEAR(seenThrough(AlphaMode::blend, 0.25f), 0.75, 0.01);
    EXPECT_NEAR(seenThrough(AlphaMode::blend, 0.8125f), 0.1875, 0.01);
}

TEST_F(LightDirect, BothSidesBlock) {
    for (const double degrees : {0.0, 180.0}) {
        LightLab lab(test::SceneBuilder()
                         .add(test::quad(20, 20), test::lambert(0.5f))
                         .add(test::quad(4, 4), test::lambert(0.5f),
                              test::translation({0, 1, 0}) * test::rotation(degrees, {1, 0, 0}))
                         .light(directional({0, -1, 0}))
                         .build());
        EXPECT_EQ(lab.irradiance({{{0.3, 0, 0.2}, kUp}})[0].x, 0) << degrees;
    }
}

TEST_F(LightDirect, MapsAreKeptWhileNothingMoves) {
    LightLab lab(boxOnFloor(at(LightType::point, {-2, 3, 0.5})));
    gl::PassTimers timers(gl::TimerMode::finish);
    EXPECT_FALSE(lab.maps().update(lab.gpuScene(), timers));
    lab.gpuScene().setTime(1);
    EXPECT_FALSE(lab.maps().update(lab.gpuScene(), timers)) << "time alone moves nothing";
    lab.maps().invalidate();
    EXPECT_TRUE(lab.maps().update(lab.gpuScene(), timers));
}

TEST_F(LightDirect, MapsFollowWhatMoves) {
    // The box leaves the point that it shades.
    Scene movingBox = boxOnFloor(directional({-1, -1, 0}));
    movingBox.nodes[1].hasMatrix = false;
    AnimationChannel channel;
    channel.node = 1;
    channel.times = {0, 1};
    channel.values = {glm::vec4(0, 0.5f, 0, 0), glm::vec4(5, 0.5f, 0, 0)};
    movingBox.animations.push_back({"", {channel}});
    // The light turns until it shades another one.
    Scene movingLight = boxOnFloor(directional({-1, -1, 0}));
    movingLight.lights[0].track.direction = {Interpolation::linear, {0, 1}, {{-1, -1, 0}, {1, -1, 0}}};
    gl::PassTimers timers(gl::TimerMode::finish);
    for (const Scene& scene : {movingBox, movingLight}) {
        LightLab lab(scene);
        const std::vector<Receiver> receiver{{{-1, 0, 0}, kUp}};
        EXPECT_EQ(lab.irradiance(receiver)[0].x, 0);
        lab.gpuScene().setTime(1);
        EXPECT_TRUE(lab.maps().update(lab.gpuScene(), timers));
        EXPECT_NEAR(lab.irradiance(receiver)[0].x, std::sqrt(0.5), 1e-5);
        EXPECT_FALSE(lab.maps().update(lab.gpuScene(), timers));
    }
}

TEST_F(LightDirect, OnlyWhatIsNeeded) {
    LightLab none(test::oneObject(test::quad(1, 1), test::lambert(0.5f)));
    EXPECT_EQ(none.maps().lightCount(), 0);
    EXPECT_EQ(none.maps().bytes(), 0u);
    Settings::Light settings;
    settings.shadowResolution = 512;
    LightLab one(boxOnFloor(directional({0, -1, 0})), dvec3(0), settings);
    EXPECT_EQ(one.maps().layout().views.size(), 1u);
    EXPECT_GE(one.maps().bytes(), 512u * 512u * 4u);
    EXPECT_LT(one.maps().bytes(), 512u * 512u * 4u + 1024u);
}

}  // namespace
}  // namespace voxcone
