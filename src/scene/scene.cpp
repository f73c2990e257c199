#include "scene/scene.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

#include "core/check.h"

namespace voxcone {

namespace {

struct Pose {
    glm::dvec3 translation, scale;
    glm::dquat rotation;
};

// glTF stores quaternions as xyzw, GLM's constructor takes wxyz.
glm::dquat quaternion(const glm::dvec4& v) {
    return {v.w, v.x, v.y, v.z};
}

/// Value of `channel` at `time`, clamped to the first and last key (glTF 2.0, appendix C).
glm::dvec4 evaluate(const AnimationChannel& channel, double time) {
    const bool spline = channel.interpolation == Interpolation::cubic_spline;
    auto value = [&](std::size_t key) { return glm::dvec4(channel.values[spline ? 3 * key + 1 : key]); };
    const auto [key, t, span] = keyPosition(channel.times, time);
    if (span == 0 || channel.interpolation == Interpolation::step) return value(key);
    if (spline) {
        return hermite(value(key), span * glm::dvec4(channel.values[3 * key + 2]), value(key + 1),
                       span * glm::dvec4(channel.values[3 * key + 3]), t);
    }
    if (channel.property == AnimatedProperty::rotation) {
        // glm::slerp takes the shorter way, as the specification asks.
        const glm::dquat q =
            glm::slerp(glm::normalize(quaternion(value(key))), glm::normalize(quaternion(value(key + 1))), t);
        return {q.x, q.y, q.z, q.w};
    }
    return (1 - t) * value(key) + t * value(key + 1);
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
    std::vector<Pose> poses(nodes.size());
    for (std::size_t i = 0; i < nodes.size(); ++i) poses[i] = {nodes[i].translation, nodes[i].scale, nodes[i].rotation};
    for (const Animation& animation : animations) {
        for (const AnimationChannel& channel : animation.channels) {
            const glm::dvec4 value = evaluate(channel, time);
            Pose& pose = poses[static_cast<std::size_t>(channel.node)];
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

Bounds Scene::bounds(double time) const {
    const std::vector<glm::dmat4> world = worldMatrices(time);
    Bounds result;
    for (const Instance& instance : instances) {
        const Mesh& mesh = meshes[static_cast<std::size_t>(instance.mesh)];
        const glm::dmat4& matrix = world[static_cast<std::size_t>(instance.node)];
        for (const std::uint32_t index : mesh.indices)
            result.add(glm::dvec3(matrix * glm::dvec4(mesh.positions[index], 1)));
    }
    return result;
}

std::vector<std::uint8_t> Scene::movingInstances() const {
    std::vector<std::uint8_t> nodeMoves(nodes.size(), 0);
    for (const Animation& animation : animations) {
        for (const AnimationChannel& channel : animation.channels)
            nodeMoves[static_cast<std::size_t>(channel.node)] = 1;
    }
    for (std::size_t i = 0; i < nodes.size(); ++i) {
        if (nodes[i].parent >= 0) nodeMoves[i] |= nodeMoves[static_cast<std::size_t>(nodes[i].parent)];
    }
    std::vector<std::uint8_t> moves;
    for (const Instance& instance : instances) moves.push_back(nodeMoves[static_cast<std::size_t>(instance.node)]);
    return moves;
}

std::size_t Scene::triangleCount() const {
    std::size_t count = 0;
    for (const Instance& instance : instances)
        count += meshes[static_cast<std::size_t>(instance.mesh)].indices.size() / 3;
    return count;
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
