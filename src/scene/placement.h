// Where a node is put instead of where its file has it: by scripts and by hand in the window, through one function, so
// that both give the same bits.
#pragma once

#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>
#include <optional>

#include "scene/scene.h"

namespace voxcone {

/// In the space of the node's parent; what is absent stays.
struct Placement {
    std::optional<glm::dvec3> translation;  ///< metres
    std::optional<glm::dvec3> rotation;     ///< degrees about x, then y, then z of the parent's axes
    std::optional<glm::dvec3> scale;        ///< along the node's own axes, above 0
    bool empty() const { return !translation && !rotation && !scale; }
    bool operator==(const Placement&) const = default;
};

/// Unit quaternion of a rotation by `degrees` about x, then y, then z.
glm::dquat rotationFromDegrees(const glm::dvec3& degrees);
/// Its inverse, up to rounding: x and z in [−180, 180], y in [−90, 90].
glm::dvec3 degreesOf(const glm::dquat& rotation);

/// Makes the matrix of `node` a translation, rotation and scale; false, and nothing is changed, when it is sheared or
/// flat.
bool decompose(Node& node);

/// Puts `node` there; false, and nothing is changed, when its matrix cannot be taken apart.
bool place(Node& node, const Placement& placement);

/// Whether an animation moves the node itself; its ancestors do not count.
bool isAnimated(const Scene& scene, int node);

}  // namespace voxcone
