// Mips of textures whose alpha cuts shapes out.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace voxcone::gl {

/// The mip levels, RGBA8 with sRGB colour, of such an image (`width` × `height`), finest first, down to 1×1. Plain
/// averages would mix in the colour of texels that are not there, mostly black: leaves would darken with the distance.
/// So colours are averaged in linear light weighted with alpha, alpha plainly; texels of alpha 0 get the colour around
/// them, from the finest coarser level that has any, so that filtering between texels does not meet black either.
std::vector<std::vector<std::uint8_t>> alphaWeightedMips(int width, int height, std::span<const std::uint8_t> rgba8);

}  // namespace voxcone::gl
