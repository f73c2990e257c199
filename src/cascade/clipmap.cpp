#include "cascade/clipmap.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>

#include "core/check.h"
#include "core/error.h"

namespace voxcone {

namespace {

/// Smallest mip of a last level, and the most mips of one that moves: it snaps to their coarsest voxel.
constexpr int kSmallestMip = 4, kMovingMips = 3;
/// Voxels of level 0 that a float still tells apart by 1/512; scenes that are larger get an origin that moves.
constexpr double kLargestLattice = 1 << 15;
/// What GL_MAX_3D_TEXTURE_SIZE is at least.
constexpr int kLargestVolume = 2048;

}  // namespace

VoxelBox intersection(const VoxelBox& a, const VoxelBox& b) {
    return {glm::max(a.low, b.low), glm::min(a.high, b.high)};
}

std::vector<VoxelBox> exposedSlabs(const VoxelBox& from, const VoxelBox& to) {
    if (to.empty()) return {};
    if (intersection(from, to).empty()) return {to};
    std::vector<VoxelBox> slabs;
    VoxelBox rest = to;  // what is not yet covered by a slab
    for (int axis = 0; axis < 3; ++axis) {
        VoxelBox below = rest, above = rest;
        below.high[axis] = std::min(rest.high[axis], from.low[axis]);
        above.low[axis] = std::max(rest.low[axis], from.high[axis]);
        for (const VoxelBox& slab : {below, above})
            if (!slab.empty()) slabs.push_back(slab);
        rest.low[axis] = std::max(rest.low[axis], from.low[axis]);
        rest.high[axis] = std::min(rest.high[axis], from.high[axis]);
    }
    return slabs;
}

int ClipmapLayout::snapOf(int level) const {
    return level == levels - 1 ? std::max(snap, 1 << mips) : snap;
}

double ClipmapLayout::radius() const {
    // The camera is at most half a snap from the window's centre; a trilinear sample reaches half a voxel, and as much
    // again is left for rounding.
    return 0.5 * resolution - 0.5 * snap - 1;
}

double ClipmapLayout::lastRadius() const {
    return 0.5 * resolution - 0.5 * snapOf(levels - 1) - static_cast<double>(1 << mips) / 2;
}

ClipmapLayout layoutClipmap(const Bounds& bounds, const Settings& settings) {
    const Settings::Voxel& voxel = settings.voxel;
    ClipmapLayout layout;
    layout.resolution = voxel.resolution;
    layout.requestedLevels = settings.cascade.levels;
    layout.levels = settings.cascade.levels;
    layout.snap = std::min(settings.cascade.snap, voxel.resolution / 4);
    // A blend begins where the level before has ended at the earliest, or the level to read would jump there.
    layout.band = std::min(settings.cascade.band, 0.5 * layout.radius() / layout.resolution);
    const glm::dvec3 size = bounds.size();
    const double extent = std::max({size.x, size.y, size.z});
    const int inside = voxel.resolution - 2 * voxel.margin - 1;  // one is lost to snapping
    if (inside < 1)
        throw UsageError(
            fmt::format("voxel.margin {} leaves nothing of voxel.resolution {}", voxel.margin, voxel.resolution));
    if (voxel.size > 0) {
        for (int l = 0; l < layout.levels; ++l)
            if (extent <= inside * std::ldexp(voxel.size, l)) layout.levels = l + 1;
        layout.fixedLast = extent <= inside * std::ldexp(voxel.size, layout.levels - 1) || layout.levels == 1;
    }
    const int last = layout.levels - 1;
    const VoxelGrid grid =
        fitGrid(bounds, voxel.resolution, voxel.margin, voxel.size > 0 ? std::ldexp(voxel.size, last) : 0);
    layout.voxelSize = std::ldexp(grid.voxelSize, -last);
    if (layout.fixedLast) {
        layout.origin = grid.origin;
        while (voxel.resolution >> (layout.mips + 1) >= kSmallestMip) ++layout.mips;
        return layout;
    }
    // What the snap and the filter of the coarsest mip take from the window must leave more than the level before
    // needs.
    while (layout.mips < kMovingMips && voxel.resolution >> (layout.mips + 1) >= kSmallestMip) ++layout.mips;
    const double coarsest = layout.voxelSizeOf(layout.count() - 1);
    layout.origin = glm::floor(bounds.center() / coarsest) * coarsest;
    if (extent > kLargestLattice * layout.voxelSize)
        layout.originStep = std::max(0.25 * kLargestLattice * layout.voxelSize, layout.sizeOf(last));
    return layout;
}

glm::dvec3 clipmapOrigin(const ClipmapLayout& layout, const glm::dvec3& cameraPosition) {
    if (layout.originStep <= 0) return layout.origin;
    return layout.origin + glm::floor((cameraPosition - layout.origin) / layout.originStep + 0.5) * layout.originStep;
}

VoxelBox clipmapWindow(const ClipmapLayout& layout, int level, const glm::dvec3& cameraFromOrigin) {
    const int r = layout.resolution;
    if (!layout.moves(level)) return {glm::ivec3(0), glm::ivec3(r)};
    const int snap = layout.snapOf(level);
    const glm::dvec3 steps = glm::floor(cameraFromOrigin / (layout.voxelSizeOf(level) * snap) + 0.5);
    // A camera lost in space must not overflow an index: there is nothing to see there.
    const glm::ivec3 center = glm::ivec3(glm::clamp(steps, glm::dvec3(-1e6), glm::dvec3(1e6))) * snap;
    return {center - r / 2, center + r / 2};
}

float containmentLevel(const glm::vec3& fromCamera, float radius, float band, int levels) {
    const glm::vec3 a = glm::abs(fromCamera);
    const float distance = std::max({a.x, a.y, a.z}) / radius;
    const float last = static_cast<float>(levels - 1);
    float level = 0, edge = 1;
    while (level < last && distance > edge) {
        edge *= 2;
        level += 1;
    }
    if (level >= last) return last;
    return std::min(level + glm::clamp((distance / edge - (1 - band)) / band, 0.0f, 1.0f), last);
}

ClipmapVolume::ClipmapVolume(const ClipmapLayout& layout, int border_)
    : resolution(layout.resolution), levels(layout.levels), mips(layout.mips), border(border_), rows(layout.levels) {
    const int box = resolution + 2 * border;
    if (levels * box + resolution / 2 + 2 * border > kLargestVolume) rows = (levels + 1) / 2;
    VOXCONE_CHECK(rows * box + resolution / 2 + 2 * border <= kLargestVolume, "levels {} resolution {}", levels,
                  resolution);
}

glm::ivec3 ClipmapVolume::size() const {
    const int box = resolution + 2 * border;
    return {box, box * (rows < levels ? 2 : 1), rows * box + (mips > 0 ? resolution / 2 + 2 * border : 0)};
}

glm::ivec3 ClipmapVolume::levelOrigin(int level) const {
    const int box = resolution + 2 * border;
    const glm::ivec3 inner(border);
    if (level < levels)
        return inner + glm::ivec3(0, level < rows ? 0 : box, (level < rows ? level : level - rows) * box);
    // The first mip, and beside it a column of the others.
    const int mip = level - levels + 1;
    if (mip == 1) return inner + glm::ivec3(0, 0, rows * box);
    return inner + glm::ivec3(resolution / 2 + 2 * border,
                              resolution / 2 - (resolution >> (mip - 1)) + 2 * border * (mip - 2), rows * box);
}

glm::ivec3 ClipmapVolume::texel(const glm::ivec3& i, int level) const {
    const int size = level < levels ? resolution : resolution >> (level - levels + 1);
    return levelOrigin(level) + toroidal(i, size);
}

}  // namespace voxcone
