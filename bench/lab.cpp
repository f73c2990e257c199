#include "lab.h"

#include <cmath>
#include <numbers>

#include "core/check.h"
#include "support/shapes.h"

namespace voxcone::bench {

namespace {

Mesh torus(int triangles) {
    // The most even way to write the number of quadrilaterals as a product.
    const int quads = triangles / 2;
    int across = static_cast<int>(std::sqrt(quads / 2));
    while (across > 3 && quads % across != 0) --across;
    VOXCONE_CHECK(2 * quads == triangles && across > 3, "no torus of {} triangles", triangles);
    const int along = quads / across;

    constexpr double kTwoPi = 2 * std::numbers::pi;
    const auto point = [&](int i, int j) {
        const double u = kTwoPi * i / along, v = kTwoPi * j / across;
        const double tube = 0.35 + 0.1 * std::sin(7 * u) * std::cos(3 * v);
        const double r = 1 + tube * std::cos(v);
        return glm::dvec3(r * std::cos(u), tube * std::sin(v), -r * std::sin(u));
    };
    Mesh mesh;
    for (int i = 0; i < along; ++i) {
        for (int j = 0; j < across; ++j) {
            const glm::dvec3 du = point(i + 1, j) - point(i - 1, j), dv = point(i, j + 1) - point(i, j - 1);
            mesh.positions.emplace_back(point(i, j));
            mesh.normals.emplace_back(glm::normalize(glm::cross(du, dv)));
        }
    }
    for (int i = 0; i < along; ++i) {
        for (int j = 0; j < across; ++j) {
            const auto vertex = [&](int a, int b) {
                return static_cast<std::uint32_t>((i + a) % along * across + (j + b) % across);
            };
            for (const std::uint32_t k :
                 {vertex(0, 0), vertex(1, 0), vertex(1, 1), vertex(0, 0), vertex(1, 1), vertex(0, 1)})
                mesh.indices.push_back(k);
        }
    }
    mesh.closed.assign(static_cast<std::size_t>(triangles), 1);
    return mesh;
}

Light sun() {
    Light light;
    light.type = LightType::directional;
    light.direction = glm::normalize(glm::dvec3(0.3, -1, 0.2));
    light.intensity = glm::vec3(4);
    return light;
}

}  // namespace

Scene torusScene(int triangles) {
    return test::SceneBuilder().add(torus(triangles), test::lambert({0.7f, 0.5f, 0.3f})).light(sun()).build();
}

Scene roomScene() {
    using test::translation;
    test::SceneBuilder scene;
    scene.add(torus(10000), test::lambert({0.7f, 0.5f, 0.3f}));
    const Material wall = test::lambert(0.7f), red = test::lambert({0.7f, 0.2f, 0.2f});
    const double t = 0.1;  // thickness
    scene.add(test::box({4.2, t, 4.2}), wall, translation({0, -1.2 - t / 2, 0}));
    scene.add(test::box({t, 2.4, 4}), red, translation({-2 - t / 2, 0, 0}));
    for (const double side : {-1.0, 1.0}) {
        if (side > 0) scene.add(test::box({t, 2.4, 4}), wall, translation({2 + t / 2, 0, 0}));
        scene.add(test::box({4, 2.4, t}), wall, translation({0, 0, side * (2 + t / 2)}));
        // The roof leaves a gap of 0.8 m in the middle.
        scene.add(test::box({1.7, t, 4.2}), wall, translation({side * 1.25, 1.2 + t / 2, 0}));
    }
    return scene.light(sun()).sky(glm::vec3(0.5f)).build();
}

Lab::Lab(const Bench& bench, Scene givenScene, const Settings& givenSettings)
    : scene(std::move(givenScene)),
      settings(givenSettings),
      timers(bench.timerMode()),
      gpuScene(scene),
      voxelizer(bench.context, bench.shaders, gpuScene, settings),
      voxels(voxelizer.allocate(layoutClipmap(scene.bounds(), settings))),
      schedule(voxels.layout, 0, false),
      sky{scene.environment.color},
      shadowMaps(bench.context, bench.shaders, settings.light),
      field(bench.shaders, settings, voxels, sky, !scene.lights.empty()) {
    gpuScene.setOrigin(voxels.origin);
    gl::PassTimers unused(gl::TimerMode::finish);
    shadowMaps.update(gpuScene, unused);
}

void Lab::update(const glm::dvec3& eye, bool anew, bool lit) {
    if (anew) schedule.reset();
    voxels.center = eye - voxels.origin;
    last = schedule.next(voxels.center, {});
    timers.beginFrame();
    if (!last.empty()) {
        voxelizer.update(gpuScene, last, voxels, timers);
        if (lit) light({anew, last.touches(voxels.layout.levels - 1), true});
    }
    timers.endFrame();
    timers.wait();
}

void Lab::relight() {
    timers.beginFrame();
    light({});
    timers.endFrame();
    timers.wait();
}

void Lab::light(const RadianceField::Change& change) {
    field.update(
        voxels, sky, change, [this](gl::Program& program) { shadowMaps.bind(program); }, timers);
}

}  // namespace voxcone::bench
