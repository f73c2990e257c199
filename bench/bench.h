// What all benchmarks share: the device, how often and how large they run, and how times become figures.
//
// A benchmark runs its frame once to warm up, so that nothing is compiled or allocated in the times, then `frames`
// times, and reports the median of the passes that it is about as the time of its one iteration. Beside it stand the
// 10th and 90th percentile and what was counted: bytes from the sizes of what the passes must read and write at least
// once, operations by the program.
#pragma once

#include <benchmark/benchmark.h>

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "gl/context.h"
#include "gl/pass_timers.h"
#include "gl/shader_library.h"

namespace voxcone::bench {

struct Bench {
    gl::Context& context;
    gl::ShaderLibrary shaders;
    int frames = 5;         ///< that are timed, at least 1
    bool smallest = false;  ///< register the smallest size of each family alone
    bool large = false;     ///< register sizes that take gigabytes and minutes too
    /// Yardsticks of the device, memory.cpp.
    double copyRate = 0;    ///< bytes read and written by a copy in its memory, 1/s
    double lookupRate = 0;  ///< trilinear look-ups in a 10:10:10:2 volume, 1/s

    bool software() const { return context.info().softwareRasterizer; }
    gl::TimerMode timerMode() const { return gl::suitableTimerMode(context.info()); }
    /// `sizes`, or their first with `smallest`.
    std::vector<int> pick(const std::vector<int>& sizes) const {
        return smallest ? std::vector<int>{sizes.front()} : sizes;
    }
};

/// Sum over the passes of the last frame whose name begins with `prefix`; "" takes all.
double passMilliseconds(const gl::PassTimers& timers, std::string_view prefix);

/// Registers benchmark `name`: `body` gets the state when it is its turn. Its errors are reported as the benchmark's.
void add(const std::string& name, std::function<void(benchmark::State&)> body);

/// Times of `frame`, which answers milliseconds, after a first run that does not count: sets the benchmark's time to
/// the median, and the counters p10_ms and p90_ms. Returns the median in seconds, more than 0.
double measure(benchmark::State& state, const Bench& bench, const std::function<double()>& frame);

/// Counter `name`: how many a second, as a plain number (`seconds` of measure()).
void rate(benchmark::State& state, const char* name, double count, double seconds);

/// Counters `bytes` and `of_copy`: their rate over that of a copy.
void bytes(benchmark::State& state, const Bench& bench, double count, double seconds);

// One file each. The first sets the yardsticks.
void addMemory(Bench& bench);
void addVoxels(Bench& bench);
void addLight(Bench& bench);
void addCones(Bench& bench);

}  // namespace voxcone::bench
