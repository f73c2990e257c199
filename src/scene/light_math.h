// Falloffs of KHR_lights_punctual. Twin of shaders/shared/light_math.glsl: same names, same arithmetic.
#pragma once

#include <algorithm>

namespace voxcone {

/// 1 inside the inner cone, 0 outside the outer one, smooth between. Arguments are cosines: of the angle between the
/// spot's axis and the direction to the receiver, and of the half-angles of both cones.
inline float spotFalloff(float cosAngle, float cosInner, float cosOuter) {
    const float t = std::clamp((cosAngle - cosOuter) / std::max(cosInner - cosOuter, 1e-3f), 0.0f, 1.0f);
    return t * t;
}

/// Window that takes the inverse-square law to zero at `range`; `range` 0 means unlimited. The factor 1/distance² is
/// not included. Only the ratio counts, so any unit of length will do.
inline float rangeWindow(float distance, float range) {
    if (range <= 0) return 1;
    const float r = distance / range;
    return std::clamp(1 - r * r * r * r, 0.0f, 1.0f);
}

}  // namespace voxcone
