// Which object lies under the cursor: one ray through the path tracer's geometry.
#pragma once

#include <glm/glm.hpp>
#include <optional>

#include "scene/scene.h"

namespace voxcone {

/// Index in Scene::instances of what the ray from `eye` along unit `direction` (world space) meets first, as a camera
/// sees it: not the backs of single-sided materials. `near` and `far`: metres along the ray; far = 0 is no limit.
/// Builds the BVH of the scene at `time` seconds for it.
std::optional<std::size_t> pickInstance(const Scene& scene, double time, const glm::dvec3& eye,
                                        const glm::dvec3& direction, double near = 0, double far = 0);

}  // namespace voxcone
