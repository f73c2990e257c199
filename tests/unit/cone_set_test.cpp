// Cone sets integrate the hemisphere: the exact checks of a cosine-weighted quadrature.
#include "cone/cone_set.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <numbers>

namespace voxcone {
namespace {

/// How far a set may be from the integrals of cosθ and cos²θ. One cone is the normal alone; the thesis' nine directions
/// are what they are, and lean to the normal.
struct Row {
    int count;
    double cosine, cosine2;
};

class ConeSets : public testing::TestWithParam<Row> {};

TEST_P(ConeSets, IntegrateTheHemisphere) {
    const ConeSet set = coneSet(GetParam().count);
    ASSERT_EQ(set.directions.size(), static_cast<std::size_t>(GetParam().count));
    ASSERT_EQ(set.weights.size(), set.directions.size());
    double weight = 0, cosine = 0, cosine2 = 0;
    for (std::size_t i = 0; i < set.weights.size(); ++i) {
        const double z = set.directions[i].z;
        EXPECT_NEAR(glm::length(set.directions[i]), 1, 1e-12);
        EXPECT_GT(z, 0) << "above the horizon";
        EXPECT_GT(set.weights[i], 0);
        weight += set.weights[i];
        cosine += set.weights[i] * z;
        cosine2 += set.weights[i] * z * z;
    }
    EXPECT_NEAR(weight, 1, 1e-12);
    EXPECT_NEAR(cosine, 2.0 / 3, GetParam().cosine);
    EXPECT_NEAR(cosine2, 0.5, GetParam().cosine2);
    EXPECT_GT(set.tanHalfAngle, 0);
    std::printf("%d cones: cosine 2/3 %+.2e, cosine squared 1/2 %+.2e\n", GetParam().count, cosine - 2.0 / 3,
                cosine2 - 0.5);
}

TEST_P(ConeSets, HalfTheSkyIsHalfOnAverage) {
    const ConeSet set = coneSet(GetParam().count);
    const int turns = 3600;
    double mean = 0, worst = 0;
    for (int k = 0; k < turns; ++k) {
        const double angle = 2 * std::numbers::pi * (k + 0.5) / turns;
        const glm::dvec3 side(std::cos(angle), std::sin(angle), 0);
        double share = 0;
        for (std::size_t i = 0; i < set.weights.size(); ++i) {
            const double d = glm::dot(set.directions[i], side);
            share += set.weights[i] * (std::abs(d) < 1e-12 ? 0.5 : d > 0 ? 1 : 0);
        }
        mean += share / turns;
        worst = std::max(worst, std::abs(share - 0.5));
    }
    EXPECT_NEAR(mean, 0.5, 1e-3);
    std::printf("%d cones: half the sky is %.4f on average, off by %.3f at worst\n", GetParam().count, mean, worst);
    EXPECT_LT(worst, 0.08) << "in a single turn";
}

INSTANTIATE_TEST_SUITE_P(All, ConeSets,
                         testing::Values(Row{1, 0.34, 0.51}, Row{5, 1e-12, 1e-12}, Row{6, 1e-12, 0.019},
                                         Row{9, 0.045, 0.026}, Row{16, 2e-3, 1e-12}, Row{32, 1e-3, 1e-12}),
                         [](const auto& row) { return std::to_string(row.param.count); });

TEST(ConeSet, SpiralsAreEquallyWeightedAndEvenlySpread) {
    for (const int count : {16, 32}) {
        const ConeSet set = coneSet(count);
        EXPECT_TRUE(set.spiral);
        EXPECT_NEAR(set.tanHalfAngle, 1 / std::sqrt(count), 1e-12);
        glm::dvec3 mean(0);
        for (std::size_t i = 0; i < set.weights.size(); ++i) {
            EXPECT_EQ(set.weights[i], 1.0 / count);
            mean += set.directions[i] / static_cast<double>(count);
            double nearest = 2;
            for (std::size_t k = 0; k < set.weights.size(); ++k)
                if (k != i) nearest = std::min(nearest, glm::distance(set.directions[i], set.directions[k]));
            EXPECT_GT(nearest, 0.8 * 2 * std::atan(set.tanHalfAngle) / 2) << "two cones in one place";
        }
        EXPECT_LT(std::hypot(mean.x, mean.y), 0.05);
    }
}

}  // namespace
}  // namespace voxcone
