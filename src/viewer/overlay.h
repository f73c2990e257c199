// Lines over the picture: world positions to pixels, clipped to what the camera sees. Plain arithmetic.
#pragma once

#include <array>
#include <glm/glm.hpp>
#include <optional>
#include <utility>

#include "scene/scene.h"

namespace voxcone {

/// Where on the screen the picture is, in screen coordinates; y grows downwards.
struct PictureRect {
    glm::dvec2 low{0}, size{0};
    bool contains(const glm::dvec2& p) const {
        return p.x >= low.x && p.y >= low.y && p.x < low.x + size.x && p.y < low.y + size.y;
    }
};

class Projection {
  public:
    Projection(const Camera& camera, const PictureRect& rect);

    /// Screen place of a world position; nothing behind the camera.
    std::optional<glm::dvec2> point(const glm::dvec3& world) const;
    /// A segment, cut at the camera's plane; nothing when all of it lies behind.
    std::optional<std::pair<glm::dvec2, glm::dvec2>> line(const glm::dvec3& a, const glm::dvec3& b) const;
    /// Screen units that a metre takes at the depth of `world`, across the view; 0 behind the camera.
    double scaleAt(const glm::dvec3& world) const;
    /// Unit direction of the ray through a screen place.
    glm::dvec3 ray(const glm::dvec2& screen) const;
    /// Distance along the view.
    double depth(const glm::dvec3& world) const { return glm::dot(world - eye_, forward_); }
    const glm::dvec3& eye() const { return eye_; }
    const glm::dvec3& forward() const { return forward_; }

  private:
    glm::dvec2 screen(const glm::dvec3& view) const;
    glm::dvec3 toView(const glm::dvec3& world) const;

    PictureRect rect_;
    glm::dvec3 eye_, right_, up_, forward_;
    double tanX_, tanY_, near_;
};

/// The twelve edges of a box, as pairs of corners; corner i has x, y, z high where bits 0, 1, 2 are set.
extern const std::array<std::pair<int, int>, 12> kBoxEdges;
glm::dvec3 boxCorner(const Bounds& box, int corner);

}  // namespace voxcone
