// Which voxels does a triangle touch, and how much of it lies in each? In double precision, for the tests to compare
// with.
#pragma once

#include <algorithm>
#include <glm/glm.hpp>
#include <vector>

#include "voxelize_lab.h"

namespace voxcone::test {

using Outline = std::vector<glm::dvec3>;

/// The part of a triangle inside the closed box [low, high] (Sutherland and Hodgman); empty when they do not touch.
inline Outline clippedToBox(const Triangle& triangle, const glm::dvec3& low, const glm::dvec3& high) {
    Outline polygon{triangle[0], triangle[1], triangle[2]};
    for (int plane = 0; plane < 6 && !polygon.empty(); ++plane) {
        const int axis = plane >> 1;
        const bool upper = (plane & 1) != 0;
        const double bound = upper ? high[axis] : low[axis];
        const auto inside = [&](const glm::dvec3& p) { return upper ? bound - p[axis] : p[axis] - bound; };
        Outline kept;
        glm::dvec3 previous = polygon.back();
        for (const glm::dvec3& current : polygon) {
            const double before = inside(previous), here = inside(current);
            if ((before < 0) != (here < 0)) {
                glm::dvec3 crossing = previous + (current - previous) * (before / (before - here));
                crossing[axis] = bound;
                kept.push_back(crossing);
            }
            if (here >= 0) kept.push_back(current);
            previous = current;
        }
        polygon = std::move(kept);
    }
    return polygon;
}

/// Area times normal: the components are the areas projected along the axes.
inline glm::dvec3 vectorArea(const Outline& polygon) {
    glm::dvec3 area(0);
    for (std::size_t i = 2; i < polygon.size(); ++i)
        area += 0.5 * glm::cross(polygon[i - 1] - polygon[0], polygon[i] - polygon[0]);
    return area;
}

/// Whether the triangle meets the half-open cell [cell, cell + 1).
inline bool touchesCell(const Triangle& triangle, const glm::dvec3& cell) {
    const Outline polygon = clippedToBox(triangle, cell, cell + 1.0);
    if (polygon.empty()) return false;
    glm::dvec3 lowest = polygon[0];
    for (const glm::dvec3& p : polygon) lowest = glm::min(lowest, p);
    return glm::all(glm::lessThan(lowest, cell + 1.0));
}

/// How well a set of voxels agrees with the half-open cells that triangles touch.
struct Agreement {
    int triangles = 0, voxels = 0;            ///< in truth
    int missed = 0, surplus = 0;              ///< against exact half-open cells
    int missedBeyond = 0, surplusBeyond = 0;  ///< that a tolerance does not explain
    int badCoverage = 0;
    double worstCoverage = 0;  ///< error of a voxel face's coverage
};

/// Error of positions that single precision may make: eight units in the last place of the largest coordinate.
inline double roundingOf(const Triangle& triangle) {
    double largest = 1;
    for (const glm::vec3& p : triangle)
        for (int a = 0; a < 3; ++a) largest = std::max(largest, std::abs(static_cast<double>(p[a])));
    return largest * 0x1p-21;
}

/// Compares the voxels of one triangle in a unit grid. A voxel is missed beyond rounding when the triangle still meets
/// its cell shrunk by the tolerance, surplus when it does not even meet the cell grown by it. `areaCoverage`: faces
/// must hold the clipped projected area, else 1 where the normal has a component along the face's axis.
inline void compare(Agreement& sum, const VoxelMap& map, const Triangle& triangle, int resolution, bool areaCoverage) {
    const double tolerance = roundingOf(triangle);
    const glm::dvec3 normal = vectorArea({triangle[0], triangle[1], triangle[2]});
    const glm::dvec3 low =
        glm::min(glm::min(glm::dvec3(triangle[0]), glm::dvec3(triangle[1])), glm::dvec3(triangle[2]));
    const glm::dvec3 high =
        glm::max(glm::max(glm::dvec3(triangle[0]), glm::dvec3(triangle[1])), glm::dvec3(triangle[2]));
    // What rounding leaves open in the direction of the normal, the product of two edges: much for slivers.
    const double unsure = 1e-6 + 0x1p-22 * glm::dot(high - low, high - low) / glm::length(normal);
    const auto clampToGrid = [&](const glm::dvec3& p) {
        return glm::ivec3(glm::clamp(glm::floor(p), glm::dvec3(0), glm::dvec3(resolution - 1)));
    };
    const glm::ivec3 first = clampToGrid(low - 1.0), last = clampToGrid(high + 1.0);
    ++sum.triangles;
    std::size_t seen = 0;
    for (int z = first.z; z <= last.z; ++z)
        for (int y = first.y; y <= last.y; ++y)
            for (int x = first.x; x <= last.x; ++x) {
                const glm::dvec3 cell(x, y, z);
                const bool truth = touchesCell(triangle, cell);
                const auto found = map.voxels.find({x, y, z});
                const bool there = found != map.voxels.end();
                sum.voxels += truth;
                seen += there;
                if (truth && !there) {
                    ++sum.missed;
                    if (!clippedToBox(triangle, cell + tolerance, cell + 1.0 - tolerance).empty()) ++sum.missedBeyond;
                }
                if (there && !truth) {
                    ++sum.surplus;
                    if (clippedToBox(triangle, cell - tolerance, cell + 1.0 + tolerance).empty()) ++sum.surplusBeyond;
                }
                if (!there) continue;
                const glm::dvec3 area = vectorArea(clippedToBox(triangle, cell, cell + 1.0));
                for (int f = 0; f < 6; ++f) {
                    // Sheets are seen from both sides.
                    const double coverage = static_cast<double>(found->second[static_cast<std::size_t>(f)].coverage);
                    if (areaCoverage) {
                        const double error = std::abs(coverage - std::abs(area[f >> 1]));
                        sum.worstCoverage = std::max(sum.worstCoverage, error);
                        // One step of the fixed point, the rounding of up to nine corners and that of the storage.
                        if (error > 0x1p-15 + 16 * tolerance + kCoverageRounding) ++sum.badCoverage;
                    } else if (truth) {
                        const double slope = std::abs(normal[f >> 1]) / glm::length(normal);
                        if (slope > 1e-3 + unsure && coverage != 1) ++sum.badCoverage;
                        if (slope < 1e-3 - unsure && coverage != 0) ++sum.badCoverage;
                    }
                }
            }
    // What lies outside the triangle's box is surplus beyond any tolerance.
    sum.surplusBeyond += static_cast<int>(map.voxels.size() - seen);
}

}  // namespace voxcone::test
