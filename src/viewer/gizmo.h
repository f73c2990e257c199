// Handles over the picture that move, turn and scale what is selected: a light, or a node of the scene.
#pragma once

#include <array>
#include <glm/glm.hpp>
#include <optional>
#include <vector>

#include "viewer/overlay.h"
#include "viewer/session.h"

namespace voxcone {

class Gizmo {
  public:
    /// Draws the handles of lights, where the session shows them, and those of the selected node, into the background
    /// list of Dear ImGui. `uiScale`: screen units of a unit of the interface.
    void draw(const Session& session, const Projection& projection, float uiScale) const;

    /// Takes hold of what lies below the cursor (screen); false when nothing does.
    bool take(Session& session, const Projection& projection, const glm::dvec2& cursor, float uiScale);
    /// Follows the cursor with what is held.
    void drag(Session& session, const Projection& projection, const glm::dvec2& cursor) const;
    void release() { held_.reset(); }
    bool holds() const { return held_.has_value(); }

  private:
    /// What has a gizmo: where it stands and how its axes lie, in the world.
    struct Target {
        int light = -1, node = -1;  ///< one of them
        GizmoMode mode = GizmoMode::move;
        glm::dvec3 center{0};
        std::array<glm::dvec3, 3> axes;
        double length = 0;  ///< of a handle, metres
    };
    /// One that is being dragged, as it was when the drag began.
    struct Held {
        Target target;
        int axis = -1;  ///< −1: the middle
        glm::dvec2 cursor{0};
        glm::dvec2 perRadian{0};  ///< way of the cursor along the ring that turns by one radian
        Light light;
        Node node;
        glm::dmat4 parent{1};
    };

    static std::vector<Target> targets(const Session& session, const Projection& projection, float uiScale);
    static void dragNode(Session& session, const Held& held, const glm::dvec3& by, double angle,
                         const glm::dvec3& factors);

    std::optional<Held> held_;
};

}  // namespace voxcone
