#include "report/page_sample.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "metric/heatmap.h"
#include "metric/image.h"

namespace voxcone {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

/// A room with a red and a green wall, a box and light from above; `noise` and `leak` make it worse.
Image picture(int width, int height, double noise, double leak, unsigned seed) {
    std::mt19937 random(seed);
    const auto uniform = [&] { return static_cast<double>(random()) / 4294967296.0; };
    Image image(width, height, 3);
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            const double u = (x + 0.5) / width, v = (y + 0.5) / height;
            double light = 0.75 - 0.5 * std::hypot(u - 0.5, v - 0.1) + leak * std::exp(-8 * v);
            double color[3] = {0.75, 0.73, 0.7};
            if (u < 0.18) color[1] = color[2] = 0.12, light *= 0.5 + v;
            if (u > 0.82) color[0] = color[2] = 0.15, light *= 0.5 + v;
            if (u > 0.3 && u < 0.52 && v > 0.48 && v < 0.86) light *= 0.55, color[2] *= 1.1;
            if (std::hypot(u - 0.68, 1.2 * (v - 0.72)) < 0.12) light *= 0.5 + 2 * (0.8 - v);
            if (v < 0.04 && u > 0.38 && u < 0.62) light = 1.2;
            for (int c = 0; c < 3; ++c)
                image.pixel(x, y)[c] = static_cast<float>(light * color[c] * (1 + noise * (uniform() - 0.5)));
        }
    }
    return image;
}

Image heat(const Image& reference, const Image& test) {
    Image error(reference.width, reference.height, 1);
    for (std::size_t i = 0; i < error.data.size(); ++i)
        error.data[i] = 4 * std::abs(reference.data[3 * i] - test.data[3 * i]);
    return heatmap(error);
}

json time(double median, double spread) {
    return {{"median", median}, {"p10", median * (1 - spread)}, {"p90", median * (1 + 2 * spread)}};
}

json facts() {
    return {{"voxcone_report", 1},
            {"command", "voxcone report assets/suites/quick.json --out build/quick --set output.width=256"},
            {"build", {{"version", "0.1.0"}, {"compiler", "GNU 12.2.0"}, {"type", "Release"}}},
            {"device",
             {{"renderer", "llvmpipe (LLVM 15.0.6, 256 bits)"},
              {"version", "4.5 (Core Profile) Mesa 22.3.6"},
              {"software_rasterizer", true}}},
            {"machine", {{"cpu", "Some CPU 3.0 GHz"}, {"cores", 2}, {"memory_bytes", 16777216000}}},
            {"times_made", {{"started", "2026-01-02T03:04:05Z"}, {"finished", "2026-01-02T03:12:45Z"}}}};
}

struct Sweep {
    const char* id;
    json set;
    double cost, error;
};

}  // namespace

json sampleReport(const fs::path& folder) {
    const Sweep sweeps[] = {
        {"thesis", json::object(), 0.62, 3.1},
        {"fast", json::object(), 0.5, 1.8},
        {"balanced", json::object(), 1, 1},
        {"accurate", json::object(), 3.4, 0.55},
        {"resolution 32", {{"voxel.resolution", 32}}, 0.58, 2.4},
        {"resolution 128", {{"voxel.resolution", 128}}, 2.1, 0.74},
        {"5 cones", {{"cone.diffuse", 5}}, 0.71, 1.35},
        {"32 cones", {{"cone.diffuse", 32}}, 1.9, 0.9},
        {"5 cones, resolution 128", {{"cone.diffuse", 5}, {"voxel.resolution", 128}}, 1.55, 0.82},
        {"isotropic", {{"voxel.storage", "isotropic"}}, 0.88, 1.7},
        {"sh1", {{"voxel.storage", "sh1"}}, 1.15, 1.3},
        {"no near field, step 1.5", {{"cone.near_field", 0}, {"cone.step", 1.5}}, 0.6, 1.5},
    };
    const std::pair<const char*, double> passes[] = {{"shadow_maps", 0.9},
                                                     {"voxelize: mark", 1.4},
                                                     {"voxelize: allocate", 0.5},
                                                     {"voxelize: accumulate", 6.2},
                                                     {"voxelize: mips", 1},
                                                     {"light: inject", 1.1},
                                                     {"light: bounce", 8},
                                                     {"light: store", 0.7},
                                                     {"gbuffer", 1.3},
                                                     {"direct", 2.2},
                                                     {"cones: diffuse", 14},
                                                     {"cones: filter", 1.6},
                                                     {"cones: specular", 5},
                                                     {"cones: specular filter", 0.8},
                                                     {"composite", 0.3}};
    json report = facts();
    report["suite"] = {{"name", "quick"}, {"file", "assets/suites/quick.json"}, {"sha256", std::string(64, 'a')}};
    for (const Sweep& sweep : sweeps) {
        const std::string id = sweep.id;
        const bool preset = id == "thesis" || id == "fast" || id == "accurate";
        report["configurations"].push_back({{"id", id}, {"preset", preset ? id : "balanced"}, {"set", sweep.set}});
    }
    const std::tuple<const char*, const char*, int, int, double> views[] = {
        {"cornell", "front", 34, 128, 1.0}, {"atrium", "arcade", 21874, 160, 2.6}, {"atrium", "ivy", 21874, 160, 3.3}};
    unsigned seed = 1;
    for (const auto& [scene, shot, triangles, width, scale] : views) {
        const std::string id = fmt::format("{}/{}", scene, shot);
        const Image reference = picture(width, 90, 0.02, 0, seed++);
        writePng(folder / "images" / fmt::format("{}-{}-reference.png", scene, shot), reference);
        report["views"].push_back(
            {{"id", id},
             {"scene", scene},
             {"shot", shot},
             {"script", fmt::format("assets/captures/{}.json", scene)},
             {"width", width},
             {"height", 90},
             {"triangles", triangles},
             {"reference",
              {{"samples", 4096},
               {"depth", 16},
               {"seconds", 48.2},
               {"standard_error", {{"beauty", 0.00031}, {"indirect_diffuse", 0.00044}}},
               {"noise_relmse", {{"beauty", 0.012 * scale}, {"indirect_diffuse", 0.00044}}},
               {"images", {{"beauty", fmt::format("images/{}-{}-reference.png", scene, shot)}}}}}});
        int index = 0;
        for (const Sweep& sweep : sweeps) {
            json row = {{"view", id}, {"configuration", sweep.id}, {"status", "ok"}};
            if (id == "atrium/ivy" && index == 5) {
                row["status"] = "failed";
                row["reason"] = "device: GL_MAX_SHADER_STORAGE_BLOCK_SIZE is 134217728, 188743680 bytes are needed";
            } else if (id == "atrium/ivy" && index == 8) {
                row["status"] = "missing";
            } else {
                const double wobble = 1 + 0.12 * std::sin(3.7 * index + scale);
                const double cost = sweep.cost * wobble, error = 0.011 * scale * sweep.error * (2 - wobble);
                double first = 0, steady = 0;
                for (const auto& [name, ms] : passes) {
                    const std::string pass = name;
                    const bool builds =
                        pass.starts_with("voxelize") || pass.starts_with("light") || pass == "shadow_maps";
                    const double own = ms * scale * (pass == "gbuffer" || pass == "composite" ? 1 : cost);
                    first += own, steady += builds ? 0 : own;
                    row["passes"].push_back({{"name", pass},
                                             {"first", time(own, 0.05)},
                                             {"steady", builds ? json(nullptr) : time(own, 0.04)}});
                }
                row["ms"] = {{"first", time(first * 1.01, 0.06)}, {"steady", time(steady * 1.01, 0.04)}};
                row["memory_bytes"] = std::lround(4.1e7 * scale * (0.5 + cost));
                row["samples_per_pixel"] = 210 * cost;
                row["voxels"] = std::lround(54000 * scale * (0.5 + cost));
                for (const char* channel : {"beauty", "indirect_diffuse"}) {
                    const double own = error * (std::string(channel) == "beauty" ? 1 : 1.8);
                    row["errors"][channel] = {{"relmse", own},
                                              {"rmse", std::sqrt(own) * 0.3},
                                              {"bias", -0.1 * own},
                                              {"relative_bias", -0.2 * own},
                                              {"p99", std::sqrt(own)},
                                              {"hdr_flip", 1.5 * std::sqrt(own)},
                                              {"flip", 0.9 * std::sqrt(own)},
                                              {"ssim", 1 - own},
                                              {"psnr", -10 * std::log10(0.05 * own)},
                                              {"grade", 10 * std::pow(1 - 0.1 * own, 1000)}};
                }
                const Image result = picture(width, 90, 6 * error, 8 * error, seed++);
                const std::string stem = fmt::format("images/{}-{}-{}", scene, shot, index);
                writePng(folder / (stem + ".png"), result);
                writePng(folder / (stem + "-heat.png"), heat(reference, result));
                row["images"] = {{"beauty", stem + ".png"}, {"beauty_heatmap", stem + "-heat.png"}};
            }
            report["rows"].push_back(row);
            ++index;
        }
    }
    return report;
}

json plainReport(int configurations) {
    json report = facts();
    report["suite"] = {{"name", "plain"}};
    report["views"] = json::array({{{"id", "cornell/front"}, {"scene", "cornell"}, {"shot", "front"}}});
    report["configurations"] = json::array();
    report["rows"] = json::array();
    std::mt19937 random(7);
    for (int i = 0; i < configurations; ++i) {
        const std::string id = i == 0 ? "balanced" : fmt::format("cone.diffuse={} voxel.resolution={}", 3 + i, 32 + i);
        const double cost = std::exp2(static_cast<double>(random()) / 1e9), ms = 4 * cost;
        const double error = 0.1 / cost * std::exp2(static_cast<double>(random()) / 1.3e9);
        report["configurations"].push_back(
            {{"id", id}, {"preset", "balanced"}, {"set", {{"cone.diffuse", 3 + i}, {"voxel.resolution", 32 + i}}}});
        report["rows"].push_back(
            {{"view", "cornell/front"},
             {"configuration", id},
             {"status", "ok"},
             {"ms", {{"first", time(3 * ms, 0.1)}, {"steady", time(ms, 0.1)}}},
             {"passes",
              json::array({{{"name", "cones: diffuse"}, {"first", time(ms, 0.1)}, {"steady", time(ms, 0.1)}}})},
             {"errors", {{"beauty", {{"relmse", error}}}}}});
    }
    return report;
}

}  // namespace voxcone
