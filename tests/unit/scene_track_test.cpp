#include "scene/track.h"

#include <gmock/gmock.h>

namespace voxcone {
namespace {

Track unevenTrack(Interpolation interpolation) {
    Track track;
    track.interpolation = interpolation;
    track.times = {1, 2, 2.25, 4, 7};
    track.values = {{0, 1, 2}, {3, -1, 0}, {2, 2, 2}, {-4, 0, 1}, {5, 5, 5}};
    return track;
}

void expectNear(const glm::dvec3& a, const glm::dvec3& b, double tolerance) {
    for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(a[axis], b[axis], tolerance) << "axis " << axis;
}

TEST(Track, PassesThroughItsKeysAndStaysAtTheEnds) {
    for (const Interpolation interpolation : {Interpolation::linear, Interpolation::step, Interpolation::catmull_rom}) {
        const Track track = unevenTrack(interpolation);
        for (std::size_t k = 0; k < track.times.size(); ++k) EXPECT_EQ(track.at(track.times[k]), track.values[k]);
        EXPECT_EQ(track.at(-100), track.values.front());
        EXPECT_EQ(track.at(100), track.values.back());
    }
}

TEST(Track, OneKeyIsAConstant) {
    for (const Interpolation interpolation : {Interpolation::linear, Interpolation::catmull_rom}) {
        const Track track{interpolation, {3}, {{1, 2, 3}}};
        for (const double time : {0., 3., 9.}) EXPECT_EQ(track.at(time), glm::dvec3(1, 2, 3));
    }
}

TEST(Track, StraightUniformMotionIsKeptOnUnevenTimes) {
    const glm::dvec3 start(1, -2, 5), velocity(3, 0.5, -2);
    for (const Interpolation interpolation : {Interpolation::linear, Interpolation::catmull_rom}) {
        Track track{interpolation, {0, 0.5, 0.625, 3, 8}, {}};
        for (const double time : track.times) track.values.push_back(start + time * velocity);
        for (double time = 0; time <= 8; time += 0.0625) expectNear(track.at(time), start + time * velocity, 1e-13);
    }
}

TEST(Track, LinearIsHalfWayInTheMiddle) {
    EXPECT_EQ(unevenTrack(Interpolation::linear).at(1.5), glm::dvec3(1.5, 0, 1));
    EXPECT_EQ(unevenTrack(Interpolation::step).at(1.99), glm::dvec3(0, 1, 2));
}

// On even times the spline of Catmull and Rom in its usual form: (−p0 + 9 p1 + 9 p2 − p3) / 16 in the middle.
TEST(Track, CatmullRomOnEvenTimesHasTheTextbookMiddle) {
    const Track track{Interpolation::catmull_rom, {0, 1, 2, 3}, {{1, 0, 0}, {4, 1, 0}, {2, 7, 0}, {-3, 2, 16}}};
    const auto& p = track.values;
    expectNear(track.at(1.5), (-p[0] + 9.0 * p[1] + 9.0 * p[2] - p[3]) / 16.0, 1e-14);
}

TEST(Track, CatmullRomHasNoKinksAtItsKeys) {
    const Track track = unevenTrack(Interpolation::catmull_rom);
    const double h = 1e-6;
    for (std::size_t k = 1; k + 1 < track.times.size(); ++k) {
        const double t = track.times[k];
        const glm::dvec3 slope =
            (track.values[k + 1] - track.values[k - 1]) / (track.times[k + 1] - track.times[k - 1]);
        expectNear((track.at(t) - track.at(t - h)) / h, slope, 1e-3);
        expectNear((track.at(t + h) - track.at(t)) / h, slope, 1e-3);
    }
}

}  // namespace
}  // namespace voxcone
