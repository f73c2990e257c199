#include "scene/scene.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

#include "core/check.h"
#include "scene/deform.h"

namespace voxcone {

namespace {

struct LocalPose {
    glm::dvec3 translation, scale;
    glm::dquat rotation;
};

// glTF stores quaternions as xyzw, GLM's constructor takes wxyz.
glm::dquat quaternion(const glm::dvec4& v) {
    return {v.w, v.x, v.y, v.z};
}

/// What `channel` says at `position` for any property but rotation; `at` gives its values in the order of the file.
template <class Value, class At>
Value between(const AnimationChannel& channel, const KeyPosition& position, At&& at) {
    const bool spline = channel.interpolation == Interpolation::cubic_spline;
    const auto value = [&](std::size_t key) -> Value { return at(spline ? 3 * key + 1 : key); };
    const auto [key, t, span] = position;
    if (span == 0 || channel.interpolation == Interpolation::step) return value(key);
    if (!spline) return (1 - t) * value(key) + t * value(key + 1);
    const Value outTangent = span * at(3 * key + 2), inTangent = span * at(3 * key + 3);
    return hermite(value(key), outTangent, value(key + 1), inTangent, t);
}

/// Value of `channel` at `time`, clamped to the first and last key (glTF 2.0, appendix C).
glm::dvec4 evaluate(const AnimationChannel& channel, double time) {
    const KeyPosition position = keyPosition(channel.times, time);
    if (channel.property == AnimatedProperty::rotation && channel.interpolation == Interpolation::linear &&
        position.span > 0) {
        const auto key = [&](std::size_t k) { return glm::normalize(quaternion(glm::dvec4(channel.values[k]))); };
        // glm::slerp takes the shorter way, as the specification asks.
        const glm::dquat q = glm::slerp(key(position.index), key(position.index + 1), position.t);
        return {q.x, q.y, q.z, q.w};
    }
    return between<glm::dvec4>(channel, position, [&](std::size_t i) { return glm::dvec4(channel.values[i]); });
}

/// Sets the weights of a mesh with as many targets as `channel` has weights.
void evaluateWeights(const AnimationChannel& channel, double time, std::vector<float>& weights) {
    const std::size_t values = channel.times.size() * (channel.interpolation == Interpolation::cubic_spline ? 3 : 1);
    const std::size_t targets = channel.weights.size() / values;
    VOXCONE_CHECK(targets == weights.size(), "{} animated weights for {} targets", targets, weights.size());
    const KeyPosition position = keyPosition(channel.times, time);
    for (std::size_t k = 0; k < targets; ++k)
        weights[k] = static_cast<float>(between<double>(
            channel, position, [&](std::size_t i) { return static_cast<double>(channel.weights[i * targets + k]); }));
}

/// Boxes of the meshes' positions.
std::vector<Bounds> boxesOf(const std::vector<Mesh>& meshes) {
    std::vector<Bounds> boxes(meshes.size());
    for (std::size_t i = 0; i < meshes.size(); ++i) {
        for (const glm::vec3& p : meshes[i].positions) boxes[i].add(glm::dvec3(p));
    }
    return boxes;
}

/// Grows `box` by an instance. `meshBox` holds the mesh's positions.
void addInstance(Bounds& box, const Mesh& mesh, const Bounds& meshBox, const glm::dmat4& matrix,
                 const Deformation& deformation) {
    std::vector<glm::vec3> deformed;
    if (!deformation.rigid()) {
        deformed = deform(mesh, deformation).positions;
    } else if (!box.empty()) {
        // Most often the instance's box lies inside already.
        const Bounds reach = transformed(meshBox, matrix);
        if (glm::all(glm::lessThanEqual(box.min, reach.min)) && glm::all(glm::lessThanEqual(reach.max, box.max)))
            return;
    }
    const std::vector<glm::vec3>& positions = deformation.rigid() ? mesh.positions : deformed;
    for (const std::uint32_t index : mesh.indices) box.add(glm::dvec3(matrix * glm::dvec4(positions[index], 1)));
}

glm::dvec3 transformDirection(const glm::dmat4& matrix, const glm::dvec3& direction, const glm::dvec3& fallback) {
    const glm::dvec3 moved = glm::dmat3(matrix) * direction;
    const double length = glm::length(moved);
    return length > 0 ? moved / length : fallback;
}

/// Scale of lengths under `matrix`: the cube root of the change of volume.
double lengthScale(const glm::dmat4& matrix) {
    return std::cbrt(std::abs(glm::determinant(glm::dmat3(matrix))));
}

}  // namespace

std::vector<glm::dmat4> Scene::worldMatrices(double time) const {
    std::vector<LocalPose> poses(nodes.size());
    for (std::size_t i = 0; i < nodes.size(); ++i) poses[i] = {nodes[i].translation, nodes[i].scale, nodes[i].rotation};
    for (const Animation& animation : animations) {
        for (const AnimationChannel& channel : animation.channels) {
            if (channel.property == AnimatedProperty::morph_weights) continue;  // for pose()
            const glm::dvec4 value = evaluate(channel, time);
            LocalPose& pose = poses[static_cast<std::size_t>(channel.node)];
            switch (channel.property) {
                case AnimatedProperty::translation:
                    pose.translation = glm::dvec3(value);
                    break;
                case AnimatedProperty::scale:
                    pose.scale = glm::dvec3(value);
                    break;
                case AnimatedProperty::rotation:
                    // A spline through unit quaternions may pass through zero, which is no rotation at all.
                    if (glm::dot(value, value) > 0) pose.rotation = glm::normalize(quaternion(value));
                    break;
                case AnimatedProperty::morph_weights:
                    break;
            }
        }
    }

    std::vector<glm::dmat4> world(nodes.size());
    for (std::size_t i = 0; i < nodes.size(); ++i) {
        const Node& node = nodes[i];
        VOXCONE_CHECK(node.parent < static_cast<int>(i), "node {} before its parent {}", i, node.parent);
        const glm::dmat4 local =
            node.hasMatrix
                ? node.localMatrix
                : glm::scale(glm::translate(glm::dmat4(1), poses[i].translation) * glm::mat4_cast(poses[i].rotation),
                             poses[i].scale);
        world[i] = node.parent < 0 ? local : world[static_cast<std::size_t>(node.parent)] * local;
    }
    return world;
}

Pose Scene::pose(double time) const {
    Pose pose;
    pose.nodes = worldMatrices(time);
    std::vector<const AnimationChannel*> weightChannels(nodes.size(), nullptr);
    for (const Animation& animation : animations) {
        for (const AnimationChannel& channel : animation.channels) {
            if (channel.property == AnimatedProperty::morph_weights)
                weightChannels[static_cast<std::size_t>(channel.node)] = &channel;
        }
    }
    for (const Instance& instance : instances) {
        const Mesh& mesh = meshes[static_cast<std::size_t>(instance.mesh)];
        const auto nodeIndex = static_cast<std::size_t>(instance.node);
        const Node& node = nodes[nodeIndex];
        Deformation deformation;
        if (!mesh.morphTargets.empty()) {
            deformation.weights = node.morphWeights.empty() ? mesh.morphWeights : node.morphWeights;
            if (weightChannels[nodeIndex]) evaluateWeights(*weightChannels[nodeIndex], time, deformation.weights);
        }
        glm::dmat4 matrix = pose.nodes[nodeIndex];
        if (instance.skin >= 0) {
            const Skin& skin = skins[static_cast<std::size_t>(instance.skin)];
            const glm::dmat4& root = pose.nodes[static_cast<std::size_t>(skin.joints.front())];
            const glm::dvec3 origin(root[3]);
            const bool mirrored = glm::determinant(glm::dmat3(root * skin.inverseBindMatrices.front())) < 0;
            const glm::dmat4 mirror = glm::scale(glm::dmat4(1), glm::dvec3(mirrored ? -1 : 1, 1, 1));
            for (std::size_t k = 0; k < skin.joints.size(); ++k) {
                glm::dmat4 joint = pose.nodes[static_cast<std::size_t>(skin.joints[k])];
                joint[3] -= glm::dvec4(origin, 0);
                deformation.joints.push_back(mirror * joint * skin.inverseBindMatrices[k]);
            }
            matrix = glm::translate(glm::dmat4(1), origin) * mirror;
        }
        pose.instances.push_back(matrix);
        pose.deformations.push_back(std::move(deformation));
    }
    return pose;
}

Bounds Scene::bounds(double time) const {
    const Pose at = pose(time);
    const std::vector<Bounds> meshBoxes = boxesOf(meshes);
    Bounds result;
    for (std::size_t i = 0; i < instances.size(); ++i) {
        const auto mesh = static_cast<std::size_t>(instances[i].mesh);
        addInstance(result, meshes[mesh], meshBoxes[mesh], at.instances[i], at.deformations[i]);
    }
    return result;
}

Bounds Scene::motionBounds() const {
    Bounds result = bounds();
    const std::vector<std::uint8_t> moves = movingInstances();
    const std::vector<Bounds> meshBoxes = boxesOf(meshes);
    std::size_t deformedVertices = 0;
    for (std::size_t i = 0; i < instances.size(); ++i) {
        if (!moves[i]) continue;
        const Mesh& mesh = meshes[static_cast<std::size_t>(instances[i].mesh)];
        if (instances[i].skin >= 0 || !mesh.morphTargets.empty()) deformedVertices += mesh.positions.size();
    }
    if (std::find(moves.begin(), moves.end(), 1) == moves.end()) return result;

    std::vector<double> keys;
    for (const Animation& animation : animations) {
        for (const AnimationChannel& channel : animation.channels)
            keys.insert(keys.end(), channel.times.begin(), channel.times.end());
    }
    std::sort(keys.begin(), keys.end());
    keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
    // A second or so of work at most: deforming a vertex takes some 50 ns.
    const std::size_t most = std::clamp<std::size_t>((std::size_t{1} << 24) / (deformedVertices + 1), 16, 4096);
    const std::size_t steps = std::clamp<std::size_t>(most / keys.size(), 1, 16);
    const std::size_t stride = (keys.size() + most - 1) / most;
    std::vector<double> times{keys.back()};
    for (std::size_t k = 0; k + 1 < keys.size(); k += stride) {
        for (std::size_t step = 0; step < steps; ++step)
            times.push_back(glm::mix(keys[k], keys[k + 1], static_cast<double>(step) / static_cast<double>(steps)));
    }
    for (const double time : times) {
        const Pose at = pose(time);
        for (std::size_t i = 0; i < instances.size(); ++i) {
            if (!moves[i]) continue;
            const auto mesh = static_cast<std::size_t>(instances[i].mesh);
            addInstance(result, meshes[mesh], meshBoxes[mesh], at.instances[i], at.deformations[i]);
        }
    }
    return result;
}

std::vector<Light> Scene::lightsAt(double time) const {
    const std::vector<glm::dmat4> world = worldMatrices(time);
    std::vector<Light> result;
    for (const Light& light : lights) result.push_back(worldLight(lightAt(light, time), world));
    return result;
}

std::vector<std::uint8_t> Scene::movingInstances() const {
    std::vector<std::uint8_t> nodeMoves(nodes.size(), 0), weightsMove(nodes.size(), 0);
    for (const Animation& animation : animations) {
        for (const AnimationChannel& channel : animation.channels)
            (channel.property == AnimatedProperty::morph_weights ? weightsMove
                                                                 : nodeMoves)[static_cast<std::size_t>(channel.node)] =
                1;
    }
    for (std::size_t i = 0; i < nodes.size(); ++i) {
        if (nodes[i].parent >= 0) nodeMoves[i] |= nodeMoves[static_cast<std::size_t>(nodes[i].parent)];
    }
    std::vector<std::uint8_t> moves;
    for (const Instance& instance : instances) {
        const auto node = static_cast<std::size_t>(instance.node);
        bool moving = nodeMoves[node] != 0;
        if (instance.skin >= 0) {
            const std::vector<int>& joints = skins[static_cast<std::size_t>(instance.skin)].joints;
            moving = std::any_of(joints.begin(), joints.end(),
                                 [&](int joint) { return nodeMoves[static_cast<std::size_t>(joint)] != 0; });
        }
        moving |= weightsMove[node] && !meshes[static_cast<std::size_t>(instance.mesh)].morphTargets.empty();
        moves.push_back(moving);
    }
    return moves;
}

Bounds transformed(const Bounds& box, const glm::dmat4& matrix) {
    Bounds result;
    if (box.empty()) return result;
    for (int corner = 0; corner < 8; ++corner) {
        const glm::dvec3 p((corner & 1) ? box.max.x : box.min.x, (corner & 2) ? box.max.y : box.min.y,
                           (corner & 4) ? box.max.z : box.min.z);
        result.add(glm::dvec3(matrix * glm::dvec4(p, 1)));
    }
    return result;
}

bool Scene::isLeaves(const Material& material) const {
    if (material.matter != Matter::automatic) return material.matter == Matter::leaves;
    if (material.alphaMode == AlphaMode::opaque) return false;
    // Exporters also write MASK or BLEND for what is opaque everywhere.
    float least = material.baseColor.a;
    if (material.baseColorTexture.texture >= 0) {
        const Texture& texture = textures[static_cast<std::size_t>(material.baseColorTexture.texture)];
        std::uint8_t lowest = 255;
        for (std::size_t i = 3; i < texture.rgba8.size(); i += 4) lowest = std::min(lowest, texture.rgba8[i]);
        least *= static_cast<float>(lowest) / 255;
    }
    return least < (material.alphaMode == AlphaMode::mask ? material.alphaCutoff : 1.0f);
}

std::size_t Scene::triangleCount() const {
    std::size_t count = 0;
    for (const Instance& instance : instances)
        count += meshes[static_cast<std::size_t>(instance.mesh)].indices.size() / 3;
    return count;
}

Light lightAt(const Light& light, double time) {
    Light result = light;
    result.track = {};
    const LightTrack& track = light.track;
    if (!track.position.empty()) result.position = track.position.at(time);
    if (!track.intensity.empty()) result.intensity = glm::max(glm::vec3(track.intensity.at(time)), glm::vec3(0));
    if (!track.direction.empty()) {
        const glm::dvec3 direction = track.direction.at(time);
        // Between opposite directions there is none for a moment.
        if (glm::length(direction) > 0) result.direction = glm::normalize(direction);
        // Rodrigues' rotation from the light's direction to this one. The opposite direction leaves `up` across.
        const glm::dvec3 axis = glm::cross(light.direction, result.direction);
        const double cosine = glm::dot(light.direction, result.direction);
        if (cosine > -1 + 1e-12) {
            const glm::dvec3 step = glm::cross(axis, light.up);
            result.up = glm::normalize(light.up + step + glm::cross(axis, step) / (1 + cosine));
        }
    }
    return result;
}

Light worldLight(const Light& light, const std::vector<glm::dmat4>& worldMatrices) {
    if (light.node < 0) return light;
    const glm::dmat4& matrix = worldMatrices[static_cast<std::size_t>(light.node)];
    Light result = light;
    result.node = -1;
    result.position = glm::dvec3(matrix * glm::dvec4(light.position, 1));
    result.direction = transformDirection(matrix, light.direction, light.direction);
    // Shear tilts `up` against `direction`; what is left of it across the direction is kept.
    const glm::dvec3 up = transformDirection(matrix, light.up, light.up);
    const glm::dvec3 across = up - glm::dot(up, result.direction) * result.direction;
    if (glm::length(across) > 1e-9) result.up = glm::normalize(across);
    result.radius = light.radius * lengthScale(matrix);
    const glm::dvec3 right = glm::cross(light.direction, light.up);
    result.width = light.width * glm::length(glm::dmat3(matrix) * right);
    result.height = light.height * glm::length(glm::dmat3(matrix) * light.up);
    return result;
}

Camera worldCamera(const Camera& camera, const std::vector<glm::dmat4>& worldMatrices) {
    if (camera.node < 0) return camera;
    const glm::dmat4& matrix = worldMatrices[static_cast<std::size_t>(camera.node)];
    Camera result = camera;
    result.node = -1;
    result.position = glm::dvec3(matrix * glm::dvec4(camera.position, 1));
    result.target = result.position + transformDirection(matrix, camera.target - camera.position, glm::dvec3(0, 0, -1));
    result.up = transformDirection(matrix, camera.up, camera.up);
    return result;
}

glm::dmat4 viewMatrix(const Camera& worldCamera) {
    const glm::dvec3 toTarget = worldCamera.target - worldCamera.position;
    VOXCONE_CHECK(glm::length(toTarget) > 0, "camera '{}' looks at its own position", worldCamera.name);
    const glm::dvec3 forward = glm::normalize(toTarget);
    glm::dvec3 up = worldCamera.up;
    if (glm::length(glm::cross(forward, up)) <= 1e-9 * glm::length(up)) {
        // Looking straight along `up`: any horizon will do, so long as it is always the same one.
        up = std::abs(forward.y) > 0.9 ? glm::dvec3(0, 0, forward.y > 0 ? 1 : -1) : glm::dvec3(0, 1, 0);
    }
    return glm::lookAt(worldCamera.position, worldCamera.position + forward, up);
}

}  // namespace voxcone
