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

Image signedHeatmap(const Image& values, double full) {
    VOXCONE_CHECK(values.channels == 1, "{} channels", values.channels);
    // sRGB-encoded at 0, half and full, for either sign; in between the encoded values run straight.
    constexpr std::array<std::array<float, 3>, 3> kAbove = {{{0, 0, 0}, {205, 40, 20}, {255, 225, 90}}},
                                                  kBelow = {{{0, 0, 0}, {30, 70, 220}, {130, 235, 255}}};
    constexpr float kNone = 96;
    Image colors(values.width, values.height, 3);
    for (std::size_t i = 0; i < values.data.size(); ++i) {
        const float value = values.data[i];
        const float at = std::min(std::abs(value) / static_cast<float>(full), 1.0f) * 2;
        const std::size_t low = at >= 1 ? 1 : 0;
        const auto& map = value < 0 ? kBelow : kAbove;
        for (std::size_t c = 0; c < 3; ++c) {
            const float encoded =
                std::isnan(value) ? kNone : std::lerp(map[low][c], map[low + 1][c], at - static_cast<float>(low));
            colors.data[3 * i + c] = linearFromSrgb(encoded / 255);
        }
    }
    return colors;
}

}  // namespace voxcone
