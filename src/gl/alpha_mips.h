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
/// `cutoff` > 0: a mask; a texel then counts in the coarser levels as there (alpha of at least this) or not, so that
/// their alpha is the share of the image that the mask leaves. The finest level keeps its alpha, to be cut when drawn.
std::vector<std::vector<std::uint8_t>> alphaWeightedMips(int width, int height, std::span<const std::uint8_t> rgba8,
                                                         float cutoff = 0);

}  // namespace voxcone::gl
