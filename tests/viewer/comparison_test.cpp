// What the window compares, without a window: errors of pairs, and changes held on surfaces.
#include "viewer/comparison.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <thread>

#include "capture/output.h"
#include "metric/flip.h"
#include "viewer/flicker.h"

namespace voxcone {
namespace {

std::shared_ptr<const Image> ramp(float gain) {
    Image image(24, 16, 3);
    for (std::size_t i = 0; i < image.data.size(); ++i) image.data[i] = gain * static_cast<float>(i % 41) / 20;
    return std::make_shared<const Image>(std::move(image));
}

TEST(Measure, FiguresAndMapsAreThoseOfTheMetrics) {
    MeasuredPair pair{ramp(1), ramp(1.25f), "beauty", {}, {}, ErrorMap::none};
    Errors errors = measure(pair);
    EXPECT_EQ(errors.map, nullptr);
    EXPECT_EQ(errors.linear.relMse, linearError(*pair.reference, *pair.test).relMse);
    const Image a = displayOf(*pair.reference, ToneMap::aces), b = displayOf(*pair.test, ToneMap::aces);
    EXPECT_EQ(errors.display.flip, displayError(a, b).flip) << "through the tone curve";
    pair.map = ErrorMap::flip;
    EXPECT_EQ(measure(pair).map->data, flip(a, b).data);
    pair.map = ErrorMap::hdr_flip;
    EXPECT_EQ(measure(pair).map->data, hdrFlip(*pair.reference, *pair.test).error.data);
    pair.map = ErrorMap::relative;
    EXPECT_EQ(measure(pair).map->data, relativeErrorMap(*pair.reference, *pair.test).data);
    pair.reference = std::make_shared<const Image>(Image(8, 16, 3));
    errors = measure(pair);
    EXPECT_THAT(errors.whyNot, testing::HasSubstr("24x16"));
    EXPECT_EQ(errors.map, nullptr);
}

TEST(Measurement, FollowsTheNewestPair) {
    Worker worker([] {});
    Measurement measurement;
    const auto wait = [&] {
        while (!worker.idle()) {
            worker.take();
            std::this_thread::yield();
        }
    };
    MeasuredPair pair{ramp(1), ramp(2), "beauty", {}, {}, ErrorMap::none};
    measurement.follow(worker, pair);
    const auto first = pair.test;
    pair.test = ramp(1);
    measurement.follow(worker, pair);  // waits for its turn
    wait();
    EXPECT_NE(measurement.errorsOf(first), nullptr);
    EXPECT_EQ(measurement.errorsOf(pair.test), nullptr);
    measurement.follow(worker, pair);
    wait();
    ASSERT_NE(measurement.errorsOf(pair.test), nullptr);
    EXPECT_EQ(measurement.errors()->linear.rmse, 0);
    pair.test = ramp(3);
    measurement.follow(worker, pair);
    measurement.forget();
    wait();
    EXPECT_EQ(measurement.errors(), nullptr) << "what was forgotten does not come back";
}

/// The plane z = 0 seen along −z from (x, 0, 4), with irradiance `light` and albedo 1/2.
std::shared_ptr<const WatchedFrame> plane(double x, double light, int width = 24, int height = 16,
                                          std::uint64_t view = 0) {
    auto out = std::make_shared<WatchedFrame>();
    out->view = view;
    out->what = Watched::indirect;
    const glm::dvec3 eye(x, 0, 4);
    const double slope = std::tan(glm::radians(25.0)), aspect = static_cast<double>(width) / height;
    TemporalFrame& frame = out->frame;
    for (Image* image : {&frame.indirectDiffuse, &frame.albedo, &frame.position, &frame.normal})
        *image = Image(width, height, 3);
    frame.worldToClip = glm::infinitePerspective(glm::radians(50.0), aspect, 1.0) * glm::translate(glm::dmat4(1), -eye);
    for (int row = 0; row < height; ++row) {
        for (int column = 0; column < width; ++column) {
            float* position = frame.position.pixel(column, row);
            position[0] = static_cast<float>(x + 4 * slope * aspect * ((column + 0.5) / width * 2 - 1));
            position[1] = static_cast<float>(4 * slope * (1 - (row + 0.5) / height * 2));
            frame.normal.pixel(column, row)[2] = 1;
            for (int c = 0; c < 3; ++c) {
                frame.albedo.pixel(column, row)[c] = 0.5f;
                frame.indirectDiffuse.pixel(column, row)[c] = static_cast<float>(0.5 * light);
            }
        }
    }
    return out;
}

float middle(const Image& image) {
    return *image.pixel(image.width / 2, image.height / 2);
}

TEST(FlickerTrail, HoldsTheLargestChangeOnTheSurface) {
    FlickerTrail trail;
    EXPECT_FALSE(trail.add(plane(0, 1)).known);
    FlickerPicture p = trail.add(plane(0, 1.1));
    EXPECT_TRUE(p.known);
    EXPECT_NEAR(middle(p.change), 0.1, 1e-5);
    EXPECT_NEAR(middle(p.held), 0.1, 1e-5);
    p = trail.add(plane(0, 0.88));
    EXPECT_NEAR(middle(p.change), -0.2, 1e-5);
    EXPECT_NEAR(middle(p.held), -0.2, 1e-5) << "with its sign";
    p = trail.add(plane(0, 0.88));
    EXPECT_NEAR(middle(p.change), 0, 1e-6);
    EXPECT_NEAR(middle(p.held), -0.2, 1e-5);
    // The camera moves by a third of the picture: what is held moves along, what comes into view has nothing.
    p = trail.add(plane(1.9, 0.88));
    EXPECT_NEAR(*p.held.pixel(0, 8), -0.2, 1e-5);
    EXPECT_NEAR(*p.change.pixel(0, 8), 0, 1e-5);
    EXPECT_TRUE(std::isnan(*p.change.pixel(23, 8)));
    EXPECT_TRUE(std::isnan(*p.held.pixel(23, 8)));
    trail.clear();
    EXPECT_FALSE(trail.add(plane(0, 1)).known);
}

TEST(FlickerTrail, OtherSizesAreNoChange) {
    FlickerTrail trail;
    trail.add(plane(0, 1));
    trail.add(plane(0, 1.1));
    // A stage of another size, with light of its own: there is nothing to compare it with yet.
    FlickerPicture p = trail.add(plane(0, 3, 6, 4));
    EXPECT_EQ(p.held.width, 6);
    EXPECT_NEAR(middle(p.held), 0.1, 1e-5) << "what is held is carried over";
    EXPECT_NEAR(middle(p.change), 0.1, 1e-5);
    EXPECT_EQ(p.figures.valid, 0);
    // The full size again: against the last one of that size.
    p = trail.add(plane(0, 1.1));
    EXPECT_NEAR(middle(p.change), 0, 1e-6);
    p = trail.add(plane(0, 3.3, 6, 4));
    EXPECT_NEAR(middle(p.change), 0.1, 1e-5);
}

TEST(FlickerTrail, StagesCountOnlyIfTheirViewWasGivenUp) {
    FlickerTrail trail;
    trail.add(plane(0, 1, 6, 4, 1));
    trail.add(plane(0, 1, 24, 16, 1));
    // The small stage changes by more than the whole picture does: it was noise.
    trail.add(plane(0, 2, 6, 4, 2));
    FlickerPicture p = trail.add(plane(0, 1.1, 24, 16, 2));
    EXPECT_NEAR(middle(p.held), 0.1, 1e-5);
    // A view that was never finished: what its stage has shown stays.
    p = trail.add(plane(0, 3, 6, 4, 3));
    EXPECT_NEAR(middle(p.held), 0.5, 1e-5);
    trail.add(plane(0, 3, 6, 4, 4));
    p = trail.add(plane(0, 1.1, 24, 16, 4));
    EXPECT_NEAR(middle(p.change), 0, 1e-6);
    EXPECT_NEAR(middle(p.held), 0.5, 1e-5);
}

TEST(Flicker, WhatWasClearedDoesNotComeBack) {
    Flicker flicker([] {});
    flicker.watched = Watched::indirect;
    flicker.take(plane(0, 1));
    flicker.take(plane(0, 2));
    flicker.clear();
    while (!flicker.idle()) {
        flicker.update();
        std::this_thread::yield();
    }
    EXPECT_EQ(flicker.shown(), nullptr);
    flicker.take(plane(0, 1));
    flicker.take(plane(0, 2));
    while (!flicker.idle()) {
        flicker.update();
        std::this_thread::yield();
    }
    ASSERT_NE(flicker.shown(), nullptr);
    EXPECT_NEAR(middle(*flicker.shown()), 1, 1e-5);
}

}  // namespace
}  // namespace voxcone
