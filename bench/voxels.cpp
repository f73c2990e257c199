// Triangles to voxels, mips, and moves of the clipmap.
#include <fmt/format.h>

#include <set>

#include "lab.h"

namespace voxcone::bench {

namespace {

// Of a record: place, six faces, two words of coverage (cascade/voxels.h).
constexpr double kRecordBytes = 4 + 6 * sizeof(FaceRecord) + 8;

Settings voxelSettings(int resolution, bool conservative, VoxelAveraging averaging) {
    Settings settings;
    settings.voxel.resolution = resolution;
    settings.voxel.conservative = conservative;
    settings.voxel.averaging = averaging;
    settings.light.bounces = 0;
    settings.light.extrapolate = false;
    settings.light.shadowResolution = 512;
    return settings;
}

/// What an update from nothing must move: vertices and indices of what is drawn; the volumes emptied and searched for
/// marks; the records' sums emptied, added to (three faces a piece of a closed surface) and read; records and coverage.
double voxelizeBytes(const Lab& lab) {
    const Voxels& voxels = lab.voxels;
    const bool cas = lab.settings.voxel.averaging == VoxelAveraging::compare_and_swap;
    const double face = 4.0 * faceWords(cas, false, false), pieces = voxels.counters.fragments;
    const double vertices = static_cast<double>(lab.gpuScene.bufferBytes()) *
                            static_cast<double>(voxels.trianglesDrawn) /
                            static_cast<double>(lab.gpuScene.triangleCount());
    const double volumes = static_cast<double>(voxels.volumeBytes() + voxels.index.bytes());
    const double sums = voxels.freshCount * 6 * face * 2 + pieces * 3 * face * 2;
    return vertices + volumes + pieces * 4 + sums + voxels.freshCount * (kRecordBytes + 8);
}

/// Index texels and records of the children, and what a mip's record is.
double mipBytes(const Voxels& voxels) {
    const double mips = voxels.counters.fresh - voxels.freshCount;
    return mips * (8 * 4 + kRecordBytes + 8) + voxels.counters.fresh * (kRecordBytes - 4);
}

void addVoxelize(Bench& bench, int triangles, int resolution, bool conservative, VoxelAveraging averaging) {
    add(fmt::format("voxelize/triangles:{}/resolution:{}/{}/{}", triangles, resolution,
                    conservative ? "conservative" : "plain",
                    averaging == VoxelAveraging::integer_sum ? "integer_sum" : "compare_and_swap"),
        [=, &bench](benchmark::State& state) {
            Lab lab(bench, torusScene(triangles), voxelSettings(resolution, conservative, averaging));
            const double seconds = measure(state, bench, [&] {
                lab.update({}, true, false);
                return passMilliseconds(lab.timers, "voxelize");
            });
            for (const char* pass : {"mark", "allocate", "accumulate", "mips"})
                state.counters[fmt::format("{}_ms", pass)] =
                    passMilliseconds(lab.timers, fmt::format("voxelize: {}", pass));
            rate(state, "triangles/s", triangles, seconds);
            rate(state, "pieces/s", lab.voxels.counters.fragments, seconds);
            state.counters["voxels"] = lab.voxels.freshCount;
            bytes(state, bench, voxelizeBytes(lab) + mipBytes(lab.voxels), seconds);
        });
}

void addMips(Bench& bench, int resolution) {
    add(fmt::format("mips/resolution:{}", resolution), [=, &bench](benchmark::State& state) {
        Lab lab(bench, torusScene(100000), voxelSettings(resolution, true, VoxelAveraging::integer_sum));
        const double seconds = measure(state, bench, [&] {
            lab.update({}, true, false);
            return passMilliseconds(lab.timers, "voxelize: mips");
        });
        const double mips = lab.voxels.counters.fresh - lab.voxels.freshCount;
        rate(state, "records/s", mips, seconds);
        bytes(state, bench, mipBytes(lab.voxels), seconds);
    });
}

/// The camera goes to and fro by one snap of level `level`, along x or along all axes; finer levels snap too.
void addMove(Bench& bench, int resolution, int level, bool diagonal) {
    add(fmt::format("clipmap_move/resolution:{}/level:{}/{}", resolution, level, diagonal ? "diagonal" : "x"),
        [=, &bench](benchmark::State& state) {
            Settings settings = voxelSettings(resolution, true, VoxelAveraging::integer_sum);
            settings.cascade.levels = 4;
            Lab lab(bench, torusScene(100000), settings);
            const ClipmapLayout& layout = lab.voxels.layout;
            const double step = layout.snapOf(level) * layout.voxelSizeOf(level);
            // About the tube, where there is something to voxelize, and such that no coarser level snaps between the
            // two: windows snap at the odd halves of their steps (clipmapWindow).
            const glm::dvec3 tube = glm::dvec3(1, 0.35, 0) - layout.origin;
            const glm::dvec3 eye = layout.origin + (8.0 * glm::round(tube / (8 * step)) - 0.75) * step;
            const glm::dvec3 there = eye + step * (diagonal ? glm::dvec3(1) : glm::dvec3(1, 0, 0));
            lab.update(eye, true, true);
            bool away = false;
            double light = 0;
            const double seconds = measure(state, bench, [&] {
                away = !away;
                lab.update(away ? there : eye, false, true);
                light = passMilliseconds(lab.timers, "light");
                return passMilliseconds(lab.timers, "voxelize") + light;
            });
            std::set<int> levels;
            double exposed = 0;
            for (const Region& region : lab.last.fixed) {
                levels.insert(region.level);
                exposed += static_cast<double>(region.box.volume());
            }
            state.counters["light_ms"] = light;
            state.counters["levels"] = static_cast<double>(levels.size());
            rate(state, "voxels/s", exposed, seconds);
            state.counters["records_made"] = lab.voxels.freshCount;
            state.counters["triangles_drawn"] = static_cast<double>(lab.voxels.trianglesDrawn);
        });
}

}  // namespace

void addVoxels(Bench& bench) {
    std::vector<int> triangles{10000, 100000, 1000000};
    if (bench.large) triangles.push_back(10000000);
    const std::vector<int> resolutions = bench.smallest ? std::vector<int>{32} : std::vector<int>{64, 128, 256};
    for (const int resolution : resolutions)
        for (const int count : bench.pick(triangles))
            addVoxelize(bench, count, resolution, true, VoxelAveraging::integer_sum);
    const int resolution = bench.smallest ? 32 : 128;
    for (const int count : bench.pick(triangles)) {
        addVoxelize(bench, count, resolution, false, VoxelAveraging::integer_sum);
        addVoxelize(bench, count, resolution, true, VoxelAveraging::compare_and_swap);
        if (!bench.smallest) addVoxelize(bench, count, resolution, false, VoxelAveraging::compare_and_swap);
    }
    for (const int size : resolutions) addMips(bench, size);
    for (const int level : bench.pick({0, 2}))
        for (const bool diagonal : {false, true}) addMove(bench, resolution, level, diagonal);
}

}  // namespace voxcone::bench
