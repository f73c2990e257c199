// Error figures on pictures whose answers are known.
#include "metric/metrics.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "core/error.h"

namespace voxcone {
namespace {

Image constant(int width, int height, std::vector<float> value) {
    Image image(width, height, static_cast<int>(value.size()));
    for (std::size_t i = 0; i < image.data.size(); ++i) image.data[i] = value[i % value.size()];
    return image;
}

Image noise(int width, int height, unsigned seed) {
    std::mt19937 random(seed);
    Image image(width, height, 3);
    for (float& v : image.data) v = static_cast<float>(random() % 1000) / 1000;
    return image;
}

TEST(LinearError, EqualPicturesHaveNone) {
    const Image image = noise(20, 10, 1);
    const LinearError error = linearError(image, image);
    EXPECT_EQ(error.rmse, 0);
    EXPECT_EQ(error.relMse, 0);
    EXPECT_EQ(error.bias, 0);
    EXPECT_EQ(error.relativeBias, 0);
    EXPECT_EQ(error.p99, 0);
}

TEST(LinearError, ConstantOffset) {
    const LinearError error = linearError(constant(8, 8, {2, 2, 2}), constant(8, 8, {2.5f, 2.5f, 2.5f}));
    EXPECT_DOUBLE_EQ(error.rmse, 0.5);
    EXPECT_DOUBLE_EQ(error.bias, 0.5);
    EXPECT_DOUBLE_EQ(error.relativeBias, 0.25);
    EXPECT_DOUBLE_EQ(error.epsilon, 0.04);
    EXPECT_NEAR(error.relMse, 0.25 / 4.04, 1e-12);
    EXPECT_DOUBLE_EQ(error.p99, 0.5);
}

TEST(LinearError, BiasCancelsAndKeepsItsSign) {
    const LinearError even = linearError(constant(4, 4, {1, 1}), constant(4, 4, {0.5f, 1.5f}));
    EXPECT_DOUBLE_EQ(even.bias, 0);
    EXPECT_DOUBLE_EQ(even.rmse, 0.5);
    EXPECT_LT(linearError(constant(4, 4, {1}), constant(4, 4, {0.75f})).relativeBias, 0);
}

TEST(LinearError, PercentileIgnoresOnePixelInAHundred) {
    const Image reference = constant(100, 1, {1});
    Image test = reference;
    test.data[17] = 100;
    EXPECT_EQ(linearError(reference, test).p99, 0);
    test.data[18] = 3;
    EXPECT_EQ(linearError(reference, test).p99, 2);
}

TEST(LinearError, BlackReference) {
    const Image black = constant(4, 4, {0, 0, 0});
    EXPECT_EQ(linearError(black, black).relMse, 0);
    EXPECT_EQ(linearError(black, constant(4, 4, {1, 1, 1})).relMse, std::numeric_limits<double>::infinity());
}

TEST(DisplayError, EqualPictures) {
    const Image image = noise(32, 16, 2);
    const DisplayError error = displayError(image, image);
    EXPECT_EQ(error.psnr, std::numeric_limits<double>::infinity());
    EXPECT_NEAR(error.ssim, 1, 1e-6);
    EXPECT_NEAR(error.grade, 10, 0.01);
    EXPECT_EQ(error.flip, 0);
}

TEST(DisplayError, PsnrIsOfEncodedValues) {
    // sRGB 0.5 against 0.6: mean squared error 0.01, 20 dB.
    const float a = linearFromSrgb(0.5f), b = linearFromSrgb(0.6f);
    EXPECT_NEAR(displayError(constant(12, 12, {a, a, a}), constant(12, 12, {b, b, b})).psnr, 20, 1e-3);
}

TEST(Ssim, ConstantPicturesFollowTheLuminanceTerm) {
    // Without variance SSIM = (2xy + C1)/(x² + y² + C1).
    const Image map = ssimMap(constant(20, 20, {0.5f}), constant(20, 20, {0.25f}));
    const double expected = (2 * 0.5 * 0.25 + 1e-4) / (0.25 + 0.0625 + 1e-4);
    EXPECT_THAT(map.data, testing::Each(testing::FloatNear(static_cast<float>(expected), 1e-5f)));
}

TEST(Ssim, InvertedStructureIsNegative) {
    const Image image = noise(40, 40, 3);
    Image inverted = image;
    for (float& v : inverted.data) v = 1 - v;
    EXPECT_LT(displayError(image, inverted).ssim, -0.5);
}

TEST(Ssim, WindowIsElevenWide) {
    Image reference = constant(31, 31, {0.5f}), test = reference;
    test.pixel(15, 15)[0] = 0.9f;
    const Image map = ssimMap(reference, test);
    EXPECT_LT(*map.pixel(15, 15), 0.9f);
    EXPECT_LT(*map.pixel(20, 15), 1 - 1e-6f);  // 5 away: the window's edge
    EXPECT_FLOAT_EQ(*map.pixel(21, 15), 1);    // 6 away: outside
    EXPECT_FLOAT_EQ(*map.pixel(15, 10), *map.pixel(15, 20));
}

TEST(Grade, IgnoresPixelsThatAreBlackInBoth) {
    Image reference(60, 20, 3), test(60, 20, 3);
    for (int y = 0; y < 20; ++y) {
        for (int x = 0; x < 10; ++x) {
            for (int c = 0; c < 3; ++c) reference.pixel(x, y)[c] = 0.4f, test.pixel(x, y)[c] = 0.5f;
        }
    }
    // Five sixths of the picture are black and equal, yet do not count.
    EXPECT_LT(displayError(reference, test).grade, 0.1);
    EXPECT_GT(displayError(reference, test).ssim, 0.9);
    EXPECT_EQ(displayError(Image(8, 8, 3), Image(8, 8, 3)).grade, 10);
}

TEST(RequireComparable, SaysWhatDiffers) {
    const auto message = [](const Image& reference, const Image& test) -> std::string {
        try {
            requireComparable(reference, "r.exr", test, "t.exr");
        } catch (const InputError& error) {
            return error.what();
        }
        return "";
    };
    const Image image = constant(5, 4, {1, 1, 1});
    EXPECT_EQ(message(image, image), "");
    EXPECT_EQ(message(image, constant(4, 5, {1, 1, 1})), "t.exr: is 4x5 pixels, the reference r.exr is 5x4");
    EXPECT_EQ(message(image, constant(5, 4, {1})), "t.exr: has 1 channels, the reference r.exr has 3");
    Image bad = image;
    bad.pixel(2, 3)[1] = std::nanf("");
    EXPECT_EQ(message(image, bad), "t.exr: pixel (2, 3) channel 1: is NaN");
    EXPECT_EQ(message(bad, image), "r.exr: pixel (2, 3) channel 1: is NaN");
    bad.pixel(2, 3)[1] = -std::numeric_limits<float>::infinity();
    EXPECT_EQ(message(image, bad), "t.exr: pixel (2, 3) channel 1: is infinite");
}

TEST(RelativeErrorMap, ItsMeanSquareIsRelMse) {
    Image reference(4, 2, 1), test(4, 2, 1);
    for (std::size_t i = 0; i < 8; ++i) {
        reference.data[i] = 0.25f * static_cast<float>(i);
        test.data[i] = reference.data[i] * (i % 2 == 0 ? 1.5f : 0.5f) + 0.1f;
    }
    const Image map = relativeErrorMap(reference, test);
    double square = 0;
    for (const float v : map.data) square += static_cast<double>(v) * static_cast<double>(v) / 8;
    EXPECT_NEAR(square, linearError(reference, test).relMse, 1e-6);
    EXPECT_GT(map.data[6], 0);
    EXPECT_LT(map.data[7], 0);
}

}  // namespace
}  // namespace voxcone
