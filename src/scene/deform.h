// Meshes bent by morph targets and skins (glTF 2.0, §3.7.2.2 and §3.7.3.3).
#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "scene/scene.h"

namespace voxcone {

/// What of a mesh's vertices changes, in the same order; `tangents` empty where the mesh has none.
struct DeformedVertices {
    std::vector<glm::vec3> positions, normals;
    std::vector<glm::vec4> tangents;
};

/// Vertices of `mesh` under `deformation`, in the space that Pose::instances takes to the world: targets first, then
/// the skin, whose joints are blended as matrices (linear blend skinning). Normals and tangents have unit length, or
/// zero where they are crushed. Flat normals are made anew from the faces.
DeformedVertices deform(const Mesh& mesh, const Deformation& deformation);

}  // namespace voxcone
