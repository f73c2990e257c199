#include "support/shapes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <initializer_list>
#include <map>
#include <utility>

#include "core/check.h"

namespace voxcone::test {
namespace {

// One flat quadrilateral, counter-clockwise seen from its front.
void addFace(Mesh& mesh, const std::array<glm::dvec3, 4>& corners, bool closed) {
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    const glm::vec3 normal(glm::normalize(glm::cross(corners[1] - corners[0], corners[2] - corners[0])));
    for (const glm::dvec3& corner : corners) {
        mesh.positions.emplace_back(corner);
        mesh.normals.push_back(normal);
    }
    for (const std::uint32_t k : {0u, 1u, 2u, 0u, 2u, 3u}) mesh.indices.push_back(first + k);
    mesh.closed.insert(mesh.closed.end(), 2, closed ? 1 : 0);
}

void addBox(Mesh& mesh, const glm::dvec3& low, const glm::dvec3& high, bool outward, bool closed) {
    for (int axis = 0; axis < 3; ++axis) {
        const int u = (axis + 1) % 3, v = (axis + 2) % 3;  // u × v = +axis
        for (const bool positive : {false, true}) {
            std::array<glm::dvec3, 4> corners;
            for (int k = 0; k < 4; ++k) {
                auto& corner = corners[static_cast<std::size_t>(k)];
                corner[axis] = positive ? high[axis] : low[axis];
                corner[u] = k == 1 || k == 2 ? high[u] : low[u];
                corner[v] = k >= 2 ? high[v] : low[v];
            }
            if (positive != outward) std::swap(corners[1], corners[3]);
            addFace(mesh, corners, closed);
        }
    }
}

void flip(Mesh& mesh) {
    for (std::size_t k = 0; k < mesh.indices.size(); k += 3) std::swap(mesh.indices[k + 1], mesh.indices[k + 2]);
    for (glm::vec3& normal : mesh.normals) normal = -normal;
}

}  // namespace

Material lambert(const glm::vec3& albedo, const glm::vec3& emission) {
    Material material;
    material.name = "lambert";
    material.baseColor = glm::vec4(albedo, 1);
    material.metallic = 0;
    material.specularFactor = 0;
    material.emission = emission;
    return material;
}

Material lambert(float albedo, float emission) {
    return lambert(glm::vec3(albedo), glm::vec3(emission));
}

Material greenLeaf() {
    Material leaf = lambert(0.8f);
    leaf.diffuseTransmission = 0.25f;
    leaf.diffuseTransmissionColor = {0.5f, 1, 0.2f};
    leaf.doubleSided = true;
    return leaf;
}

Material tintedGlass() {
    Material glass = glossy({1, 0.9f, 0.8f}, 0, 0.1f);
    glass.transmission = 1;
    glass.thickness = 0.6f;
    return glass;
}

Light sunFromBelow() {
    Light sun;
    sun.type = LightType::directional;
    sun.direction = {0, 1, 0};
    sun.intensity = glm::vec3(2);
    return sun;
}

Material glossy(const glm::vec3& baseColor, float metallic, float roughness) {
    Material material;
    material.name = "glossy";
    material.baseColor = glm::vec4(baseColor, 1);
    material.metallic = metallic;
    material.roughness = roughness;
    return material;
}

Mesh quad(double sizeX, double sizeZ, int divisions) {
    Mesh mesh;
    mesh.name = "quad";
    const auto row = static_cast<std::uint32_t>(divisions + 1);
    for (int j = 0; j <= divisions; ++j)
        for (int i = 0; i <= divisions; ++i) {
            const glm::dvec2 uv(static_cast<double>(i) / divisions, static_cast<double>(j) / divisions);
            mesh.positions.emplace_back(sizeX * (uv.x - 0.5), 0, sizeZ * (uv.y - 0.5));
            mesh.normals.emplace_back(0, 1, 0);
            mesh.texCoords[0].emplace_back(uv);
        }
    for (std::uint32_t j = 0; j + 1 < row; ++j)
        for (std::uint32_t i = 0; i + 1 < row; ++i) {
            const std::uint32_t a = j * row + i, b = a + 1, c = a + row, d = c + 1;
            mesh.indices.insert(mesh.indices.end(), {a, c, d, a, d, b});
        }
    mesh.closed.assign(mesh.indices.size() / 3, 0);
    return mesh;
}

Mesh disc(double radius, int segments) {
    Mesh mesh;
    mesh.name = "disc";
    mesh.positions.emplace_back(0);
    for (int k = 0; k < segments; ++k) {
        const double phi = 2 * glm::pi<double>() * k / segments;
        mesh.positions.emplace_back(radius * std::cos(phi), 0, -radius * std::sin(phi));
    }
    mesh.normals.assign(mesh.positions.size(), glm::vec3(0, 1, 0));
    const auto count = static_cast<std::uint32_t>(segments);
    for (std::uint32_t k = 0; k < count; ++k) mesh.indices.insert(mesh.indices.end(), {0u, 1 + k, 1 + (k + 1) % count});
    mesh.closed.assign(count, 0);
    return mesh;
}

Mesh box(const glm::dvec3& size) {
    Mesh mesh;
    mesh.name = "box";
    addBox(mesh, -0.5 * size, 0.5 * size, true, true);
    return mesh;
}

Mesh room(const glm::dvec3& size) {
    Mesh mesh;
    mesh.name = "room";
    addBox(mesh, -0.5 * size, 0.5 * size, false, false);
    return mesh;
}

Mesh slabRoom(const glm::dvec3& inner, double thickness) {
    VOXCONE_CHECK(thickness > 0, "thickness {}", thickness);
    Mesh mesh;
    mesh.name = "slabRoom";
    const glm::dvec3 in = 0.5 * inner, out = in + thickness;
    for (const bool positive : {false, true}) {
        const auto wall = [&](int axis, const glm::dvec3& reach) {
            glm::dvec3 low = -reach, high = reach;
            (positive ? low : high)[axis] = positive ? in[axis] : -in[axis];
            addBox(mesh, low, high, true, true);
        };
        wall(1, out);
        wall(0, {out.x, in.y, out.z});
        wall(2, {in.x, in.y, out.z});
    }
    return mesh;
}

Mesh hollowBox(const glm::dvec3& inner, double thickness) {
    VOXCONE_CHECK(thickness > 0, "thickness {}", thickness);
    Mesh mesh;
    mesh.name = "hollowBox";
    const glm::dvec3 in = 0.5 * inner, out = in + thickness;
    addBox(mesh, -out, out, true, true);
    addBox(mesh, -in, in, false, true);
    return mesh;
}

Mesh sphere(double radius, int subdivisions) {
    const double golden = glm::golden_ratio<double>();
    std::vector<glm::dvec3> points;
    for (int axis = 0; axis < 3; ++axis)
        for (const double a : {-1.0, 1.0})
            for (const double b : {-golden, golden}) {
                glm::dvec3 point(0);
                point[(axis + 1) % 3] = a;
                point[(axis + 2) % 3] = b;
                points.push_back(glm::normalize(point));
            }
    // The faces of an icosahedron are the triples of corners that are mutually nearest neighbours.
    using Index = std::uint32_t;
    std::vector<std::array<Index, 3>> faces;
    const auto near = [&](Index a, Index b) { return glm::dot(points[a], points[b]) > 0.4; };
    for (Index a = 0; a < 12; ++a)
        for (Index b = a + 1; b < 12; ++b)
            for (Index c = b + 1; c < 12; ++c)
                if (near(a, b) && near(b, c) && near(c, a)) {
                    const bool outward =
                        glm::dot(glm::cross(points[b] - points[a], points[c] - points[a]), points[a]) > 0;
                    faces.push_back(outward ? std::array{a, b, c} : std::array{a, c, b});
                }
    for (int level = 0; level < subdivisions; ++level) {
        std::map<std::pair<Index, Index>, Index> middles;
        const auto middle = [&](Index a, Index b) {
            const auto [entry, isNew] = middles.try_emplace(std::minmax(a, b), static_cast<Index>(points.size()));
            if (isNew) points.push_back(glm::normalize(points[a] + points[b]));
            return entry->second;
        };
        std::vector<std::array<Index, 3>> finer;
        for (const auto& [a, b, c] : faces) {
            const Index ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
            finer.insert(finer.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
        }
        faces = std::move(finer);
    }
    Mesh mesh;
    mesh.name = "sphere";
    for (const glm::dvec3& point : points) {
        mesh.positions.emplace_back(radius * point);
        mesh.normals.emplace_back(point);
    }
    for (const auto& face : faces) mesh.indices.insert(mesh.indices.end(), face.begin(), face.end());
    mesh.closed.assign(faces.size(), 1);
    return mesh;
}

Mesh inwardSphere(double radius, int subdivisions) {
    Mesh mesh = sphere(radius, subdivisions);
    flip(mesh);
    mesh.closed.assign(mesh.closed.size(), 0);
    return mesh;
}

Mesh merged(const Mesh& first, const Mesh& second) {
    Mesh mesh = first;
    const auto offset = static_cast<std::uint32_t>(mesh.positions.size());
    const auto append = [](auto& to, const auto& from) {
        VOXCONE_CHECK(to.empty() == from.empty(), "an attribute is missing in one of two meshes");
        to.insert(to.end(), from.begin(), from.end());
    };
    append(mesh.positions, second.positions);
    append(mesh.normals, second.normals);
    append(mesh.tangents, second.tangents);
    append(mesh.texCoords[0], second.texCoords[0]);
    append(mesh.texCoords[1], second.texCoords[1]);
    append(mesh.colors, second.colors);
    append(mesh.closed, second.closed);
    for (const std::uint32_t index : second.indices) mesh.indices.push_back(offset + index);
    return mesh;
}

glm::dmat4 translation(const glm::dvec3& offset) {
    return glm::translate(glm::dmat4(1), offset);
}

glm::dmat4 scaling(const glm::dvec3& factors) {
    return glm::scale(glm::dmat4(1), factors);
}

glm::dmat4 rotation(double degrees, const glm::dvec3& axis) {
    return glm::rotate(glm::dmat4(1), glm::radians(degrees), glm::normalize(axis));
}

glm::dmat4 yTo(const glm::dvec3& direction) {
    const glm::dvec3 y = glm::normalize(direction);
    const glm::dvec3 x = glm::normalize(glm::cross(y, std::abs(y.z) < 0.9 ? glm::dvec3(0, 0, 1) : glm::dvec3(1, 0, 0)));
    return glm::dmat4(glm::dmat3(x, y, glm::cross(x, y)));
}

SceneBuilder& SceneBuilder::add(Mesh mesh, const Material& material, const glm::dmat4& placement) {
    Node node;
    node.name = mesh.name;
    node.hasMatrix = true;
    node.localMatrix = placement;
    mesh.material = static_cast<int>(scene_.materials.size());
    scene_.instances.push_back({static_cast<int>(scene_.meshes.size()), static_cast<int>(scene_.nodes.size())});
    scene_.materials.push_back(material);
    scene_.meshes.push_back(std::move(mesh));
    scene_.nodes.push_back(std::move(node));
    return *this;
}

SceneBuilder& SceneBuilder::light(const Light& light) {
    scene_.lights.push_back(light);
    return *this;
}

SceneBuilder& SceneBuilder::sky(const glm::vec3& radiance) {
    scene_.environment.color = radiance;
    return *this;
}

SceneBuilder& SceneBuilder::transform(const glm::dmat4& matrix) {
    for (Node& node : scene_.nodes) node.localMatrix = matrix * node.localMatrix;
    const double scale = glm::length(glm::dvec3(matrix[0]));
    const glm::dmat3 turn = glm::dmat3(matrix) / scale;
    for (Light& light : scene_.lights) {
        light.position = glm::dvec3(matrix * glm::dvec4(light.position, 1));
        light.direction = turn * light.direction;
        light.up = turn * light.up;
        light.range *= scale;
        light.radius *= scale;
        light.width *= scale;
        light.height *= scale;
    }
    return *this;
}

Scene oneObject(Mesh mesh, const Material& material, const glm::dmat4& placement, const glm::vec3& skyRadiance) {
    return SceneBuilder().add(std::move(mesh), material, placement).sky(skyRadiance).build();
}

Camera camera(const glm::dvec3& position, const glm::dvec3& target, double verticalFovDeg, const glm::dvec3& up) {
    Camera result;
    result.position = position;
    result.target = target;
    result.up = up;
    result.verticalFovDeg = verticalFovDeg;
    return result;
}

}  // namespace voxcone::test
