#include "viewer/camera_control.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

#include "capture/script.h"

namespace voxcone {
namespace {

/// The view stays this far from the poles, radians.
constexpr double kPole = 0.01;

}  // namespace

void CameraControl::set(const Camera& c) {
    position_ = c.position;
    target_ = c.target;
    const glm::dvec3 view = glm::normalize(target_ - position_), upright(0, 1, 0);
    // A camera without roll has its right axis in the horizontal plane.
    const glm::dvec3 right = glm::cross(view, c.up);
    const bool rolled = std::abs(right.y) > 1e-6 || glm::dot(c.up, upright) < 1e-3;
    up_ = rolled ? c.up : upright;
    fovDeg_ = c.verticalFovDeg;
    near_ = c.near;
    far_ = c.far;
}

Camera CameraControl::camera() const {
    Camera c;
    c.position = position_;
    c.target = target_;
    c.up = uprightOf(up_, glm::normalize(target_ - position_));
    c.verticalFovDeg = fovDeg_;
    c.near = near_;
    c.far = far_;
    return c;
}

void CameraControl::turn(const glm::dvec3& view, double right, double upward, glm::dvec3& out) const {
    const double length = glm::length(view);
    const glm::dvec3 axis = glm::normalize(up_);
    const double height = std::asin(std::clamp(glm::dot(view / length, axis), -1.0, 1.0));
    const double limit = 0.5 * 3.14159265358979323846 - kPole;
    const double wanted = std::clamp(height + upward, -limit, limit);
    const glm::dvec3 side = glm::normalize(glm::cross(view, axis));
    const glm::dmat4 tilt = glm::rotate(glm::dmat4(1), wanted - height, side);
    const glm::dmat4 swing = glm::rotate(glm::dmat4(1), -right, axis);
    out = length * glm::normalize(glm::dvec3(swing * tilt * glm::dvec4(view / length, 0)));
}

void CameraControl::orbit(double right, double upward) {
    glm::dvec3 view;
    turn(target_ - position_, -right, -upward, view);
    position_ = target_ - view;
}

void CameraControl::look(double right, double upward) {
    glm::dvec3 view;
    turn(target_ - position_, right, upward, view);
    target_ = position_ + view;
}

void CameraControl::pan(double right, double upward) {
    const Camera c = camera();
    const glm::dvec3 side = glm::normalize(glm::cross(target_ - position_, c.up));
    const glm::dvec3 move = right * side + upward * c.up;
    position_ += move;
    target_ += move;
}

void CameraControl::dolly(double factor) {
    position_ = target_ + factor * (position_ - target_);
}

void CameraControl::fly(const glm::dvec3& move) {
    const glm::dvec3 view = glm::normalize(target_ - position_);
    const glm::dvec3 side = glm::normalize(glm::cross(view, up_));
    const glm::dvec3 by = move.x * side + move.y * glm::normalize(up_) + move.z * view;
    position_ += by;
    target_ += by;
}

void CameraControl::focus(const glm::dvec3& point) {
    const glm::dvec3 view = point - position_;
    if (glm::length(view) <= 0 || glm::length(glm::cross(glm::normalize(view), glm::normalize(up_))) < kPole) return;
    target_ = point;
}

void CameraControl::frame(const Bounds& bounds, double aspect) {
    const glm::dvec3 view = glm::normalize(target_ - position_);
    const double radius = bounds.empty() ? 1 : std::max(0.5 * glm::length(bounds.size()), 1e-9);
    const double half = glm::radians(0.5 * fovDeg_), narrow = std::min(half, std::atan(std::tan(half) * aspect));
    target_ = bounds.center();
    position_ = target_ - view * (1.05 * radius / std::sin(narrow));
}

void CameraControl::fieldOfView(double verticalDeg) {
    fovDeg_ = std::clamp(verticalDeg, 1.0, 170.0);
}

}  // namespace voxcone
