// Cones from what a camera sees of the room, by the marching loop that pictures use (shaders/cone/trace.glsl).
#include <fmt/format.h>

#include <cmath>

#include "core/check.h"
#include "frame/gbuffer.h"
#include "gl/bindings.h"
#include "lab.h"
#include "support/shapes.h"

namespace voxcone::bench {

namespace {

constexpr int kPointStorage = 3, kResultStorage = 5;

// As shaders/cone/diffuse.comp, from listed points instead of a G-buffer, and with any aperture.
constexpr const char* kCones = R"(
#include "cone/sky.glsl"
#include "cone/trace.glsl"
#include "cone/cone_set.glsl"
layout(local_size_x = 8, local_size_y = 8) in;

struct Point {
    vec4 position;  // voxels; w 0 where nothing is seen
    vec4 normal;
};
uniform int u_edge;  // points a row
uniform float u_aperture;  // tangent of half of it; 0: the set's
layout(std430, binding = 3) readonly buffer Points { Point b_points[]; };
layout(std430, binding = 5) writeonly buffer Results { vec4 b_results[]; };

void main() {
    uint index = gl_GlobalInvocationID.y * uint(u_edge) + gl_GlobalInvocationID.x;
    Point point = b_points[index];
    vec4 sum = vec4(0.0);
    if (point.position.w > 0.0) {
        Cone cone;
        cone.origin = point.position.xyz;
        cone.normal = point.normal.xyz;
        cone.level = 0.0;
        cone.tanHalfAngle = u_aperture > 0.0 ? u_aperture : u_coneTanHalfAngle;
        cone.near = u_aperture > 0.0 ? nearOfOne(cone.tanHalfAngle) : u_nearDistance;
        mat3 frame = frameAround(cone.normal);
        for (int i = 0; i < CONES; ++i) {
            vec4 local = coneOfSet(i, 0.0, 0.0);
            cone.direction = frame * local.xyz;
            ConeResult result = traceCone(cone);
            sum += local.w * vec4(result.radiance + result.transmittance * skyRadiance(cone.direction, cone.tanHalfAngle),
                                  result.openness);
        }
    }
    storeSamples();
    b_results[index] = sum;
}
)";

/// Points of a picture of the room.
struct Points {
    int edge;
    double seen = 0;  ///< pixels with a surface
    gl::Buffer points, results;

    Points(const Bench& bench, Lab& lab, int givenEdge) : edge(givenEdge) {
        GBuffer gbuffer(bench.shaders, lab.gpuScene, edge, edge);
        const Camera camera = test::camera({1.7, 0.5, 1.7}, {-0.3, -0.3, -0.3}, 65);
        gl::PassTimers unused(gl::TimerMode::finish);
        gbuffer.draw(lab.gpuScene, cameraView(camera, lab.gpuScene.origin(), lab.gpuScene.bounds(), edge, edge),
                     unused);
        const Image positions = gbuffer.channel("position", 1), normals = gbuffer.channel("normal", 1),
                    depths = gbuffer.channel("depth", 1);
        std::vector<glm::vec4> packed;
        for (int y = 0; y < edge; ++y) {
            for (int x = 0; x < edge; ++x) {
                const float *p = positions.pixel(x, y), *n = normals.pixel(x, y);
                const bool hit = *depths.pixel(x, y) > 0;
                seen += hit;
                const glm::dvec3 position =
                    (glm::dvec3(p[0], p[1], p[2]) - lab.voxels.origin) / lab.voxels.layout.voxelSize;
                packed.emplace_back(position, hit ? 1 : 0);
                packed.emplace_back(hit ? glm::normalize(glm::vec3(n[0], n[1], n[2])) : glm::vec3(0, 1, 0), 0);
            }
        }
        VOXCONE_CHECK(seen > 0.9 * edge * edge, "{} of {} pixels see the room", seen, edge * edge);
        points = gl::Buffer::of(packed);
        results = gl::Buffer(static_cast<std::size_t>(edge * edge) * sizeof(glm::vec4));
    }
};

/// As shaders/cone/trace.glsl counts.
struct Counts {
    double samples = 0, nearVoxels = 0, levels = 0, radiances = 0;
};

struct Tracer {
    Tracer(const Bench& bench, Lab& givenLab, int cones, double apertureDeg, bool count)
        : lab(givenLab), coneCount(cones), tanHalfAngle(std::tan(glm::radians(apertureDeg / 2))) {
        gl::Defines defines = coneSetDefines(lab.settings, lab.voxels, lab.sky, cones);
        defines["COUNT_SAMPLES"] = count ? "1" : "0";
        program = bench.shaders.computeFromText("cones.comp", kCones, defines);
    }

    void run(const Points& points) {
        points.points.bindBase(GL_SHADER_STORAGE_BUFFER, kPointStorage);
        points.results.bindBase(GL_SHADER_STORAGE_BUFFER, kResultStorage);
        program.set("u_edge", points.edge);
        program.set("u_aperture", tanHalfAngle);
        setConeUniforms(program, lab.settings, lab.sky, lab.volume(), lab.settings.cone.step, gl::kPassTextureUnit);
        setConeSetUniforms(program, coneCount);
        gl::dispatch(program, points.edge / 8, points.edge / 8, 1);
        gl::memoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT);
    }

    double milliseconds(const Points& points) {
        lab.timers.beginFrame();
        {
            const auto pass = lab.timers.pass("cones");
            run(points);
        }
        lab.timers.endFrame();
        lab.timers.wait();
        return passMilliseconds(lab.timers, "cones");
    }

    Lab& lab;
    int coneCount;
    double tanHalfAngle;
    gl::Program program;
};

Counts countOf(const Bench& bench, Lab& lab, int cones, double apertureDeg, const Points& points) {
    gl::Buffer words(kSampleWords * sizeof(std::uint32_t));
    words.clear();
    words.bindBase(GL_SHADER_STORAGE_BUFFER, kSampleStorage);
    Tracer(bench, lab, cones, apertureDeg, true).run(points);
    const auto read = words.read<std::uint64_t>();  // low word first
    return {static_cast<double>(read[0]), static_cast<double>(read[1]), static_cast<double>(read[2]),
            static_cast<double>(read[3])};
}

/// `apertureDeg` 0: the set's own.
void addCone(Bench& bench, const std::string& name, const Settings& settings, int cones, double apertureDeg = 0) {
    add("cones/" + name, [=, &bench](benchmark::State& state) {
        Lab lab(bench, roomScene(), settings);
        lab.update({}, true, true);
        const Points points(bench, lab, bench.smallest ? 32 : bench.software() ? 64 : 1024);
        const Counts counts = countOf(bench, lab, cones, apertureDeg, points);
        Tracer tracer(bench, lab, cones, apertureDeg, false);
        const double seconds = measure(state, bench, [&] { return tracer.milliseconds(points); });

        const double traced = points.seen * cones;
        rate(state, "cones/s", traced, seconds);
        rate(state, "samples/s", counts.samples, seconds);
        state.counters["samples/cone"] = counts.samples / traced;
        state.counters["near/cone"] = counts.nearVoxels / traced;
        state.counters["gathers/cone"] = counts.radiances / traced;
        // Coverage is looked up in one volume, or two for six faces.
        const double lookups = counts.levels * (lab.voxels.sixFace() ? 2 : 1);
        rate(state, "lookups/s", lookups, seconds);
        state.counters["of_lookups"] = lookups / seconds / bench.lookupRate;
    });
}

}  // namespace

void addCones(Bench& bench) {
    Settings settings;
    settings.voxel.resolution = bench.smallest ? 32 : 128;
    settings.light.bounces = 0;
    settings.light.extrapolate = false;
    settings.light.shadowResolution = 512;

    for (const int cones : bench.pick({1, 5, 6, 9, 16, 32}))
        addCone(bench, fmt::format("set:{}", cones), settings, cones);
    for (const int degrees : bench.pick({60, 2, 5, 10, 20, 40, 90}))
        addCone(bench, fmt::format("aperture:{}", degrees), settings, 1, degrees);
    for (const auto& [name, storage] : {std::pair{"isotropic", VoxelStorage::isotropic},
                                        {"sh1", VoxelStorage::sh1},
                                        {"six_face", VoxelStorage::six_face}}) {
        Settings stored = settings;
        stored.voxel.storage = storage;
        stored.cone.nearField = 0;  // which six_face alone has
        addCone(bench, fmt::format("storage:{}/near_field:0", name), stored, bench.smallest ? 5 : 16);
        if (bench.smallest) break;
    }
    for (const int near : bench.pick({8, 16, 32})) {
        Settings nearer = settings;
        nearer.cone.nearField = near;
        addCone(bench, fmt::format("near_field:{}", near), nearer, bench.smallest ? 5 : 16);
    }
}

}  // namespace voxcone::bench
