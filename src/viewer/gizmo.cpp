#include "viewer/gizmo.h"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>

namespace voxcone {

namespace {

constexpr double kLength = 70;  ///< of a handle
constexpr double kReach = 8;    ///< from the cursor to what it takes
constexpr int kRingPieces = 48;
constexpr std::array<ImU32, 3> kColors = {0xff4040ff, 0xff40ff40, 0xffff6040};

ImVec2 vec(const glm::dvec2& p) {
    return {static_cast<float>(p.x), static_cast<float>(p.y)};
}

/// Two unit vectors across `axis`.
std::array<glm::dvec3, 2> across(const glm::dvec3& axis) {
    const glm::dvec3 other = std::abs(axis.y) < 0.9 ? glm::dvec3(0, 1, 0) : glm::dvec3(1, 0, 0);
    const glm::dvec3 a = glm::normalize(glm::cross(axis, other));
    return {a, glm::cross(axis, a)};
}

/// Points of the ring about `axis`, the first one again at the end.
std::vector<glm::dvec3> ring(const glm::dvec3& center, const glm::dvec3& axis, double radius) {
    const auto [a, b] = across(axis);
    std::vector<glm::dvec3> points;
    for (int i = 0; i <= kRingPieces; ++i) {
        const double angle = glm::radians(360.0 * (i % kRingPieces) / kRingPieces);
        points.push_back(center + radius * (std::cos(angle) * a + std::sin(angle) * b));
    }
    return points;
}

double distanceToSegment(const glm::dvec2& p, const std::pair<glm::dvec2, glm::dvec2>& segment) {
    const glm::dvec2 along = segment.second - segment.first;
    const double t = std::clamp(glm::dot(p - segment.first, along) / std::max(glm::dot(along, along), 1e-9), 0.0, 1.0);
    return glm::length(segment.first + t * along - p);
}

/// Where along `axis` from `center` it comes nearest to the ray, metres.
double alongAxis(const Projection& projection, const glm::dvec3& center, const glm::dvec3& axis,
                 const glm::dvec3& ray) {
    const double b = glm::dot(axis, ray), free = 1 - b * b;
    const glm::dvec3 w = center - projection.eye();
    return free > 1e-6 ? (b * glm::dot(ray, w) - glm::dot(axis, w)) / free : 0.0;
}

/// Where the ray meets the plane through `center` that faces the camera.
glm::dvec3 inPlane(const Projection& projection, const glm::dvec3& center, const glm::dvec3& ray) {
    return projection.eye() + projection.depth(center) / glm::dot(ray, projection.forward()) * ray;
}

}  // namespace

std::vector<Gizmo::Target> Gizmo::targets(const Session& session, const Projection& projection, float uiScale) {
    std::vector<Target> out;
    const std::array<glm::dvec3, 3> world = {glm::dvec3(1, 0, 0), glm::dvec3(0, 1, 0), glm::dvec3(0, 0, 1)};
    const auto add = [&](Target target) {
        const double scale = projection.scaleAt(target.center);
        if (scale <= 0) return;
        target.length = kLength * static_cast<double>(uiScale) / scale;
        out.push_back(target);
    };
    if (session.selectedNode >= 0 && session.fixedBecause(session.selectedNode).empty()) {
        Target target{-1, session.selectedNode, session.gizmoMode, {}, world, 0};
        const glm::dmat4 matrix =
            session.scene().worldMatrices(session.time)[static_cast<std::size_t>(session.selectedNode)];
        target.center = session.nodeCenter(session.selectedNode);
        if (target.mode == GizmoMode::scale) {
            for (int k = 0; k < 3; ++k)
                if (glm::length(glm::dvec3(matrix[k])) > 0)
                    target.axes[static_cast<std::size_t>(k)] = glm::normalize(glm::dvec3(matrix[k]));
        }
        add(target);
    }
    if (!session.showLights || session.selectedLight < 0 ||
        session.selectedLight >= static_cast<int>(session.lights.size()))
        return out;
    const auto light = static_cast<std::size_t>(session.selectedLight);
    const bool turns = session.gizmoMode == GizmoMode::turn && session.turnable(light);
    const auto position = session.lightPosition(light);
    if (!session.movable(light) || (!turns && !position)) return out;
    // What lights from infinity is turned in the middle of the scene.
    add({session.selectedLight, -1, turns ? GizmoMode::turn : GizmoMode::move,
         position.value_or(session.facts->bounds.center()), world, 0});
    return out;
}

void Gizmo::draw(const Session& session, const Projection& projection, float uiScale) const {
    ImDrawList& list = *ImGui::GetBackgroundDrawList();
    const auto line = [&](const glm::dvec3& a, const glm::dvec3& b, ImU32 color, float width) {
        if (const auto l = projection.line(a, b)) list.AddLine(vec(l->first), vec(l->second), color, width * uiScale);
    };
    for (std::size_t i = 0; session.showLights && i < session.lights.size(); ++i) {
        const auto position = session.lightPosition(i);
        const auto place = position ? projection.point(*position) : std::nullopt;
        if (!place) continue;
        list.AddCircleFilled(vec(*place), 5 * uiScale, session.movable(i) ? 0xff60e0ff : 0xff808080);
        list.AddCircle(vec(*place), 8 * uiScale, 0xff000000, 0, 1.5f * uiScale);
        list.AddText(vec(*place + glm::dvec2(10 * uiScale, -6 * uiScale)), 0xffffffff, session.lights[i].name.c_str());
    }
    if (session.selectedNode >= 0) {
        const Bounds box = session.nodeBox(session.selectedNode);
        const glm::dmat4 matrix =
            session.scene().worldMatrices(session.time)[static_cast<std::size_t>(session.selectedNode)];
        const auto corner = [&](int k) { return glm::dvec3(matrix * glm::dvec4(boxCorner(box, k), 1)); };
        if (!box.empty())
            for (const auto& [a, b] : kBoxEdges) line(corner(a), corner(b), 0xa060e0ff, 1);
    }
    for (const Target& target : targets(session, projection, uiScale)) {
        const auto middle = projection.point(target.center);
        for (std::size_t k = 0; k < 3; ++k) {
            const bool grabbed = held_ && held_->target.light == target.light && held_->target.node == target.node &&
                                 held_->axis == static_cast<int>(k);
            const ImU32 color = grabbed ? 0xff40ffff : kColors[k];
            if (target.mode == GizmoMode::turn) {
                const std::vector<glm::dvec3> points = ring(target.center, target.axes[k], target.length);
                for (std::size_t p = 0; p + 1 < points.size(); ++p) line(points[p], points[p + 1], color, 2.5f);
                continue;
            }
            const glm::dvec3 end = target.center + target.length * target.axes[k];
            line(target.center, end, color, 3);
            const auto tip = projection.point(end);
            if (!tip || !middle) continue;
            const glm::dvec2 way = *tip - *middle;
            const double length = glm::length(way);
            if (target.mode == GizmoMode::scale || length < 1) {
                const glm::dvec2 half(4.5 * static_cast<double>(uiScale));
                list.AddRectFilled(vec(*tip - half), vec(*tip + half), color);
            } else {
                const glm::dvec2 u = 5.0 * static_cast<double>(uiScale) / length * way, v(-u.y, u.x);
                list.AddTriangleFilled(vec(*tip + 2.4 * u), vec(*tip + v), vec(*tip - v), color);
            }
        }
        if (const auto way =
                target.light >= 0 ? session.lightDirection(static_cast<std::size_t>(target.light)) : std::nullopt)
            line(target.center -
                     (session.lightPosition(static_cast<std::size_t>(target.light)) ? 0.0 : target.length) * *way,
                 target.center + target.length * *way, 0xff60e0ff, 2);
        if (!middle || target.mode == GizmoMode::turn || target.light >= 0) continue;
        const glm::dvec2 half(4.5 * static_cast<double>(uiScale));
        list.AddRectFilled(vec(*middle - half), vec(*middle + half), 0xffffffff);
        list.AddRect(vec(*middle - half), vec(*middle + half), 0xff000000);
    }
}

bool Gizmo::take(Session& session, const Projection& projection, const glm::dvec2& cursor, float uiScale) {
    const double reach = kReach * static_cast<double>(uiScale);
    const auto hold = [&](const Target& target, int axis) {
        Held held;
        held.target = target;
        held.axis = axis;
        held.cursor = cursor;
        if (target.light >= 0) {
            held.light = session.lights[static_cast<std::size_t>(target.light)];
        } else {
            held.node = session.scene().nodes[static_cast<std::size_t>(target.node)];
            decompose(held.node);
            if (held.node.parent >= 0)
                held.parent = session.scene().worldMatrices(session.time)[static_cast<std::size_t>(held.node.parent)];
        }
        held_ = held;
    };
    for (const Target& target : targets(session, projection, uiScale)) {
        const auto middle = projection.point(target.center);
        if (target.node >= 0 && target.mode != GizmoMode::turn && middle && glm::length(*middle - cursor) < reach) {
            hold(target, -1);
            return true;
        }
        // Lights are held by their middle, below.
        if (target.light >= 0 && session.lightPosition(static_cast<std::size_t>(target.light)) && middle &&
            glm::length(*middle - cursor) < reach)
            continue;
        // Of all lines that are within reach the nearest.
        double nearest = reach;
        int axis = -1;
        glm::dvec2 piece(0);
        const auto look = [&](int k, const glm::dvec3& from, const glm::dvec3& to) {
            const auto line = projection.line(from, to);
            const double distance = line ? distanceToSegment(cursor, *line) : nearest;
            if (distance >= nearest) return;
            nearest = distance;
            axis = k;
            piece = line->second - line->first;
        };
        for (int k = 0; k < 3; ++k) {
            const glm::dvec3& direction = target.axes[static_cast<std::size_t>(k)];
            if (target.mode != GizmoMode::turn) {
                look(k, target.center, target.center + 1.15 * target.length * direction);
                continue;
            }
            const std::vector<glm::dvec3> points = ring(target.center, direction, target.length);
            for (std::size_t p = 0; p + 1 < points.size(); ++p) look(k, points[p], points[p + 1]);
        }
        if (axis < 0) continue;
        hold(target, axis);
        if (target.mode != GizmoMode::turn) return true;
        // One radian is a radius along the ring; where that points at the eye, not less than a fifth of it.
        const double angle = glm::radians(360.0 / kRingPieces), length = glm::length(piece) / angle;
        const double least = 0.2 * kLength * static_cast<double>(uiScale);
        held_->perRadian = length > 1e-6 ? piece / angle * (std::max(length, least) / length) : glm::dvec2(least, 0);
        return true;
    }
    for (std::size_t i = 0; session.showLights && i < session.lights.size(); ++i) {
        const auto position = session.movable(i) ? session.lightPosition(i) : std::nullopt;
        const auto place = position ? projection.point(*position) : std::nullopt;
        if (!place || glm::length(*place - cursor) >= reach) continue;
        session.selectedLight = static_cast<int>(i);
        Target target;
        target.light = session.selectedLight;
        target.center = *position;
        hold(target, -1);
        return true;
    }
    return false;
}

void Gizmo::drag(Session& session, const Projection& projection, const glm::dvec2& cursor) const {
    const Held& held = *held_;
    const Target& target = held.target;
    const glm::dvec3 from = projection.ray(held.cursor), to = projection.ray(cursor);
    glm::dvec3 by(0), factors(1);
    double angle = 0;
    if (target.mode == GizmoMode::turn) {
        angle = glm::dot(cursor - held.cursor, held.perRadian) / glm::dot(held.perRadian, held.perRadian);
    } else if (target.mode == GizmoMode::move && held.axis < 0) {
        by = inPlane(projection, target.center, to) - inPlane(projection, target.center, from);
    } else if (target.mode == GizmoMode::move) {
        const glm::dvec3& axis = target.axes[static_cast<std::size_t>(held.axis)];
        by = (alongAxis(projection, target.center, axis, to) - alongAxis(projection, target.center, axis, from)) * axis;
    } else if (held.axis < 0) {
        // To the right larger, to the left smaller.
        factors = glm::dvec3(std::exp2((cursor.x - held.cursor.x) / kLength));
    } else {
        const glm::dvec3& axis = target.axes[static_cast<std::size_t>(held.axis)];
        const double was = alongAxis(projection, target.center, axis, from),
                     is = alongAxis(projection, target.center, axis, to);
        factors[held.axis] = std::clamp(is / std::max(was, 0.1 * target.length), 0.01, 100.0);
    }
    if (target.node >= 0) return dragNode(session, held, by, angle, factors);
    const auto light = static_cast<std::size_t>(target.light);
    if (target.mode == GizmoMode::turn) {
        const glm::dvec3& axis = target.axes[static_cast<std::size_t>(held.axis)];
        session.turnLight(light, held.light, glm::angleAxis(angle, axis));
    } else {
        session.moveLight(light, target.center + by);
    }
}

/// In the parent's space, about the gizmo's centre, which for meshes far from their node's origin is not the latter.
void Gizmo::dragNode(Session& session, const Held& held, const glm::dvec3& by, double angle,
                     const glm::dvec3& factors) {
    const Node& node = held.node;
    const glm::dmat4 toParent = glm::inverse(held.parent);
    const glm::dvec3 center(toParent * glm::dvec4(held.target.center, 1));
    Placement placement;
    switch (held.target.mode) {
        case GizmoMode::move:
            placement.translation = node.translation + glm::dmat3(toParent) * by;
            break;
        case GizmoMode::turn: {
            const glm::dvec3 axis =
                glm::normalize(glm::dmat3(toParent) * held.target.axes[static_cast<std::size_t>(held.axis)]);
            const double side = glm::determinant(glm::dmat3(toParent)) < 0 ? -1 : 1;
            const glm::dquat turn = glm::angleAxis(side * angle, axis);
            placement.rotation = degreesOf(turn * node.rotation);
            placement.translation = center + turn * (node.translation - center);
            break;
        }
        case GizmoMode::scale: {
            const glm::dvec3 scale = node.scale * factors;
            if (glm::any(glm::lessThanEqual(node.scale, glm::dvec3(0)))) return;
            placement.scale = glm::clamp(scale, 1e-6, 1e6);
            const glm::dvec3 local = glm::inverse(node.rotation) * (center - node.translation) / node.scale;
            placement.translation = center - node.rotation * (*placement.scale * local);
            break;
        }
    }
    session.placeNode(held.target.node, placement);
}

}  // namespace voxcone
