#include "reference/pick.h"

#include <limits>

#include "reference/geometry.h"

namespace voxcone {

std::optional<std::size_t> pickInstance(const Scene& scene, double time, const glm::dvec3& eye,
                                        const glm::dvec3& direction, double near, double far) {
    const Geometry geometry(scene, time);
    const TracingSpace& space = geometry.space();
    const float end = far > 0 ? static_cast<float>(far * space.scale) : std::numeric_limits<float>::infinity();
    Hit hit;
    if (!geometry.intersect(Geometry::RayKind::camera, space.fromWorld(eye), glm::vec3(direction),
                            static_cast<float>(near * space.scale), end, 0, hit))
        return std::nullopt;
    return hit.instance;
}

}  // namespace voxcone
