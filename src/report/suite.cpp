#include "report/suite.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <utility>

#include "capture/strict_json.h"
#include "core/atomic_file.h"
#include "core/error.h"
#include "core/log.h"
#include "report/evaluate.h"
#include "report/sha256.h"

namespace voxcone {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

/// A grid multiplies quickly; more than this is a slip.
constexpr std::size_t kMostConfigurations = 100000;

// ---- Settings in a suite

/// References are the suite's own, and a preset would undo what stands before it.
void checkSettings(const json& tree, const std::string& file, const std::string& path) {
    if (!tree.is_object()) throw InputError(file, path, "must be an object, is " + jsonKind(tree));
    if (tree.contains("reference"))
        throw InputError(file, path + ".reference", "belongs to the key reference of the suite or of its views");
    if (tree.contains("preset")) throw InputError(file, path + ".preset", "belongs to a configuration");
    Settings probe;
    applyJson(probe, tree, file, path);
}

/// {"cone.diffuse": 5} as {"cone": {"diffuse": 5}}.
json nested(const json& flat) {
    json tree = json::object();
    for (const auto& [key, value] : flat.items()) {
        std::string pointer = "/" + key;
        std::replace(pointer.begin(), pointer.end(), '.', '/');
        tree[json::json_pointer(pointer)] = value;
    }
    return tree;
}

/// The other way.
void flatten(const json& tree, const std::string& prefix, json& flat) {
    for (const auto& [key, value] : tree.items()) {
        const std::string full = prefix.empty() ? key : prefix + "." + key;
        if (value.is_object())
            flatten(value, full, flat);
        else
            flat[full] = value;
    }
}

void checkPreset(const json& preset, const std::string& file, const std::string& path) {
    Settings probe;
    applyJson(probe, {{"preset", preset}}, file, path.substr(0, path.rfind('.')));
}

/// Keys and values of one point of a sweep, with "preset" among them.
using Point = std::vector<std::pair<std::string, json>>;

void checkPoint(const Point& point, const std::string& file, const std::string& path) {
    json flat = json::object();
    for (const auto& [key, value] : point) {
        if (key.empty() || key.front() == '.' || key.back() == '.' || key.find("..") != std::string::npos ||
            key.find_first_of("/~") != std::string::npos)
            throw InputError(file, path + "." + key, "is no key of settings");
        if (key == "preset")
            checkPreset(value, file, path + ".preset");
        else
            flat[key] = value;
    }
    checkSettings(nested(flat), file, path);
}

// ---- Configurations

/// All points of a grid, the last key running fastest. Order of keys is that of the alphabet.
std::vector<Point> gridPoints(const JsonObject& entry, const json& grid) {
    if (!grid.is_object() || grid.empty()) entry.fail("grid", "must be an object with at least one setting");
    std::vector<Point> points = {{}};
    for (const auto& [key, values] : grid.items()) {
        if (!values.is_array() || values.empty()) entry.fail("grid." + key, "must be an array with at least one value");
        std::vector<Point> next;
        for (const Point& point : points) {
            for (const json& value : values) {
                next.push_back(point);
                next.back().emplace_back(key, value);
            }
        }
        points = std::move(next);
        if (points.size() > kMostConfigurations) entry.fail("grid", "has too many points");
    }
    return points;
}

std::vector<Point> listPoints(const JsonObject& entry, const json& list) {
    if (!list.is_array() || list.empty()) entry.fail("list", "must be an array with at least one object");
    std::vector<Point> points;
    for (std::size_t i = 0; i < list.size(); ++i) {
        if (!list[i].is_object()) entry.fail(fmt::format("list[{}]", i), "must be an object of settings");
        Point& point = points.emplace_back();
        for (const auto& [key, value] : list[i].items()) point.emplace_back(key, value);
    }
    return points;
}

std::string valueText(const json& value) {
    return value.is_string() ? value.get<std::string>() : value.dump();
}

std::vector<std::string> strings(JsonObject& object, const std::string& key) {
    std::vector<std::string> out;
    const json* list = object.find(key);
    if (list == nullptr) return out;
    if (!list->is_array() || list->empty()) object.fail(key, "must be an array with at least one name");
    for (std::size_t i = 0; i < list->size(); ++i) {
        if (!(*list)[i].is_string()) object.fail(fmt::format("{}[{}]", key, i), "must be a name");
        out.push_back((*list)[i].get<std::string>());
    }
    return out;
}

void readConfigurations(JsonObject entry, Suite& suite) {
    SuiteConfiguration base;
    base.path = entry.pathOf("");
    if (const json* preset = entry.find("preset")) {
        checkPreset(*preset, entry.file(), entry.pathOf("preset"));
        base.preset = preset->get<std::string>();
    }
    if (const json* settings = entry.find("settings")) {
        checkSettings(*settings, entry.file(), entry.pathOf("settings"));
        flatten(*settings, "", base.set);
    }
    base.multiplyAo = entry.boolean("multiply_ao", false);
    base.scenes = strings(entry, "scenes");
    const json *grid = entry.find("grid"), *list = entry.find("list");
    if (entry.find("id") != nullptr || (grid == nullptr && list == nullptr)) base.id = entry.string("id");
    entry.finish();
    if (grid != nullptr && list != nullptr) entry.fail("list", "stands beside a grid; give each an entry of its own");

    const std::vector<Point> points = grid   ? gridPoints(entry, *grid)
                                      : list ? listPoints(entry, *list)
                                             : std::vector<Point>{{}};
    for (std::size_t i = 0; i < points.size(); ++i) {
        const std::string path = list   ? fmt::format("{}[{}]", entry.pathOf("list"), i)
                                 : grid ? entry.pathOf("grid")
                                        : base.path;
        checkPoint(points[i], entry.file(), path);
        SuiteConfiguration configuration = base;
        for (const auto& [key, value] : points[i]) {
            if (key == "preset")
                configuration.preset = value.get<std::string>();
            else
                configuration.set[key] = value;
            configuration.id += fmt::format("{}{}={}", configuration.id.empty() ? "" : " ", key, valueText(value));
        }
        suite.configurations.push_back(std::move(configuration));
        if (suite.configurations.size() > kMostConfigurations) entry.fail("", "too many configurations");
    }
}

// ---- Views

/// Changes `reference` by the object at `key`, if there is one.
void readReferenceSettings(JsonObject& parent, Settings::Reference& reference) {
    const json* tree = parent.find("reference");
    if (tree == nullptr) return;
    JsonObject object(*tree, parent.file(), parent.pathOf("reference"));
    Settings settings;
    settings.reference = reference;
    for (Field& field : fields(settings)) {
        if (!field.key.starts_with("reference.")) continue;
        const std::string name = field.key.substr(std::string("reference.").size());
        if (auto* const* whole = std::get_if<int*>(&field.value))
            **whole = object.integer(name, **whole, static_cast<int>(field.min), static_cast<int>(field.max));
        else if (auto* const* real = std::get_if<double*>(&field.value))
            **real = object.number(name, **real, field.min, field.max);
    }
    object.finish();
    reference = settings.reference;
}

/// The name becomes part of names of files.
std::string readName(JsonObject& object, const std::string& key) {
    std::string name = object.string(key);
    const bool plain = std::all_of(name.begin(), name.end(),
                                   [](unsigned char c) { return std::isalnum(c) || c == '_' || c == '-' || c == '.'; });
    if (name.empty() || name.size() > 100 || name[0] == '.' || !plain)
        object.fail(key, "must be 1 to 100 letters, digits, '_', '-' or '.', and not begin with '.'");
    return name;
}

Shot readCamera(JsonObject object) {
    Shot shot;
    shot.name = readName(object, "name");
    shot.camera.position = object.vector("position", -kLargest, kLargest);
    shot.camera.target = object.vector("target", -kLargest, kLargest);
    shot.camera.up = object.find("up") != nullptr ? object.direction("up") : glm::dvec3(0, 1, 0);
    shot.camera.verticalFovDeg = object.number("fov_deg", 45, 1, 179, "degrees");
    shot.channels = {"beauty"};
    object.finish();
    const glm::dvec3 view = shot.camera.target - shot.camera.position;
    if (glm::length(glm::cross(view, shot.camera.up)) < 1e-9 * glm::length(view))
        object.fail("target", "must not be the position, nor lie above or below it along up");
    return shot;
}

std::vector<int> readFrames(JsonObject& entry, const Shot& shot) {
    const json* list = entry.find("frames");
    if (list == nullptr) return {shot.firstFrame};
    if (!list->is_array() || list->empty()) entry.fail("frames", "must be an array with at least one number");
    std::vector<int> frames;
    for (std::size_t i = 0; i < list->size(); ++i) {
        const json& value = (*list)[i];
        const std::string at = fmt::format("frames[{}]", i);
        if (!value.is_number_integer()) entry.fail(at, "must be a whole number");
        const auto frame = value.get<std::int64_t>();
        if (frame < shot.firstFrame || frame > shot.lastFrame)
            entry.fail(at, fmt::format("{} is no frame of shot {}: {} to {}", frame, shot.name, shot.firstFrame,
                                       shot.lastFrame));
        frames.push_back(static_cast<int>(frame));
    }
    return frames;
}

/// `scenes`: glTF files by name of scene; `textHash` gets the text of scripts.
void readViews(JsonObject entry, const Settings::Reference* common, const std::map<std::string, fs::path>& scenes,
               Suite& suite, std::set<std::string>& names, Sha256& textHash) {
    const std::string name = readName(entry, "scene");
    if (!names.insert(name).second) entry.fail("scene", fmt::format("\"{}\" is another scene's name already", name));
    fs::path file = entry.string("script");
    const std::string given = file.string();
    if (file.is_relative()) file = suite.file.parent_path() / file;
    const bool optional = entry.boolean("optional", false);
    const std::vector<std::string> wanted = strings(entry, "shots");
    const json* cameras = entry.find("cameras");
    json settings = json::object();
    if (const json* tree = entry.find("settings")) {
        checkSettings(*tree, entry.file(), entry.pathOf("settings"));
        settings = *tree;
    }

    const auto replaced = scenes.find(name);
    fs::path scene = replaced == scenes.end() ? fs::path() : replaced->second;
    if (!scene.empty() && file.extension() != ".json") file = std::exchange(scene, {});
    if (optional && replaced == scenes.end()) {
        fs::path needed = file;
        if (file.extension() == ".json" && fs::exists(file)) {
            const json script = parseStrictly(readTextFile(file), file.string());
            const auto path = script.find("scene");
            if (path != script.end() && path->is_string()) needed = file.parent_path() / path->get<std::string>();
        }
        if (!fs::exists(needed)) {
            log::info("{} is left out: there is no {}; give it by --scene {}=FILE.gltf", name, needed.string(), name);
            for (const char* key : {"reference", "frames"}) entry.find(key);
            entry.finish();
            return;
        }
    }
    if (!fs::exists(file)) entry.fail("script", fmt::format("no such file: {}", file.string()));
    suite.scripts.push_back(std::make_unique<CaptureScript>(loadCaptureScript(file, scene)));
    const CaptureScript& script = *suite.scripts.back();
    if (file.extension() == ".json") textHash.text(readTextFile(file));

    SuiteView view;
    view.scene = name, view.script = &script, view.file = given;
    view.settings = settings, view.path = entry.pathOf("settings");
    view.reference = common ? *common : script.settings.reference;
    readReferenceSettings(entry, view.reference);
    std::vector<Shot> shots = script.shots;
    if (cameras != nullptr) {
        if (!cameras->is_array() || cameras->empty())
            entry.fail("cameras", "must be an array with at least one camera");
        // Cameras of the suite stand for the script's shots unless these are named too.
        if (wanted.empty()) shots.clear();
        for (std::size_t i = 0; i < cameras->size(); ++i)
            shots.push_back(
                readCamera(JsonObject((*cameras)[i], entry.file(), entry.pathOf(fmt::format("cameras[{}]", i)))));
    }
    for (std::size_t i = 0; i < wanted.size(); ++i) {
        if (std::none_of(script.shots.begin(), script.shots.end(), [&](const Shot& s) { return s.name == wanted[i]; }))
            entry.fail(fmt::format("shots[{}]", i), fmt::format("\"{}\" is no shot of {}", wanted[i], given));
    }
    for (std::size_t i = 0; i < shots.size(); ++i) {
        const Shot& shot = shots[i];
        const bool ofScript = i < script.shots.size() && !(cameras != nullptr && wanted.empty());
        if (ofScript && !wanted.empty() && std::find(wanted.begin(), wanted.end(), shot.name) == wanted.end()) continue;
        for (const int frame : readFrames(entry, shot)) {
            view.shot = shot, view.frame = frame;
            view.id =
                fmt::format("{}/{}{}", name, shot.name, frame == shot.firstFrame ? "" : fmt::format("@{}", frame));
            if (std::any_of(suite.views.begin(), suite.views.end(), [&](auto& v) { return v.id == view.id; }))
                entry.fail("", fmt::format("view {} stands there twice", view.id));
            suite.views.push_back(view);
        }
    }
    entry.finish();
}

}  // namespace

bool Suite::measures(const SuiteView& view, const SuiteConfiguration& configuration) const {
    const auto& list = configuration.scenes;
    return list.empty() || std::find(list.begin(), list.end(), view.scene) != list.end();
}

Settings Suite::settingsOf(const SuiteView& view, const SuiteConfiguration& configuration) const {
    Settings out = view.script->settings;
    // A preset's file is relative to the suite, as all paths in it.
    if (!configuration.preset.empty()) applyJson(out, {{"preset", configuration.preset}}, file.string(), "");
    applyJson(out, settings, file.string(), "settings");
    applyJson(out, view.settings, file.string(), view.path);
    applyJson(out, nested(configuration.set), file.string(), configuration.path);
    out.reference = view.reference;
    return out;
}

Suite loadSuite(const fs::path& file, const std::map<std::string, fs::path>& scenes) {
    Suite suite;
    suite.file = file;
    if (!fs::exists(file)) throw InputError(file.string(), "", "no such file");
    const std::string text = readTextFile(file);
    const json tree = parseStrictly(text, file.string());
    JsonObject object(tree, file.string(), "");
    object.require("version");
    if (const int version = object.integer("version", 0, 0, 1000000); version != 1)
        object.fail("version", fmt::format("{} is not supported, 1 is", version));
    suite.name = readName(object, "name");
    suite.warmUp = object.integer("warm_up", 1, 1, 1000);
    suite.repeats = object.integer("repeats", 3, 1, 100000);
    suite.memoryBytes =
        std::uint64_t{1048576} * static_cast<std::uint64_t>(object.integer("memory_mib", 2048, 1, 1 << 24));
    suite.channels = strings(object, "channels");
    if (suite.channels.empty()) suite.channels = comparedChannels();
    for (std::size_t i = 0; i < suite.channels.size(); ++i) {
        const std::vector<std::string> known = {"beauty",       "direct", "indirect_diffuse", "indirect_specular",
                                                "transmission", "ao"};
        const std::string at = fmt::format("channels[{}]", i);
        if (std::find(known.begin(), known.end(), suite.channels[i]) == known.end())
            object.fail(at,
                        fmt::format("\"{}\" cannot be compared; {} can", suite.channels[i], fmt::join(known, ", ")));
        if (std::count(suite.channels.begin(), suite.channels.end(), suite.channels[i]) > 1)
            object.fail(at, fmt::format("\"{}\" stands there twice", suite.channels[i]));
    }
    if (const json* settings = object.find("settings")) {
        checkSettings(*settings, file.string(), "settings");
        suite.settings = *settings;
    }
    Settings::Reference reference;
    readReferenceSettings(object, reference);
    const bool common = object.find("reference") != nullptr;
    const json &views = object.require("views"), &configurations = object.require("configurations");
    object.finish();
    if (!views.is_array() || views.empty()) object.fail("views", "must be an array with at least one entry");
    if (!configurations.is_array() || configurations.empty())
        object.fail("configurations", "must be an array with at least one entry");

    for (std::size_t i = 0; i < configurations.size(); ++i)
        readConfigurations(JsonObject(configurations[i], file.string(), fmt::format("configurations[{}]", i)), suite);
    std::set<std::string> ids;
    for (const SuiteConfiguration& configuration : suite.configurations) {
        if (!ids.insert(configuration.id).second)
            throw InputError(file.string(), configuration.path,
                             fmt::format("configuration \"{}\" stands there twice", configuration.id));
    }

    Sha256 hash;
    hash.text(text);
    std::set<std::string> names;
    for (std::size_t i = 0; i < views.size(); ++i)
        readViews(JsonObject(views[i], file.string(), fmt::format("views[{}]", i)), common ? &reference : nullptr,
                  scenes, suite, names, hash);
    for (const auto& [name, path] : scenes) {
        if (!names.contains(name)) throw UsageError(fmt::format("--scene {}: the suite has no such scene", name));
    }
    if (suite.views.empty()) object.fail("views", "no scene is left");
    for (const SuiteConfiguration& configuration : suite.configurations) {
        for (const std::string& scene : configuration.scenes) {
            if (!names.contains(scene))
                throw InputError(file.string(), configuration.path + ".scenes",
                                 fmt::format("\"{}\" is no scene of the suite", scene));
        }
    }
    for (const SuiteView& view : suite.views) hash.text(view.id);
    suite.hash = hash.hex();
    return suite;
}

std::vector<SuiteRow> rowsOf(const Suite& suite) {
    std::vector<SuiteRow> rows;
    for (std::size_t v = 0; v < suite.views.size(); ++v) {
        for (std::size_t c = 0; c < suite.configurations.size(); ++c)
            if (suite.measures(suite.views[v], suite.configurations[c])) rows.push_back({v, c});
    }
    return rows;
}

std::vector<SuiteRow> rowsOf(const Suite& suite, const Shard& shard) {
    const std::vector<SuiteRow> all = rowsOf(suite);
    const auto part = static_cast<std::size_t>(shard.part), parts = static_cast<std::size_t>(shard.parts);
    const bool byView = suite.views.size() >= parts;
    const std::size_t total = byView ? suite.views.size() : all.size();
    const std::size_t first = (part - 1) * total / parts, last = part * total / parts;
    std::vector<SuiteRow> rows;
    for (std::size_t i = 0; i < all.size(); ++i) {
        const std::size_t place = byView ? all[i].view : i;
        if (place >= first && place < last) rows.push_back(all[i]);
    }
    return rows;
}

}  // namespace voxcone
