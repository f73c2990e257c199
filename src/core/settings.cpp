#include "core/settings.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "core/atomic_file.h"
#include "core/error.h"
#include "core/nearest.h"

namespace voxcone {

using nlohmann::json;

namespace {

// Built-in presets say only what differs from the defaults. `thesis` is voxel cone tracing as the 2017 thesis describes
// it (Y. ten Brug, Utrecht University, §3.4):
// isotropic voxels written binary with a compare-and-swap average, nine 60° cones stepped by their diameter, the nudge
// of its eq. 3.4.
struct Preset {
    const char* name;
    const char* tree;
};
constexpr Preset kPresets[] = {
    {"thesis", R"({"voxel": {"storage": "isotropic", "averaging": "compare_and_swap", "coverage": "binary"},
                   "light": {"bounces": 0, "extrapolate": false, "extract_environment": 0, "extract_emitters": 0},
                   "cone": {"diffuse": 9, "compositing": "alpha", "start": "nudge", "footprint_cap": 0, "step": 1,
                            "rotate": false},
                   "specular": {"aperture": "linear"}})"},
    {"fast",
     R"({"light": {"bounces": 2, "bounce_cones": 5}, "cone": {"diffuse": 6, "step": 1.5, "footprint_cap": 6, "near_field": 8},
         "specular": {"cones": 2}})"},
    {"balanced", "{}"},
    {"accurate", R"({"light": {"bounces": 6, "bounce_cones": 16},
                     "cone": {"diffuse": 32, "footprint_cap": 16, "near_field": 32},
                     "specular": {"cones": 8, "step": 0.5}})"},
};

template <class E>
Field choice(const char* key, E& e, std::vector<std::string> names, const char* meaning) {
    Field field;
    field.key = key;
    field.value =
        Field::Choice{[&e] { return static_cast<int>(e); }, [&e](int i) { e = static_cast<E>(i); }, std::move(names)};
    field.meaning = meaning;
    return field;
}

Field number(const char* key, double& d, double min, double max, const char* unit, const char* meaning) {
    return {key, &d, min, max, {}, unit, meaning};
}
Field integer(const char* key, int& i, int min, int max, const char* unit, const char* meaning) {
    return {key, &i, static_cast<double>(min), static_cast<double>(max), {}, unit, meaning};
}
Field oneOf(const char* key, int& i, std::vector<int> allowed, const char* unit, const char* meaning) {
    const auto [min, max] = std::minmax_element(allowed.begin(), allowed.end());
    const double lowest = *min, highest = *max;
    return {key, &i, lowest, highest, std::move(allowed), unit, meaning};
}
Field flag(const char* key, bool& b, const char* meaning) {
    return {key, &b, 0, 1, {}, "", meaning};
}

std::string rangeOf(const Field& field) {
    if (std::holds_alternative<bool*>(field.value)) return "true or false";
    if (const auto* c = std::get_if<Field::Choice>(&field.value))
        return fmt::format("one of {}", fmt::join(c->names, ", "));
    if (!field.allowed.empty()) return fmt::format("one of {}", fmt::join(field.allowed, ", "));
    return fmt::format("{} to {}", field.min, field.max);
}

std::string valueOf(const Field& field) {
    if (const auto* b = std::get_if<bool*>(&field.value)) return **b ? "true" : "false";
    if (const auto* i = std::get_if<int*>(&field.value)) return fmt::format("{}", **i);
    if (const auto* d = std::get_if<double*>(&field.value)) return fmt::format("{}", **d);
    const auto& c = std::get<Field::Choice>(field.value);
    return c.names[static_cast<std::size_t>(c.get())];
}

/// Stores `value`; returns false when it has the wrong type or is out of range.
bool store(const Field& field, const json& value) {
    if (const auto* b = std::get_if<bool*>(&field.value)) {
        if (!value.is_boolean()) return false;
        **b = value.get<bool>();
        return true;
    }
    if (const auto* c = std::get_if<Field::Choice>(&field.value)) {
        if (!value.is_string()) return false;
        const auto found = std::find(c->names.begin(), c->names.end(), value.get<std::string>());
        if (found == c->names.end()) return false;
        c->set(static_cast<int>(found - c->names.begin()));
        return true;
    }
    if (!value.is_number()) return false;
    const double d = value.get<double>();
    if (!(d >= field.min && d <= field.max)) return false;
    if (const auto* target = std::get_if<double*>(&field.value)) {
        **target = d;
        return true;
    }
    const int i = static_cast<int>(d);
    if (static_cast<double>(i) != d) return false;
    if (!field.allowed.empty() && std::find(field.allowed.begin(), field.allowed.end(), i) == field.allowed.end())
        return false;
    *std::get<int*>(field.value) = i;
    return true;
}

std::string unknownKey(const std::vector<Field>& all, const std::string& key) {
    std::vector<std::string> keys;
    for (const Field& field : all) keys.push_back(field.key);
    return fmt::format("unknown setting \"{}\"; did you mean \"{}\"?", key, nearestWord(keys, key));
}

std::string badValue(const Field& field, const std::string& given) {
    return fmt::format("{} is not a value of {}: {}{}", given, field.key, rangeOf(field),
                       field.unit.empty() ? "" : " " + field.unit);
}

void applyTree(std::vector<Field>& all, const json& tree, const std::string& prefix, const std::string& file,
               const std::string& path) {
    if (!tree.is_object()) throw InputError(file, path, "must be an object");
    for (const auto& [name, value] : tree.items()) {
        if (prefix.empty() && name == "preset") continue;
        const std::string key = prefix.empty() ? name : prefix + "." + name;
        const auto field = std::find_if(all.begin(), all.end(), [&](const Field& f) { return f.key == key; });
        if (field != all.end()) {
            if (!store(*field, value)) throw InputError(file, path + "." + name, badValue(*field, value.dump()));
            continue;
        }
        const bool group =
            std::any_of(all.begin(), all.end(), [&](const Field& f) { return f.key.rfind(key + ".", 0) == 0; });
        if (!group) throw InputError(file, path + "." + name, unknownKey(all, key));
        applyTree(all, value, key, file, path + "." + name);
    }
}

}  // namespace

std::vector<Field> fields(Settings& s) {
    return {
        integer("output.width", s.output.width, 1, 16384, "pixels", "width of the picture"),
        integer("output.height", s.output.height, 1, 16384, "pixels", "height of the picture"),
        integer("output.supersample", s.output.supersample, 1, 8, "",
                "n x n samples a pixel on a regular grid, averaged; the path tracer uses the same grid"),
        number("output.exposure", s.output.exposure, -32, 32, "EV",
               "the picture is scaled by 2^exposure before tone mapping"),
        choice("output.tone_map", s.output.toneMap, {"linear", "reinhard", "aces"}, "tone curve of the beauty PNG"),
        oneOf("voxel.resolution", s.voxel.resolution, {16, 32, 64, 128, 256}, "voxels",
              "edge of the voxel grid, of each level"),
        choice("voxel.storage", s.voxel.storage, {"isotropic", "six_face", "sh1"},
               "what cones see of a voxel: one value, one a face, or one opacity and spherical harmonics"),
        choice("voxel.averaging", s.voxel.averaging, {"integer_sum", "compare_and_swap"},
               "how fragments of a voxel are averaged; compare_and_swap depends on their order"),
        choice("voxel.coverage", s.voxel.coverage, {"area", "binary"},
               "opacity of a voxel: projected area of the clipped triangles, or 1 when touched"),
        flag("voxel.conservative", s.voxel.conservative, "every touched voxel gets a fragment"),
        number("voxel.size", s.voxel.size, 0, 1e9, "m",
               "edge of a voxel of the finest level; 0 = such that the last level just holds the scene"),
        integer("voxel.margin", s.voxel.margin, 0, 8, "voxels", "empty voxels kept around the scene"),
        integer("cascade.levels", s.cascade.levels, 1, 8, "",
                "clipmap levels around the camera, each twice as large; fewer when fewer hold the scene"),
        oneOf("cascade.snap", s.cascade.snap, {1, 2, 4, 8, 16, 32, 64}, "voxels",
              "a level moves in steps of this many of its voxels, at most a quarter of voxel.resolution"),
        number("cascade.band", s.cascade.band, 0.001, 0.2, "",
               "outer part of a level that blends with the next one, over the level's size"),
        choice("cascade.center", s.cascade.center, {"camera", "window"},
               "levels blend around the camera, or around the snapped window of the finest one, as in the thesis"),
        choice("cascade.update", s.cascade.update, {"exact", "budget"},
               "each frame: all levels that the camera has left, or as many as the budget allows"),
        integer("cascade.budget", s.cascade.budget, 1, 8, "levels",
                "levels that a frame may update, in turns, with cascade.update = budget"),
        oneOf("light.shadow_resolution", s.light.shadowResolution, {128, 256, 512, 1024, 2048, 4096, 8192}, "texels",
              "edge of a directional or spot light's map; a cube face has half of it, one of an area light a quarter"),
        number("light.shadow_filter", s.light.shadowFilter, 0, 8, "texels", "radius of the shadow map filter"),
        integer("light.bounces", s.light.bounces, 0, 64, "",
                "bounces between voxels before the one the picture's cones gather"),
        number("light.tolerance", s.light.tolerance, 0, 1, "",
               "bounces end before their number when one adds less than this share of the light reflected; 0 = never"),
        oneOf("light.bounce_cones", s.light.bounceCones, {1, 5, 6, 9, 16, 32}, "",
              "cones a voxel face gathers a bounce with"),
        flag("light.extrapolate", s.light.extrapolate,
             "add the bounces that were left out as the geometric series of the last two"),
        integer("light.extract_environment", s.light.extractEnvironment, 0, 16, "lights",
                "small bright parts of the panorama that become directional lights, at most"),
        integer("light.extract_emitters", s.light.extractEmitters, 0, 64, "lights",
                "rectangles of small emitting meshes that become rectangle lights, at most"),
        oneOf("cone.diffuse", s.cone.diffuse, {1, 5, 6, 9, 16, 32}, "", "diffuse cones a pixel"),
        number("cone.step", s.cone.step, 0.1, 4, "footprints", "distance between samples"),
        choice("cone.compositing", s.cone.compositing, {"linear", "exponential", "alpha"},
               "transmittance: 1 - g*tau, exp(-g*tau), or product of 1 - alpha"),
        number("cone.gain", s.cone.gain, 0.1, 8, "", "g of the compositing rule"),
        number("cone.footprint_cap", s.cone.footprintCap, 0, 64, "",
               "footprint is at most the height above the tangent plane over this; 0 = no cap"),
        choice("cone.start", s.cone.start, {"normal", "nudge"},
               "start offset along the normal, or the nudge along the cone of Rauwendaal"),
        number("cone.offset", s.cone.offset, 0, 8, "voxels", "least height above the surface where the filtered volumes are sampled, times |n|_1; sh1 and isotropic need 1.5 voxels of the level read"),
        number("cone.near_field", s.cone.nearField, 0, 64, "voxels",
               "so far cones meet the surfaces in voxels exactly instead of filtered; 0 = not at all"),
        number("cone.nudge", s.cone.nudge, 0, 8, "voxel diagonals", "nudge factor"),
        flag("cone.rotate", s.cone.rotate, "cone sets are turned about the normal from pixel to pixel and filtered"),
        number("cone.max_distance", s.cone.maxDistance, 0, 1e9, "m",
               "cones end there; 0 = at the edge of the last level"),
        flag("specular.enabled", s.specular.enabled, "trace a specular cone"),
        choice("specular.aperture", s.specular.aperture, {"ggx", "linear"},
               "cone angle: matched to the GGX lobe, or 1 to 80 degrees linear in roughness"),
        oneOf("specular.cones", s.specular.cones, {1, 2, 4, 8, 16}, "",
              "cones of a rough GGX lobe; smooth ones take one"),
        number("specular.step", s.specular.step, 0.1, 4, "footprints", "distance between samples of the specular cone"),
        number("ao.distance", s.ao.distance, 0, 1e9, "m", "occluders farther away do not count; 0 = all count"),
        choice("ao.falloff", s.ao.falloff, {"none", "linear", "square_root"},
               "weight of an occluder over its distance"),
        flag("shadow.cones", s.shadow.cones,
             "trace cones to the lights for the channel soft_shadow; direct light keeps its shadow maps"),
        integer("shadow.cone_count", s.shadow.coneCount, 1, 32, "", "cones that share a sphere or rectangle of light"),
        integer("reference.samples", s.reference.samples, 2, 1 << 20, "per pixel", "paths of the reference"),
        number("reference.error", s.reference.error, 0, 1, "",
               "stop early when the reference's own relative error is below this; 0 = never"),
        integer("reference.max_depth", s.reference.maxDepth, 1, 10000, "segments", "longest path of the reference"),
        integer("reference.seed", s.reference.seed, 0, 2147483647, "", "seed of the reference's sample sequences"),
        choice("device.timer", s.device.timer, {"automatic", "query", "finish"},
               "pass times by GL queries, or by glFinish and a clock (automatic: finish on software rasterisers)"),
    };
}

void applyJson(Settings& settings, const json& tree, const std::string& file, const std::string& path) {
    if (!tree.is_object()) throw InputError(file, path, "must be an object");
    if (const auto preset = tree.find("preset"); preset != tree.end()) {
        if (!preset->is_string()) throw InputError(file, path + ".preset", "must be a name or a file");
        auto name = preset->get<std::string>();
        // A file is relative to the file that names it.
        if (name.size() > 5 && name.ends_with(".json") && std::filesystem::path(name).is_relative())
            name = (std::filesystem::path(file).parent_path() / name).string();
        try {
            applyPreset(settings, name);
        } catch (const UsageError& error) {
            throw InputError(file, path + ".preset", error.what());
        }
    }
    auto all = fields(settings);
    applyTree(all, tree, "", file, path);
}

void applyAssignment(Settings& settings, const std::string& assignment) {
    const auto equals = assignment.find('=');
    if (equals == std::string::npos || equals == 0)
        throw UsageError(fmt::format("--set {}: expected key=value, e.g. --set voxel.resolution=64", assignment));
    const std::string key = assignment.substr(0, equals), text = assignment.substr(equals + 1);
    if (key == "preset") return applyPreset(settings, text);
    const auto all = fields(settings);
    const auto field = std::find_if(all.begin(), all.end(), [&](const Field& f) { return f.key == key; });
    if (field == all.end()) throw UsageError(fmt::format("--set {}: {}", assignment, unknownKey(all, key)));
    json value = json::parse(text, nullptr, false);
    if (value.is_discarded() || std::holds_alternative<Field::Choice>(field->value)) value = text;
    if (!store(*field, value)) throw UsageError(fmt::format("--set {}: {}", assignment, badValue(*field, text)));
}

void applyPreset(Settings& settings, const std::string& nameOrFile) {
    for (const Preset& preset : kPresets) {
        if (preset.name != nameOrFile) continue;
        const Settings::Output output = settings.output;  // a preset is about the method, not about the picture's size
        const Settings::Reference reference = settings.reference;
        settings = Settings{};
        settings.output = output, settings.reference = reference;
        auto all = fields(settings);
        applyTree(all, json::parse(preset.tree), "", preset.name, "preset");
        return;
    }
    if (!nameOrFile.ends_with(".json"))
        throw UsageError(fmt::format("unknown preset \"{}\"; there are {} and JSON files", nameOrFile,
                                     fmt::join(presetNames(), ", ")));
    json tree;
    try {
        tree = json::parse(readTextFile(nameOrFile));
    } catch (const json::parse_error& error) {
        throw InputError(nameOrFile, fmt::format("byte {}", error.byte), "not valid JSON");
    }
    applyJson(settings, tree, nameOrFile, "preset");
}

std::vector<std::string> presetNames() {
    std::vector<std::string> names;
    for (const Preset& preset : kPresets) names.emplace_back(preset.name);
    return names;
}

json toJson(const Settings& settings) {
    Settings copy = settings;
    json tree = json::object();
    for (const Field& field : fields(copy)) {
        std::string pointer = "/" + field.key;
        std::replace(pointer.begin(), pointer.end(), '.', '/');
        json& leaf = tree[json::json_pointer(pointer)];
        if (const auto* b = std::get_if<bool*>(&field.value))
            leaf = **b;
        else if (const auto* i = std::get_if<int*>(&field.value))
            leaf = **i;
        else if (const auto* d = std::get_if<double*>(&field.value))
            leaf = **d;
        else
            leaf = valueOf(field);
    }
    return tree;
}

std::string describeSettings() {
    Settings defaults;
    std::string text;
    for (const Field& field : fields(defaults))
        text += fmt::format("  {:<24} {:<12} {}{}\n{:40}{}\n", field.key, valueOf(field), rangeOf(field),
                            field.unit.empty() ? "" : " " + field.unit, "", field.meaning);
    return text;
}

}  // namespace voxcone
