// Environment panoramas through OpenImageIO, and how they are looked up. The same look-up stands in
// shaders/shared/environment.glsl.
#pragma once

#include <filesystem>

#include "scene/scene.h"

namespace voxcone {

/// Reads an equirectangular .hdr or .exr (any format that OpenImageIO knows); values are linear radiance. NaN, Inf and
/// negative texels are an InputError that counts them.
Environment loadEnvironment(const std::filesystem::path& file);

/// Radiance from unit direction `d` (towards the sky), bilinear, wrapping in longitude, clamped at the poles.
glm::vec3 environmentRadiance(const Environment& environment, const glm::vec3& d);

/// The part of it that analytic lights leave to cones: of Environment::residual.
glm::vec3 environmentResidual(const Environment& environment, const glm::vec3& d);

/// Texture coordinates in [0,1)² of unit direction `d` after the rotation: u grows to the right seen from inside, v
/// downwards.
glm::vec2 environmentUv(const Environment& environment, const glm::vec3& d);

}  // namespace voxcone
