#include "viewer/script_writer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include "capture/motion.h"
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
    if (light.type == LightType::rectangle) tree["up"] = three(light.up);
    if (light.type == LightType::directional) tree["angular_radius_deg"] = glm::degrees(light.angularRadius);
    if (light.type == LightType::sphere) tree["radius"] = light.radius;
    return tree;
}

/// The entry of `list` that `matches`, or a new one whose `key` is `reference`.
json& entryOf(json& list, const char* key, const json& reference, const std::function<bool(JsonObject&)>& matches) {
    for (json& entry : list) {
        JsonObject object(entry, "", "");
        if (matches(object)) return entry;
    }
    list.push_back({{key, reference}});
    return list.back();
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

json captureScript(const ScriptSource& source, const std::vector<Light>& lights, const std::map<int, Placement>& placed,
                   const Settings& settings, const std::vector<SavedView>& views) {
    json tree = {{"version", 1}};
    const bool script = source.file.extension() == ".json";
    if (script) {
        const json given = parseStrictly(readTextFile(source.file), source.file.string());
        for (const char* key : {"scene", "environment", "scene_lights", "lights", "objects"})
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
        const json full = lightTree(lights[i]);
        if (lights[i].node >= 0) {
            if (!moved) continue;
            const json was = lightTree(before[i]);
            json& given = entryOf(tree["scene_lights"], "light", sceneLightReference(*source.outline, i),
                                  [&](JsonObject& entry) { return readSceneLightIndex(entry, *source.outline) == i; });
            if (lights[i].intensity != before[i].intensity) given.erase("off");
            for (const char* key : {"position", "direction", "intensity"})
                if (full.contains(key) && full[key] != was[key]) given[key] = full[key];
            continue;
        }
        if (!script) {
            tree["lights"].push_back(full);
            continue;
        }
        json& given = tree["lights"][own++];
        if (!moved) continue;
        for (const char* key : {"position", "direction", "intensity"})
            if (given.contains(key) && full.contains(key)) given[key] = full[key];
        if (lights[i].up != before[i].up) given["up"] = full["up"];
    }
    for (const auto& [node, placement] : placed) {
        json& given = entryOf(tree["objects"], "node", nodeReference(*source.outline, node),
                              [&](JsonObject& entry) { return readNode(entry, *source.outline) == node; });
        if (placement.translation) given["translation"] = three(*placement.translation);
        if (placement.rotation) given["rotation"] = three(*placement.rotation);
        if (placement.scale) given["scale"] = three(*placement.scale);
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
