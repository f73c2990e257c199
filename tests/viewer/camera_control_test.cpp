// Cameras that mouse and keys move, and lines that are drawn over their pictures.
#include "viewer/camera_control.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "viewer/overlay.h"

namespace voxcone {
namespace {

constexpr double kPi = 3.14159265358979323846;

Camera exampleCamera() {
    Camera camera;
    camera.position = {1, 2, 5};
    camera.target = {0, 1, 0};
    camera.up = {0, 1, 0};
    camera.verticalFovDeg = 50;
    return camera;
}

CameraControl exampleControl() {
    CameraControl control;
    control.set(exampleCamera());
    return control;
}

double distanceBetween(const glm::dvec3& a, const glm::dvec3& b) {
    return glm::length(a - b);
}

TEST(CameraControl, KeepsPositionAndTargetBitForBit) {
    const Camera given = exampleCamera(), taken = exampleControl().camera();
    EXPECT_EQ(taken.position, given.position);
    EXPECT_EQ(taken.target, given.target);
    EXPECT_EQ(taken.verticalFovDeg, given.verticalFovDeg);
    EXPECT_NEAR(glm::dot(taken.up, glm::normalize(taken.target - taken.position)), 0, 1e-15);
}

TEST(CameraControl, OrbitKeepsTargetAndDistance) {
    CameraControl control = exampleControl();
    const double distance = control.distance();
    std::mt19937 random(3);
    std::uniform_real_distribution<double> angle(-1, 1);
    for (int i = 0; i < 200; ++i) control.orbit(angle(random), angle(random));
    EXPECT_EQ(control.camera().target, glm::dvec3(0, 1, 0));
    EXPECT_NEAR(control.distance(), distance, 1e-9);
    EXPECT_NEAR(glm::length(control.camera().up), 1, 1e-12);
}

TEST(CameraControl, OrbitToTheRightMovesTheCameraToItsRight) {
    CameraControl control = exampleControl();
    const Camera before = control.camera();
    const glm::dvec3 right = glm::cross(before.target - before.position, before.up);
    control.orbit(0.1, 0);
    EXPECT_GT(glm::dot(control.camera().position - before.position, right), 0);
    control = exampleControl();
    control.orbit(0, 0.1);
    EXPECT_GT(control.camera().position.y, before.position.y);
}

TEST(CameraControl, AFullTurnComesBack) {
    CameraControl control = exampleControl();
    for (int i = 0; i < 8; ++i) control.orbit(kPi / 4, 0);
    EXPECT_LT(distanceBetween(control.camera().position, exampleCamera().position), 1e-12);
}

TEST(CameraControl, NeverLooksAlongItsUp) {
    CameraControl control = exampleControl();
    for (int i = 0; i < 100; ++i) control.orbit(0, 0.3);
    const Camera top = control.camera();
    EXPECT_GT(glm::length(glm::cross(glm::normalize(top.target - top.position), control.up())), 0.009);
    for (int i = 0; i < 100; ++i) control.look(0.1, 0.3);
    const Camera sky = control.camera();
    EXPECT_GT(glm::length(glm::cross(glm::normalize(sky.target - sky.position), control.up())), 0.009);
}

TEST(CameraControl, LookTurnsAboutTheCamera) {
    CameraControl control = exampleControl();
    const Camera before = control.camera();
    control.look(0.2, 0.1);
    const Camera after = control.camera();
    EXPECT_EQ(after.position, before.position);
    const glm::dvec3 right = glm::cross(before.target - before.position, before.up);
    EXPECT_GT(glm::dot(after.target - before.target, right), 0);
    EXPECT_GT(after.target.y, before.target.y);
}

TEST(CameraControl, FlyGoesAlongTheView) {
    CameraControl control = exampleControl();
    const Camera before = control.camera();
    control.fly({0, 0, 2});
    const glm::dvec3 way = control.camera().position - before.position;
    EXPECT_LT(distanceBetween(way, 2.0 * glm::normalize(before.target - before.position)), 1e-12);
    EXPECT_LT(distanceBetween(control.camera().target - before.target, way), 1e-12);
}

TEST(CameraControl, FramedBoxIsInThePicture) {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> unit(-1, 1);
    for (int i = 0; i < 50; ++i) {
        Bounds box;
        for (int corner = 0; corner < 3; ++corner) box.add(10.0 * glm::dvec3(unit(random), unit(random), unit(random)));
        const glm::dvec2 size(100 + 300 * std::abs(unit(random)), 200);
        CameraControl control = exampleControl();
        control.orbit(3 * unit(random), unit(random));
        control.frame(box, size.x / size.y);
        const PictureRect rect{{10, 20}, size};
        const Projection projection(control.camera(), rect);
        for (int corner = 0; corner < 8; ++corner) {
            const auto p = projection.point(boxCorner(box, corner));
            ASSERT_TRUE(p.has_value());
            EXPECT_TRUE(rect.contains(*p)) << p->x << ' ' << p->y;
        }
    }
}

TEST(CameraControl, FocusTurnsToThePoint) {
    CameraControl control = exampleControl();
    control.focus({2, 0, -1});
    EXPECT_EQ(control.camera().target, glm::dvec3(2, 0, -1));
    EXPECT_EQ(control.camera().position, exampleCamera().position);
    const Projection projection(control.camera(), {{0, 0}, {200, 100}});
    const auto p = projection.point({2, 0, -1});
    ASSERT_TRUE(p.has_value());
    EXPECT_NEAR(p->x, 100, 1e-9);
    EXPECT_NEAR(p->y, 50, 1e-9);
}

TEST(Projection, RayAndPointAreInverse) {
    const PictureRect rect{{30, 40}, {320, 180}};
    const Projection projection(exampleControl().camera(), rect);
    for (const glm::dvec2 place : {glm::dvec2(40, 50), glm::dvec2(340, 210), glm::dvec2(190, 130)}) {
        const auto p = projection.point(exampleCamera().position + 3.0 * projection.ray(place));
        ASSERT_TRUE(p.has_value());
        EXPECT_NEAR(p->x, place.x, 1e-9);
        EXPECT_NEAR(p->y, place.y, 1e-9);
    }
}

TEST(Projection, CutsLinesAtTheCamera) {
    Camera camera;
    camera.position = {0, 0, 0};
    camera.target = {0, 0, -1};
    const PictureRect rect{{0, 0}, {100, 100}};
    const Projection projection(camera, rect);
    EXPECT_FALSE(projection.line({0, 0, 1}, {1, 0, 2}).has_value());
    const auto line = projection.line({0.1, 0, -1}, {0.1, 0, 5});
    ASSERT_TRUE(line.has_value());
    EXPECT_GT(line->second.x, 1000);  // towards the camera's plane, far out of the picture
    EXPECT_FALSE(projection.point({0, 0, 1}).has_value());
}

}  // namespace
}  // namespace voxcone
