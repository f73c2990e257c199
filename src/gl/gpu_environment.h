// The environment's panorama on the device.
#pragma once

#include <glm/glm.hpp>

#include "gl/texture.h"
#include "scene/scene.h"

namespace voxcone::gl {

/// Radiance from direction d is `color` times the panorama at environmentUv(d, rotation)
/// (shaders/shared/environment.glsl), or `color` alone without a panorama.
struct GpuEnvironment {
    GpuEnvironment() = default;
    /// Uploads the panorama, if there is one and `color` is not black: RGB32F, so that suns keep their strength, with
    /// mips for cones, trilinear, repeating in longitude. Throws DeviceError when it is too large for the device.
    explicit GpuEnvironment(const Environment& environment) : GpuEnvironment(environment, {}) {}
    /// The same with other texels, of the same size, in the place of the panorama's, unless they are empty.
    GpuEnvironment(const Environment& environment, const std::vector<glm::vec3>& texels);

    glm::vec3 color{0};
    float rotation = 0;  ///< radians
    Texture panorama;    ///< empty: constant colour
};

}  // namespace voxcone::gl
