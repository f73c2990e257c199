// The environment's panorama on the device, prefiltered for cones.
#pragma once

#include <glm/glm.hpp>

#include "gl/texture.h"
#include "scene/scene.h"

namespace voxcone::gl {

/// Radiance from direction d is `color` times the panorama at environmentUv(d, rotation)
/// (shaders/shared/environment.glsl), or `color` alone without a panorama.
struct GpuEnvironment {
    GpuEnvironment() = default;
    /// Uploads the panorama, if there is one and `color` is not black: RGB32F, so that suns keep their strength,
    /// repeating in longitude. A texel of mip l > 0 is the mean radiance over the cone of half-angle min(2π/h, π), h
    /// the mip's height; its rows lie at polar angles from 0 to π inclusive, its columns' centres as in the panorama.
    /// Read by shaders/cone/sky.glsl. Throws DeviceError when the panorama is too large for the device.
    explicit GpuEnvironment(const Environment& environment) : GpuEnvironment(environment, {}) {}
    /// The same with other texels, of the same size, in the place of the panorama's, unless they are empty.
    GpuEnvironment(const Environment& environment, const std::vector<glm::vec3>& texels);

    glm::vec3 color{0};
    float rotation = 0;  ///< radians
    Texture panorama;    ///< empty: constant colour
};

}  // namespace voxcone::gl
