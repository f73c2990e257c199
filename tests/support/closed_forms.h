// Form factors: the share of a point's cosine-weighted hemisphere that a shape fills. Rows are those of
// docs/accuracy.md.
#pragma once

#include <glm/glm.hpp>
#include <vector>

namespace voxcone::test {

/// Row C3: a flat polygon, seen from either side, cut at the horizon of the point. With it all rows made of rectangles.
double polygonFactor(const glm::dvec3& point, const glm::dvec3& normal, const std::vector<glm::dvec3>& corners);

/// Parallelogram with one corner and two sides.
double rectangleFactor(const glm::dvec3& point, const glm::dvec3& normal, const glm::dvec3& corner,
                       const glm::dvec3& sideU, const glm::dvec3& sideV);

/// Outside of a box.
double boxFactor(const glm::dvec3& point, const glm::dvec3& normal, const glm::dvec3& low, const glm::dvec3& high);

/// Rows B5 and B6.
double sphereFactor(const glm::dvec3& point, const glm::dvec3& normal, const glm::dvec3& center, double radius);

/// Row K1: visible share of a disc whose centre is `t` radii inside a straight edge.
double discPastEdge(double t);

}  // namespace voxcone::test
