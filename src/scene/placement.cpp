#include "scene/placement.h"

#include <algorithm>
#include <cmath>

namespace voxcone {

glm::dquat rotationFromDegrees(const glm::dvec3& degrees) {
    const glm::dvec3 a = glm::radians(degrees);
    return glm::angleAxis(a.z, glm::dvec3(0, 0, 1)) * glm::angleAxis(a.y, glm::dvec3(0, 1, 0)) *
           glm::angleAxis(a.x, glm::dvec3(1, 0, 0));
}

glm::dvec3 degreesOf(const glm::dquat& rotation) {
    const glm::dmat3 m = glm::mat3_cast(glm::normalize(rotation));
    const double sine = std::clamp(-m[0][2], -1.0, 1.0), y = std::asin(sine);
    // Where y is a right angle, x and z turn about the same axis: all of it is given to x.
    const bool locked = std::abs(sine) > 1 - 1e-12;
    const double x = locked ? std::atan2(-m[2][1], m[1][1]) : std::atan2(m[1][2], m[2][2]);
    const double z = locked ? 0 : std::atan2(m[0][1], m[0][0]);
    return glm::degrees(glm::dvec3(x, y, z)) + 0.0;  // no −0
}

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

bool place(Node& node, const Placement& placement) {
    if (placement.empty()) return true;
    if (!decompose(node)) return false;
    if (placement.translation) node.translation = *placement.translation;
    if (placement.rotation) node.rotation = rotationFromDegrees(*placement.rotation);
    if (placement.scale) node.scale = *placement.scale;
    return true;
}

bool isAnimated(const Scene& scene, int node) {
    return std::any_of(scene.animations.begin(), scene.animations.end(), [node](const Animation& animation) {
        return std::any_of(animation.channels.begin(), animation.channels.end(), [node](const AnimationChannel& c) {
            return c.node == node && c.property != AnimatedProperty::morph_weights;
        });
    });
}

}  // namespace voxcone
