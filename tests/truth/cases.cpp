#include "cases.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "frame/renderer.h"
#include "reference/path_tracer.h"
#include "support/closed_forms.h"
#include "support/shapes.h"

namespace voxcone::test {

using glm::dmat4;
using glm::dvec3;

void Errors::add(double value, double truth) {
    values += value, truths += truth, ++count;
    squares += (value - truth) * (value - truth);
    worst = std::max(worst, std::abs(value - truth));
}

void Errors::add(const Errors& other) {
    values += other.values, truths += other.truths, squares += other.squares, count += other.count;
    worst = std::max(worst, other.worst);
}

double Errors::rms() const {
    return std::sqrt(squares / count);
}

namespace {

constexpr double kPi = std::numbers::pi;
const dvec3 kUp(0, 1, 0);
const dmat4 kFaceDown = rotation(180, {1, 0, 0});
const dmat4 kStanding = rotation(90, {1, 0, 0});  // faces +z, its x side stays level

/// Bars that many answers share.
const Bar kOpenness{Figure::rms, {0.05, 0.025}};
const Bar kFormFactor{Figure::relative_mean, {0.03, 0.03}};

Bar missed(Bar bar, double balanced, double accurate) {
    bar.missed = {balanced, accurate};
    return bar;
}

/// A point of a surface in the scene's own space, and what it should gather.
struct Point {
    dvec3 position, normal;
    double truth;
};

enum class Gathered { radiance, openness };

/// Gathers at `points` of a scene that the trial places, and adds the errors to one answer.
void compare(Trial& trial, SceneBuilder scene, const std::vector<Point>& points, Gathered what,
             std::size_t answer = 0) {
    VoxelLab lab(glContext(), scene.transform(trial.placement).build(), trial.settings, trial.voxel);
    std::vector<ConeProbe> probes;
    for (const Point& p : points)
        probes.push_back({dvec3(trial.placement * glm::dvec4(p.position, 1)),
                          glm::vec3(dvec3(trial.placement * glm::dvec4(p.normal, 0)))});
    const std::vector<ConeProbeResult> results = lab.gather(probes);
    for (std::size_t i = 0; i < points.size(); ++i)
        trial.add(answer,
                  what == Gathered::openness ? static_cast<double>(results[i].openness)
                                             : static_cast<double>(results[i].radiance.x),
                  points[i].truth);
}

/// A floor whose upper side is y = 0, as a body.
SceneBuilder floorOf(double sizeX, double sizeZ, float albedo = 0.5f) {
    SceneBuilder scene;
    scene.add(box({sizeX, 1, sizeZ}), lambert(albedo), translation({0, -0.5, 0}));
    return scene;
}

// A: light in closed rooms.

const dvec3 kRoom(3, 2.5, 3.5);

/// Points on the walls of a room around the origin.
std::vector<Point> wallPoints(Trial& trial, const dvec3& inner, int count, double truth) {
    std::vector<Point> points;
    for (int i = 0; i < count; ++i) {
        const int axis = i % 3;
        const double side = i % 2 ? 1 : -1;
        Point p{dvec3(trial.uniform(-0.5, 0.5), trial.uniform(-0.5, 0.5), trial.uniform(-0.5, 0.5)) * inner, dvec3(0),
                truth};
        p.position[axis] = side * inner[axis] / 2;
        p.normal[axis] = -side;
        points.push_back(p);
    }
    return points;
}

/// A solid with a cavity of 16 × 14 × 19 voxels whose walls emit 1/8, which voxels store exactly, and reflect .5 in red
/// and .9 in green.
void furnace(Trial& trial, double wall, const std::function<void(const ConeProbeResult&)>& use) {
    const dvec3 inner = 0.6 * kRoom;
    SceneBuilder scene;
    scene.add(hollowBox(inner, wall * trial.voxel), lambert(glm::vec3(0.5f, 0.9f, 0.5f), glm::vec3(0.125f)));
    VoxelLab lab(glContext(), scene.transform(trial.placement).build(), trial.settings, trial.voxel);
    std::vector<ConeProbe> probes;
    for (const Point& p : wallPoints(trial, inner, 96, 1))
        probes.push_back({dvec3(trial.placement * glm::dvec4(p.position, 1)),
                          glm::vec3(dvec3(trial.placement * glm::dvec4(p.normal, 0)))});
    for (const ConeProbeResult& r : lab.gather(probes)) use(r);
}

/// Walls of one voxel and of four, with the bounces of the preset.
void convergedFurnace(Trial& trial) {
    for (std::size_t thick = 0; thick < 2; ++thick)
        furnace(trial, thick ? 4 : 1, [&](const ConeProbeResult& r) {
            trial.add(2 * thick, static_cast<double>(r.radiance.x), 0.125 / (1 - 0.5));
            trial.add(2 * thick + 1, static_cast<double>(r.radiance.y), 0.125 / (1 - 0.9));
        });
}

void bouncedFurnace(Trial& trial) {
    trial.settings.light.extrapolate = false;
    double truth = 0;
    for (int bounces = 0; bounces < 4; ++bounces) {
        truth = 0.125 + 0.5 * truth;
        trial.settings.light.bounces = bounces;
        furnace(trial, 1, [&](const ConeProbeResult& r) {
            trial.add(static_cast<std::size_t>(bounces), static_cast<double>(r.radiance.x), truth);
        });
    }
}

void litSphere(Trial& trial) {
    const double radius = 1.5;
    Light light;
    light.intensity = glm::vec3(static_cast<float>(kPi * radius * radius));
    SceneBuilder scene;
    scene.add(inwardSphere(radius, 4), lambert(0.5f)).light(light);
    std::vector<Point> points;
    for (int i = 0; i < 32; ++i) {
        dvec3 direction;
        do direction = {trial.uniform(-1, 1), trial.uniform(-1, 1), trial.uniform(-1, 1)};
        while (glm::length(direction) > 1 || glm::length(direction) < 0.1);
        direction = glm::normalize(direction);
        points.push_back({radius * direction, -direction, 1});
    }
    compare(trial, scene, points, Gathered::radiance);
}

// B: openness.

void openPlane(Trial& trial) {
    for (std::size_t sheet = 0; sheet < 2; ++sheet) {
        SceneBuilder scene;
        if (sheet)
            scene.add(quad(6, 6), lambert(0.5f));
        else
            scene = floorOf(6, 6);
        std::vector<Point> points;
        for (int i = 0; i < 32; ++i) points.push_back({{trial.uniform(-2, 2), 0, trial.uniform(-2, 2)}, kUp, 1});
        compare(trial, scene, points, Gathered::openness, sheet);
    }
}

/// A body's own edges do not darken what lies behind them.
void convexEdge(Trial& trial) {
    SceneBuilder scene;
    scene.add(box({3, 3, 3}), lambert(0.5f));
    std::vector<Point> points;
    for (int i = 0; i < 32; ++i)
        points.push_back({{1.5 - trial.uniform(0, 1.5) * trial.voxel, 1.5, trial.uniform(-1.25, 1.25)}, kUp, 1});
    compare(trial, scene, points, Gathered::openness);
}

/// Beside a wall of height 2 and length 8.
void wall(Trial& trial) {
    SceneBuilder scene = floorOf(6, 8);
    scene.add(box({1, 2, 8}), lambert(0.5f), translation({-0.5, 1, 0}));
    std::vector<Point> points;
    for (int i = 0; i < 32; ++i) {
        const dvec3 p(trial.uniform(0.05, 2.5), 0, trial.uniform(-0.5, 0.5));
        points.push_back({p, kUp, 1 - boxFactor(p, kUp, {-1, 0, -4}, {0, 2, 4})});
    }
    compare(trial, scene, points, Gathered::openness);
}

void wallBySixCones(Trial& trial) {
    trial.settings.cone.diffuse = 6;
    wall(trial);
}

/// Where walls 3 high and 5 long meet a floor: two planes far from the third, and all three.
void corner(Trial& trial) {
    for (std::size_t planes = 0; planes < 2; ++planes) {
        SceneBuilder scene;
        scene.add(box({6, 1, 6}), lambert(0.5f), translation({2, -0.5, 2}))
            .add(box({1, 3, 6}), lambert(0.5f), translation({-0.5, 1.5, 2}));
        if (planes == 1) scene.add(box({5, 3, 1}), lambert(0.5f), translation({2.5, 1.5, -0.5}));
        std::vector<Point> points;
        for (int i = 0; i < 32; ++i) {
            const dvec3 p(trial.uniform(0.05, 1), 0, planes == 1 ? trial.uniform(0.05, 1) : trial.uniform(1.5, 2.5));
            double open =
                1 - rectangleFactor(p, kUp, {0, 0, planes == 1 ? 0 : -1}, {0, 3, 0}, {0, 0, planes == 1 ? 5 : 6});
            if (planes == 1) open -= rectangleFactor(p, kUp, {0, 0, 0}, {0, 3, 0}, {5, 0, 0});
            points.push_back({p, kUp, open});
        }
        compare(trial, scene, points, Gathered::openness, planes);
    }
}

/// A sheet overhead at height 1, from its middle to far outside.
void roof(Trial& trial) {
    SceneBuilder scene = floorOf(10, 8);
    scene.add(quad(5, 8), lambert(0.5f), translation({-2.5, 1, 0}));
    std::vector<Point> points;
    for (int i = 0; i < 32; ++i) {
        const dvec3 p(trial.uniform(-1.5, 1.5), 0, trial.uniform(-0.5, 0.5));
        points.push_back({p, kUp, 1 - rectangleFactor(p, kUp, {-5, 1, -4}, {5, 0, 0}, {0, 0, 8})});
    }
    compare(trial, scene, points, Gathered::openness);
}

/// Points of a floor at a distance from the foot of a sphere's axis, where it hides `factor`.
void sphereOverFloor(Trial& trial, double height, double least, double most, std::size_t answer) {
    SceneBuilder scene = floorOf(8, 8);
    scene.add(sphere(1), lambert(0.5f), translation({0, height, 0}));
    std::vector<Point> points;
    for (int i = 0; i < 32; ++i) {
        const double distance = trial.uniform(least, most), azimuth = trial.uniform(0, 2 * kPi);
        const dvec3 p(distance * std::cos(azimuth), 0, distance * std::sin(azimuth));
        points.push_back({p, kUp, 1 - sphereFactor(p, kUp, {0, height, 0}, 1)});
    }
    compare(trial, scene, points, Gathered::openness, answer);
}

void spheresAbove(Trial& trial) {
    sphereOverFloor(trial, 1.6, 1.2, 1.2, 0);
    sphereOverFloor(trial, 1 + 3 * trial.voxel, 0, 2, 1);
}

void spheresCut(Trial& trial) {
    const double cosines[] = {0.2, 0, -0.2};
    for (std::size_t i = 0; i < 3; ++i) {
        const double away = 2 * std::sqrt(1 - cosines[i] * cosines[i]);
        sphereOverFloor(trial, 2 * cosines[i], away, away, i);
    }
}

/// An open box of inner edge 2: the middle of its floor, and all of it.
void openBox(Trial& trial) {
    SceneBuilder scene = floorOf(2.5, 2.5);
    for (const double side : {-1.0, 1.0}) {
        scene.add(box({0.25, 2, 2.5}), lambert(0.5f), translation({side * 1.125, 1, 0}));
        scene.add(box({2, 2, 0.25}), lambert(0.5f), translation({0, 1, side * 1.125}));
    }
    const auto open = [](const dvec3& p) { return rectangleFactor(p, kUp, {-1, 2, -1}, {2, 0, 0}, {0, 0, 2}); };
    compare(trial, scene, {{dvec3(0), kUp, open(dvec3(0))}}, Gathered::openness, 0);
    std::vector<Point> points;
    for (int i = 0; i < 32; ++i) {
        const dvec3 p(trial.uniform(-1, 1), 0, trial.uniform(-1, 1));
        points.push_back({p, kUp, open(p)});
    }
    compare(trial, scene, points, Gathered::openness, 1);
}

/// Leaves of 2 to 4 voxels in all directions over a floor. The truth is the path tracer's, of the same leaves.
void foliage(Trial& trial) {
    Material leaf = lambert(0.5f);
    leaf.doubleSided = true;
    leaf.alphaMode = AlphaMode::mask;
    SceneBuilder scene = floorOf(6, 6);
    for (int i = 0; i < 220; ++i) {
        dvec3 normal;
        do normal = {trial.uniform(-1, 1), trial.uniform(-1, 1), trial.uniform(-1, 1)};
        while (glm::length(normal) > 1 || glm::length(normal) < 0.1);
        const double size = trial.uniform(2, 4) * trial.voxel;
        scene.add(quad(size, size), leaf,
                  translation({trial.uniform(-2, 2), trial.uniform(0.5, 2), trial.uniform(-2, 2)}) * yTo(normal));
    }
    Settings settings;
    settings.reference.samples = 4096;
    std::vector<PathTracer::Probe> probes;
    for (int i = 0; i < 32; ++i) probes.push_back({{trial.uniform(-1.5, 1.5), 0, trial.uniform(-1.5, 1.5)}, kUp});
    const Scene still = scene.build();
    const auto truths = PathTracer(still).probe(probes, settings);
    std::vector<Point> points;
    for (std::size_t i = 0; i < probes.size(); ++i)
        points.push_back({probes[i].position, kUp, static_cast<double>(truths[i].openness)});
    compare(trial, scene, points, Gathered::openness);
}

/// Four sheets of opacity 1/4 a voxel apart, by the preset's rule of compositing and by those of other fields.
void slab(Trial& trial) {
    Material mist = lambert(0.5f);
    mist.alphaMode = AlphaMode::blend;
    mist.doubleSided = true;
    mist.baseColor.a = 0.25f;
    SceneBuilder scene = floorOf(6, 6);
    for (int layer = 0; layer < 4; ++layer) scene.add(quad(6, 6), mist, translation({0, 0.5 + layer * trial.voxel, 0}));
    Settings settings;
    settings.reference.samples = 4096;
    std::vector<PathTracer::Probe> probes;
    for (int i = 0; i < 16; ++i) probes.push_back({{trial.uniform(-0.5, 0.5), 0, trial.uniform(-0.5, 0.5)}, kUp});
    const Scene still = scene.build();
    const auto truths = PathTracer(still).probe(probes, settings);
    std::vector<Point> points;
    for (std::size_t i = 0; i < probes.size(); ++i)
        points.push_back({probes[i].position, kUp, static_cast<double>(truths[i].openness)});
    compare(trial, scene, points, Gathered::openness, 0);
    trial.settings.cone.compositing = Compositing::exponential;
    trial.settings.cone.gain = 1;
    compare(trial, scene, points, Gathered::openness, 1);
    trial.settings.cone.step *= 0.5;
    compare(trial, scene, points, Gathered::openness, 2);
}

// C and D: form factors of emitters, gathered as radiance.

void parallelRectangle(Trial& trial) {
    SceneBuilder one = floorOf(4, 4, 0), large = one;
    one.add(quad(1, 1), lambert(0, 1), translation({0, 1, 0}) * kFaceDown);
    large.add(quad(2, 2), lambert(0, 1), translation({0, 1, 0}) * kFaceDown);
    std::vector<Point> corners;
    for (const double x : {-0.5, 0.5})
        for (const double z : {-0.5, 0.5}) corners.push_back({{x, 0, z}, kUp, 0.138532});
    compare(trial, one, corners, Gathered::radiance, 0);
    compare(trial, large, {{dvec3(0), kUp, 0.554126}}, Gathered::radiance, 1);
}

/// A rectangle standing at z = -1, of some width and from some depth below the floor.
void standingRectangle(Trial& trial, double low, double high, double width, double truth, std::size_t answer) {
    SceneBuilder scene = floorOf(4, 4, 0);
    scene.add(quad(width, high - low), lambert(0, 1), translation({0, (low + high) / 2, -1}) * kStanding);
    compare(trial, scene, {{{width / 2, 0, 0}, kUp, truth}, {{-width / 2, 0, 0}, kUp, truth}}, Gathered::radiance,
            answer);
}

void standingRectangles(Trial& trial) {
    standingRectangle(trial, 0, 1, 1, 0.0557342, 0);
    standingRectangle(trial, 0, 2, 0.5, 0.0581339, 1);
}

void sunkRectangle(Trial& trial) {
    standingRectangle(trial, -0.9, 1, 1, 0.0557342, 0);
}

void discAbove(Trial& trial) {
    const double offsets[] = {0, 0.5, 1}, truths[] = {0.5, 0.437983, 0.276393};
    for (std::size_t i = 0; i < 3; ++i) {
        SceneBuilder scene = floorOf(4, 4, 0);
        scene.add(disc(1), lambert(0, 1), translation({0, 1, 0}) * kFaceDown);
        std::vector<Point> points;
        for (int k = 0; k < 4; ++k) {
            const double azimuth = trial.uniform(0, 2 * kPi);
            points.push_back({{offsets[i] * std::cos(azimuth), 0, offsets[i] * std::sin(azimuth)}, kUp, truths[i]});
        }
        compare(trial, scene, points, Gathered::radiance, i);
    }
}

void cap(Trial& trial) {
    SceneBuilder scene = floorOf(4, 4, 0);
    scene.add(sphere(1), lambert(0, 1), translation({0, 2, 0}));
    compare(trial, scene, {{dvec3(0), kUp, 0.25}}, Gathered::radiance);
}

/// A black cube of inner edge 2 whose ceiling emits.
void cube(Trial& trial) {
    SceneBuilder scene;
    scene.add(box({2.5, 0.25, 2.5}), lambert(0), translation({0, -1.125, 0}))
        .add(box({2.5, 0.25, 2.5}), lambert(0, 1), translation({0, 1.125, 0}));
    for (const double side : {-1.0, 1.0}) {
        scene.add(box({0.25, 2, 2.5}), lambert(0), translation({side * 1.125, 0, 0}));
        scene.add(box({2, 2, 0.25}), lambert(0), translation({0, 0, side * 1.125}));
    }
    // Every point has its own answer: their means are the factors of the table.
    std::vector<Point> bottom, side;
    for (int i = 0; i < 8; ++i)
        for (int k = 0; k < 8; ++k) {
            const double u = -1 + (i + trial.uniform(0, 1)) / 4, v = -1 + (k + trial.uniform(0, 1)) / 4;
            const dvec3 ceiling(-1, 1, -1), x(2, 0, 0), z(0, 0, 2), right(1, 0, 0);
            bottom.push_back({{u, -1, v}, kUp, rectangleFactor({u, -1, v}, kUp, ceiling, x, z)});
            side.push_back({{-1, u, v}, right, rectangleFactor({-1, u, v}, right, ceiling, x, z)});
        }
    compare(trial, scene, bottom, Gathered::radiance, 0);
    compare(trial, scene, side, Gathered::radiance, 1);
}

// K: soft shadows by one cone, through the whole renderer.

void pastAnEdge(Trial& trial) {
    const double radius = 1, lightHeight = 4.5, low = 1.5, high = low + 2 * trial.voxel;
    Light light;
    light.type = LightType::sphere;
    light.position = {0, lightHeight, 0};
    light.radius = radius;
    SceneBuilder builder = floorOf(4, 4);
    builder.add(box({2, high - low, 4}), lambert(0.5f), translation({-1, (low + high) / 2, 0})).light(light);
    const Scene scene = builder.transform(trial.placement).build();
    const auto placed = [&](const dvec3& p, double w) { return dvec3(trial.placement * glm::dvec4(p, w)); };

    Settings settings = trial.settings;
    settings.voxel.size = trial.voxel;
    settings.shadow.cones = true;
    settings.specular.enabled = false;
    settings.cone.diffuse = 1;
    settings.output.width = settings.output.height = 64;
    settings.light.shadowResolution = 128;
    Renderer renderer(glContext(), scene, settings);
    renderer.render(camera(placed({0.8, 1.2, 0}, 1), placed({0, 0, 0}, 1), 60, placed({0, 0, 1}, 0)));
    const Image position = renderer.channel("position"), seen = renderer.channel("soft_shadow");
    const dmat4 back = glm::inverse(trial.placement);
    for (std::size_t i = 0; i < seen.data.size(); ++i) {
        const dvec3 p(back * glm::dvec4(position.data[3 * i], position.data[3 * i + 1], position.data[3 * i + 2], 1));
        // The plate's lower edge decides in its shadow, the upper one outside; seen through either, the light's plane.
        const double edge = p.x > 0 ? high : low, t = p.x * (lightHeight - edge) / edge / radius;
        if (std::abs(p.y) > 1e-3 || std::abs(p.z) > 1 || std::abs(t) > 1.5) continue;
        trial.add(0, static_cast<double>(seen.data[i]), discPastEdge(t));
    }
}

// L: light through walls.

void sealedRoom(Trial& trial) {
    const double walls[] = {0, 0.25, 0.5, 1, 2, 4};
    for (std::size_t i = 0; i < std::size(walls); ++i) {
        SceneBuilder scene;
        scene.add(walls[i] > 0 ? slabRoom(kRoom, walls[i] * trial.voxel) : room(kRoom), lambert(0)).sky(glm::vec3(1));
        compare(trial, scene, wallPoints(trial, kRoom, walls[i] < 1 ? 90 : 240, 0), Gathered::radiance, i);
    }
}

std::vector<Case> makeCases() {
    const auto furnaceBar = [](double balanced, double accurate) {
        return Bar{Figure::relative_mean, {balanced, accurate}};
    };
    const auto leakBars = [](double worstBalanced, double worstAccurate) {
        return std::vector<Bar>{{Figure::mean, {0.008, 0.003}},
                                missed({Figure::worst, {0.08, 0.04}}, worstBalanced, worstAccurate)};
    };
    const auto thinLeak = [](double balanced, double accurate) {
        return std::vector<Bar>{{Figure::mean, {balanced, accurate}}};
    };
    return {
        {"A1",
         "FurnaceConverged",
         {{"closed room, ρ = .5, all bounces, wall of 1 voxel", {furnaceBar(0.008, 0.004)}},
          {"the same, ρ = .9", {furnaceBar(0.02, 0.02)}},
          {"ρ = .5, wall of 4 voxels", {furnaceBar(0.008, 0.004)}},
          {"ρ = .9, wall of 4 voxels", {furnaceBar(0.02, 0.02)}}},
         64,
         7.0 / 64,
         1,
         convergedFurnace},
        {"A1",
         "FurnaceBounces",
         {{"ρ = .5, no bounce", {furnaceBar(0.008, 0.004)}},
          {"1 bounce", {furnaceBar(0.008, 0.004)}},
          {"2 bounces", {furnaceBar(0.008, 0.004)}},
          {"3 bounces", {furnaceBar(0.008, 0.004)}}},
         64,
         7.0 / 64,
         1,
         bouncedFurnace},
        {"A2", "LitSphere", {{"sphere of 12 voxels lit from its centre, ρ = .5", {}}}, 64, 0.125, 1, litSphere},
        {"B1",
         "OpenPlane",
         {{"open plane, a body's", {{Figure::worst, {0.005, 0.005}}}},
          {"open plane, a sheet", {{Figure::worst, {0.005, 0.005}}}}},
         64,
         10.0 / 64,
         3,
         openPlane},
        {"B1",
         "ConvexEdge",
         {{"within 1.5 voxels of a convex edge", {{Figure::mean, {0.03, 0.03}}}}},
         64,
         7.0 / 64,
         3,
         convexEdge},
        {"B2",
         "Wall",
         {{"beside a wall 16 voxels high, to 20 away", {{Figure::rms, {0.035, 0.025}}}}},
         128,
         0.125,
         2,
         wall},
        {"B2",
         "WallBySixCones",
         {{"the same by 6 cones", {missed({Figure::rms, {0.06, 0.06}}, 0.065, 0.065)}}},
         128,
         0.125,
         1,
         wallBySixCones},
        {"B3",
         "Corner",
         {{"by an edge of two planes, to 8 voxels away", {kOpenness}}, {"by a corner of three planes", {kOpenness}}},
         128,
         0.125,
         2,
         corner},
        {"B4", "Roof", {{"below and beside a sheet 8 voxels overhead", {kOpenness}}}, 128, 0.125, 2, roof},
        {"B5",
         "SphereAbove",
         {{"sphere of radius 8 voxels, cosθ = .8, D = 2r", {kOpenness}},
          {"sphere 3 voxels above a floor", {{Figure::rms, {0.06, 0.04}}}}},
         128,
         0.125,
         2,
         spheresAbove},
        {"B6",
         "SphereCut",
         {{"sphere cut by the horizon, D = 2r, cosθ = .2", {kOpenness}},
          {"cosθ = 0", {kOpenness}},
          {"cosθ = −.2", {kOpenness}}},
         128,
         0.125,
         1,
         spheresCut},
        {"B7",
         "OpenBox",
         {{"middle of the floor of an open box of 16 voxels", {kOpenness}}, {"anywhere on it", {kOpenness}}},
         64,
         0.125,
         2,
         openBox},
        {"B",
         "Foliage",
         {{"below random leaves of 2 to 4 voxels", {missed({Figure::mean, {0.05, 0.05}}, 0.18, 0.06)}}},
         64,
         0.125,
         1,
         foliage},
        {"C1",
         "ParallelRectangle",
         {{"8 × 8 voxels, 8 above, below a corner", {missed(kFormFactor, 0.09, 0)}},
          {"16 × 16 voxels, below the middle", {missed(kFormFactor, 0.055, 0)}}},
         64,
         0.125,
         3,
         parallelRectangle},
        {"C2",
         "StandingRectangle",
         {{"8 × 8 voxels, 8 away", {missed(kFormFactor, 0.12, 0)}},
          {"height 16, width 4", {missed(kFormFactor, 0.125, 0.042)}}},
         64,
         0.125,
         3,
         standingRectangles},
        {"C3",
         "SunkRectangle",
         {{"the first, sunk in the floor", {missed(kFormFactor, 0.12, 0.043)}}},
         64,
         0.125,
         3,
         sunkRectangle},
        {"C4",
         "Disc",
         {{"disc of radius 8 voxels, 8 above", {missed(kFormFactor, 0.037, 0)}},
          {"a = .5 r", {missed(kFormFactor, 0.05, 0)}},
          {"a = r", {missed(kFormFactor, 0.065, 0)}}},
         64,
         0.125,
         2,
         discAbove},
        {"C5", "Cap", {{"sphere of half-angle 30° overhead, over π", {}}}, 64, 0.125, 3, cap},
        {"D", "Cube", {{"opposite face", {}}, {"adjacent face", {}}}, 64, 0.125, 1, cube},
        {"K1",
         "PastAnEdge",
         {{"light past an edge, penumbra of 9 voxels", {missed({Figure::rms, {0.05, 0.05}}, 0.062, 0)}}},
         64,
         0.125,
         2,
         pastAnEdge},
        {"L1",
         "SealedRoom",
         {{"sealed room, wall without thickness", {}},
          {"¼ voxel", thinLeak(0.02, 0.01)},
          {"½ voxel", thinLeak(0.02, 0.01)},
          {"1 voxel", leakBars(0, 0)},
          {"2 voxels", leakBars(0.12, 0.12)},
          {"4 voxels", leakBars(0, 0)}},
         64,
         7.0 / 64,
         2,
         sealedRoom},
        {"T1",
         "Slab",
         {{"four sheets of opacity ¼, a voxel apart", {}},
          {"the same, exponential with g = 1", {}},
          {"exponential with g = 1, half the step", {}}},
         64,
         0.125,
         1,
         slab},
    };
}

}  // namespace

const std::vector<Case>& cases() {
    static const std::vector<Case> all = makeCases();
    return all;
}

const std::vector<Orientation>& orientations() {
    static const std::vector<Orientation> all{
        {"0", dmat4(1)},
        {"30", rotation(30, {0, 1, 0})},
        {"45", rotation(45, glm::normalize(dvec3(1, 0, 1)))},
        {"random", rotation(67.3, glm::normalize(dvec3(0.3, 0.8, -0.5)))},
    };
    return all;
}

std::vector<Errors> measure(const Case& case_, const Orientation& orientation, const Settings& settings) {
    std::vector<Errors> errors(case_.answers.size());
    for (int phase = 0; phase < case_.phases; ++phase) {
        const std::string name = case_.name + orientation.name + std::to_string(phase);
        std::seed_seq seed(name.begin(), name.end());
        Trial trial{settings, case_.voxel, dmat4(1), std::mt19937(seed), errors};
        trial.settings.voxel.resolution = case_.resolution;
        if (case_.row[0] != 'A') trial.settings.light.bounces = 0;  // nothing there reflects what is asked for
        dvec3 aside;
        for (int a = 0; a < 3; ++a) aside[a] = trial.uniform(0, 1) * trial.voxel;
        trial.placement = translation(aside) * orientation.matrix;
        case_.measure(trial);
    }
    return errors;
}

}  // namespace voxcone::test
