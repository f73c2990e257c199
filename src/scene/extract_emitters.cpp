#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>

#include "scene/extract.h"

namespace voxcone {
namespace {

using glm::dvec3;

/// Rectangles of a mesh at most: a box.
constexpr std::size_t kMostRectangles = 6;
/// Longest side of a rectangle over the diagonal of the scene. Larger ones are wide to cones from most places.
constexpr double kSmallOfDiagonal = 0.25;
/// What sides and angles may be off by, over the length of a side.
constexpr double kTolerance = 1e-4;

/// In object space.
struct Rectangle {
    dvec3 center, halfRight, halfUp;
    dvec3 normal() const { return glm::normalize(glm::cross(halfRight, halfUp)); }
};

bool perpendicular(const dvec3& a, const dvec3& b) {
    return std::abs(glm::dot(a, b)) <= kTolerance * glm::length(a) * glm::length(b);
}

/// The rectangle of two triangles, if they are one.
std::optional<Rectangle> rectangleOf(const Mesh& mesh, std::size_t first, std::size_t second) {
    const auto corner = [&](std::size_t triangle, std::size_t k) {
        return dvec3(mesh.positions[mesh.indices[3 * triangle + k % 3]]);
    };
    for (std::size_t k = 0; k < 3; ++k) {
        // Corner b has the right angle, a and c are the ends of the diagonal.
        const dvec3 a = corner(first, k), b = corner(first, k + 1), c = corner(first, k + 2);
        const double size = glm::distance(a, c);
        if (!(glm::distance(a, b) > 0) || !(glm::distance(b, c) > 0) || !perpendicular(a - b, c - b)) continue;
        for (std::size_t m = 0; m < 3; ++m) {
            // The other one runs along the diagonal the other way.
            if (glm::distance(corner(second, m), c) > kTolerance * size ||
                glm::distance(corner(second, m + 1), a + c - b) > kTolerance * size ||
                glm::distance(corner(second, m + 2), a) > kTolerance * size)
                continue;
            return Rectangle{0.5 * (a + c), 0.5 * (b - a), 0.5 * (c - b)};
        }
    }
    return std::nullopt;
}

/// The rectangles that make up the mesh; none when something else does.
std::vector<Rectangle> rectanglesOf(const Mesh& mesh) {
    const std::size_t triangles = mesh.indices.size() / 3;
    if (triangles == 0 || triangles % 2 != 0 || triangles > 2 * kMostRectangles) return {};
    std::vector<Rectangle> found;
    std::vector<bool> used(triangles, false);
    for (std::size_t i = 0; i < triangles; ++i) {
        for (std::size_t j = i + 1; j < triangles && !used[i]; ++j) {
            const auto rectangle = used[j] ? std::nullopt : rectangleOf(mesh, i, j);
            if (!rectangle) continue;
            found.push_back(*rectangle);
            used[i] = used[j] = true;
        }
        if (!used[i]) return {};
    }
    return found;
}

/// Whether the node's matrix leaves `rectangle` one that is no longer than `longest`, and its normal a normal.
bool staysRectangle(const Rectangle& rectangle, const glm::dmat4& matrix, double longest) {
    const glm::dmat3 linear(matrix);
    const dvec3 right = linear * rectangle.halfRight, up = linear * rectangle.halfUp,
                normal = linear * rectangle.normal();
    return 2 * std::max(glm::length(right), glm::length(up)) <= longest && glm::length(right) > 0 &&
           glm::length(up) > 0 && glm::length(normal) > 0 && perpendicular(right, up) && perpendicular(right, normal) &&
           perpendicular(up, normal);
}

bool scaleIsAnimated(const Scene& scene, int node) {
    for (; node >= 0; node = scene.nodes[static_cast<std::size_t>(node)].parent) {
        for (const Animation& animation : scene.animations) {
            for (const AnimationChannel& channel : animation.channels)
                if (channel.node == node && channel.property == AnimatedProperty::scale) return true;
        }
    }
    return false;
}

bool mayBeExtracted(const Mesh& mesh, const Material& material) {
    return material.emits() && !material.unlit && material.emissionTexture.texture < 0 &&
           material.alphaMode == AlphaMode::opaque && mesh.joints.empty() && mesh.morphTargets.empty();
}

struct Candidate {
    std::size_t mesh;
    std::vector<Light> lights;
    double power = 0;  ///< luminance, up to a factor
};

}  // namespace

void extractEmitters(Scene& scene, int most) {
    if (most <= 0) return;
    const std::vector<glm::dmat4> world = scene.worldMatrices();
    const double longest = kSmallOfDiagonal * glm::length(scene.bounds().size());
    std::vector<Candidate> candidates;
    for (std::size_t m = 0; m < scene.meshes.size(); ++m) {
        const Mesh& mesh = scene.meshes[m];
        const Material& material = scene.materials[static_cast<std::size_t>(mesh.material)];
        if (!mayBeExtracted(mesh, material)) continue;
        const std::vector<Rectangle> rectangles = rectanglesOf(mesh);
        Candidate candidate{m, {}, 0};
        bool all = !rectangles.empty();
        for (const Instance& instance : scene.instances) {
            if (instance.mesh != static_cast<int>(m)) continue;
            const glm::dmat4& matrix = world[static_cast<std::size_t>(instance.node)];
            all = all && instance.skin < 0 && !scaleIsAnimated(scene, instance.node);
            for (const Rectangle& rectangle : rectangles) {
                all = all && staysRectangle(rectangle, matrix, longest);
                Light light;
                light.name = mesh.name;
                light.type = LightType::rectangle;
                light.intensity = material.emission;
                light.node = instance.node;
                light.position = rectangle.center;
                light.direction = rectangle.normal();
                light.up = glm::normalize(rectangle.halfUp);
                light.width = 2 * glm::length(rectangle.halfRight);
                light.height = 2 * glm::length(rectangle.halfUp);
                light.extracted = true;
                const Light placed = worldLight(light, world);
                candidate.lights.push_back(light);
                if (material.doubleSided) {
                    light.direction = -light.direction;
                    candidate.lights.push_back(light);
                }
                candidate.power += (material.doubleSided ? 2 : 1) * placed.width * placed.height *
                                   static_cast<double>(glm::dot(material.emission, glm::vec3(0.2126, 0.7152, 0.0722)));
            }
        }
        if (all && !candidate.lights.empty()) candidates.push_back(std::move(candidate));
    }
    std::stable_sort(candidates.begin(), candidates.end(),
                     [](const Candidate& a, const Candidate& b) { return a.power > b.power; });

    std::set<std::size_t> extracted;
    std::size_t count = 0;
    for (const Candidate& candidate : candidates) {
        if (count + candidate.lights.size() > static_cast<std::size_t>(most)) break;
        count += candidate.lights.size();
        scene.lights.insert(scene.lights.end(), candidate.lights.begin(), candidate.lights.end());
        extracted.insert(candidate.mesh);
    }
    // A material that other meshes keep gets a double.
    std::map<int, int> materialOf;
    for (const std::size_t m : extracted) {
        const int material = scene.meshes[m].material;
        if (materialOf.contains(material)) continue;
        bool shared = false;
        for (std::size_t k = 0; k < scene.meshes.size(); ++k)
            shared = shared || (scene.meshes[k].material == material && !extracted.contains(k));
        materialOf[material] = shared ? static_cast<int>(scene.materials.size()) : material;
        if (shared) scene.materials.push_back(scene.materials[static_cast<std::size_t>(material)]);
        scene.materials[static_cast<std::size_t>(materialOf[material])].extracted = true;
    }
    for (const std::size_t m : extracted) scene.meshes[m].material = materialOf.at(scene.meshes[m].material);
}

void extractLights(Scene& scene, const Settings::Light& settings) {
    extractEnvironment(scene, settings.extractEnvironment);
    extractEmitters(scene, settings.extractEmitters);
}

}  // namespace voxcone
