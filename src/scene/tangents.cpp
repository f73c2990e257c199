#include "scene/tangents.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>

#include "core/check.h"

namespace voxcone {

namespace {

struct Face {
    glm::vec3 tangent{0};   ///< unit, along +u
    bool mirrored = false;  ///< uv runs clockwise
    bool flat = true;       ///< no uv area: has no tangent of its own
};

glm::vec3 safeNormalize(const glm::vec3& v) {
    const float length = glm::length(v);
    return length > 0 ? v / length : glm::vec3(0);
}

glm::vec3 acrossNormal(const glm::vec3& v, const glm::vec3& normal) {
    return safeNormalize(v - glm::dot(v, normal) * normal);
}

glm::vec3 anyAcross(const glm::vec3& normal) {
    return acrossNormal(std::abs(normal.x) < 0.9f ? glm::vec3(1, 0, 0) : glm::vec3(0, 1, 0), normal);
}

std::uint32_t find(std::vector<std::uint32_t>& parent, std::uint32_t i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
}

/// For every vertex the first one with the same position, normal and uv.
std::vector<std::uint32_t> weld(const Mesh& mesh, const std::vector<glm::vec2>& uv) {
    auto key = [&](std::uint32_t i) {
        const glm::vec3 &p = mesh.positions[i], &n = mesh.normals[i];
        return std::array{p.x, p.y, p.z, n.x, n.y, n.z, uv[i].x, uv[i].y};
    };
    std::vector<std::uint32_t> order(mesh.positions.size());
    std::iota(order.begin(), order.end(), 0u);
    std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
        const auto ka = key(a), kb = key(b);
        return ka != kb ? ka < kb : a < b;
    });
    std::vector<std::uint32_t> first(order.size());
    for (std::size_t i = 0; i < order.size(); ++i)
        first[order[i]] = i > 0 && key(order[i]) == key(order[i - 1]) ? first[order[i - 1]] : order[i];
    return first;
}

Face faceOf(const Mesh& mesh, const std::vector<glm::vec2>& uv, std::size_t triangle) {
    const std::uint32_t* v = mesh.indices.data() + 3 * triangle;
    const glm::vec3 d1 = mesh.positions[v[1]] - mesh.positions[v[0]], d2 = mesh.positions[v[2]] - mesh.positions[v[0]];
    const glm::vec2 t1 = uv[v[1]] - uv[v[0]], t2 = uv[v[2]] - uv[v[0]];
    const float area = t1.x * t2.y - t1.y * t2.x;
    Face face;
    face.mirrored = area < 0;
    face.tangent = safeNormalize((face.mirrored ? -1.0f : 1.0f) * (t2.y * d1 - t1.y * d2));
    face.flat = !(std::abs(area) > 0) || face.tangent == glm::vec3(0);
    return face;
}

struct Edge {
    std::uint32_t low, high, corner;  ///< `corner` is where the edge begins; the next corner of the triangle is its end
    bool forward;
};

/// Joins corners of neighbouring faces that share both ends of an edge and their handedness.
std::vector<std::uint32_t> groupCorners(const Mesh& mesh, const std::vector<std::uint32_t>& welded,
                                        const std::vector<Face>& faces) {
    const auto corners = static_cast<std::uint32_t>(mesh.indices.size());
    std::vector<std::uint32_t> group(corners);
    std::iota(group.begin(), group.end(), 0u);
    auto next = [](std::uint32_t corner) { return corner % 3 == 2 ? corner - 2 : corner + 1; };

    std::vector<Edge> edges;
    for (std::uint32_t c = 0; c < corners; ++c) {
        if (faces[c / 3].flat) continue;
        const std::uint32_t a = welded[mesh.indices[c]], b = welded[mesh.indices[next(c)]];
        if (a != b) edges.push_back({std::min(a, b), std::max(a, b), c, a < b});
    }
    std::sort(edges.begin(), edges.end(), [](const Edge& a, const Edge& b) {
        return std::array{a.low, a.high, a.corner} < std::array{b.low, b.high, b.corner};
    });
    for (std::size_t begin = 0, end = 0; begin < edges.size(); begin = end) {
        while (end < edges.size() && edges[end].low == edges[begin].low && edges[end].high == edges[begin].high) ++end;
        for (std::size_t i = begin; i < end; ++i) {
            for (std::size_t j = i + 1; j < end; ++j) {
                const std::uint32_t a = edges[i].corner, b = edges[j].corner;
                if (edges[i].forward == edges[j].forward || faces[a / 3].mirrored != faces[b / 3].mirrored) continue;
                group[find(group, a)] = find(group, next(b));
                group[find(group, next(a))] = find(group, b);
                break;  // one neighbour an edge, also where more than two faces meet
            }
        }
    }
    for (std::uint32_t c = 0; c < corners; ++c) group[c] = find(group, c);
    return group;
}

/// The face's tangent projected on the normal of `corner`, times the angle of the (projected) edges there.
glm::vec3 weightedTangent(const Mesh& mesh, const Face& face, std::uint32_t corner) {
    const std::uint32_t base = corner / 3 * 3;
    const std::uint32_t v0 = mesh.indices[corner];
    const std::uint32_t v1 = mesh.indices[base + (corner - base + 1) % 3],
                        v2 = mesh.indices[base + (corner - base + 2) % 3];
    const glm::vec3& normal = mesh.normals[v0];
    const glm::vec3 e1 = acrossNormal(mesh.positions[v1] - mesh.positions[v0], normal);
    const glm::vec3 e2 = acrossNormal(mesh.positions[v2] - mesh.positions[v0], normal);
    const float angle = std::acos(std::clamp(glm::dot(e1, e2), -1.0f, 1.0f));
    return angle * acrossNormal(face.tangent, normal);
}

}  // namespace

void makeTangents(Mesh& mesh, const std::vector<glm::vec2>& uv) {
    VOXCONE_CHECK(uv.size() == mesh.positions.size() && mesh.normals.size() == mesh.positions.size(),
                  "{} positions, {} normals, {} uv", mesh.positions.size(), mesh.normals.size(), uv.size());
    const std::vector<std::uint32_t> welded = weld(mesh, uv);
    std::vector<Face> faces(mesh.indices.size() / 3);
    for (std::size_t t = 0; t < faces.size(); ++t) faces[t] = faceOf(mesh, uv, t);
    std::vector<std::uint32_t> group = groupCorners(mesh, welded, faces);

    const auto corners = static_cast<std::uint32_t>(mesh.indices.size());
    constexpr std::uint32_t kNone = UINT32_MAX;
    std::vector<glm::vec3> sum(corners, glm::vec3(0));
    std::vector<std::uint32_t> groupAtVertex(mesh.positions.size(), kNone);  // by welded vertex
    for (std::uint32_t c = 0; c < corners; ++c) {
        if (faces[c / 3].flat) continue;
        sum[group[c]] += weightedTangent(mesh, faces[c / 3], c);
        std::uint32_t& known = groupAtVertex[welded[mesh.indices[c]]];
        if (known == kNone) known = group[c];
    }
    for (std::uint32_t c = 0; c < corners; ++c) {
        if (!faces[c / 3].flat) continue;
        std::uint32_t& known = groupAtVertex[welded[mesh.indices[c]]];
        if (known == kNone) known = c;
        group[c] = known;
    }

    // One vertex for each pair of old vertex and group; the first pair of a vertex keeps its place.
    mesh.tangents.assign(mesh.positions.size(), glm::vec4(0));
    std::vector<std::uint32_t> firstGroup(mesh.positions.size(), kNone);
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> split;
    for (std::uint32_t c = 0; c < corners; ++c) {
        const std::uint32_t vertex = mesh.indices[c];
        std::uint32_t target = vertex;
        if (firstGroup[vertex] == kNone) {
            firstGroup[vertex] = group[c];
        } else if (firstGroup[vertex] != group[c]) {
            const auto [place, added] =
                split.try_emplace({vertex, group[c]}, static_cast<std::uint32_t>(mesh.positions.size()));
            target = place->second;
            if (added) {
                const auto repeat = [vertex](auto& values) {
                    if (values.empty()) return;
                    const auto value = values[vertex];
                    values.push_back(value);
                };
                repeat(mesh.positions);
                repeat(mesh.normals);
                for (auto& set : mesh.texCoords) repeat(set);
                repeat(mesh.colors);
                repeat(mesh.joints);
                repeat(mesh.jointWeights);
                for (MorphTarget& morph : mesh.morphTargets) {
                    repeat(morph.positions);
                    repeat(morph.normals);
                    repeat(morph.tangents);
                }
                mesh.tangents.emplace_back(0);
            }
        }
        mesh.indices[c] = target;
        const Face& owner = faces[group[c] / 3];
        glm::vec3 tangent = safeNormalize(sum[group[c]]);
        if (tangent == glm::vec3(0)) tangent = anyAcross(mesh.normals[vertex]);
        // uv grows downwards in glTF, MikkTSpace's t grows upwards: hence + for what runs clockwise in uv.
        mesh.tangents[target] = glm::vec4(tangent, owner.flat || owner.mirrored ? 1.0f : -1.0f);
    }
    for (std::size_t v = 0; v < mesh.tangents.size(); ++v)
        if (mesh.tangents[v].w == 0) mesh.tangents[v] = glm::vec4(anyAcross(mesh.normals[v]), 1);  // unused vertices
}

}  // namespace voxcone
