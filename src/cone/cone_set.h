// Sets of cones that integrate a hemisphere with cosine weight. Pure; the GLSL twin is shaders/cone/cone_set.glsl.
#pragma once

#include <glm/glm.hpp>
#include <vector>

namespace voxcone {

/// Directions around +z, unit; weights are (1/π)∫cosθ dω over each cone's share and add up to 1; all cones of a set
/// have the same aperture.
struct ConeSet {
    std::vector<glm::dvec3> directions;
    std::vector<double> weights;
    double tanHalfAngle = 0;
    bool spiral =
        false;  ///< cosine-stratified golden-angle spiral, which can be turned and shifted from pixel to pixel
};

/// Sets of 1, 5, 6, 9, 16 and 32 cones.
///  1: the normal, as wide as the hemisphere's cosine lobe.
///  5: the normal and four at 60°, weights 1/3 and 1/6: Σw cosθ = 2/3 and Σw cos²θ = 1/2 exactly.
///  6: the normal and five at 56.25°, weights 1/4 and 3/20: Σw cosθ = 2/3 exactly, Σw cos²θ = 0.4815. Thin cones at 60°
///     with the weights that make both exact see more of what stands on the horizon: beside a wall the RMSE of openness
///     is .066 against .052.
///  9: the 2017 thesis': normal, four sides at 45° and four corners of the cube, 60° wide; weights are those of the
///     directions nearest to each.
///  16, 32: cosθ = √(1 − (i + ½)/n), azimuth by the golden angle, equal weights.
ConeSet coneSet(int count);

}  // namespace voxcone
