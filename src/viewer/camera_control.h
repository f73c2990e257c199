// How mouse and keys move the camera. Plain arithmetic, no window.
#pragma once

#include <glm/glm.hpp>

#include "scene/scene.h"

namespace voxcone {

/// A camera with an upright `up`, moved by turning around its target (orbit) or about itself (fly). The camera never
/// looks along `up`.
class CameraControl {
  public:
    /// Takes over place, view and field of view of a camera in world space. `up` is the horizon's: of a camera that is
    /// rolled, its own; else +y. Keeps position and target bit for bit.
    void set(const Camera& worldCamera);

    /// What is rendered. Position, target and `up()` read from a capture script give the same camera bit for bit.
    Camera camera() const;
    const glm::dvec3& up() const { return up_; }
    double distance() const { return glm::length(target_ - position_); }

    /// Turns around the target: radians about `up` (positive moves the camera to its right) and towards it.
    void orbit(double right, double upward);
    /// Turns the view about the camera: radians to the right and upwards.
    void look(double right, double upward);
    /// Moves camera and target sidewise and upwards, metres.
    void pan(double right, double upward);
    /// Multiplies the distance to the target, which stays.
    void dolly(double factor);
    /// Moves camera and target in the camera's own axes: x right, y along `up`, z forward, metres.
    void fly(const glm::dvec3& move);
    /// Looks at `point`, which becomes the target, from where the camera is.
    void focus(const glm::dvec3& point);
    /// Goes back along the view until all of `bounds` is in the picture of the given aspect (width / height).
    void frame(const Bounds& bounds, double aspect);

    void fieldOfView(double verticalDeg);

  private:
    void turn(const glm::dvec3& view, double right, double upward, glm::dvec3& out) const;

    glm::dvec3 position_{0, 0, 1}, target_{0}, up_{0, 1, 0};
    double fovDeg_ = 45, near_ = 0, far_ = 0;
};

}  // namespace voxcone
