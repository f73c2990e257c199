// Shared-exponent colour, EXT_texture_shared_exponent: three 9-bit mantissas and a 5-bit exponent, bias 15. Twin of
// shaders/shared/rgb9e5.glsl: same names, same arithmetic.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>

namespace voxcone {

/// Largest component that can be stored: 511/512 · 2^16.
inline constexpr float kMaxRgb9e5 = 65408;

/// Components are clamped to [0, kMaxRgb9e5] and rounded to nearest, by at most 1/512 of the largest one.
inline std::uint32_t packRgb9e5(const glm::vec3& color) {
    const glm::vec3 c = glm::clamp(color, glm::vec3(0), glm::vec3(kMaxRgb9e5));
    const float largest = std::max(c.x, std::max(c.y, c.z));
    int exponent = std::max(-16, static_cast<int>(std::bit_cast<std::uint32_t>(largest) >> 23) - 127) + 16;
    float scale = std::exp2(static_cast<float>(24 - exponent));
    if (std::floor(largest * scale + 0.5f) == 512.0f) {
        ++exponent;
        scale *= 0.5f;
    }
    const glm::uvec3 mantissa(glm::floor(c * scale + 0.5f));
    return mantissa.x | (mantissa.y << 9) | (mantissa.z << 18) | (static_cast<std::uint32_t>(exponent) << 27);
}

inline glm::vec3 unpackRgb9e5(std::uint32_t p) {
    const float scale = std::exp2(static_cast<float>(static_cast<int>(p >> 27) - 24));
    return glm::vec3(glm::uvec3(p & 511u, (p >> 9) & 511u, (p >> 18) & 511u)) * scale;
}

}  // namespace voxcone
