#include "viewer/overlay.h"

#include <cmath>

namespace voxcone {

const std::array<std::pair<int, int>, 12> kBoxEdges = {
    {{0, 1}, {2, 3}, {4, 5}, {6, 7}, {0, 2}, {1, 3}, {4, 6}, {5, 7}, {0, 4}, {1, 5}, {2, 6}, {3, 7}}};

glm::dvec3 boxCorner(const Bounds& box, int corner) {
    return {(corner & 1) != 0 ? box.max.x : box.min.x, (corner & 2) != 0 ? box.max.y : box.min.y,
            (corner & 4) != 0 ? box.max.z : box.min.z};
}

Projection::Projection(const Camera& camera, const PictureRect& rect) : rect_(rect), eye_(camera.position) {
    forward_ = glm::normalize(camera.target - camera.position);
    right_ = glm::normalize(glm::cross(forward_, camera.up));
    up_ = glm::cross(right_, forward_);
    tanY_ = std::tan(glm::radians(0.5 * camera.verticalFovDeg));
    tanX_ = tanY_ * (rect.size.y > 0 ? rect.size.x / rect.size.y : 1);
    near_ = 1e-4 * glm::length(camera.target - camera.position);
}

glm::dvec3 Projection::toView(const glm::dvec3& world) const {
    const glm::dvec3 d = world - eye_;
    return {glm::dot(d, right_), glm::dot(d, up_), glm::dot(d, forward_)};
}

glm::dvec2 Projection::screen(const glm::dvec3& v) const {
    return rect_.low + rect_.size * glm::dvec2(0.5 + 0.5 * v.x / (v.z * tanX_), 0.5 - 0.5 * v.y / (v.z * tanY_));
}

std::optional<glm::dvec2> Projection::point(const glm::dvec3& world) const {
    const glm::dvec3 v = toView(world);
    if (v.z <= near_) return std::nullopt;
    return screen(v);
}

std::optional<std::pair<glm::dvec2, glm::dvec2>> Projection::line(const glm::dvec3& a, const glm::dvec3& b) const {
    glm::dvec3 p = toView(a), q = toView(b);
    if (p.z <= near_ && q.z <= near_) return std::nullopt;
    if (p.z <= near_) p += (q - p) * ((near_ - p.z) / (q.z - p.z));
    if (q.z <= near_) q += (p - q) * ((near_ - q.z) / (p.z - q.z));
    return std::pair(screen(p), screen(q));
}

double Projection::scaleAt(const glm::dvec3& world) const {
    const double z = toView(world).z;
    return z > near_ ? 0.5 * rect_.size.y / (z * tanY_) : 0;
}

glm::dvec3 Projection::ray(const glm::dvec2& s) const {
    const glm::dvec2 at = 2.0 * (s - rect_.low) / rect_.size - 1.0;
    return glm::normalize(forward_ + at.x * tanX_ * right_ - at.y * tanY_ * up_);
}

}  // namespace voxcone
