// Direct light and emission of the voxels, and their bounces.
#include <fmt/format.h>

#include "lab.h"

namespace voxcone::bench {

namespace {

constexpr double kFaces = 6;

Settings lightSettings(int resolution, int bounces, int cones) {
    Settings settings;
    settings.voxel.resolution = resolution;
    settings.light.bounces = bounces;
    settings.light.extrapolate = false;
    settings.light.bounceCones = cones;
    settings.light.shadowResolution = 512;
    return settings;
}

void addInject(Bench& bench, int resolution) {
    add(fmt::format("inject/resolution:{}", resolution), [=, &bench](benchmark::State& state) {
        Lab lab(bench, roomScene(), lightSettings(resolution, 0, 6));
        lab.update({}, true, true);
        const double seconds = measure(state, bench, [&] {
            lab.relight();
            return passMilliseconds(lab.timers, "light: inject");
        });
        const double slots = lab.voxels.slots, gathering = lab.field.activeFaces();
        state.counters["store_ms"] = passMilliseconds(lab.timers, "light: store");
        rate(state, "faces/s", gathering, seconds);
        // Place, faces and direct light; then place, coverage and direct light, for the list of faces that gather.
        bytes(state, bench,
              slots * (4 + kFaces * (sizeof(FaceRecord) + 4)) + slots * (4 + 8 + kFaces * 4) + gathering * 8, seconds);
    });
}

void addBounce(Bench& bench, int resolution, int cones) {
    add(fmt::format("bounce/resolution:{}/cones:{}", resolution, cones), [=, &bench](benchmark::State& state) {
        Lab lab(bench, roomScene(), lightSettings(resolution, 1, cones));
        lab.update({}, true, true);
        const double seconds = measure(state, bench, [&] {
            lab.relight();
            return passMilliseconds(lab.timers, "light: bounce");
        });
        const double faces = lab.field.activeFaces();
        state.counters["faces"] = faces;
        rate(state, "cones/s", faces * cones, seconds);
    });
}

}  // namespace

void addLight(Bench& bench) {
    const std::vector<int> resolutions = bench.smallest ? std::vector<int>{32} : std::vector<int>{64, 128, 256};
    for (const int resolution : resolutions) addInject(bench, resolution);
    for (const int cones : bench.pick({5, 6, 9, 16, 32})) addBounce(bench, bench.smallest ? 32 : 64, cones);
}

}  // namespace voxcone::bench
