#include "capture/script.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "capture/motion.h"
#include "capture/strict_json.h"
#include "core/atomic_file.h"
#include "core/error.h"
#include "core/log.h"
#include "core/nearest.h"
#include "core/voxel_channel.h"
#include "scene/environment.h"
#include "scene/gltf.h"

namespace voxcone {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

Environment readEnvironment(JsonObject object) {
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
        environment.color = object.color("color") * intensity;
    }
    environment.rotationDeg = object.number("rotation_deg", 0, -36000, 36000, "degrees");
    object.finish();
    return environment;
}

/// `up` without its part along `direction`, which is unit; what is upright already keeps its bits. Fails when the two
/// are parallel.
glm::dvec3 perpendicular(const JsonObject& object, const std::string& key, const glm::dvec3& up,
                         const glm::dvec3& direction) {
    if (glm::length(up - glm::dot(up, direction) * direction) < 1e-6 * std::max(1.0, glm::length(up)))
        object.fail(key, "must not be parallel to the direction");
    const bool upright = std::abs(glm::dot(up, direction)) < 4e-15 && std::abs(glm::dot(up, up) - 1) < 4e-15;
    return upright ? up : uprightOf(up, direction);
}

/// What a light has beside its intensity, place and direction; what is absent stays as it is.
void readExtent(JsonObject& object, Light& light) {
    if (light.type == LightType::directional && object.find("angular_radius_deg") != nullptr)
        light.angularRadius = glm::radians(object.number("angular_radius_deg", 0, 0, 45, "degrees"));
    if (light.type == LightType::point || light.type == LightType::spot)
        light.range = object.number("range", light.range, 0, kLargest, "m");
    if (light.type != LightType::spot) return;
    const bool outerGiven = object.find("outer_cone_deg") != nullptr,
               innerGiven = object.find("inner_cone_deg") != nullptr;
    if (!outerGiven && !innerGiven) return;
    const double outer = object.number("outer_cone_deg", glm::degrees(light.outerConeAngle), 0, 90, "degrees");
    const double inner = object.number("inner_cone_deg", glm::degrees(light.innerConeAngle), 0, 90, "degrees");
    if (!(outer > 0)) object.fail("outer_cone_deg", "must be above 0");
    if (!(inner < outer)) object.fail("inner_cone_deg", fmt::format("must be below outer_cone_deg, {}", outer));
    if (innerGiven) light.innerConeAngle = glm::radians(inner);
    if (outerGiven) light.outerConeAngle = glm::radians(outer);
}

Light readLight(JsonObject object) {
    Light light;
    light.type =
        static_cast<LightType>(object.word("type", {"directional", "point", "spot", "sphere", "rectangle"}, "light"));
    light.name = object.find("name") != nullptr ? object.string("name") : object.pathOf("");
    const bool spot = light.type == LightType::spot, rectangle = light.type == LightType::rectangle;
    const bool hasPosition = light.type != LightType::directional;
    const bool hasDirection = light.type == LightType::directional || spot || rectangle;
    if (object.find("path") != nullptr) light.track = readLightPath(object, hasPosition, hasDirection);
    // The light as it is at the first key; the path is given instead of a value, not beside it.
    const auto fromPath = [&](const char* key, const Track& track) {
        if (!track.empty() && object.find(key) != nullptr) object.fail(key, "is given by the path");
        return !track.empty();
    };
    const LightTrack& track = light.track;
    light.intensity =
        fromPath("intensity", track.intensity) ? glm::vec3(track.intensity.values.front()) : object.color("intensity");
    if (hasPosition)
        light.position = fromPath("position", track.position) ? track.position.values.front()
                                                              : object.vector("position", -kLargest, kLargest);
    if (hasDirection)
        light.direction =
            fromPath("direction", track.direction) ? track.direction.values.front() : object.direction("direction");
    readExtent(object, light);
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

/// Changes one light of the glTF. `changed`: those that were.
void readSceneLight(JsonObject object, Scene& scene, std::set<std::size_t>& changed) {
    const std::size_t index = readSceneLightIndex(object, scene);
    if (!changed.insert(index).second) object.fail("light", "is changed by an entry before");
    Light& light = scene.lights[index];
    const bool off = object.boolean("off", false);
    if (object.find("intensity") != nullptr) {
        if (off) object.fail("intensity", "is that of a light which is off");
        light.intensity = object.color("intensity");
    }
    if (off) light.intensity = glm::vec3(0);
    if (light.type != LightType::directional && object.find("position") != nullptr)
        light.position = object.vector("position", -kLargest, kLargest);
    if (light.type != LightType::point && object.find("direction") != nullptr)
        light.direction = object.direction("direction");
    readExtent(object, light);
    object.finish();
}

/// A camera of the scene by name or index.
Camera sceneCamera(JsonObject& object, const Scene& scene) {
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

/// Camera and, where it has one, path of a shot.
void readCamera(JsonObject object, const Scene& scene, Shot& shot) {
    Camera& camera = shot.camera;
    if (object.find("scene_camera") != nullptr) {
        camera = sceneCamera(object, scene);
        object.finish();
        return;
    }
    camera.up = object.vectorOr("up", glm::dvec3(0, 1, 0), -kLargest, kLargest);
    if (object.find("path") != nullptr) {
        if (object.find("position") != nullptr || object.find("target") != nullptr)
            object.fail("path", "stands instead of position and target");
        if (glm::length(camera.up) < 1e-9) object.fail("up", "must not be zero");
        shot.path = readCameraPath(object);
    } else {
        camera.position = object.vector("position", -kLargest, kLargest);
        camera.target = object.vector("target", -kLargest, kLargest);
        if (glm::length(camera.target - camera.position) < 1e-9) object.fail("target", "must differ from position");
        camera.up = perpendicular(object, "up", camera.up, glm::normalize(camera.target - camera.position));
    }
    camera.verticalFovDeg = object.number("fov_deg", camera.verticalFovDeg, 0.1, 179, "degrees");
    camera.near = object.number("near", 0, 0, kLargest, "m");
    camera.far = object.number("far", 0, 0, kLargest, "m");
    if (camera.far > 0 && camera.far <= camera.near) object.fail("far", "must be above near");
    object.finish();
}

/// Refuses paths on which the camera has no direction or no horizon in some frame of the shot.
void checkPath(const JsonObject& object, const Shot& shot) {
    if (shot.path.empty()) return;
    for (int frame = shot.firstFrame; frame <= shot.lastFrame; ++frame) {
        const double time = shot.timeOf(frame);
        const glm::dvec3 view = shot.path.target.at(time) - shot.path.position.at(time);
        const std::string place = fmt::format("in frame {}, at {} s, the camera", frame, time);
        if (glm::length(view) < 1e-9) object.fail("camera.path", place + " is at its target");
        if (glm::length(glm::cross(glm::normalize(view), shot.camera.up)) < 1e-6 * glm::length(shot.camera.up))
            object.fail("camera.path", place + " looks along its up direction");
    }
}

/// "frames": their number, or the first and the last; "fps" and "start" say when they are.
void readFrames(JsonObject& object, Shot& shot) {
    constexpr int kMost = 100000;
    const json* frames = object.find("frames");
    if (frames != nullptr && frames->is_object()) {
        JsonObject range(*frames, object.file(), object.pathOf("frames"));
        range.require("first"), range.require("last");
        shot.firstFrame = range.integer("first", 0, 0, kMost);
        shot.lastFrame = range.integer("last", 0, shot.firstFrame, kMost);
        range.finish();
    } else {
        shot.lastFrame = object.integer("frames", 1, 1, kMost) - 1;
    }
    shot.fps = object.number("fps", shot.fps, 1e-3, 1e6, "frames a second");
    shot.start = object.number("start", shot.start, -kLargest, kLargest, "s");
}

/// A channel by its name; voxel views may have bounce, face and level behind colons.
void checkChannel(const JsonObject& object, const std::string& at, const std::string& name) {
    const std::string base = baseChannel(name);
    const auto& names = channelNames();
    if (std::find(names.begin(), names.end(), base) == names.end())
        object.fail(at, fmt::format("\"{}\" is no channel; did you mean \"{}\"? (there are {})", base,
                                    nearestWord(names, base), fmt::join(names, ", ")));
    if (base == name) return;
    if (!base.starts_with("voxel_")) object.fail(at, fmt::format("\"{}\" has no levels; voxel views have", base));
    VoxelChannel channel;
    if (const std::string why = VoxelChannel::parse(name, channel); !why.empty()) object.fail(at, why);
}

std::vector<std::string> readChannels(JsonObject& object) {
    const json& list = object.require("channels");
    if (!list.is_array() || list.empty()) object.fail("channels", "must be an array with at least one channel");
    std::vector<std::string> channels;
    for (std::size_t i = 0; i < list.size(); ++i) {
        const std::string at = fmt::format("channels[{}]", i);
        if (!list[i].is_string()) object.fail(at, "must be the name of a channel");
        const auto name = list[i].get<std::string>();
        checkChannel(object, at, name);
        if (std::find(channels.begin(), channels.end(), name) != channels.end())
            object.fail(at, fmt::format("\"{}\" stands there twice", name));
        channels.push_back(name);
    }
    return channels;
}

Shot readShot(JsonObject object, const Scene& scene) {
    Shot shot;
    shot.name = object.string("name");
    // The name becomes a folder.
    const bool plain = std::all_of(shot.name.begin(), shot.name.end(), [](char c) {
        return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-' ||
               c == '.';
    });
    if (shot.name.empty() || shot.name.size() > 100 || shot.name[0] == '.' || !plain)
        object.fail("name", "must be 1 to 100 letters, digits, '_', '-' or '.', and not begin with '.'");
    readCamera(JsonObject(object.require("camera"), object.file(), object.pathOf("camera")), scene, shot);
    shot.channels = readChannels(object);
    readFrames(object, shot);
    shot.temporal = object.boolean("temporal", false);
    object.finish();
    checkPath(object, shot);
    if (shot.temporal && shot.firstFrame == shot.lastFrame) object.fail("temporal", "needs more than one frame");
    return shot;
}

CaptureScript readScript(const fs::path& file, const fs::path& otherScene) {
    const json tree = parseStrictly(readTextFile(file), file.string());
    JsonObject object(tree, file.string(), "");
    object.require("version");
    if (const int version = object.integer("version", 0, 0, 1000000); version != 1)
        object.fail("version", fmt::format("{} is not supported, 1 is", version));

    // All that is cheap is checked before the scene is loaded, but messages about cameras need the scene.
    CaptureScript script;
    if (const json* settings = object.find("settings"))
        applyJson(script.settings, *settings, file.string(), "settings");
    fs::path scene = object.string("scene");
    if (scene.is_relative()) scene = file.parent_path() / scene;
    if (!otherScene.empty()) scene = otherScene;
    if (!fs::exists(scene)) object.fail("scene", fmt::format("no such file: {}", scene.string()));
    const json* environment = object.find("environment");
    const json* lights = object.find("lights");
    const json* sceneLights = object.find("scene_lights");
    const json* objects = object.find("objects");
    const json& shots = object.require("shots");
    object.finish();
    if (lights != nullptr && !lights->is_array()) object.fail("lights", "must be an array");
    if (sceneLights != nullptr && !sceneLights->is_array()) object.fail("scene_lights", "must be an array");
    if (!shots.is_array() || shots.empty()) object.fail("shots", "must be an array with at least one shot");

    script.scene = loadGltf(scene);
    if (environment != nullptr)
        script.scene.environment = readEnvironment(JsonObject(*environment, file.string(), "environment"));
    std::set<std::size_t> changed;
    for (std::size_t i = 0; sceneLights != nullptr && i < sceneLights->size(); ++i)
        readSceneLight(JsonObject((*sceneLights)[i], file.string(), fmt::format("scene_lights[{}]", i)), script.scene,
                       changed);
    for (std::size_t i = 0; lights != nullptr && i < lights->size(); ++i)
        script.scene.lights.push_back(readLight(JsonObject((*lights)[i], file.string(), fmt::format("lights[{}]", i))));
    if (objects != nullptr) readObjects(*objects, file.string(), script.scene);
    std::set<std::string> names;
    for (std::size_t i = 0; i < shots.size(); ++i) {
        const std::string path = fmt::format("shots[{}]", i);
        script.shots.push_back(readShot(JsonObject(shots[i], file.string(), path), script.scene));
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
    static const std::vector<std::string> names = {"beauty",
                                                   "direct",
                                                   "indirect_diffuse",
                                                   "indirect_specular",
                                                   "transmission",
                                                   "ao",
                                                   "soft_shadow",
                                                   "emission",
                                                   "albedo",
                                                   "normal",
                                                   "depth",
                                                   "position",
                                                   "cascade",
                                                   "seam",
                                                   "voxel_albedo",
                                                   "voxel_normal",
                                                   "voxel_radiance",
                                                   "voxel_opacity",
                                                   "voxel_lobes"};
    return names;
}

std::string baseChannel(const std::string& channel) {
    return channel.substr(0, channel.find(':'));
}

glm::dvec3 uprightOf(const glm::dvec3& up, const glm::dvec3& view) {
    return glm::normalize(up - glm::dot(up, view) * view);
}

Camera cameraAt(const Shot& shot, const Scene& scene, double time) {
    Camera camera = shot.camera;
    if (!shot.path.empty()) {
        camera.position = shot.path.position.at(time);
        camera.target = shot.path.target.at(time);
        camera.up = uprightOf(camera.up, glm::normalize(camera.target - camera.position));
    }
    return worldCamera(camera, scene.worldMatrices(time));
}

CaptureScript loadCaptureScript(const fs::path& file, const fs::path& scene) {
    std::string extension = file.extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return std::tolower(c); });
    if (!fs::exists(file)) throw InputError(file.string(), "", "no such file");
    if (extension == ".json") return readScript(file, scene);
    if (extension == ".gltf" || extension == ".glb") return scriptForScene(scene.empty() ? file : scene);
    throw InputError(file.string(), "", "is neither a capture script (.json) nor a scene (.gltf, .glb)");
}

}  // namespace voxcone
