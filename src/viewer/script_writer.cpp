#include "viewer/script_writer.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "capture/strict_json.h"
#include "core/atomic_file.h"

namespace voxcone {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

template <class Vector>
json three(const Vector& v) {
    return {v.x, v.y, v.z};
}

json cameraTree(const SavedView& view) {
    const Camera& c = view.camera;
    json tree = {{"up", three(c.up)}, {"fov_deg", c.verticalFovDeg}};
    if (c.near > 0) tree["near"] = c.near;
    if (c.far > 0) tree["far"] = c.far;
    if (view.path.empty()) {
        tree["position"] = three(c.position);
        tree["target"] = three(c.target);
        return tree;
    }
    tree["path"] = json::array();
    for (std::size_t i = 0; i < view.path.position.times.size(); ++i)
        tree["path"].push_back({{"time", view.time + view.path.position.times[i]},
                                {"position", three(view.path.position.values[i])},
                                {"target", three(view.path.target.values[i])}});
    return tree;
}

/// A light in full, as a script gives it.
json lightTree(const Light& light) {
    constexpr std::array kTypes = {"directional", "point", "spot", "sphere", "rectangle"};
    json tree = {{"type", kTypes[static_cast<std::size_t>(light.type)]},
                 {"name", light.name},
                 {"intensity", three(light.intensity)}};
    if (light.type != LightType::directional) tree["position"] = three(light.position);
    if (light.type == LightType::directional || light.type == LightType::spot || light.type == LightType::rectangle)
        tree["direction"] = three(light.direction);
    if (light.type == LightType::directional) tree["angular_radius_deg"] = glm::degrees(light.angularRadius);
    if (light.type == LightType::sphere) tree["radius"] = light.radius;
    return tree;
}

/// Paths of a script as they are seen from anywhere.
void makeAbsolute(json& path, const fs::path& script) {
    const fs::path file = path.get<std::string>();
    if (file.is_relative()) path = fs::absolute(script.parent_path() / file).lexically_normal().string();
}

}  // namespace

int SavedView::frames() const {
    if (path.empty()) return 1;
    const double seconds = path.position.times.back() - path.position.times.front();
    return std::max(1, static_cast<int>(std::floor(seconds * fps + 1e-9)) + 1);
}

json captureScript(const ScriptSource& source, const std::vector<Light>& lights, const Settings& settings,
                   const std::vector<SavedView>& views, std::vector<std::string>& lost) {
    json tree = {{"version", 1}};
    const bool script = source.file.extension() == ".json";
    if (script) {
        const json given = parseStrictly(readTextFile(source.file), source.file.string());
        for (const char* key : {"scene", "environment", "lights", "objects"})
            if (given.contains(key)) tree[key] = given[key];
        makeAbsolute(tree["scene"], source.file);
        if (tree.contains("environment") && tree["environment"].contains("image"))
            makeAbsolute(tree["environment"]["image"], source.file);
    } else {
        tree["scene"] = fs::absolute(source.file).lexically_normal().string();
        const Environment& environment = source.outline->environment;
        if (!environment.black()) tree["environment"] = {{"color", three(environment.color)}};
    }
    if (!source.environment.empty())
        tree["environment"] = {{"image", fs::absolute(source.environment).lexically_normal().string()}};

    // Lights of the script come after those of the scene, in its order; a bare scene may have got a sun.
    const std::vector<Light>& before = source.outline->lights;
    std::size_t own = 0;
    for (std::size_t i = 0; i < lights.size() && i < before.size(); ++i) {
        if (lights[i].extracted) continue;
        const bool moved = !(lights[i] == before[i]);
        if (lights[i].node >= 0) {
            if (moved) lost.push_back(lights[i].name);
            continue;
        }
        if (!script) {
            tree["lights"].push_back(lightTree(lights[i]));
            continue;
        }
        json& given = tree["lights"][own++];
        if (!moved) continue;
        const json full = lightTree(lights[i]);
        for (const char* key : {"position", "direction", "intensity"})
            if (given.contains(key) && full.contains(key)) given[key] = full[key];
    }

    tree["settings"] = toJson(settings);
    tree["shots"] = json::array();
    for (const SavedView& view : views) {
        json shot = {{"name", view.name}, {"camera", cameraTree(view)}, {"channels", {view.channel}}};
        if (view.time != 0) shot["start"] = view.time;
        if (!view.path.empty()) shot["frames"] = view.frames(), shot["fps"] = view.fps;
        tree["shots"].push_back(std::move(shot));
    }
    return tree;
}

}  // namespace voxcone
