// The change between frames whose pictures are known.
#include "metric/temporal.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <glm/gtc/matrix_transform.hpp>

namespace voxcone {
namespace {

constexpr int kWidth = 48, kHeight = 32;
using Field = std::function<glm::dvec3(const glm::dvec3& position)>;

/// Scene of tests: the plane z = 0 and, when wide, a square screen of half the `screen` width in the plane z = 1 about
/// the axis, seen along −z from `eye`. Both reflect `albedo` of the irradiance `light`.
TemporalFrame frameOf(const glm::dvec3& eye, const Field& albedo, const Field& light, double screen = 0) {
    const glm::dvec3 normal(0, 0, 1);
    TemporalFrame frame{Image(kWidth, kHeight, 3), Image(kWidth, kHeight, 3), Image(kWidth, kHeight, 3),
                        Image(kWidth, kHeight, 3), glm::dmat4(1)};
    frame.worldToClip = glm::infinitePerspective(glm::radians(50.0), static_cast<double>(kWidth) / kHeight, 1.0) *
                        glm::translate(glm::dmat4(1), -eye);
    const double slope = std::tan(glm::radians(25.0));
    for (int y = 0; y < kHeight; ++y) {
        for (int x = 0; x < kWidth; ++x) {
            const glm::dvec3 ray(((x + 0.5) / kWidth * 2 - 1) * slope * kWidth / kHeight,
                                 (1 - (y + 0.5) / kHeight * 2) * slope, -1);
            glm::dvec3 hit = eye + (eye.z - 1) * ray;
            if (std::max(std::abs(hit.x), std::abs(hit.y)) >= screen / 2) hit = eye + eye.z * ray;
            const glm::dvec3 a = albedo(hit), l = light(hit);
            for (int c = 0; c < 3; ++c) {
                frame.albedo.pixel(x, y)[c] = static_cast<float>(a[c]);
                frame.indirectDiffuse.pixel(x, y)[c] = static_cast<float>(a[c] * l[c]);
                frame.position.pixel(x, y)[c] = static_cast<float>(hit[c]);
                frame.normal.pixel(x, y)[c] = static_cast<float>(normal[c]);
            }
        }
    }
    return frame;
}

glm::dvec3 texture(const glm::dvec3& p) {
    return glm::dvec3(0.5) + 0.4 * glm::sin(glm::dvec3(40, 70, 55) * p.x + glm::dvec3(60, 35, 90) * p.y);
}

glm::dvec3 linearLight(const glm::dvec3& p) {
    return glm::dvec3(3, 2, 4) + glm::dvec3(0.2, -0.1, 0.05) * p.x + glm::dvec3(-0.03, 0.1, 0.15) * p.y;
}

glm::dvec3 grey(const glm::dvec3&) {
    return glm::dvec3(0.5);
}

TEST(TemporalChange, TexturedPlaneBeforeAMovingCameraHasNone) {
    // Bilinear means of a linear field are exact, and the texture is divided out pixel by pixel.
    const TemporalFrame before = frameOf({0, 0, 4}, texture, linearLight);
    const TemporalChange change = temporalChange(before, frameOf({0.217, -0.131, 3.9}, texture, linearLight));
    EXPECT_LT(change.rms, 1e-6 * change.mean);
    EXPECT_LT(std::abs(change.meanChange), 1e-6 * change.mean);
    EXPECT_NEAR(change.mean, 3, 0.1);
    EXPECT_GT(change.valid, 0.85);
    EXPECT_LT(change.valid, 1);
}

TEST(TemporalChange, ABrighterPictureJumps) {
    const auto brighter = [](const glm::dvec3& p) { return 1.01 * linearLight(p); };
    const TemporalChange change =
        temporalChange(frameOf({0, 0, 4}, texture, linearLight), frameOf({0.1, 0.05, 4}, texture, brighter));
    EXPECT_NEAR(change.jump(), 0.01, 1e-6);
    EXPECT_NEAR(change.meanChange, 0.01 * change.mean, 1e-6 * change.mean);
    const TemporalChange darker =
        temporalChange(frameOf({0, 0, 4}, texture, brighter), frameOf({0.1, 0.05, 4}, texture, linearLight));
    EXPECT_NEAR(darker.meanChange, -0.01 / 1.01 * darker.mean, 1e-6 * darker.mean);
    EXPECT_NEAR(darker.jump(), 0.01 / 1.01, 1e-6);
}

TEST(TemporalChange, NoiseWithoutMeanIsNoJump) {
    // Columns change by ±0.1 in turn.
    TemporalFrame before = frameOf({0, 0, 4}, grey, [](const glm::dvec3&) { return glm::dvec3(1); });
    TemporalFrame now = before;
    for (int y = 0; y < kHeight; ++y) {
        for (int x = 0; x < kWidth; ++x) {
            for (int c = 0; c < 3; ++c) now.indirectDiffuse.pixel(x, y)[c] *= x % 2 == 0 ? 1.1f : 0.9f;
        }
    }
    const TemporalChange change = temporalChange(before, now);
    EXPECT_NEAR(change.rms, 0.1, 1e-6);
    EXPECT_LT(change.jump(), 0.1 / (kWidth - 1) + 1e-6);
}

TEST(TemporalChange, WhatWasHiddenIsLeftOut) {
    // The screen is dark and the plane behind is bright: any pixel that mixed the two would show.
    const auto light = [](const glm::dvec3& p) { return glm::dvec3(p.z > 0.5 ? 1 : 5); };
    const TemporalFrame before = frameOf({0, 0, 4}, grey, light, 1);
    const TemporalFrame now = frameOf({0.6, 0, 4}, grey, light, 1);
    const TemporalChange change = temporalChange(before, now);
    EXPECT_LT(change.rms, 1e-6);
    const TemporalChange open = temporalChange(frameOf({0, 0, 4}, grey, light), frameOf({0.6, 0, 4}, grey, light));
    EXPECT_LT(change.valid, open.valid - 0.02);
    EXPECT_GT(change.valid, open.valid - 0.15);
}

TEST(TemporalChange, BackgroundDarkAlbedoAndOtherSidesAreLeftOut) {
    const TemporalFrame plane = frameOf({0, 0, 4}, grey, linearLight);
    EXPECT_EQ(temporalChange(plane, frameOf(
                                        {0, 0, 4}, [](const glm::dvec3&) { return glm::dvec3(0.02); }, linearLight))
                  .valid,
              0);
    TemporalFrame turned = plane, sky = plane;
    for (float& v : turned.normal.data) v = -v;
    for (float& v : sky.normal.data) v = 0;
    for (const TemporalFrame& other : {turned, sky}) {
        EXPECT_EQ(temporalChange(plane, other).valid, 0);
        EXPECT_EQ(temporalChange(other, plane).valid, 0);
    }
    // A red surface is compared in red alone.
    const auto red = [](const glm::dvec3&) { return glm::dvec3(0.5, 0.01, 0); };
    const TemporalChange change =
        temporalChange(frameOf({0, 0, 4}, red, linearLight), frameOf({0, 0, 4}, red, linearLight));
    EXPECT_GT(change.valid, 0.85);
    EXPECT_NEAR(change.mean, 3, 0.05);
}

TEST(TemporalChange, AWholeSceneInOtherUnitsIsTheSame) {
    const auto scaled = [](TemporalFrame frame) {
        for (float& v : frame.position.data) v *= 1024;
        frame.worldToClip = frame.worldToClip * glm::scale(glm::dmat4(1), glm::dvec3(1.0 / 1024));
        frame.worldToClip = 1024.0 * frame.worldToClip;  // w is a distance
        return frame;
    };
    const auto light = [](const glm::dvec3& p) { return glm::dvec3(p.z > 0.5 ? 1 : 5); };
    const TemporalFrame before = frameOf({0, 0, 4}, texture, light, 1), now = frameOf({0.3, 0.1, 4}, texture, light, 1);
    const TemporalChange change = temporalChange(before, now), large = temporalChange(scaled(before), scaled(now));
    EXPECT_EQ(change.valid, large.valid);
    EXPECT_EQ(change.rms, large.rms);
}

TEST(TemporalFigure, IsTheRootMeanSquareOverTheMean) {
    // rms 3 and 4, mean 2 and 8; the frame without valid pixels counts in `valid` alone.
    const TemporalFigure figure = temporalFigure({{3, 0.1, 2, 0.6}, {4, -1.6, 8, 0.9}, {}});
    EXPECT_DOUBLE_EQ(figure.mean, 5);
    EXPECT_DOUBLE_EQ(figure.f, std::sqrt(12.5) / 5);
    EXPECT_DOUBLE_EQ(figure.worstJump, 0.2);
    EXPECT_DOUBLE_EQ(figure.valid, 0.5);
    EXPECT_EQ(temporalFigure({}).f, 0);
    EXPECT_EQ(temporalFigure({{}, {}}).worstJump, 0);
}

TEST(ChangeMap, EveryPixelIsComparedWithItselfUnderACameraThatStands) {
    const TemporalFrame before = frameOf({0.3, 0.2, 4}, texture, linearLight, 1);
    const auto step = [](const glm::dvec3& p) { return linearLight(p) * (p.x < 0 ? 0.9 : 1.2); };
    const TemporalFrame now = frameOf({0.3, 0.2, 4}, texture, step, 1);
    const ChangeMap map = changeMap(before, now);
    EXPECT_EQ(map.figures.valid, 1) << "edges of the screen and of the picture as well";
    for (int y = 0; y < kHeight; ++y) {
        for (int x = 0; x < kWidth; ++x) {
            const float* p = now.position.pixel(x, y);
            const glm::dvec3 light = linearLight({p[0], p[1], p[2]});
            const double change = (p[0] < 0 ? -0.1 : 0.2) * (light.x + light.y + light.z) / 3 / map.figures.mean;
            EXPECT_NEAR(static_cast<double>(*map.change.pixel(x, y)), change, 1e-5);
        }
    }
}

TEST(ChangeMap, ItsFiguresAreThoseOfTheShot) {
    const TemporalFrame before = frameOf({0, 0, 4}, texture, linearLight);
    const auto brighter = [](const glm::dvec3& p) { return 1.01 * linearLight(p); };
    const TemporalFrame now = frameOf({0.217, -0.131, 3.9}, texture, brighter);
    const ChangeMap map = changeMap(before, now);
    const TemporalChange figures = temporalChange(before, now);
    EXPECT_EQ(map.figures.mean, figures.mean);
    EXPECT_EQ(map.figures.rms, figures.rms);
    EXPECT_EQ(map.figures.valid, figures.valid);
    double sum = 0;
    int valid = 0;
    for (const float v : map.change.data) {
        if (std::isnan(v)) continue;
        sum += static_cast<double>(v), ++valid;
    }
    EXPECT_NEAR(sum / valid, 0.01, 1e-5);
    EXPECT_EQ(valid, std::lround(figures.valid * kWidth * kHeight));
}

TEST(ChangeMap, WhatWasHiddenHasNone) {
    // The screen covers another part of the plane before.
    const TemporalFrame before = frameOf({0, 0, 4}, grey, linearLight, 1),
                        now = frameOf({0.8, 0, 4}, grey, linearLight, 1);
    const ChangeMap map = changeMap(before, now);
    int hidden = 0;
    for (int y = 0; y < kHeight; ++y) {
        for (int x = 0; x < kWidth; ++x) {
            const float* p = now.position.pixel(x, y);
            if (p[2] != 0) continue;
            // Where the ray to `before` passes the screen's plane; well inside of it.
            const double t = 1.0 / 4, sx = p[0] + t * (0 - p[0]), sy = p[1] + t * (0 - p[1]);
            if (std::max(std::abs(sx), std::abs(sy)) > 0.46) continue;
            EXPECT_TRUE(std::isnan(*map.change.pixel(x, y))) << x << ' ' << y;
            ++hidden;
        }
    }
    EXPECT_GT(hidden, 5);
}

TEST(Carried, ValuesStayOnTheirSurfaces) {
    const TemporalFrame before = frameOf({0, 0, 4}, grey, linearLight),
                        now = frameOf({0.3, -0.2, 3.8}, grey, linearLight);
    Image values(kWidth, kHeight, 1);
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) *values.pixel(x, y) = before.position.pixel(x, y)[0];
    const double pixel = 2 * 4 * std::tan(glm::radians(25.0)) / kHeight;
    const Image moved = carried(values, before, now);
    int seen = 0;
    for (int y = 0; y < kHeight; ++y) {
        for (int x = 0; x < kWidth; ++x) {
            if (std::isnan(*moved.pixel(x, y))) continue;
            EXPECT_NEAR(*moved.pixel(x, y), now.position.pixel(x, y)[0], 0.51 * pixel);
            ++seen;
        }
    }
    EXPECT_GT(seen, kWidth * kHeight * 4 / 5);
    EXPECT_EQ(carried(values, before, before).data, values.data);
}

}  // namespace
}  // namespace voxcone
