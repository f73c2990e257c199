#include "bench.h"

#include <algorithm>
#include <cmath>

namespace voxcone::bench {

double passMilliseconds(const gl::PassTimers& timers, std::string_view prefix) {
    double sum = 0;
    for (const gl::PassTime& pass : timers.results())
        if (pass.name.starts_with(prefix)) sum += pass.milliseconds;
    return sum;
}

void add(const std::string& name, std::function<void(benchmark::State&)> body) {
    const auto guarded = [body = std::move(body)](benchmark::State& state) {
        try {
            body(state);
        } catch (const std::exception& error) {
            state.SkipWithError(error.what());
        }
    };
    benchmark::RegisterBenchmark(name.c_str(), guarded)->UseManualTime()->Iterations(1)->Unit(benchmark::kMillisecond);
}

double measure(benchmark::State& state, const Bench& bench, const std::function<double()>& frame) {
    double median = 0;
    for (auto _ : state) {
        frame();
        std::vector<double> times;
        for (int i = 0; i < bench.frames; ++i) times.push_back(frame());
        std::sort(times.begin(), times.end());
        const auto nearest = [&](double share) {
            return times[static_cast<std::size_t>(std::lround(share * static_cast<double>(times.size() - 1)))];
        };
        // A clock that has not ticked is no rate without end.
        median = std::max(nearest(0.5), 1e-6) / 1000;
        state.SetIterationTime(median);
        state.counters["p10_ms"] = nearest(0.1);
        state.counters["p90_ms"] = nearest(0.9);
    }
    return median;
}

void rate(benchmark::State& state, const char* name, double count, double seconds) {
    state.counters[name] = count / seconds;
}

void bytes(benchmark::State& state, const Bench& bench, double count, double seconds) {
    state.counters["bytes"] = benchmark::Counter(count, benchmark::Counter::kDefaults, benchmark::Counter::kIs1024);
    state.counters["of_copy"] = count / seconds / bench.copyRate;
}

}  // namespace voxcone::bench
