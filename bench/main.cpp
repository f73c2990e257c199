// The benchmarks' command line: Google Benchmark's own options, and how large and how often.
#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "bench.h"
#include "core/error.h"
#include "core/log.h"

namespace {

using namespace voxcone;

int run(int argc, char** argv) {
    benchmark::Initialize(&argc, argv);
    CLI::App app(
        "Times of the renderer's passes beside what they read, write and do; --benchmark_filter=REGEX chooses,\n"
        "--benchmark_format=json prints JSON, --benchmark_list_tests lists (see docs/performance.md).",
        "voxcone_bench");
    int frames = 5;
    bool smallest = false, large = false;
    app.add_option("--frames", frames, "frames that are timed for each figure")->check(CLI::Range(1, 1000));
    app.add_flag("--smallest", smallest, "every family once, at its smallest size");
    app.add_flag("--large", large, "10 million triangles too");
    CLI11_PARSE(app, argc, argv);

    const auto context = gl::Context::createHeadless(false);
    bench::Bench bench{*context, gl::ShaderLibrary(), frames, smallest, large};
    bench::addMemory(bench);
    bench::addVoxels(bench);
    bench::addLight(bench);
    bench::addCones(bench);
    benchmark::AddCustomContext("device", context->info().renderer + ", OpenGL " + context->info().version);
    benchmark::AddCustomContext(
        "times", bench.timerMode() == gl::TimerMode::query ? "timestamp queries" : "glFinish and a clock");
    benchmark::AddCustomContext("of_copy is over", fmt::format("{:.3g} GB/s, read and written", bench.copyRate / 1e9));
    benchmark::AddCustomContext("of_lookups is over",
                                fmt::format("{:.3g} G/s trilinear look-ups", bench.lookupRate / 1e9));
    benchmark::AddCustomContext("left out",
                                "512³ voxels: records keep 8 bits of each coordinate in a level, so that "
                                "voxel.resolution ends at 256");
    if (!large) benchmark::AddCustomContext("left out as well", "10 million triangles, which --large adds");
    benchmark::RunSpecifiedBenchmarks();
    return 0;
}

}  // namespace

int main(int argc, char** argv) {
    try {
        return run(argc, argv);
    } catch (const Error& error) {
        log::message("", error.what());
        return static_cast<int>(error.exitCode);
    }
}
