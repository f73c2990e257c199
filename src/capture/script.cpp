#include "capture/script.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <glm/gtc/constants.hpp>
#include <nlohmann/json.hpp>
#include <numbers>
#include <set>

#include "core/atomic_file.h"
#include "core/error.h"
#include "core/log.h"
#include "core/nearest.h"
#include "scene/environment.h"
#include "scene/gltf.h"

namespace voxcone {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr double kLargest = 1e9;  // metres, watts: beyond that single precision has nothing left

// ---- Reading JSON strictly

/// "line 3, column 14" of the byte at `offset`.
std::string placeOf(const std::string& text, std::size_t offset) {
    const std::string_view before = std::string_view(text).substr(0, std::min(offset, text.size()));
    const auto lines = std::count(before.begin(), before.end(), '\n');
    const std::size_t lineStart = before.rfind('\n') == std::string_view::npos ? 0 : before.rfind('\n') + 1;
    return fmt::format("line {}, column {}", lines + 1, before.size() - lineStart + 1);
}

/// The reason inside a message of nlohmann's parser, which wraps it in numbers and places of its own.
std::string reasonOf(const json::exception& error) {
    std::string text = error.what();
    if (const auto at = text.find("syntax error"); at != std::string::npos) text = text.substr(at);
    std::replace(text.begin(), text.end(), '\n', ' ');
    return text;
}

json parseStrictly(const std::string& text, const std::string& file) {
    std::vector<std::set<std::string>> open;
    std::string duplicate;
    const auto watch = [&](int, json::parse_event_t event, json& parsed) {
        if (event == json::parse_event_t::object_start) open.emplace_back();
        if (event == json::parse_event_t::object_end) open.pop_back();
        if (event == json::parse_event_t::key && !open.back().insert(parsed.get<std::string>()).second &&
            duplicate.empty())
            duplicate = parsed.get<std::string>();
        return true;
    };
    json tree;
    try {
        tree = json::parse(text, watch);
    } catch (const json::parse_error& error) {
        throw InputError(file, placeOf(text, error.byte == 0 ? 0 : error.byte - 1),
                         "not valid JSON: " + reasonOf(error));
    } catch (const json::exception& error) {
        throw InputError(file, "", "not valid JSON: " + reasonOf(error));
    }
    if (!duplicate.empty()) throw InputError(file, "", fmt::format("key \"{}\" stands twice in one object", duplicate));
    return tree;
}

/// One object of the script. Every look-up is noted, so that `finish` can refuse what nobody asked for.
class Object {
  public:
    Object(const json& tree, std::string file, std::string path)
        : tree_(tree), file_(std::move(file)), path_(std::move(path)) {
        if (!tree.is_object()) fail("", fmt::format("must be an object, is {}", kind(tree)));
    }

    std::string pathOf(const std::string& key) const {
        return key.empty() ? path_ : path_.empty() ? key : path_ + "." + key;
    }

    [[noreturn]] void fail(const std::string& key, const std::string& reason) const {
        throw InputError(file_, pathOf(key), reason);
    }

    /// The value of `key`, or null when it is absent.
    const json* find(const std::string& key) {
        known_.push_back(key);
        const auto found = tree_.find(key);
        return found == tree_.end() ? nullptr : &*found;
    }

    const json& require(const std::string& key) {
        const json* value = find(key);
        if (value == nullptr) fail(key, "is missing");
        return *value;
    }

    std::string string(const std::string& key) {
        const json& value = require(key);
        if (!value.is_string()) fail(key, fmt::format("must be a string, is {}", kind(value)));
        return value.get<std::string>();
    }

    double number(const std::string& key, double otherwise, double min, double max, const char* unit = "") {
        const json* value = find(key);
        if (value == nullptr) return otherwise;
        if (!value->is_number()) fail(key, fmt::format("must be a number, is {}", kind(*value)));
        const double number = value->get<double>();
        if (!(number >= min && number <= max))
            fail(key,
                 fmt::format("{} is out of range: {} to {}{}{}", value->dump(), min, max, *unit == 0 ? "" : " ", unit));
        return number;
    }

    double requiredNumber(const std::string& key, double min, double max, const char* unit = "") {
        if (!tree_.contains(key)) fail(key, "is missing");
        return number(key, 0, min, max, unit);
    }

    int integer(const std::string& key, int otherwise, int min, int max) {
        const double value = number(key, otherwise, min, max);
        if (value != std::floor(value)) fail(key, "must be a whole number");
        return static_cast<int>(value);
    }

    glm::dvec3 vector(const std::string& key, double min, double max) {
        const json& value = require(key);
        if (!value.is_array() || value.size() != 3) fail(key, "must be an array of 3 numbers");
        glm::dvec3 out;
        for (glm::length_t i = 0; i < 3; ++i) {
            const json& component = value[static_cast<std::size_t>(i)];
            const std::string at = fmt::format("{}[{}]", key, i);
            if (!component.is_number()) fail(at, fmt::format("must be a number, is {}", kind(component)));
            out[i] = component.get<double>();
            if (!(out[i] >= min && out[i] <= max))
                fail(at, fmt::format("{} is out of range: {} to {}", component.dump(), min, max));
        }
        return out;
    }

    glm::dvec3 vectorOr(const std::string& key, const glm::dvec3& otherwise, double min, double max) {
        return tree_.contains(key) ? vector(key, min, max) : (find(key), otherwise);
    }

    glm::dvec3 direction(const std::string& key) {
        const glm::dvec3 out = vector(key, -kLargest, kLargest);
        if (glm::length(out) < 1e-9) fail(key, "must not be zero");
        return glm::normalize(out);
    }

    /// Refuses a key that belongs to something this version does not do.
    void refuse(const std::string& key, const char* reason) const {
        if (tree_.contains(key)) fail(key, reason);
    }

    /// Call last: throws for the first key that was never looked up.
    void finish() const {
        for (const auto& [key, value] : tree_.items()) {
            if (std::find(known_.begin(), known_.end(), key) == known_.end())
                fail(key, fmt::format("unknown key; did you mean \"{}\"? (there are {})", nearestWord(known_, key),
                                      fmt::join(known_, ", ")));
        }
    }

    const std::string& file() const { return file_; }

    static std::string kind(const json& value) {
        if (value.is_null()) return "null";
        return fmt::format("{} {}", value.is_structured() ? "an" : "a", value.type_name());
    }

  private:
    const json& tree_;
    std::string file_, path_;
    std::vector<std::string> known_;
};

// ---- The parts of a script

/// Radiometric colour: three numbers, or one for grey.
glm::vec3 readColor(Object& object, const std::string& key) {
    if (const json* value = object.find(key); value != nullptr && value->is_number())
        return glm::vec3(static_cast<float>(object.number(key, 0, 0, kLargest)));
    return glm::vec3(object.vector(key, 0, kLargest));
}

Environment readEnvironment(Object object) {
    Environment environment;
    const bool image = object.find("image") != nullptr, color = object.find("color") != nullptr;
    if (image == color) object.fail("", "must have either \"image\" or \"color\"");
    const auto intensity = static_cast<float>(object.number("intensity", 1, 0, kLargest));
    if (image) {
        fs::path file = object.string("image");
        if (file.is_relative()) file = fs::path(object.file()).parent_path() / file;
        environment = loadEnvironment(file);
        environment.color = glm::vec3(intensity);
    } else {
        environment.color = readColor(object, "color") * intensity;
    }
    environment.rotationDeg = object.number("rotation_deg", 0, -36000, 36000, "degrees");
    object.finish();
    return environment;
}

/// `up` without its part along `direction`; both unit. Fails when the two are parallel.
glm::dvec3 perpendicular(const Object& object, const std::string& key, const glm::dvec3& up,
                         const glm::dvec3& direction) {
    const glm::dvec3 rest = up - glm::dot(up, direction) * direction;
    if (glm::length(rest) < 1e-6 * std::max(1.0, glm::length(up)))
        object.fail(key, "must not be parallel to the direction");
    return glm::normalize(rest);
}

Light readLight(Object object) {
    object.refuse("path", "animated lights are not supported");
    Light light;
    const std::vector<std::string> types = {"directional", "point", "spot", "sphere", "rectangle"};
    const std::string type = object.string("type");
    const auto found = std::find(types.begin(), types.end(), type);
    if (found == types.end())
        object.fail("type", fmt::format("\"{}\" is no light; did you mean \"{}\"? (there are {})", type,
                                        nearestWord(types, type), fmt::join(types, ", ")));
    light.type = static_cast<LightType>(found - types.begin());
    light.name = object.find("name") != nullptr ? object.string("name") : object.pathOf("");
    light.intensity = readColor(object, "intensity");

    const bool spot = light.type == LightType::spot, rectangle = light.type == LightType::rectangle;
    if (light.type != LightType::directional) light.position = object.vector("position", -kLargest, kLargest);
    if (light.type == LightType::directional || spot || rectangle) light.direction = object.direction("direction");
    if (light.type == LightType::point || spot) light.range = object.number("range", 0, 0, kLargest, "m");
    if (spot) {
        const double outer = object.number("outer_cone_deg", 45, 0, 90, "degrees");
        const double inner = object.number("inner_cone_deg", 0, 0, 90, "degrees");
        if (!(outer > 0)) object.fail("outer_cone_deg", "must be above 0");
        if (!(inner < outer)) object.fail("inner_cone_deg", fmt::format("must be below outer_cone_deg, {}", outer));
        light.innerConeAngle = glm::radians(inner), light.outerConeAngle = glm::radians(outer);
    }
    if (light.type == LightType::sphere) {
        light.radius = object.requiredNumber("radius", 0, kLargest, "m");
        if (!(light.radius > 0)) object.fail("radius", "must be above 0");
    }
    if (rectangle) {
        light.width = object.requiredNumber("width", 0, kLargest, "m");
        light.height = object.requiredNumber("height", 0, kLargest, "m");
        if (!(light.width > 0)) object.fail("width", "must be above 0");
        if (!(light.height > 0)) object.fail("height", "must be above 0");
        const glm::dvec3 upright = std::abs(light.direction.y) < 0.99 ? glm::dvec3(0, 1, 0) : glm::dvec3(0, 0, 1);
        light.up = perpendicular(object, "up", object.vectorOr("up", upright, -kLargest, kLargest), light.direction);
    }
    object.finish();
    return light;
}

/// A camera of the scene by name or index.
Camera sceneCamera(Object& object, const Scene& scene) {
    const json& which = object.require("scene_camera");
    if (scene.cameras.empty()) object.fail("scene_camera", "the scene has no cameras");
    if (which.is_string()) {
        const auto name = which.get<std::string>();
        std::vector<std::string> names;
        for (const Camera& camera : scene.cameras) {
            if (camera.name == name) return camera;
            names.push_back(camera.name);
        }
        object.fail("scene_camera",
                    fmt::format("the scene has no camera \"{}\"; it has \"{}\"", name, fmt::join(names, "\", \"")));
    }
    const int last = static_cast<int>(scene.cameras.size()) - 1;
    return scene.cameras[static_cast<std::size_t>(object.integer("scene_camera", 0, 0, last))];
}

Camera readCamera(Object object, const Scene& scene) {
    object.refuse("path", "camera paths are not supported; give position and target");
    Camera camera;
    if (object.find("scene_camera") != nullptr) {
        camera = sceneCamera(object, scene);
        object.finish();
        return camera;
    }
    camera.position = object.vector("position", -kLargest, kLargest);
    camera.target = object.vector("target", -kLargest, kLargest);
    if (glm::length(camera.target - camera.position) < 1e-9) object.fail("target", "must differ from position");
    camera.up = object.vectorOr("up", glm::dvec3(0, 1, 0), -kLargest, kLargest);
    camera.up = perpendicular(object, "up", camera.up, glm::normalize(camera.target - camera.position));
    camera.verticalFovDeg = object.number("fov_deg", camera.verticalFovDeg, 0.1, 179, "degrees");
    camera.near = object.number("near", 0, 0, kLargest, "m");
    camera.far = object.number("far", 0, 0, kLargest, "m");
    if (camera.far > 0 && camera.far <= camera.near) object.fail("far", "must be above near");
    object.finish();
    return camera;
}

std::vector<std::string> readChannels(Object& object) {
    const json& list = object.require("channels");
    if (!list.is_array() || list.empty()) object.fail("channels", "must be an array with at least one channel");
    std::vector<std::string> channels;
    for (std::size_t i = 0; i < list.size(); ++i) {
        const std::string at = fmt::format("channels[{}]", i);
        if (!list[i].is_string()) object.fail(at, "must be the name of a channel");
        const auto name = list[i].get<std::string>();
        const auto& names = channelNames();
        if (std::find(names.begin(), names.end(), name) == names.end())
            object.fail(at, fmt::format("\"{}\" is no channel; did you mean \"{}\"? (there are {})", name,
                                        nearestWord(names, name), fmt::join(names, ", ")));
        if (std::find(channels.begin(), channels.end(), name) != channels.end())
            object.fail(at, fmt::format("\"{}\" stands there twice", name));
        channels.push_back(name);
    }
    return channels;
}

Shot readShot(Object object, const Scene& scene) {
    Shot shot;
    shot.name = object.string("name");
    // The name becomes a folder.
    const bool plain = std::all_of(shot.name.begin(), shot.name.end(), [](char c) {
        return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-' ||
               c == '.';
    });
    if (shot.name.empty() || shot.name.size() > 100 || shot.name[0] == '.' || !plain)
        object.fail("name", "must be 1 to 100 letters, digits, '_', '-' or '.', and not begin with '.'");
    shot.camera = readCamera(Object(object.require("camera"), object.file(), object.pathOf("camera")), scene);
    shot.channels = readChannels(object);
    shot.frames = object.integer("frames", 1, 1, 100000);
    object.finish();
    return shot;
}

CaptureScript readScript(const fs::path& file) {
    const json tree = parseStrictly(readTextFile(file), file.string());
    Object object(tree, file.string(), "");
    object.require("version");
    if (const int version = object.integer("version", 0, 0, 1000000); version != 1)
        object.fail("version", fmt::format("{} is not supported, 1 is", version));

    // All that is cheap is checked before the scene is loaded, but messages about cameras need the scene.
    CaptureScript script;
    if (const json* settings = object.find("settings"))
        applyJson(script.settings, *settings, file.string(), "settings");
    fs::path scene = object.string("scene");
    if (scene.is_relative()) scene = file.parent_path() / scene;
    if (!fs::exists(scene)) object.fail("scene", fmt::format("no such file: {}", scene.string()));
    const json* environment = object.find("environment");
    const json* lights = object.find("lights");
    const json& shots = object.require("shots");
    object.finish();
    if (lights != nullptr && !lights->is_array()) object.fail("lights", "must be an array");
    if (!shots.is_array() || shots.empty()) object.fail("shots", "must be an array with at least one shot");

    script.scene = loadGltf(scene);
    if (environment != nullptr)
        script.scene.environment = readEnvironment(Object(*environment, file.string(), "environment"));
    for (std::size_t i = 0; lights != nullptr && i < lights->size(); ++i)
        script.scene.lights.push_back(readLight(Object((*lights)[i], file.string(), fmt::format("lights[{}]", i))));
    std::set<std::string> names;
    for (std::size_t i = 0; i < shots.size(); ++i) {
        const std::string path = fmt::format("shots[{}]", i);
        script.shots.push_back(readShot(Object(shots[i], file.string(), path), script.scene));
        if (!names.insert(script.shots.back().name).second)
            object.fail(path + ".name", fmt::format("\"{}\" is another shot's name already", script.shots.back().name));
    }
    return script;
}

// ---- A bare scene

/// A camera outside that sees all of `bounds`, from the front, a little above and to the right.
Camera cameraAround(const Bounds& bounds) {
    Camera camera;
    const double radius = bounds.empty() ? 1 : std::max(glm::length(bounds.size()) / 2, 1e-9);
    const double distance = 1.05 * radius / std::sin(glm::radians(camera.verticalFovDeg / 2));
    camera.target = bounds.empty() ? glm::dvec3(0) : bounds.center();
    camera.position = camera.target + distance * glm::normalize(glm::dvec3(0.5, 0.4, 1));
    return camera;
}

CaptureScript scriptForScene(const fs::path& file) {
    CaptureScript script;
    script.scene = loadGltf(file);
    Scene& scene = script.scene;
    const bool emitters =
        std::any_of(scene.materials.begin(), scene.materials.end(), [](const Material& m) { return m.emits(); });
    if (scene.lights.empty() && !emitters) {
        log::info("{} has neither lights nor emitters: lit by a sun and a sky", file.string());
        Light sun;
        sun.name = "sun", sun.type = LightType::directional;
        sun.direction = glm::normalize(glm::dvec3(-0.4, -1, -0.5));
        sun.intensity = {4.0f, 3.7f, 3.2f};
        scene.lights.push_back(sun);
        scene.environment.color = {0.4f, 0.5f, 0.65f};
    }
    Shot shot;
    shot.name = "default";
    shot.camera = scene.cameras.empty() ? cameraAround(scene.bounds()) : scene.cameras.front();
    shot.channels = {"beauty", "direct", "indirect_diffuse", "indirect_specular", "ao"};
    script.shots.push_back(shot);
    return script;
}

}  // namespace

const std::vector<std::string>& channelNames() {
    static const std::vector<std::string> names = {
        "beauty",       "direct",         "indirect_diffuse", "indirect_specular",
        "ao",           "soft_shadow",    "emission",         "albedo",
        "normal",       "depth",          "position",         "voxel_albedo",
        "voxel_normal", "voxel_radiance", "voxel_opacity"};
    return names;
}

CaptureScript loadCaptureScript(const fs::path& file) {
    std::string extension = file.extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return std::tolower(c); });
    if (!fs::exists(file)) throw InputError(file.string(), "", "no such file");
    if (extension == ".json") return readScript(file);
    if (extension == ".gltf" || extension == ".glb") return scriptForScene(file);
    throw InputError(file.string(), "", "is neither a capture script (.json) nor a scene (.gltf, .glb)");
}

}  // namespace voxcone
