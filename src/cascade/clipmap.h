// Clipmap arithmetic: which voxels each level holds around a camera, where they lie in the volumes, and what a move
// exposes. Pure; the GLSL twin of what shaders need is shaders/cascade/clipmap.glsl.
//
// Levels share one lattice: voxel i of level l is the cube [i, i+1)³·Δ₀·2^l relative to the origin. A level keeps a
// window of `resolution`³ voxels, and voxel i lies in its volume at i mod resolution, so that a window moves without a
// copy (Losasso and Hoppe 2004; Panteleev 2014). What a voxel holds depends on its index alone, never on the window.
//
// Coarser than the last level are mips of it: they hold the same region with half the resolution each.
#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "cascade/grid.h"
#include "core/settings.h"
#include "scene/scene.h"

namespace voxcone {

/// Half-open box of voxel indices of one level.
struct VoxelBox {
    glm::ivec3 low{0}, high{0};
    bool empty() const { return glm::any(glm::greaterThanEqual(low, high)); }
    glm::ivec3 size() const { return empty() ? glm::ivec3(0) : high - low; }
    long long volume() const { return 1LL * size().x * size().y * size().z; }
    bool contains(const glm::ivec3& i) const {
        return glm::all(glm::greaterThanEqual(i, low)) && glm::all(glm::lessThan(i, high));
    }
    bool operator==(const VoxelBox&) const = default;
};
VoxelBox intersection(const VoxelBox& a, const VoxelBox& b);

/// What `to` has and `from` has not, as disjoint slabs: at most three for boxes of one size that meet, at most six for
/// others; all of `to` if they do not meet.
std::vector<VoxelBox> exposedSlabs(const VoxelBox& from, const VoxelBox& to);

/// i mod size for a power of two; negative indices too.
inline glm::ivec3 toroidal(const glm::ivec3& i, int size) {
    return i & glm::ivec3(size - 1);
}
/// The index in the window [low, low + size) that lies at texel `t`.
inline glm::ivec3 fromToroidal(const glm::ivec3& t, const glm::ivec3& low, int size) {
    return low + ((t - low) & glm::ivec3(size - 1));
}

/// What is decided once for a scene and settings.
struct ClipmapLayout {
    int resolution = 0;       ///< of a level; a power of two
    double voxelSize = 0;     ///< edge of a voxel of level 0, metres
    glm::dvec3 origin{0};     ///< of the lattice, world space; a multiple of the last level's edge, or of the coarsest
                              ///< mip's when it moves
    double originStep = 0;    ///< > 0: the scene is so large that the origin follows the camera by this many metres
    int levels = 1;           ///< clipmap levels
    int mips = 0;             ///< filtered from the last level
    int requestedLevels = 1;  ///< as the settings asked; more than `levels` when fewer cover the scene
    bool fixedLast = true;    ///< the last level covers the scene and stays
    int snap = 1;             ///< voxels of each moving level
    double band = 0;  ///< width of the blend between levels, as a share of a level's size; at most half of the radius

    int count() const { return levels + mips; }
    int resolutionOf(int level) const { return level < levels ? resolution : resolution >> (level - levels + 1); }
    double voxelSizeOf(int level) const { return voxelSize * static_cast<double>(1 << level); }
    double sizeOf(int level) const { return voxelSizeOf(level) * resolutionOf(level); }
    /// The first level that stays; mips do as the last level does.
    int firstFixed() const { return fixedLast ? levels - 1 : count(); }
    bool moves(int level) const { return level < firstFixed(); }
    /// Voxels by which a level moves. A last level that moves keeps its mips aligned.
    int snapOf(int level) const;
    /// Half the edge, in voxels of level 0, of the cube around the camera inside which level 0 may be read whatever the
    /// snap has done; twice that at each further level.
    double radius() const;
    /// The same for the last level, in its own voxels, when it moves: filtered mips may be read there too.
    double lastRadius() const;
};

/// Smallest set of levels for `bounds` (all that ever moves included). voxel.size 0: the last level fits the bounds and
/// level 0 has 2^(levels−1) times finer voxels; otherwise voxel.size is level 0's edge, and levels beyond the first
/// that holds the bounds are left out.
ClipmapLayout layoutClipmap(const Bounds& bounds, const Settings& settings);

/// Origin for a camera: the layout's, unless the scene is too large for one.
glm::dvec3 clipmapOrigin(const ClipmapLayout& layout, const glm::dvec3& cameraPosition);

/// The voxels that a level (no mip) holds for a camera; positions relative to the origin.
VoxelBox clipmapWindow(const ClipmapLayout& layout, int level, const glm::dvec3& cameraFromOrigin);

/// Continuous level that may be read at `fromCamera` (voxels of level 0, relative to the centre): the integer part is
/// the finest level there, the fraction the weight of the next one (thesis, eq. 3.2, by the largest component).
/// `radius` as ClipmapLayout::radius(), perhaps reduced; `band` is a share of it. Twin of containmentLevel in
/// clipmap.glsl.
float containmentLevel(const glm::vec3& fromCamera, float radius, float band, int levels);

/// Where a level lies in a volume that stacks all of them, with a border of `border` texels on each side that repeats
/// the other end. Twin of levelTexel in clipmap.glsl.
struct ClipmapVolume {
    int resolution = 0, levels = 1, mips = 0, border = 0;
    int rows = 1;  ///< levels stacked along z; what is beyond lies in a second column along y

    ClipmapVolume(const ClipmapLayout& layout, int border);
    glm::ivec3 size() const;
    /// Texel of voxel index `i`.
    glm::ivec3 texel(const glm::ivec3& i, int level) const;
    glm::ivec3 levelOrigin(int level) const;
};

}  // namespace voxcone
