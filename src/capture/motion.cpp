#include "capture/motion.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <set>

#include "core/error.h"
#include "core/nearest.h"
#include "scene/placement.h"

namespace voxcone {

using nlohmann::json;

namespace {

constexpr double kLeastScale = 1e-6, kMostScale = 1e6;
constexpr int kMostNodes = 1 << 30;

/// Times of the keys of "path": at least two, strictly increasing. `readKey` reads what a key holds beside its time.
std::vector<double> readPath(JsonObject& object, const std::function<void(JsonObject&)>& readKey) {
    const json& list = object.require("path");
    if (!list.is_array() || list.size() < 2) object.fail("path", "must be an array of at least two keys");
    std::vector<double> times;
    for (std::size_t i = 0; i < list.size(); ++i) {
        JsonObject key(list[i], object.file(), object.pathOf(fmt::format("path[{}]", i)));
        const double time = key.requiredNumber("time", -kLargest, kLargest, "s");
        if (!times.empty() && !(time > times.back()))
            key.fail("time", fmt::format("{} must be later than that of the key before, {}", time, times.back()));
        times.push_back(time);
        readKey(key);
        key.finish();
    }
    return times;
}

Interpolation readInterpolation(JsonObject& object) {
    if (object.find("interpolation") == nullptr) return Interpolation::catmull_rom;
    return object.word("interpolation", {"catmull_rom", "linear"}, "interpolation") == 0 ? Interpolation::catmull_rom
                                                                                         : Interpolation::linear;
}

/// Whether key number `index` of a path holds the property `name`, of which `count` were met before. Every key of a
/// path has the same properties.
bool holds(JsonObject& key, const std::string& name, std::size_t index, std::size_t count) {
    const bool found = key.find(name) != nullptr;
    if (index > 0 && found && count == 0) key.fail(name, "is absent from the keys before; all must have the same");
    if (index > 0 && !found && count > 0) key.fail(name, "is missing; the keys before have it");
    return found;
}

/// Channel of `node` through `values` (xyz or xyzw) at `times`. Catmull-Rom becomes a cubic spline of the same
/// tangents.
AnimationChannel channelThrough(int node, AnimatedProperty property, Interpolation interpolation,
                                const std::vector<double>& times, const std::vector<glm::dvec4>& values) {
    AnimationChannel channel;
    channel.node = node;
    channel.property = property;
    channel.times = times;
    const bool spline = interpolation == Interpolation::catmull_rom;
    channel.interpolation = spline ? Interpolation::cubic_spline : Interpolation::linear;
    for (std::size_t i = 0; i < times.size(); ++i) {
        if (!spline) {
            channel.values.emplace_back(values[i]);
            continue;
        }
        const std::size_t before = i > 0 ? i - 1 : i, after = std::min(i + 1, times.size() - 1);
        const glm::vec4 tangent((values[after] - values[before]) / (times[after] - times[before]));
        channel.values.insert(channel.values.end(), {tangent, glm::vec4(values[i]), tangent});
    }
    return channel;
}

/// Degrees about x, then y, then z of the parent, as unit quaternions xyzw; neighbours in one hemisphere, so that the
/// way between them is the shorter one.
std::vector<glm::dvec4> quaternions(const std::vector<glm::dvec3>& degrees) {
    std::vector<glm::dvec4> out;
    for (const glm::dvec3& angles : degrees) {
        const glm::dquat q = rotationFromDegrees(angles);
        const glm::dvec4 v(q.x, q.y, q.z, q.w);
        out.push_back(!out.empty() && glm::dot(v, out.back()) < 0 ? -v : v);
    }
    return out;
}

/// What an object of a script says of its node.
struct ObjectMotion {
    int node = 0;
    std::vector<AnimatedProperty> given;  ///< that the file's animations leave alone from now on
    std::vector<AnimationChannel> channels;
};

/// Reads one object, and puts its node where the object says without keys.
ObjectMotion readObject(JsonObject object, Scene& scene) {
    ObjectMotion motion;
    motion.node = readNode(object, scene);
    Placement placement;
    if (object.find("translation") != nullptr)
        placement.translation = object.vector("translation", -kLargest, kLargest);
    if (object.find("rotation") != nullptr) placement.rotation = object.vector("rotation", -36000, 36000);
    if (object.find("scale") != nullptr) placement.scale = object.vector("scale", kLeastScale, kMostScale);

    std::vector<glm::dvec3> translations, rotations, scales;
    std::vector<double> times;
    Interpolation interpolation = Interpolation::linear;
    if (object.find("path") != nullptr) {
        std::size_t index = 0;
        times = readPath(object, [&](JsonObject& key) {
            if (holds(key, "translation", index, translations.size()))
                translations.push_back(key.vector("translation", -kLargest, kLargest));
            if (holds(key, "scale", index, scales.size()))
                scales.push_back(key.vector("scale", kLeastScale, kMostScale));
            if (holds(key, "rotation", index, rotations.size())) {
                rotations.push_back(key.vector("rotation", -36000, 36000));
                // A pose does not know how often it was turned: the way to the next one is the shorter.
                if (index > 0 &&
                    glm::any(glm::greaterThanEqual(glm::abs(rotations[index] - rotations[index - 1]), glm::dvec3(180))))
                    key.fail("rotation", "must differ by less than 180 degrees from that of the key before");
            }
            ++index;
        });
        interpolation = readInterpolation(object);
        if (translations.empty() && rotations.empty() && scales.empty())
            object.fail("path", "has keys without translation, rotation or scale");
    }
    object.finish();
    if (times.empty() && placement.empty())
        object.fail("", "has neither translation, rotation or scale nor a path of them");
    Node& node = scene.nodes[static_cast<std::size_t>(motion.node)];
    if (!decompose(node)) object.fail("node", "has a matrix with shear, which keys cannot replace");
    place(node, placement);

    const auto extended = [](const std::vector<glm::dvec3>& values) {
        std::vector<glm::dvec4> out;
        for (const glm::dvec3& v : values) out.emplace_back(v, 0);
        return out;
    };
    const auto add = [&](const char* key, AnimatedProperty property, bool placed,
                         const std::vector<glm::dvec4>& values) {
        if (placed && !values.empty()) object.fail(key, "is given by the path");
        if (placed || !values.empty()) motion.given.push_back(property);
        if (!values.empty())
            motion.channels.push_back(channelThrough(motion.node, property, interpolation, times, values));
    };
    add("translation", AnimatedProperty::translation, placement.translation.has_value(), extended(translations));
    add("rotation", AnimatedProperty::rotation, placement.rotation.has_value(), quaternions(rotations));
    add("scale", AnimatedProperty::scale, placement.scale.has_value(), extended(scales));
    return motion;
}

}  // namespace

CameraPath readCameraPath(JsonObject& camera) {
    CameraPath path;
    std::vector<glm::dvec3>&positions = path.position.values, &targets = path.target.values;
    path.position.times = path.target.times = readPath(camera, [&](JsonObject& key) {
        positions.push_back(key.vector("position", -kLargest, kLargest));
        targets.push_back(key.vector("target", -kLargest, kLargest));
    });
    path.position.interpolation = path.target.interpolation = readInterpolation(camera);
    return path;
}

LightTrack readLightPath(JsonObject& light, bool hasPosition, bool hasDirection) {
    LightTrack track;
    std::vector<glm::dvec3>&positions = track.position.values, &directions = track.direction.values;
    std::vector<glm::dvec3>& intensities = track.intensity.values;
    std::size_t index = 0;
    const std::vector<double> times = readPath(light, [&](JsonObject& key) {
        if (hasPosition && holds(key, "position", index, positions.size()))
            positions.push_back(key.vector("position", -kLargest, kLargest));
        if (hasDirection && holds(key, "direction", index, directions.size()))
            directions.push_back(key.direction("direction"));
        if (holds(key, "intensity", index, intensities.size())) intensities.emplace_back(key.color("intensity"));
        ++index;
    });
    const Interpolation interpolation = readInterpolation(light);
    for (Track* part : {&track.position, &track.direction, &track.intensity}) {
        part->interpolation = interpolation;
        if (!part->values.empty()) part->times = times;
    }
    if (track.position.empty() && track.direction.empty() && track.intensity.empty())
        light.fail("path", "has keys without position, direction or intensity");
    return track;
}

int readNode(JsonObject& object, const Scene& scene) {
    const auto at = [&](auto&& matches) {
        return static_cast<int>(std::find_if(scene.nodes.begin(), scene.nodes.end(), matches) - scene.nodes.begin());
    };
    const int count = static_cast<int>(scene.nodes.size());
    if (object.require("node").is_number()) {
        const int index = object.integer("node", 0, 0, kMostNodes);
        const int found = at([index](const Node& node) { return node.fileIndex == index; });
        if (found == count) object.fail("node", fmt::format("the scene that is shown has no nodes[{}]", index));
        return found;
    }
    const std::string name = object.string("node");
    std::vector<std::string> names;
    for (const Node& node : scene.nodes)
        if (!node.name.empty()) names.push_back(node.name);
    if (names.empty()) object.fail("node", "the scene has no nodes with names");
    const auto same = std::count(names.begin(), names.end(), name);
    if (same > 1)
        object.fail("node",
                    fmt::format("the scene has several nodes \"{}\"; an index of the file's nodes is unique", name));
    if (same == 0)
        object.fail("node",
                    fmt::format("the scene has no node \"{}\"; did you mean \"{}\"?", name, nearestWord(names, name)));
    return at([&](const Node& node) { return node.name == name; });
}

json nodeReference(const Scene& scene, int node) {
    const Node& n = scene.nodes[static_cast<std::size_t>(node)];
    const auto same =
        std::count_if(scene.nodes.begin(), scene.nodes.end(), [&](const Node& other) { return other.name == n.name; });
    if (n.name.empty() || same > 1) return n.fileIndex;
    return n.name;
}

std::size_t readSceneLightIndex(JsonObject& object, const Scene& scene) {
    std::vector<std::string> names;
    for (const Light& light : scene.lights)
        if (light.node >= 0 && !light.extracted) names.push_back(light.name);
    if (names.empty()) object.fail("light", "the glTF has no lights");
    if (object.require("light").is_number())
        return static_cast<std::size_t>(object.integer("light", 0, 0, static_cast<int>(names.size()) - 1));
    const std::string name = object.string("light");
    const auto same = std::count(names.begin(), names.end(), name);
    if (same == 0)
        object.fail("light",
                    fmt::format("the glTF has no light \"{}\"; it has \"{}\"", name, fmt::join(names, "\", \"")));
    if (same > 1) object.fail("light", fmt::format("the glTF has several lights \"{}\"; an index is unique", name));
    return static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin());
}

json sceneLightReference(const Scene& scene, std::size_t light) {
    const std::string& name = scene.lights[light].name;
    const auto same = std::count_if(scene.lights.begin(), scene.lights.end(), [&](const Light& other) {
        return other.node >= 0 && !other.extracted && other.name == name;
    });
    if (name.empty() || same > 1) return light;
    return name;
}

void readObjects(const json& objects, const std::string& file, Scene& scene) {
    if (!objects.is_array()) throw InputError(file, "objects", "must be an array");
    Animation animation;
    animation.name = "script";
    std::set<int> moved;
    for (std::size_t i = 0; i < objects.size(); ++i) {
        const std::string path = fmt::format("objects[{}]", i);
        const ObjectMotion motion = readObject(JsonObject(objects[i], file, path), scene);
        if (!moved.insert(motion.node).second) throw InputError(file, path + ".node", "is moved by an object before");
        for (Animation& other : scene.animations) {
            std::erase_if(other.channels, [&](const AnimationChannel& channel) {
                return channel.node == motion.node &&
                       std::find(motion.given.begin(), motion.given.end(), channel.property) != motion.given.end();
            });
        }
        animation.channels.insert(animation.channels.end(), motion.channels.begin(), motion.channels.end());
    }
    std::erase_if(scene.animations, [](const Animation& other) { return other.channels.empty(); });
    if (!animation.channels.empty()) scene.animations.push_back(std::move(animation));
}

}  // namespace voxcone
