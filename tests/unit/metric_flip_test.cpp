// ꟻLIP against the properties and constants of its papers.
#include "metric/flip.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "metric/heatmap.h"

namespace voxcone {
namespace {

Image constant(int width, int height, float r, float g, float b) {
    Image image(width, height, 3);
    for (std::size_t i = 0; i < image.data.size(); i += 3)
        image.data[i] = r, image.data[i + 1] = g, image.data[i + 2] = b;
    return image;
}

Image noise(int width, int height, unsigned seed, float scale = 1) {
    std::mt19937 random(seed);
    Image image(width, height, 3);
    for (float& v : image.data) v = scale * static_cast<float>(random() % 1000) / 1000;
    return image;
}

TEST(Flip, EqualPicturesAreZero) {
    const Image image = noise(40, 30, 1);
    EXPECT_THAT(flip(image, image).data, testing::Each(0.0f));
    EXPECT_THAT(hdrFlip(image, image).error.data, testing::Each(0.0f));
}

TEST(Flip, SymmetricInItsArguments) {
    const Image a = noise(40, 30, 1), b = noise(40, 30, 2);
    EXPECT_EQ(flip(a, b).data, flip(b, a).data);
}

// Colours without structure have no feature difference; the error is the redistributed HyAB distance. By hand from the
// 2020 paper: blue and green are the farthest apart (1 by definition); black and white differ by ΔL = 100 only, 100^0.7
// = 25.12 of at most 41.28, which the redistribution (knee 0.4, 0.95) brings to 0.967.
TEST(Flip, UniformColoursHaveThePapersDistances) {
    const auto error = [](const Image& a, const Image& b) { return meanOf(flip(a, b)); };
    const Image black = constant(48, 48, 0, 0, 0), white = constant(48, 48, 1, 1, 1);
    EXPECT_NEAR(error(constant(48, 48, 0, 1, 0), constant(48, 48, 0, 0, 1)), 1, 1e-3);
    EXPECT_NEAR(error(black, white), 0.967, 2e-3);
    EXPECT_GT(error(black, white), error(black, constant(48, 48, 0.5f, 0.5f, 0.5f)));
}

TEST(Flip, ValuesStayInRange) {
    for (const float v : flip(noise(50, 50, 3), noise(50, 50, 4)).data) {
        EXPECT_GE(v, 0);
        EXPECT_LE(v, 1);
    }
}

// A mirrored pair of pictures has the mirrored error.
TEST(Flip, CommutesWithMirroring) {
    Image a = noise(33, 21, 5), b = noise(33, 21, 6);
    const Image error = flip(a, b);
    const auto mirrored = [](const Image& image) {
        Image out = image;
        for (int y = 0; y < image.height; ++y) {
            for (int x = 0; x < image.width; ++x)
                std::copy_n(image.pixel(image.width - 1 - x, y), image.channels, out.pixel(x, y));
        }
        return out;
    };
    const Image other = mirrored(flip(mirrored(a), mirrored(b)));
    for (std::size_t i = 0; i < error.data.size(); ++i) EXPECT_NEAR(error.data[i], other.data[i], 2e-4);
}

// At 67 pixels a degree the eye blurs luminance over about a pixel and blue-yellow over several.
TEST(Flip, FineChromaticPatternsBlurAway) {
    const auto checker = [](float r, float g, float b) {
        Image image = constant(64, 64, 0.5f, 0.5f, 0.5f);
        for (int y = 0; y < 64; ++y) {
            for (int x = 0; x < 64; ++x) {
                const float sign = (x + y) % 2 == 0 ? 1.0f : -1.0f;
                float* p = image.pixel(x, y);
                p[0] += sign * r, p[1] += sign * g, p[2] += sign * b;
            }
        }
        return image;
    };
    const Image grey = constant(64, 64, 0.5f, 0.5f, 0.5f);
    EXPECT_LT(meanOf(flip(grey, checker(0, 0, 0.2f))), meanOf(flip(grey, constant(64, 64, 0.5f, 0.5f, 0.7f))) * 0.5);
}

TEST(Flip, IsolatedPixelIsMoreVisibleFromNear) {
    Image reference = constant(64, 64, 0.3f, 0.3f, 0.3f), test = reference;
    for (int c = 0; c < 3; ++c) test.pixel(32, 32)[c] = 1;
    EXPECT_GT(*flip(reference, test, 20).pixel(32, 32), *flip(reference, test, 200).pixel(32, 32));
    EXPECT_EQ(*flip(reference, test).pixel(0, 0), 0);  // far outside every filter
}

TEST(HdrFlip, RangeOfExposuresIsThatOfTheReference) {
    // Median 1, brightest 16: four stops apart. Where the ACES curve gives 0.85 by hand: x = 1.8835 before
    // pre-exposure.
    Image reference = constant(20, 20, 1, 1, 1);
    for (int c = 0; c < 3; ++c) reference.pixel(3, 3)[c] = 16;
    const HdrFlip result = hdrFlip(reference, reference);
    EXPECT_NEAR(result.stopExposure - result.startExposure, 4, 1e-6);
    EXPECT_EQ(result.exposures, 4);
    const double x = std::exp2(result.stopExposure) * 0.6;
    EXPECT_NEAR(x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14), 0.85, 1e-6);
}

TEST(HdrFlip, BlackBackgroundDoesNotWidenTheRange) {
    Image reference = constant(20, 20, 1, 1, 1), framed = constant(60, 60, 0, 0, 0);
    for (int y = 0; y < 20; ++y) {
        for (int x = 0; x < 20; ++x) std::copy_n(reference.pixel(x, y), 3, framed.pixel(x + 20, y + 20));
    }
    EXPECT_EQ(hdrFlip(framed, framed).stopExposure, hdrFlip(reference, reference).stopExposure);
}

TEST(HdrFlip, SeesErrorsThatDisplayRangeHides) {
    const Image reference = constant(32, 32, 8, 8, 8);
    Image test = reference;
    for (int c = 0; c < 3; ++c) test.pixel(16, 16)[c] = 2;
    EXPECT_EQ(meanOf(flip(reference, test)), 0);  // both are clipped to white
    EXPECT_GT(*hdrFlip(reference, test).error.pixel(16, 16), 0.1f);
}

TEST(HdrFlip, ScalingBothPicturesChangesNothing) {
    const Image a = noise(24, 24, 7), b = noise(24, 24, 8);
    const Image error = hdrFlip(a, b).error;
    Image c = a, d = b;
    for (float& v : c.data) v *= 64;
    for (float& v : d.data) v *= 64;
    const Image scaled = hdrFlip(c, d).error;
    for (std::size_t i = 0; i < error.data.size(); ++i) EXPECT_NEAR(error.data[i], scaled.data[i], 1e-4);
}

TEST(HdrFlip, BlackReferenceIsNoTrap) {
    const HdrFlip result = hdrFlip(constant(8, 8, 0, 0, 0), constant(8, 8, 1, 1, 1));
    EXPECT_GT(meanOf(result.error), 0.9);
    EXPECT_EQ(result.exposures, 2);
}

TEST(Heatmap, RunsFromBlackToLight) {
    Image values(3, 1, 1);
    values.data = {0, 0.5f, 7};
    const Image colors = heatmap(values);
    EXPECT_LT(colors.data[0] + colors.data[1] + colors.data[2], 0.01f);
    EXPECT_NEAR(srgbFromLinear(colors.data[3]) * 255, 181, 0.01);
    EXPECT_NEAR(srgbFromLinear(colors.data[8]) * 255, 191, 0.01);
    const Image half = heatmap(values, 14);
    EXPECT_NEAR(srgbFromLinear(half.data[6]) * 255, 181, 0.01);
}

TEST(Heatmap, SignsHaveColoursOfTheirOwn) {
    Image values(5, 1, 1);
    values.data = {-3, -1, 0, 1, std::numeric_limits<float>::quiet_NaN()};
    const Image colors = signedHeatmap(values, 2);
    const auto rgb = [&](int x) { return colors.pixel(x, 0); };
    EXPECT_NEAR(srgbFromLinear(rgb(0)[2]) * 255, 255, 0.01) << "cyan beyond the end";
    EXPECT_GT(rgb(1)[2], rgb(1)[0]) << "blue below zero";
    EXPECT_EQ(rgb(2)[0] + rgb(2)[1] + rgb(2)[2], 0);
    EXPECT_GT(rgb(3)[0], rgb(3)[2]) << "red above zero";
    EXPECT_EQ(rgb(4)[0], rgb(4)[2]) << "grey without a value";
    EXPECT_GT(rgb(4)[0], 0.05f);
}

}  // namespace
}  // namespace voxcone
