#include "metric/heatmap.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/check.h"

namespace voxcone {

Image heatmap(const Image& values, double full) {
    VOXCONE_CHECK(values.channels == 1, "{} channels", values.channels);
    // "magma" at nine even places, sRGB-encoded; in between the encoded values run straight.
    constexpr std::array<std::array<float, 3>, 9> kMagma = {{{0, 0, 4},
                                                             {28, 16, 68},
                                                             {79, 18, 123},
                                                             {129, 37, 129},
                                                             {181, 54, 122},
                                                             {229, 80, 100},
                                                             {251, 135, 97},
                                                             {254, 194, 135},
                                                             {252, 253, 191}}};
    Image colors(values.width, values.height, 3);
    for (std::size_t i = 0; i < values.data.size(); ++i) {
        const float at = std::clamp(values.data[i] / static_cast<float>(full), 0.0f, 1.0f) * 8;
        const std::size_t low = std::min<std::size_t>(static_cast<std::size_t>(at), 7);
        const float part = at - static_cast<float>(low);
        for (std::size_t c = 0; c < 3; ++c)
            colors.data[3 * i + c] = linearFromSrgb(std::lerp(kMagma[low][c], kMagma[low + 1][c], part) / 255);
    }
    return colors;
}

}  // namespace voxcone
