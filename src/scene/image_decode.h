// PNG and JPEG in memory to eight-bit RGBA.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace voxcone {

struct DecodedImage {
    int width = 0, height = 0;
    std::vector<std::uint8_t> rgba8;  ///< row 0 on top, alpha unassociated
};

/// Decodes `bytes` through OpenImageIO (libpng, libjpeg). Sides are limited to 16384 and the whole to 2²⁶ texels,
/// checked before the pixels are allocated. Grey is spread to RGB, missing alpha is 255, deeper than 8 bits is rounded.
/// Throws InputError with `file` and `jsonPath`. Safe to call from several threads.
DecodedImage decodeImage(const std::vector<std::uint8_t>& bytes, const std::string& file, const std::string& jsonPath);

}  // namespace voxcone
