#include "scene/deform.h"

#include <cmath>

#include "core/check.h"

namespace voxcone {
namespace {

glm::vec3 unitOrZero(const glm::dvec3& v) {
    const double length = glm::length(v);
    return length > 0 && std::isfinite(length) ? glm::vec3(v / length) : glm::vec3(0);
}

void addTarget(std::vector<glm::vec3>& values, const std::vector<glm::vec3>& deltas, float weight) {
    for (std::size_t v = 0; v < deltas.size(); ++v) values[v] += weight * deltas[v];
}

}  // namespace

DeformedVertices deform(const Mesh& mesh, const Deformation& deformation) {
    VOXCONE_CHECK(deformation.weights.size() == mesh.morphTargets.size(), "{} weights for {} morph targets of {}",
                  deformation.weights.size(), mesh.morphTargets.size(), mesh.name);
    DeformedVertices out{mesh.positions, mesh.normals, mesh.tangents};
    for (std::size_t k = 0; k < mesh.morphTargets.size(); ++k) {
        const MorphTarget& target = mesh.morphTargets[k];
        const float weight = deformation.weights[k];
        if (weight == 0) continue;
        addTarget(out.positions, target.positions, weight);
        addTarget(out.normals, target.normals, weight);
        if (out.tangents.empty()) continue;
        for (std::size_t v = 0; v < target.tangents.size(); ++v)
            out.tangents[v] += weight * glm::vec4(target.tangents[v], 0);
    }

    for (std::size_t v = 0; v < out.positions.size(); ++v) {
        glm::dvec3 normal(out.normals[v]);
        if (!deformation.joints.empty()) {
            glm::dmat4 blend(0);
            for (std::size_t k = 0; k < 4; ++k) {
                const auto weight = static_cast<double>(mesh.jointWeights[v][static_cast<int>(k)]);
                if (weight > 0) blend += weight * deformation.joints[mesh.joints[v][k]];
            }
            const glm::dmat3 linear(blend);
            // Cofactors are the inverse transpose times the determinant, and exist where there is no inverse.
            const glm::dmat3 cofactors(glm::cross(linear[1], linear[2]), glm::cross(linear[2], linear[0]),
                                       glm::cross(linear[0], linear[1]));
            const double side = glm::determinant(linear) < 0 ? -1 : 1;
            out.positions[v] = glm::vec3(blend * glm::dvec4(glm::dvec3(out.positions[v]), 1));
            normal = side * (cofactors * normal);
            if (!out.tangents.empty()) {
                const glm::vec4 tangent = out.tangents[v];
                out.tangents[v] = glm::vec4(linear * glm::dvec3(tangent), side * static_cast<double>(tangent.w));
            }
        }
        out.normals[v] = unitOrZero(normal);
        if (!out.tangents.empty())
            out.tangents[v] = glm::vec4(unitOrZero(glm::dvec3(out.tangents[v])), out.tangents[v].w);
    }
    if (!mesh.flatNormals) return out;
    for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
        const std::uint32_t* t = mesh.indices.data() + i;
        const glm::dvec3 corner(out.positions[t[0]]);
        const glm::vec3 normal =
            unitOrZero(glm::cross(glm::dvec3(out.positions[t[1]]) - corner, glm::dvec3(out.positions[t[2]]) - corner));
        for (int k = 0; k < 3; ++k) out.normals[t[k]] = normal;
    }
    return out;
}

}  // namespace voxcone
