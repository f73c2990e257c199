// Directional albedo of the specular lobe, split into its parts by Fresnel ("split sum", Karis 2013, "Real Shading in
// Unreal Engine 4"; height-correlated Smith masking as in scene/brdf.h).
#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "gl/texture.h"

namespace voxcone {

/// Edge of the table.
constexpr int kSpecularTableSize = 32;

/// (A, B) with  ∫ f_s(v, l) n·l dl = f0·A + f90·B  for the GGX lobe with Schlick's Fresnel: A = ∫ (1−w) …, B = ∫ w …
/// with w = (1 − v·h)⁵. `cosTheta` = n·v in (0,1], `alpha` GGX width in [kMinAlpha,1]. Integrated over `samples`
/// visible normals.
glm::dvec2 specularAlbedo(double cosTheta, double alpha, int samples);

/// `size`² texels of specularAlbedo, cosTheta along x, roughness = √alpha along y, both at i/(size − 1), so that the
/// ends of their ranges are met. The first column is that of a small cosTheta > 0.
std::vector<glm::vec2> specularAlbedoTable(int size);

/// The table as an RG32F texture with linear filter: texture(table, (vec2(n·v, roughness)·(size − 1) + ½) / size).rg.
gl::Texture specularAlbedoTexture();

}  // namespace voxcone
