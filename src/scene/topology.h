// Which triangles belong to watertight solids.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

namespace voxcone {

/// One entry a triangle of the indexed list: 1 when its connected part (vertices welded where their positions are
/// bit-equal, parts joined over edges) is a closed, consistently oriented surface whose signed volume is positive, so
/// that counter-clockwise faces point outwards; else 0. Triangles that welding collapses are no part of the surface and
/// get the flag of the part they touch, or 0.
std::vector<std::uint8_t> closedTriangles(const std::vector<glm::vec3>& positions,
                                          const std::vector<std::uint32_t>& indices);

/// Triangles of the indexed list that have no area: voxels hold nothing of them.
std::size_t degenerateTriangles(const std::vector<glm::vec3>& positions, const std::vector<std::uint32_t>& indices);

}  // namespace voxcone
