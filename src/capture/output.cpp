#include "capture/output.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "core/atomic_file.h"
#include "frame/tone_curve.h"
#include "metric/heatmap.h"

namespace voxcone {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

json array(const glm::dvec3& v) {
    return {v.x, v.y, v.z};
}

fs::path fileOf(const fs::path& out, const Shot& shot, std::string channel, int frame, const char* extension) {
    // Not every file system has colons in names.
    std::replace(channel.begin(), channel.end(), ':', '_');
    return out / shot.name / fmt::format("{}.{:04}.{}", channel, frame, extension);
}

}  // namespace

bool moves(const Scene& scene) {
    return !scene.animations.empty() || std::any_of(scene.lights.begin(), scene.lights.end(), [](const Light& light) {
        return !light.track.position.empty() || !light.track.direction.empty() || !light.track.intensity.empty();
    });
}

void ShotWriter::channel(const Shot& shot, const std::string& name, int frame, const Image& image,
                         const Image& picture) {
    files_.push_back(fileOf(out_, shot, name, frame, "exr"));
    writeExr(files_.back(), image);
    files_.push_back(fileOf(out_, shot, name, frame, "png"));
    writePng(files_.back(), picture);
}

void ShotWriter::stats(const Shot& shot, const json& stats) {
    files_.push_back(out_ / shot.name / "stats.json");
    writeTextFile(files_.back(), stats.dump(2) + "\n");
}

Image pictureOf(const std::string& name, const Image& image, const Settings& settings) {
    const std::string channel = baseChannel(name);
    Image out = image;
    if (channel == "normal" || channel == "voxel_normal") {
        for (std::size_t i = 0; i + 2 < out.data.size(); i += 3) {
            // No surface there: black, not the grey of a zero vector.
            if (out.data[i] == 0 && out.data[i + 1] == 0 && out.data[i + 2] == 0) continue;
            for (std::size_t c = 0; c < 3; ++c)
                out.data[i + c] = linearFromSrgb(std::clamp(0.5f * out.data[i + c] + 0.5f, 0.0f, 1.0f));
        }
    } else if (channel == "depth") {
        const float largest = *std::max_element(out.data.begin(), out.data.end());
        for (float& v : out.data) v = largest > 0 ? linearFromSrgb(v / largest) : 0;
    } else if (channel == "position") {
        std::array<float, 3> low{}, high{};
        low.fill(1e30f), high.fill(-1e30f);
        for (std::size_t i = 0; i < out.data.size(); ++i) {
            low[i % 3] = std::min(low[i % 3], out.data[i]);
            high[i % 3] = std::max(high[i % 3], out.data[i]);
        }
        for (std::size_t i = 0; i < out.data.size(); ++i) {
            const float range = high[i % 3] - low[i % 3];
            out.data[i] = range > 0 ? linearFromSrgb((out.data[i] - low[i % 3]) / range) : 0;
        }
    } else if (channel == "ao" || channel == "soft_shadow" || channel == "voxel_opacity") {
        for (float& v : out.data) v = linearFromSrgb(std::clamp(v, 0.0f, 1.0f));
    } else if (channel == "seam") {
        for (float& v : out.data) v = std::abs(v);
        return heatmap(out, 0.1);
    } else if (channel != "albedo" && channel != "voxel_albedo" && channel != "cascade") {
        const auto exposure = static_cast<float>(std::exp2(settings.output.exposure));
        for (float& v : out.data) v = std::clamp(exposure * v, 0.0f, 1.0f);
    }
    return out;
}

Image displayOf(const Image& radiance, ToneMap curve) {
    Image out = radiance;
    for (std::size_t i = 0; i + 2 < out.data.size(); i += 3) {
        const glm::vec3 shown = toneCurve(curve, {out.data[i], out.data[i + 1], out.data[i + 2]});
        out.data[i] = shown.x, out.data[i + 1] = shown.y, out.data[i + 2] = shown.z;
    }
    return out;
}

json statsHead(const char* command, const CaptureScript& script, const Shot& shot) {
    const Camera camera = cameraAt(shot, script.scene, shot.timeOf(shot.firstFrame));
    return {{"program", {{"name", "voxcone"}, {"version", VOXCONE_VERSION}, {"command", command}}},
            {"scene", describeScene(script.scene)},
            {"shot",
             {{"name", shot.name},
              {"channels", shot.channels},
              {"frames", {{"first", shot.firstFrame}, {"last", shot.lastFrame}}},
              {"fps", shot.fps},
              {"start_s", shot.start},
              {"camera",
               {{"position", array(camera.position)},
                {"target", array(camera.target)},
                {"up", array(camera.up)},
                {"fov_deg", camera.verticalFovDeg}}}}},
            {"settings", toJson(script.settings)}};
}

json describeScene(const Scene& scene) {
    constexpr std::array kTypes = {"directional", "point", "spot", "sphere", "rectangle"};
    json lights = json::object();
    for (const char* type : kTypes) {
        const auto count = std::count_if(scene.lights.begin(), scene.lights.end(), [&](const Light& light) {
            return std::string(kTypes[static_cast<std::size_t>(light.type)]) == type;
        });
        if (count > 0) lights[type] = count;
    }
    std::size_t closed = 0, total = 0;
    for (const Instance& instance : scene.instances) {
        const Mesh& mesh = scene.meshes[static_cast<std::size_t>(instance.mesh)];
        closed += static_cast<std::size_t>(std::count(mesh.closed.begin(), mesh.closed.end(), std::uint8_t{1}));
        total += mesh.indices.size() / 3;
    }
    std::size_t textureBytes = 0;
    for (const Texture& texture : scene.textures) textureBytes += texture.rgba8.size();
    const Bounds bounds = scene.bounds();
    const Environment& environment = scene.environment;
    json sky = "none";
    if (!environment.black() && environment.radiance.empty()) sky = "constant";
    if (!environment.black() && !environment.radiance.empty())
        sky = fmt::format("{}x{} panorama", environment.width, environment.height);
    json out = {{"file", scene.file.string()},
                {"triangles", total},
                {"closed_triangles", closed},
                {"meshes", scene.meshes.size()},
                {"instances", scene.instances.size()},
                {"materials", scene.materials.size()},
                {"emitting_materials", std::count_if(scene.materials.begin(), scene.materials.end(),
                                                     [](const Material& m) { return m.emits(); })},
                {"textures", scene.textures.size()},
                {"texture_bytes", textureBytes},
                {"lights", lights},
                {"cameras", scene.cameras.size()},
                {"animations", scene.animations.size()},
                {"environment", sky}};
    if (!bounds.empty()) out["bounds"] = {{"min", array(bounds.min)}, {"max", array(bounds.max)}};
    return out;
}

}  // namespace voxcone
