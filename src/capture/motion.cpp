#include "capture/motion.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <set>

#include "core/error.h"
#include "core/nearest.h"

namespace voxcone {

using nlohmann::json;

namespace {

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
        const glm::dvec3 a = glm::radians(angles);
        const glm::dquat q = glm::angleAxis(a.z, glm::dvec3(0, 0, 1)) * glm::angleAxis(a.y, glm::dvec3(0, 1, 0)) *
                             glm::angleAxis(a.x, glm::dvec3(1, 0, 0));
        const glm::dvec4 v(q.x, q.y, q.z, q.w);
        out.push_back(!out.empty() && glm::dot(v, out.back()) < 0 ? -v : v);
    }
    return out;
}

/// Makes the matrix of `node` a translation, rotation and scale, which keys can replace; false when it is sheared.
bool decompose(Node& node) {
    if (!node.hasMatrix) return true;
    const glm::dmat4& m = node.localMatrix;
    const glm::dmat3 linear(m);
    glm::dvec3 scale(glm::length(linear[0]), glm::length(linear[1]), glm::length(linear[2]));
    if (glm::determinant(linear) < 0) scale.x = -scale.x;
    const glm::dmat3 rotation(linear[0] / scale.x, linear[1] / scale.y, linear[2] / scale.z);
    const glm::dmat3 square = glm::transpose(rotation) * rotation;
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
            if (!(std::abs(square[i][j] - (i == j ? 1.0 : 0.0)) < 1e-5)) return false;
        }
    }
    node.translation = glm::dvec3(m[3]);
    node.rotation = glm::normalize(glm::quat_cast(rotation));
    node.scale = scale;
    node.hasMatrix = false;
    return true;
}

/// The one node of `scene` with the name at "node".
int readNode(JsonObject& object, const Scene& scene) {
    const std::string name = object.string("node");
    std::vector<std::string> names;
    int found = -1;
    for (std::size_t i = 0; i < scene.nodes.size(); ++i) {
        const std::string& candidate = scene.nodes[i].name;
        if (candidate.empty()) continue;
        names.push_back(candidate);
        if (candidate != name) continue;
        if (found >= 0) object.fail("node", fmt::format("the scene has several nodes \"{}\"", name));
        found = static_cast<int>(i);
    }
    if (names.empty()) object.fail("node", "the scene has no nodes with names");
    if (found < 0)
        object.fail("node",
                    fmt::format("the scene has no node \"{}\"; did you mean \"{}\"?", name, nearestWord(names, name)));
    return found;
}

std::vector<AnimationChannel> readObject(JsonObject object, Scene& scene) {
    const int node = readNode(object, scene);
    std::vector<glm::dvec3> translations, rotations, scales;
    std::size_t index = 0;
    const std::vector<double> times = readPath(object, [&](JsonObject& key) {
        if (holds(key, "translation", index, translations.size()))
            translations.push_back(key.vector("translation", -kLargest, kLargest));
        if (holds(key, "scale", index, scales.size())) scales.push_back(key.vector("scale", 1e-6, 1e6));
        if (holds(key, "rotation", index, rotations.size())) {
            rotations.push_back(key.vector("rotation", -36000, 36000));
            // A pose does not know how often it was turned: the way to the next one is the shorter.
            if (index > 0 &&
                glm::any(glm::greaterThanEqual(glm::abs(rotations[index] - rotations[index - 1]), glm::dvec3(180))))
                key.fail("rotation", "must differ by less than 180 degrees from that of the key before");
        }
        ++index;
    });
    const Interpolation interpolation = readInterpolation(object);
    object.finish();
    if (translations.empty() && rotations.empty() && scales.empty())
        object.fail("path", "has keys without translation, rotation or scale");
    if (!decompose(scene.nodes[static_cast<std::size_t>(node)]))
        object.fail("node", "has a matrix with shear, which keys cannot replace");

    std::vector<AnimationChannel> channels;
    const auto add = [&](AnimatedProperty property, const std::vector<glm::dvec4>& values) {
        if (!values.empty()) channels.push_back(channelThrough(node, property, interpolation, times, values));
    };
    const auto extended = [](const std::vector<glm::dvec3>& values) {
        std::vector<glm::dvec4> out;
        for (const glm::dvec3& v : values) out.emplace_back(v, 0);
        return out;
    };
    add(AnimatedProperty::translation, extended(translations));
    add(AnimatedProperty::rotation, quaternions(rotations));
    add(AnimatedProperty::scale, extended(scales));
    return channels;
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

void readObjects(const json& objects, const std::string& file, Scene& scene) {
    if (!objects.is_array()) throw InputError(file, "objects", "must be an array");
    Animation animation;
    animation.name = "script";
    std::set<int> moved;
    for (std::size_t i = 0; i < objects.size(); ++i) {
        const std::string path = fmt::format("objects[{}]", i);
        const std::vector<AnimationChannel> channels = readObject(JsonObject(objects[i], file, path), scene);
        if (!moved.insert(channels.front().node).second)
            throw InputError(file, path + ".node", "is moved by an object before");
        animation.channels.insert(animation.channels.end(), channels.begin(), channels.end());
    }
    if (animation.channels.empty()) return;
    for (Animation& other : scene.animations) {
        std::erase_if(other.channels, [&](const AnimationChannel& channel) {
            return std::any_of(animation.channels.begin(), animation.channels.end(), [&](const AnimationChannel& own) {
                return own.node == channel.node && own.property == channel.property;
            });
        });
    }
    std::erase_if(scene.animations, [](const Animation& other) { return other.channels.empty(); });
    scene.animations.push_back(std::move(animation));
}

}  // namespace voxcone
