#include "gl/alpha_mips.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/glm.hpp>

#include "core/check.h"

namespace voxcone::gl {
namespace {

/// Colours in linear light times alpha; alpha last.
struct Level {
    int width = 0, height = 0;
    std::vector<glm::vec4> texels;
    const glm::vec4& at(int x, int y) const {
        return texels[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)];
    }
};

float linearFromSrgb(float s) {
    return s <= 0.04045f ? s / 12.92f : std::pow((s + 0.055f) / 1.055f, 2.4f);
}

std::uint8_t byteOf(float value) {
    return static_cast<std::uint8_t>(std::lround(255 * std::clamp(value, 0.0f, 1.0f)));
}

std::uint8_t srgbByteOf(float linear) {
    return byteOf(linear <= 0.0031308f ? 12.92f * linear : 1.055f * std::pow(linear, 1 / 2.4f) - 0.055f);
}

/// Texels of an axis of `from` that texel `i` of `to` covers: first, and one past the last. Where an odd size is halved
/// one of them belongs to both neighbours.
std::array<int, 2> covered(int i, int from, int to) {
    return {i * from / to, ((i + 1) * from + to - 1) / to};
}

Level halved(const Level& fine) {
    Level coarse{std::max(fine.width / 2, 1), std::max(fine.height / 2, 1), {}};
    for (int y = 0; y < coarse.height; ++y) {
        const auto [y0, y1] = covered(y, fine.height, coarse.height);
        for (int x = 0; x < coarse.width; ++x) {
            const auto [x0, x1] = covered(x, fine.width, coarse.width);
            glm::vec4 sum(0);
            for (int v = y0; v < y1; ++v) {
                for (int u = x0; u < x1; ++u) sum += fine.at(u, v);
            }
            coarse.texels.push_back(sum / static_cast<float>((x1 - x0) * (y1 - y0)));
        }
    }
    return coarse;
}

}  // namespace

std::vector<std::vector<std::uint8_t>> alphaWeightedMips(int width, int height, std::span<const std::uint8_t> rgba8,
                                                         float cutoff) {
    VOXCONE_CHECK(width > 0 && height > 0 &&
                      rgba8.size() == 4 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height),
                  "{} bytes for {}×{} texels", rgba8.size(), width, height);
    std::array<float, 256> linear{};
    for (std::size_t i = 0; i < linear.size(); ++i) linear[i] = linearFromSrgb(static_cast<float>(i) / 255);

    std::vector<Level> levels(1);
    levels[0] = {width, height, {}};
    for (std::size_t i = 0; i < rgba8.size(); i += 4) {
        const float alpha = static_cast<float>(rgba8[i + 3]) / 255;
        levels[0].texels.emplace_back(alpha * glm::vec3(linear[rgba8[i]], linear[rgba8[i + 1]], linear[rgba8[i + 2]]),
                                      alpha);
    }
    Level cut = levels[0];
    if (cutoff > 0) {
        for (glm::vec4& texel : cut.texels) texel = texel.a >= cutoff ? texel / texel.a : glm::vec4(0);
    }
    while (levels.back().width > 1 || levels.back().height > 1)
        levels.push_back(halved(levels.size() == 1 ? cut : levels.back()));

    std::vector<std::vector<std::uint8_t>> bytes(levels.size());
    std::vector<glm::vec3> coarser(1, glm::vec3(0));  // colours of the next coarser level, not weighted
    for (std::size_t k = levels.size(); k-- > 0;) {
        const Level& level = levels[k];
        const int coarserWidth = std::max(level.width / 2, 1), coarserHeight = std::max(level.height / 2, 1);
        std::vector<glm::vec3> colors;
        for (int y = 0; y < level.height; ++y) {
            for (int x = 0; x < level.width; ++x) {
                const glm::vec4 texel = level.at(x, y);
                const std::size_t above = static_cast<std::size_t>(std::min(y / 2, coarserHeight - 1)) *
                                              static_cast<std::size_t>(coarserWidth) +
                                          static_cast<std::size_t>(std::min(x / 2, coarserWidth - 1));
                const glm::vec3 color = texel.a > 0 ? glm::vec3(texel) / texel.a : coarser[above];
                colors.push_back(color);
                for (int c = 0; c < 3; ++c) bytes[k].push_back(srgbByteOf(color[c]));
                bytes[k].push_back(byteOf(texel.a));
            }
        }
        coarser = std::move(colors);
    }
    return bytes;
}

}  // namespace voxcone::gl
