// Tone curves, for pictures that are already on the CPU (reference, tests). Twin of shaders/shared/tone_curve.glsl.
#pragma once

#include <glm/glm.hpp>

#include "core/settings.h"

namespace voxcone {

/// Linear exposed radiance to linear display-referred values in [0,1], per channel:
///  - linear: clipped at 1;
///  - reinhard: x/(1+x) (Reinhard et al. 2002, eq. 3);
///  - aces: fit of the ACES reference rendering and output transforms by Narkowicz ("ACES Filmic Tone Mapping Curve",
///  2016).
inline glm::vec3 toneCurve(ToneMap curve, glm::vec3 x) {
    x = glm::max(x, glm::vec3(0));
    if (curve == ToneMap::reinhard) return x / (1.0f + x);
    if (curve == ToneMap::aces) {
        x = glm::min(x, glm::vec3(1e4f));
        x = (x * (2.51f * x + 0.03f)) / (x * (2.43f * x + 0.59f) + 0.14f);
    }
    return glm::min(x, glm::vec3(1));
}

}  // namespace voxcone
