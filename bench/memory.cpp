// Yardsticks: how fast the device copies its memory and looks up volumes, by nothing but that.
#include <memory>

#include "bench.h"
#include "gl/buffer.h"
#include "gl/program.h"
#include "gl/texture.h"

namespace voxcone::bench {

namespace {

constexpr const char* kCopy = R"(
layout(local_size_x = 256) in;
layout(std430, binding = 0) readonly buffer From { uvec4 b_from[]; };
layout(std430, binding = 1) writeonly buffer To { uvec4 b_to[]; };
void main() { b_to[gl_GlobalInvocationID.x] = b_from[gl_GlobalInvocationID.x]; }
)";

// Neighbouring invocations read neighbouring places, as cones of neighbouring pixels do.
constexpr const char* kLookup = R"(
layout(local_size_x = 8, local_size_y = 8) in;
uniform sampler3D u_volume;
layout(std430, binding = 0) writeonly buffer Sums { float b_sums[]; };
void main() {
    vec2 at = (vec2(gl_GlobalInvocationID.xy) + 0.25) / (vec2(gl_NumWorkGroups.xy) * 8.0);
    vec3 sum = vec3(0.0);
    for (int i = 0; i < LOOKUPS; ++i) sum += textureLod(u_volume, vec3(at, (float(i) + 0.7) / float(LOOKUPS)), 0.0).rgb;
    b_sums[gl_GlobalInvocationID.y * gl_NumWorkGroups.x * 8u + gl_GlobalInvocationID.x] = sum.r + sum.g + sum.b;
}
)";
constexpr int kLookupsPerInvocation = 64;

/// Times one kind of work under a name.
struct Work {
    gl::PassTimers timers;
    std::function<void()> issue;
    double count;  ///< of bytes or look-ups

    double milliseconds() {
        timers.beginFrame();
        {
            const auto pass = timers.pass("yardstick");
            issue();
        }
        timers.endFrame();
        timers.wait();
        return passMilliseconds(timers, "");
    }
    double bestRate(int frames) {
        double best = 0;
        for (int i = 0; i <= frames; ++i) best = std::max(best, count / (std::max(milliseconds(), 1e-6) / 1000));
        return best;
    }
};

}  // namespace

void addMemory(Bench& bench) {
    const std::size_t size = bench.smallest ? 1 << 20 : 1 << 26;
    const auto from = std::make_shared<gl::Buffer>(size), to = std::make_shared<gl::Buffer>(size);
    from->clear(1);
    const auto copy = std::make_shared<gl::Program>(bench.shaders.computeFromText("copy.comp", kCopy));
    const auto shaderCopy = std::make_shared<Work>(
        gl::PassTimers(bench.timerMode()),
        [=] {
            from->bindBase(GL_SHADER_STORAGE_BUFFER, 0);
            to->bindBase(GL_SHADER_STORAGE_BUFFER, 1);
            gl::dispatch(*copy, static_cast<int>(size / 4096), 1, 1);
            gl::memoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
        },
        2.0 * static_cast<double>(size));
    const auto bufferCopy = std::make_shared<Work>(
        gl::PassTimers(bench.timerMode()), [=] { to->copyFrom(*from, size); }, 2.0 * static_cast<double>(size));

    const int edge = bench.smallest ? 128 : bench.software() ? 512 : 2048;
    const auto volume = std::make_shared<gl::Texture>(gl::Texture::create3D(GL_RGB10_A2, 128, 128, 128));
    volume->clear();
    volume->filter(GL_LINEAR, GL_LINEAR);
    const auto sums = std::make_shared<gl::Buffer>(static_cast<std::size_t>(edge * edge) * sizeof(float));
    const auto lookup = std::make_shared<gl::Program>(
        bench.shaders.computeFromText("lookup.comp", kLookup, {{"LOOKUPS", std::to_string(kLookupsPerInvocation)}}));
    const auto lookups = std::make_shared<Work>(
        gl::PassTimers(bench.timerMode()),
        [=] {
            volume->bindTo(0);
            lookup->set("u_volume", 0);
            sums->bindBase(GL_SHADER_STORAGE_BUFFER, 0);
            gl::dispatch(*lookup, edge / 8, edge / 8, 1);
            gl::memoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
        },
        static_cast<double>(edge) * edge * kLookupsPerInvocation);

    bench.copyRate = std::max(shaderCopy->bestRate(bench.frames), bufferCopy->bestRate(bench.frames));
    bench.lookupRate = lookups->bestRate(bench.frames);

    for (const auto& [name, work] : {std::pair{"memory/copy_shader", shaderCopy}, {"memory/copy_buffer", bufferCopy}})
        add(name, [&bench, work](benchmark::State& state) {
            const double seconds = measure(state, bench, [&] { return work->milliseconds(); });
            bytes(state, bench, work->count, seconds);
        });
    add("memory/lookup", [&bench, lookups](benchmark::State& state) {
        const double seconds = measure(state, bench, [&] { return lookups->milliseconds(); });
        rate(state, "lookups/s", lookups->count, seconds);
    });
}

}  // namespace voxcone::bench
