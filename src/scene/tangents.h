// Tangent frames by the conventions of MikkTSpace (Mikkelsen, "Simulation of Wrinkled Surfaces Revisited", 2008), which
// glTF 2.0 names for meshes that bring none.
#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "scene/scene.h"

namespace voxcone {

/// Fills `mesh.tangents` from positions, normals and `uv` (one a vertex: the coordinates that the normal map is looked
/// up with, texture transform applied). Corners are grouped over shared edges between triangles of equal handedness
/// whose position, normal and uv agree; a group's tangent is the mean of its faces' tangents, each projected on the
/// vertex normal and weighted by the corner's angle. Vertices whose corners fall in several groups are split, so vertex
/// counts may grow and `mesh.indices` change. w is such that bitangent = w · cross(normal, tangent) points up the image
/// (−v). Faces without uv area take the tangent of a neighbour, or any direction across the normal.
void makeTangents(Mesh& mesh, const std::vector<glm::vec2>& uv);

}  // namespace voxcone
