// Mips of cut-out textures: colour of what is there only, alpha as it is.
#include <gtest/gtest.h>

#include "gl/alpha_mips.h"

namespace voxcone::gl {
namespace {

using Bytes = std::vector<std::uint8_t>;

TEST(AlphaMips, WhatIsNotThereHasNoColour) {
    // Green leaves on transparent black, in a pattern that no level divides evenly: 5 × 3.
    Bytes image;
    for (int i = 0; i < 15; ++i) {
        const bool leaf = i % 4 == 1;
        for (const int value : {leaf ? 40 : 0, leaf ? 180 : 0, leaf ? 20 : 0, leaf ? 255 : 0})
            image.push_back(static_cast<std::uint8_t>(value));
    }
    const auto levels = alphaWeightedMips(5, 3, image);
    ASSERT_EQ(levels.size(), 3u);  // 5×3, 2×1, 1×1
    EXPECT_EQ(levels[1].size(), 8u);
    EXPECT_EQ(levels[2].size(), 4u);
    for (const Bytes& level : levels) {
        for (std::size_t i = 0; i < level.size(); i += 4) {
            EXPECT_EQ(Bytes(level.begin() + static_cast<std::ptrdiff_t>(i),
                            level.begin() + static_cast<std::ptrdiff_t>(i + 3)),
                      (Bytes{40, 180, 20}));
        }
    }
    for (std::size_t i = 3; i < image.size(); i += 4) EXPECT_EQ(levels[0][i], image[i]);
}

TEST(AlphaMips, AMaskKeepsItsShare) {
    // Three of eight texels reach the cutoff; their alpha averages to 0.41, and only their colour counts.
    Bytes image;
    for (const int alpha : {255, 200, 90, 90, 128, 0, 40, 40}) {
        const int green = alpha >= 128 ? 180 : 20;
        for (const int value : {0, green, 0, alpha}) image.push_back(static_cast<std::uint8_t>(value));
    }
    const auto levels = alphaWeightedMips(8, 1, image, 0.5f);
    ASSERT_EQ(levels.size(), 4u);
    EXPECT_EQ(levels[0], alphaWeightedMips(8, 1, image)[0]) << "the finest level is not cut";
    EXPECT_EQ(levels[1], (Bytes{0, 180, 0, 255, 0, 180, 0, 0, 0, 180, 0, 128, 0, 180, 0, 0}));
    EXPECT_EQ(levels[3], (Bytes{0, 180, 0, 96}));
}

TEST(AlphaMips, AveragesAreOfLinearLightAndWeighted) {
    // 255 at alpha 1 and 0 at alpha 1/3: three quarters of the light, two thirds of the alpha.
    const auto levels = alphaWeightedMips(2, 1, Bytes{255, 255, 255, 255, 0, 0, 0, 85});
    ASSERT_EQ(levels.size(), 2u);
    EXPECT_EQ(levels[1], (Bytes{225, 225, 225, 170}));
    // Without any alpha there is no colour to take, and nothing is divided by it.
    EXPECT_EQ(alphaWeightedMips(1, 2, Bytes{9, 9, 9, 0, 9, 9, 9, 0})[1], (Bytes{0, 0, 0, 0}));
}

}  // namespace
}  // namespace voxcone::gl
