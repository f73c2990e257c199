// Unit vectors on the octahedron (Cigolle et al. 2014, "A Survey of Efficient Representations for Independent Unit
// Vectors"). Twin of shaders/shared/octahedral.glsl.
#pragma once

#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>
#include <glm/gtc/packing.hpp>

namespace voxcone {

/// In [−1,1]².
inline glm::vec2 octahedralFromUnit(const glm::vec3& n) {
    const glm::vec2 p = glm::vec2(n) / (std::abs(n.x) + std::abs(n.y) + std::abs(n.z));
    const glm::vec2 folded{(1 - std::abs(p.y)) * (p.x >= 0 ? 1.0f : -1.0f),
                           (1 - std::abs(p.x)) * (p.y >= 0 ? 1.0f : -1.0f)};
    return n.z >= 0 ? p : folded;
}

inline glm::vec3 unitFromOctahedral(const glm::vec2& p) {
    glm::vec3 n(p, 1 - std::abs(p.x) - std::abs(p.y));
    const float fold = std::max(-n.z, 0.0f);
    n.x += n.x >= 0 ? -fold : fold;
    n.y += n.y >= 0 ? -fold : fold;
    return glm::normalize(n);
}

/// 16-bit snorm each: at most 6e-5 radians off.
inline std::uint32_t packOctahedral(const glm::vec3& n) {
    return glm::packSnorm2x16(octahedralFromUnit(n));
}
inline glm::vec3 unpackOctahedral(std::uint32_t bits) {
    return unitFromOctahedral(glm::unpackSnorm2x16(bits));
}

}  // namespace voxcone
