// What of the session moves lights and objects.
#include <algorithm>
#include <cmath>

#include "reference/pick.h"
#include "viewer/session.h"

namespace voxcone {

namespace {

/// Script's ranges of what a node is placed by.
constexpr double kFarthest = 1e9, kLeastScale = 1e-6, kMostScale = 1e6;

bool finite(const glm::dvec3& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

bool invertible(const glm::dmat4& matrix) {
    const glm::dmat4 inverse = glm::inverse(matrix);
    return finite(inverse[0]) && finite(inverse[1]) && finite(inverse[2]) && finite(inverse[3]);
}

}  // namespace

// ---- Lights

std::optional<glm::dvec3> Session::lightPosition(std::size_t light) const {
    const Light& l = lights[light];
    if (l.type == LightType::directional) return std::nullopt;
    return worldLight(lightAt(l, time), scene_.worldMatrices(time)).position;
}

bool Session::movable(std::size_t light) const {
    const Light& l = lights[light];
    if (l.extracted || !l.track.position.empty()) return false;
    return l.node < 0 || invertible(scene_.worldMatrices(time)[static_cast<std::size_t>(l.node)]);
}

void Session::moveLight(std::size_t light, const glm::dvec3& to) {
    Light& l = lights[light];
    glm::dvec3 place = to;
    if (l.node >= 0) {
        const glm::dmat4 world = scene_.worldMatrices(time)[static_cast<std::size_t>(l.node)];
        place = glm::dvec3(glm::inverse(world) * glm::dvec4(to, 1));
    }
    if (finite(place)) l.position = glm::clamp(place, -kFarthest, kFarthest);
}

std::optional<glm::dvec3> Session::lightDirection(std::size_t light) const {
    const Light& l = lights[light];
    if (l.type == LightType::point || l.type == LightType::sphere) return std::nullopt;
    return worldLight(lightAt(l, time), scene_.worldMatrices(time)).direction;
}

bool Session::turnable(std::size_t light) const {
    return lights[light].track.direction.empty() && lightDirection(light) && movable(light);
}

void Session::pointLight(std::size_t light, const glm::dvec3& direction) {
    Light& l = lights[light];
    glm::dmat3 world(1);
    if (l.node >= 0) world = glm::dmat3(scene_.worldMatrices(time)[static_cast<std::size_t>(l.node)]);
    const glm::dvec3 way = glm::normalize(glm::inverse(world) * direction);
    if (finite(way)) l.direction = way;
}

void Session::turnLight(std::size_t light, const Light& before, const glm::dquat& rotation) {
    Light& l = lights[light];
    glm::dmat3 world(1);
    if (l.node >= 0) world = glm::dmat3(scene_.worldMatrices(time)[static_cast<std::size_t>(l.node)]);
    const glm::dmat3 turn = glm::inverse(world) * glm::mat3_cast(rotation) * world;
    const glm::dvec3 direction = glm::normalize(turn * before.direction);
    if (!finite(direction)) return;
    l.direction = direction;
    if (l.type == LightType::rectangle) l.up = uprightOf(turn * before.up, direction);
}

// ---- Objects

void Session::poseScene() {
    scene_.nodes = facts->outline.nodes;
    for (const auto& [node, placement] : placed) place(scene_.nodes[static_cast<std::size_t>(node)], placement);
}

std::string Session::fixedBecause(int node) const {
    if (isAnimated(facts->outline, node)) return "it is animated";
    Node copy = facts->outline.nodes[static_cast<std::size_t>(node)];
    if (!decompose(copy)) return "its matrix has shear";
    if (copy.parent >= 0 && !invertible(scene_.worldMatrices(time)[static_cast<std::size_t>(copy.parent)]))
        return "what carries it is flat";
    return {};
}

void Session::placeNode(int node, const Placement& placement) {
    Placement next = placed.contains(node) ? placed[node] : Placement{};
    const auto take = [](std::optional<glm::dvec3>& to, const std::optional<glm::dvec3>& from, double low,
                         double high) {
        if (from && finite(*from)) to = glm::clamp(*from, low, high);
    };
    take(next.translation, placement.translation, -kFarthest, kFarthest);
    take(next.rotation, placement.rotation, -36000, 36000);
    take(next.scale, placement.scale, kLeastScale, kMostScale);
    if (next.empty()) return;
    placed[node] = next;
    poseScene();
}

void Session::putBack(int node) {
    placed.erase(node);
    poseScene();
}

Bounds Session::nodeBox(int node) const {
    const std::vector<glm::dmat4> world = scene_.worldMatrices(time);
    const glm::dmat4& own = world[static_cast<std::size_t>(node)];
    if (!invertible(own)) return {};
    const glm::dmat4 toNode = glm::inverse(own);
    std::vector<char> below(scene_.nodes.size(), 0);
    for (std::size_t i = 0; i < below.size(); ++i) {
        const int parent = scene_.nodes[i].parent;
        below[i] = static_cast<int>(i) == node || (parent >= 0 && below[static_cast<std::size_t>(parent)] != 0);
    }
    Bounds all;
    for (std::size_t i = 0; i < scene_.instances.size(); ++i) {
        const Instance& instance = scene_.instances[i];
        auto carrier = static_cast<std::size_t>(instance.node);
        glm::dmat4 bind(1);
        if (instance.skin >= 0) {
            // As it is bound to its first joint, which says roughly where it is.
            const Skin& skin = scene_.skins[static_cast<std::size_t>(instance.skin)];
            carrier = static_cast<std::size_t>(skin.joints.front());
            bind = skin.inverseBindMatrices.front();
        }
        if (below[carrier] == 0) continue;
        const bool itself = static_cast<int>(carrier) == node;
        const Bounds box = transformed(facts->boxes[i], itself ? bind : toNode * world[carrier] * bind);
        if (!box.empty()) all.add(box.min), all.add(box.max);
    }
    return all;
}

glm::dvec3 Session::nodeCenter(int node) const {
    return glm::dvec3(scene_.worldMatrices(time)[static_cast<std::size_t>(node)] *
                      glm::dvec4(nodeBox(node).center(), 1));
}

void Session::pick(const glm::dvec2& at) {
    if (!facts) return;
    const Camera c = camera.camera();
    const Settings::Output& output = settings.now().output;
    const glm::dvec3 direction = Projection(c, {{0, 0}, glm::dvec2(output.width, output.height)})
                                     .ray(at * glm::dvec2(output.width, output.height));
    const double along = glm::dot(direction, glm::normalize(c.target - c.position)), now = time;
    thread.now([this, c, direction, along, now](RenderThread::Desk& desk) {
        const auto found = pickInstance(desk.scene, now, c.position, direction, c.near / along, c.far / along);
        const std::uint64_t serial = desk.view.scene;
        thread.deliver([this, found, serial] {
            if (serial != sceneSerial) return;
            selectedNode = -1;
            if (!found) return;
            const Instance& instance = scene_.instances[*found];
            // A skinned mesh goes where its skeleton does.
            selectedNode = instance.skin < 0 ? instance.node
                                             : scene_.skins[static_cast<std::size_t>(instance.skin)].joints.front();
        });
    });
}

// ---- Undo

void Session::takeLights(const std::vector<Light>& from) {
    for (std::size_t i = 0; i < std::min(from.size(), lights.size()); ++i)
        if (!from[i].extracted && !lights[i].extracted) lights[i] = from[i];
}

void Session::rememberEdits() {
    if (!dragging) edits_.commit({lights, placed});
}

void Session::takeEdits() {
    takeLights(edits_.now().lights);
    placed = edits_.now().placed;
    poseScene();
    edits_.replace({lights, placed});
}

}  // namespace voxcone
