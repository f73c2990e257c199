// Laws of the clipmap's arithmetic, over layouts, cameras and movements drawn at random.
#include "cascade/clipmap.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <set>
#include <tuple>

#include "cascade/update.h"
#include "cascade/voxels.h"

namespace voxcone {
namespace {

Bounds boundsOf(const glm::dvec3& low, const glm::dvec3& high) {
    Bounds bounds;
    bounds.add(low);
    bounds.add(high);
    return bounds;
}

glm::ivec3 indexAt(const glm::ivec3& size, int i) {
    return {i % size.x, i / size.x % size.y, i / (size.x * size.y)};
}

bool overlap(const VoxelBox& a, const VoxelBox& b) {
    return !intersection(a, b).empty();
}

/// Boxes that do not overlap; their volume is that of their union.
long long disjointVolume(const std::vector<VoxelBox>& boxes) {
    long long volume = 0;
    for (std::size_t i = 0; i < boxes.size(); ++i) {
        EXPECT_FALSE(boxes[i].empty());
        volume += boxes[i].volume();
        for (std::size_t j = 0; j < i; ++j) EXPECT_FALSE(overlap(boxes[i], boxes[j])) << i << " and " << j;
    }
    return volume;
}

bool anyContains(const std::vector<VoxelBox>& boxes, const glm::ivec3& i) {
    return std::any_of(boxes.begin(), boxes.end(), [&](const VoxelBox& box) { return box.contains(i); });
}

std::vector<VoxelBox> ofLevel(const std::vector<Region>& regions, int level) {
    std::vector<VoxelBox> boxes;
    for (const Region& region : regions)
        if (region.level == level) boxes.push_back(region.box);
    return boxes;
}

class Clipmap : public testing::Test {
  protected:
    double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
    int integer(int low, int high) { return std::uniform_int_distribution<int>(low, high)(random_); }
    glm::dvec3 point(double low, double high) { return {uniform(low, high), uniform(low, high), uniform(low, high)}; }
    glm::ivec3 index(int low, int high) { return {integer(low, high), integer(low, high), integer(low, high)}; }
    glm::ivec3 indexIn(const VoxelBox& box) {
        return {integer(box.low.x, box.high.x - 1), integer(box.low.y, box.high.y - 1),
                integer(box.low.z, box.high.z - 1)};
    }
    VoxelBox box(int spread, int largest) {
        const glm::ivec3 low = index(-spread, spread);
        return {low, low + index(1, largest)};
    }

    /// Settings with every combination of what a layout depends on, the smallest resolution as given.
    Settings settings(int smallestResolution = 16) {
        Settings s;
        do {
            s.voxel.resolution = 16 << integer(0, 4);
        } while (s.voxel.resolution < smallestResolution);
        s.voxel.margin = integer(0, 4);
        s.cascade.levels = integer(1, 8);
        s.cascade.snap = 1 << integer(0, 6);
        s.cascade.band = uniform(0.001, 0.2);
        return s;
    }
    /// A layout whose last level stays, or one whose last level moves, too.
    ClipmapLayout layout(bool fixedLast, int smallestResolution = 16) {
        Settings s = settings(smallestResolution);
        const double edge = std::exp2(uniform(-8, 3));
        if (!fixedLast) s.cascade.levels = integer(2, 8), s.voxel.size = edge;
        const double extent =
            fixedLast ? edge : edge * s.voxel.resolution * std::exp2(s.cascade.levels - 1) * uniform(1, 40);
        const glm::dvec3 low = point(-extent, extent);
        const ClipmapLayout made = layoutClipmap(boundsOf(low, low + extent), s);
        EXPECT_EQ(made.fixedLast, fixedLast);
        EXPECT_EQ(made.levels, s.cascade.levels);
        return made;
    }
    /// A camera near the lattice's origin, relative to it.
    glm::dvec3 camera(const ClipmapLayout& layout) {
        return point(-1, 1) * layout.sizeOf(layout.levels - 1) * std::exp2(uniform(-12, 2));
    }
    std::mt19937 random_{1};
};

TEST_F(Clipmap, WindowsHoldTheCameraInTheirMiddle) {
    for (int i = 0; i < 4000; ++i) {
        const ClipmapLayout l = layout(i % 2);
        const glm::dvec3 eye = camera(l);
        for (int level = 0; level < l.levels; ++level) {
            const VoxelBox window = clipmapWindow(l, level, eye);
            ASSERT_EQ(window.size(), glm::ivec3(l.resolution));
            if (!l.moves(level)) {
                EXPECT_EQ(window.low, glm::ivec3(0));
                continue;
            }
            const int snap = l.snapOf(level);
            EXPECT_EQ(window.low % snap, glm::ivec3(0));
            const glm::dvec3 middle = 0.5 * glm::dvec3(window.low + window.high);
            const glm::dvec3 off = glm::abs(eye / l.voxelSizeOf(level) - middle);
            EXPECT_LE(std::max({off.x, off.y, off.z}), 0.5 * snap + 1e-6);
        }
    }
}

TEST_F(Clipmap, WhatMayBeReadLiesInEveryWindow) {
    for (int i = 0; i < 4000; ++i) {
        const ClipmapLayout l = layout(i % 2);
        const glm::dvec3 eye = camera(l);
        // Level l may be read radius()·2^l voxels of level 0 around the camera, that is, radius() of its own. A
        // trilinear sample reaches half a voxel further.
        EXPECT_GE(l.radius(), l.resolution / 4.0);
        for (int level = 0; level < l.levels - 1; ++level) {
            const VoxelBox window = clipmapWindow(l, level, eye);
            const glm::dvec3 c = eye / l.voxelSizeOf(level);
            const glm::dvec3 below = c - l.radius() - glm::dvec3(window.low);
            const glm::dvec3 above = glm::dvec3(window.high) - c - l.radius();
            EXPECT_GE(std::min({below.x, below.y, below.z, above.x, above.y, above.z}), 0.5);
        }
        if (l.fixedLast) continue;
        // The last level is read together with its mips, the coarsest of which has the widest samples.
        const VoxelBox window = clipmapWindow(l, l.levels - 1, eye);
        const glm::dvec3 c = eye / l.voxelSizeOf(l.levels - 1);
        const glm::dvec3 below = c - l.lastRadius() - glm::dvec3(window.low);
        const glm::dvec3 above = glm::dvec3(window.high) - c - l.lastRadius();
        EXPECT_GE(std::min({below.x, below.y, below.z, above.x, above.y, above.z}), 0.5 * std::exp2(l.mips) - 1e-6);
        // Where the level before ends the last one may be read: its cube is the larger one.
        EXPECT_GT(2 * l.lastRadius(), l.radius()) << l.resolution << " snap " << l.snap;
    }
}

TEST_F(Clipmap, MipsOfWindowsThatMoveAreWhole) {
    for (int i = 0; i < 2000; ++i) {
        const ClipmapLayout l = layout(false);
        const VoxelBox last = clipmapWindow(l, l.levels - 1, camera(l));
        EXPECT_EQ(last.low % (1 << l.mips), glm::ivec3(0));
        ClipmapSchedule schedule(l, 0, false);
        const ClipmapUpdate update = schedule.next(camera(l), {});
        ASSERT_EQ(update.windows.size(), static_cast<std::size_t>(l.count()));
        for (int mip = l.levels; mip < l.count(); ++mip) {
            const VoxelBox& window = update.windows[static_cast<std::size_t>(mip)];
            EXPECT_EQ(window.low * (1 << (mip - l.levels + 1)),
                      update.windows[static_cast<std::size_t>(l.levels - 1)].low);
            EXPECT_EQ(window.size(), glm::ivec3(l.resolutionOf(mip)));
        }
    }
}

TEST_F(Clipmap, AMoveExposesWhatTheOldWindowLacks) {
    std::map<std::size_t, int> counts;
    for (int i = 0; i < 4000; ++i) {
        const int size = 32 << (i % 4);
        const VoxelBox from = {index(-500, 500), {}};
        const VoxelBox old = {from.low, from.low + size};
        // None to three axes move; now and then all is left behind.
        const int reach = i % 7 == 0 ? 3 * size : size / 2;
        const glm::ivec3 moves(integer(0, 1), integer(0, 1), integer(0, 1));
        const glm::ivec3 by = moves * index(-reach, reach);
        const VoxelBox now = {old.low + by, old.high + by};
        const std::vector<VoxelBox> slabs = exposedSlabs(old, now);
        EXPECT_EQ(disjointVolume(slabs), now.volume() - intersection(old, now).volume());
        for (const VoxelBox& slab : slabs) EXPECT_EQ(intersection(slab, now), slab);
        for (int k = 0; k < 50; ++k) {
            const glm::ivec3 voxel = indexIn(now);
            EXPECT_EQ(anyContains(slabs, voxel), !old.contains(voxel));
        }
        const auto axes = static_cast<std::size_t>((by.x != 0) + (by.y != 0) + (by.z != 0));
        EXPECT_EQ(slabs.size(), overlap(old, now) ? axes : 1u);
        ++counts[slabs.size()];
    }
    for (const std::size_t n : {0u, 1u, 2u, 3u}) EXPECT_GT(counts[n], 100) << n;
}

TEST_F(Clipmap, BoxesOfAnySizeExposeWhatTheyDoNotShare) {
    for (int i = 0; i < 4000; ++i) {
        const VoxelBox from = box(20, 40), to = box(20, 40);
        const std::vector<VoxelBox> slabs = exposedSlabs(from, to);
        EXPECT_EQ(disjointVolume(slabs), to.volume() - intersection(from, to).volume());
        EXPECT_LE(slabs.size(), 6u);
        const glm::ivec3 voxel = indexIn(to);
        EXPECT_EQ(anyContains(slabs, voxel), !from.contains(voxel));
    }
    const VoxelBox nothing, some{glm::ivec3(-4), glm::ivec3(4)};
    EXPECT_TRUE(exposedSlabs(some, nothing).empty());
    EXPECT_TRUE(exposedSlabs(some, some).empty());
    EXPECT_EQ(exposedSlabs(nothing, some), std::vector<VoxelBox>{some});
}

TEST_F(Clipmap, VoxelsOfAWindowHaveTexelsOfTheirOwn) {
    for (const int size : {4, 8, 16}) {
        for (int i = 0; i < 20; ++i) {
            const glm::ivec3 low = index(-1000, 1000);
            std::vector<bool> taken(static_cast<std::size_t>(size * size * size));
            for (int k = 0; k < size * size * size; ++k) {
                const glm::ivec3 voxel = low + indexAt(glm::ivec3(size), k), texel = toroidal(voxel, size);
                ASSERT_TRUE(VoxelBox({glm::ivec3(0), glm::ivec3(size)}).contains(texel));
                const auto at = static_cast<std::size_t>((texel.z * size + texel.y) * size + texel.x);
                EXPECT_FALSE(taken[at]);
                taken[at] = true;
                EXPECT_EQ(fromToroidal(texel, low, size), voxel);
            }
        }
    }
}

TEST_F(Clipmap, TexelsDoNotDependOnTheWindow) {
    for (int i = 0; i < 2000; ++i) {
        const int size = 4 << integer(0, 6);
        const glm::ivec3 voxel = index(-100000, 100000), low = voxel - index(0, size - 1);
        EXPECT_EQ(fromToroidal(toroidal(voxel, size), low, size), voxel);
        EXPECT_EQ(toroidal(voxel + size * index(-50, 50), size), toroidal(voxel, size));
    }
}

TEST_F(Clipmap, LevelsShareAVolumeWithoutMeeting) {
    std::set<std::tuple<int, int, int, int>> seen;
    for (const int resolution : {16, 32, 64, 128, 256})
        for (int levels = 1; levels <= 8; ++levels)
            for (const bool fixedLast : {true, false})
                for (const int border : {0, 1}) {
                    Settings s;
                    s.voxel.resolution = resolution;
                    s.cascade.levels = levels;
                    if (!fixedLast) s.voxel.size = 1;
                    const ClipmapLayout l = layoutClipmap(boundsOf(glm::dvec3(0), glm::dvec3(1e6)), s);
                    ASSERT_EQ(l.levels, levels);
                    const ClipmapVolume volume(l, border);
                    const VoxelBox whole{glm::ivec3(0), volume.size()};
                    EXPECT_LE(std::max({whole.high.x, whole.high.y, whole.high.z}), 2048);
                    std::vector<VoxelBox> boxes;
                    for (int level = 0; level < l.count(); ++level) {
                        const glm::ivec3 first = volume.levelOrigin(level);
                        const int size = l.resolutionOf(level);
                        boxes.push_back({first - border, first + size + border});
                        EXPECT_EQ(intersection(boxes.back(), whole), boxes.back());
                        const glm::ivec3 voxel = index(-1000, 1000);
                        EXPECT_EQ(volume.texel(voxel, level), first + toroidal(voxel, size));
                    }
                    disjointVolume(boxes);
                    // Records keep a texel in 8 bits an axis and a level in 4.
                    EXPECT_LE(l.count(), 16);
                    EXPECT_LE(l.resolution, 256);
                }
}

TEST_F(Clipmap, TheLevelToReadIsContinuous) {
    for (int i = 0; i < 4000; ++i) {
        const int levels = integer(1, 8);
        const auto radius = static_cast<float>(uniform(5, 127)), band = static_cast<float>(uniform(0.01, 0.5));
        const glm::vec3 a = point(-1, 1) * static_cast<double>(radius) * std::exp2(uniform(-2, levels));
        const glm::vec3 b = a + glm::vec3(point(-1, 1) * std::exp2(uniform(-10, 6)));
        // A band is crossed over band·radius·2^l voxels, never fewer than those of level 0.
        const glm::vec3 d = glm::abs(a - b);
        const float steepest = std::max({d.x, d.y, d.z}) / (band * radius);
        EXPECT_LE(std::abs(containmentLevel(a, radius, band, levels) - containmentLevel(b, radius, band, levels)),
                  steepest * 1.001f + 1e-5f / band);
    }
}

TEST_F(Clipmap, TheLevelToReadStaysInsideItsRadius) {
    for (int i = 0; i < 4000; ++i) {
        const int levels = integer(1, 8);
        const auto radius = static_cast<float>(uniform(5, 127)), band = static_cast<float>(uniform(0.01, 0.5));
        const glm::vec3 p = point(-1, 1) * static_cast<double>(radius) * std::exp2(uniform(-2, levels));
        const float level = containmentLevel(p, radius, band, levels);
        ASSERT_GE(level, 0);
        ASSERT_LE(level, levels - 1);
        const float whole = std::floor(level), distance = std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)});
        const float edge = radius * std::exp2(whole);
        if (whole < static_cast<float>(levels - 1)) {
            EXPECT_LE(distance, edge * 1.00001f);
        }
        // The finest level that reaches so far, but for the end of a band, which rounds up to the next level.
        if (whole > 0) {
            EXPECT_GE(distance, 0.5f * edge * 0.99999f);
        }
        // Whole where no band is.
        if (distance < edge * (1 - band) * 0.99999f) {
            EXPECT_EQ(level, whole);
        }
        if (level > whole) {
            EXPECT_GT(distance, edge * (1 - band) * 0.99999f);
        }
        // Six sides and three axes are alike.
        EXPECT_EQ(containmentLevel(-p, radius, band, levels), level);
        EXPECT_EQ(containmentLevel({p.y, -p.z, p.x}, radius, band, levels), level);
    }
}

TEST_F(Clipmap, ABandEndsBeforeTheOneOfTheNextLevelBegins) {
    for (int i = 0; i < 2000; ++i) {
        const ClipmapLayout l = layout(i % 2);
        // As a share of the radius; the level before ends at half of it.
        EXPECT_LE(l.band * l.resolution / l.radius(), 0.5);
    }
}

TEST_F(Clipmap, TheLastLevelHoldsTheSceneWithItsMargin) {
    for (int i = 0; i < 4000; ++i) {
        const Settings s = settings();
        const double spread = std::exp2(uniform(-10, 20));
        const Bounds bounds = boundsOf(point(-spread, spread), point(-spread, spread));
        const ClipmapLayout l = layoutClipmap(bounds, s);
        EXPECT_TRUE(l.fixedLast);
        EXPECT_EQ(l.levels, s.cascade.levels);
        EXPECT_EQ(l.originStep, 0);
        const double edge = l.voxelSizeOf(l.levels - 1);
        for (int a = 0; a < 3; ++a) {
            EXPECT_GE((bounds.min[a] - l.origin[a]) / edge, s.voxel.margin - 1e-9);
            EXPECT_LE((bounds.max[a] - l.origin[a]) / edge, s.voxel.resolution - s.voxel.margin + 1e-9);
        }
        // One level alone would have the same voxels there.
        const VoxelGrid grid = fitGrid(bounds, s.voxel.resolution, s.voxel.margin);
        EXPECT_EQ(edge, grid.voxelSize);
        EXPECT_EQ(l.origin, grid.origin);
    }
}

TEST_F(Clipmap, LevelsBeyondTheFirstThatHoldsTheSceneAreLeftOut) {
    for (int i = 0; i < 4000; ++i) {
        Settings s = settings();
        s.voxel.size = std::exp2(uniform(-8, 3));
        const double extent = s.voxel.size * s.voxel.resolution * std::exp2(uniform(-2, 9));
        const glm::dvec3 low = point(-extent, extent);
        const ClipmapLayout l = layoutClipmap(boundsOf(low, low + extent), s);
        EXPECT_EQ(l.requestedLevels, s.cascade.levels);
        EXPECT_DOUBLE_EQ(l.voxelSize, s.voxel.size);
        const auto holds = [&](int level) {
            return std::ldexp(s.voxel.size, level) * (s.voxel.resolution - 2 * s.voxel.margin - 1) >=
                   extent * (1 - 1e-12);
        };
        for (int level = 0; level < l.levels - 1; ++level) EXPECT_FALSE(holds(level));
        if (l.levels < s.cascade.levels) {
            EXPECT_TRUE(holds(l.levels - 1));
        }
        if (l.levels > 1) {
            EXPECT_EQ(l.fixedLast, holds(l.levels - 1));
        }
        if (holds(l.levels - 1)) {
            const double edge = l.voxelSizeOf(l.levels - 1);
            for (int a = 0; a < 3; ++a) {
                EXPECT_GE((low[a] - l.origin[a]) / edge, s.voxel.margin - 1e-6);
                EXPECT_LE((low[a] + extent - l.origin[a]) / edge, s.voxel.resolution - s.voxel.margin + 1e-6);
            }
        }
        const glm::dvec3 coarsest = l.origin / l.voxelSizeOf(l.fixedLast ? l.levels - 1 : l.count() - 1);
        for (int a = 0; a < 3; ++a) EXPECT_NEAR(coarsest[a], std::round(coarsest[a]), 1e-6);
    }
}

TEST_F(Clipmap, ScalesExactlyWithPowersOfTwo) {
    for (int i = 0; i < 2000; ++i) {
        Settings s = settings();
        if (i % 2) s.voxel.size = uniform(0.001, 1);
        const Bounds bounds = boundsOf(point(-100, 100), point(-100, 100));
        const ClipmapLayout l = layoutClipmap(bounds, s);
        const glm::dvec3 eye = point(-200, 200);
        const double scale = std::exp2(integer(-10, 10));
        s.voxel.size *= scale;
        const ClipmapLayout scaled = layoutClipmap(boundsOf(bounds.min * scale, bounds.max * scale), s);
        EXPECT_EQ(scaled.voxelSize, l.voxelSize * scale);
        EXPECT_EQ(scaled.origin, l.origin * scale);
        EXPECT_EQ(scaled.originStep, l.originStep * scale);
        EXPECT_EQ(scaled.levels, l.levels);
        EXPECT_EQ(scaled.fixedLast, l.fixedLast);
        const glm::dvec3 origin = clipmapOrigin(l, eye);
        EXPECT_EQ(clipmapOrigin(scaled, eye * scale), origin * scale);
        for (int level = 0; level < l.levels; ++level)
            EXPECT_EQ(clipmapWindow(scaled, level, (eye - origin) * scale), clipmapWindow(l, level, eye - origin));
    }
}

TEST_F(Clipmap, MovesByWholeVoxels) {
    for (int i = 0; i < 2000; ++i) {
        Settings s = settings();
        s.voxel.size = 0.125;
        // Numbers on a lattice that doubles hold exactly, wherever they are moved.
        const auto lattice = [&](const glm::dvec3& v) { return glm::round(v * 1024.0) / 1024.0; };
        const double spread = std::exp2(uniform(0, 14));
        const Bounds bounds = boundsOf(lattice(point(-spread, 0)), lattice(point(0, spread)));
        const glm::dvec3 eye = lattice(point(-spread, spread));
        const ClipmapLayout l = layoutClipmap(bounds, s);
        const glm::dvec3 move = l.voxelSizeOf(l.count() - 1) * glm::round(point(-1e4, 1e4));
        const ClipmapLayout moved = layoutClipmap(boundsOf(bounds.min + move, bounds.max + move), s);
        EXPECT_EQ(moved.voxelSize, l.voxelSize);
        EXPECT_EQ(moved.origin, l.origin + move);
        const glm::dvec3 origin = clipmapOrigin(l, eye);
        EXPECT_EQ(clipmapOrigin(moved, eye + move), origin + move);
        for (int level = 0; level < l.levels; ++level)
            EXPECT_EQ(clipmapWindow(moved, level, eye + move - (origin + move)), clipmapWindow(l, level, eye - origin));
    }
}

TEST_F(Clipmap, NothingAndAPoint) {
    for (const double size : {0.0, 0.25}) {
        for (const Bounds& bounds : {Bounds(), boundsOf({7, 7, 7}, {7, 7, 7})}) {
            Settings s;
            s.cascade.levels = 4;
            s.voxel.size = size;
            const ClipmapLayout l = layoutClipmap(bounds, s);
            EXPECT_EQ(l.levels, size > 0 ? 1 : 4);
            EXPECT_TRUE(l.fixedLast);
            EXPECT_GT(l.voxelSize, 0);
            for (int a = 0; a < 3; ++a) {
                EXPECT_LT(l.origin[a], bounds.center()[a]);
                EXPECT_GT(l.origin[a] + l.sizeOf(l.levels - 1), bounds.center()[a]);
            }
            EXPECT_EQ(clipmapOrigin(l, {1e9, 0, 0}), l.origin);
        }
    }
}

TEST_F(Clipmap, HugeScenesHaveAnOriginNearTheCamera) {
    for (int i = 0; i < 2000; ++i) {
        Settings s = settings();
        s.cascade.levels = integer(2, 8);
        s.voxel.size = std::exp2(integer(-8, 0));
        const double extent =
            s.voxel.size * std::max(32768.0 * 1.01, s.voxel.resolution * std::exp2(s.cascade.levels - 1));
        const Bounds bounds = boundsOf(glm::dvec3(0), glm::dvec3(extent * uniform(1, 100)));
        const ClipmapLayout l = layoutClipmap(bounds, s);
        ASSERT_FALSE(l.fixedLast);
        ASSERT_GT(l.originStep, 0);
        const glm::dvec3 eye = point(-1, 2) * bounds.size(), origin = clipmapOrigin(l, eye);
        const glm::dvec3 off = glm::abs(eye - origin);
        EXPECT_LE(std::max({off.x, off.y, off.z}), 0.5 * l.originStep);
        // Voxels of all levels keep their place in the world.
        const glm::dvec3 coarsest = (origin - l.origin) / l.voxelSizeOf(l.count() - 1);
        EXPECT_EQ(coarsest, glm::round(coarsest));
        // What a float makes of a position is far finer than a voxel of level 0.
        EXPECT_LE(0.5 * l.originStep / l.voxelSize, 1 << 15);
    }
}

TEST_F(Clipmap, ACameraLostInSpaceHasWindows) {
    const ClipmapLayout l = layout(true);
    for (const double far : {1e12, 1e30, 1e300, -1e300}) {
        const VoxelBox window = clipmapWindow(l, 0, glm::dvec3(far));
        EXPECT_EQ(window.size(), glm::ivec3(l.resolution));
    }
}

TEST_F(Clipmap, DisjointBoxesKeepTheirUnion) {
    for (int i = 0; i < 400; ++i) {
        std::vector<VoxelBox> boxes;
        for (int k = integer(0, 8); k > 0; --k) boxes.push_back(box(12, 16));
        boxes.push_back({});
        boxes.push_back({glm::ivec3(3), glm::ivec3(-3)});
        std::shuffle(boxes.begin(), boxes.end(), random_);
        const std::vector<VoxelBox> apart = disjoint(boxes);
        disjointVolume(apart);
        for (int k = 0; k < 500; ++k) {
            const glm::ivec3 voxel = index(-13, 29);
            EXPECT_EQ(anyContains(apart, voxel), anyContains(boxes, voxel));
        }
    }
}

TEST_F(Clipmap, AVoxelBoxHoldsWhatItIsOf) {
    for (int i = 0; i < 4000; ++i) {
        const double edge = std::exp2(uniform(-8, 3));
        glm::dvec3 low = point(-1e4, 1e4) * edge, size = point(0, 10) * edge;
        if (i % 2) low = glm::round(low / edge) * edge, size = glm::round(size / edge) * edge;
        const VoxelBox box = voxelBox(boundsOf(low, low + size), edge);
        // Also when floats round it outwards.
        const glm::dvec3 hair = 1e-7 * glm::abs(low);
        for (int a = 0; a < 3; ++a) {
            EXPECT_LT(box.low[a] * edge, low[a] - hair[a]);
            EXPECT_GT(box.high[a] * edge, low[a] + size[a] + hair[a]);
            EXPECT_GT((box.low[a] + 1.1) * edge, low[a]);
            EXPECT_LT((box.high[a] - 1.1) * edge, low[a] + size[a]);
        }
    }
    EXPECT_TRUE(voxelBox(Bounds(), 1).empty());
    EXPECT_FALSE(voxelBox(boundsOf(glm::dvec3(-1e200), glm::dvec3(1e200)), 1).empty());
}

TEST_F(Clipmap, WhatConesReadDoesNotDependOnTheSnap) {
    for (int i = 0; i < 2000; ++i) {
        Voxels voxels;
        voxels.layout = layout(i % 2);
        voxels.center = camera(voxels.layout);
        voxels.windows = ClipmapSchedule(voxels.layout, 0, false).next(voxels.center, {}).windows;
        EXPECT_NEAR(voxels.radius(), voxels.layout.radius(), 1e-6)
            << voxels.layout.resolution << " snap " << voxels.layout.snap << " fixed " << voxels.layout.fixedLast;
        if (voxels.layout.fixedLast) continue;
        const auto [low, high] = voxels.readable();
        const double half = voxels.layout.lastRadius() * std::exp2(voxels.layout.levels - 1);
        const glm::dvec3 c = voxels.center / voxels.layout.voxelSize;
        for (int a = 0; a < 3; ++a) {
            EXPECT_NEAR(low[a], c[a] - half, 1e-5 * half);
            EXPECT_NEAR(high[a], c[a] + half, 1e-5 * half);
        }
    }
}

/// Cameras that rest, walk and jump, and things that move.
class Schedule : public Clipmap {
  protected:
    glm::dvec3 step(const ClipmapLayout& l, const glm::dvec3& eye) {
        const int kind = integer(0, 9);
        if (kind < 3) return eye;
        if (kind == 9) return camera(l);
        return eye + point(-1, 1) * l.voxelSize * std::exp2(uniform(-2, 6));
    }
    std::vector<Bounds> moves(const ClipmapLayout& l, const glm::dvec3& eye) {
        std::vector<Bounds> boxes;
        for (int k = integer(-2, 2); k > 0; --k) {
            const glm::dvec3 low = eye + point(-1, 1) * l.sizeOf(integer(0, l.levels - 1));
            boxes.push_back(boundsOf(low, low + point(0, 0.5) * l.sizeOf(integer(0, l.levels - 1))));
        }
        return boxes;
    }
};

TEST_F(Schedule, ExactUpdatesAreOfWhatMovedAndNoMore) {
    for (int run = 0; run < 60; ++run) {
        const ClipmapLayout l = layout(run % 2);
        const bool anyMoving = run % 3 != 0;
        ClipmapSchedule schedule(l, 0, anyMoving);
        std::vector<VoxelBox> windows(static_cast<std::size_t>(l.levels));
        glm::dvec3 eye = camera(l);
        for (int frame = 0; frame < 20; ++frame) {
            eye = step(l, eye);
            const std::vector<Bounds> moved = anyMoving ? moves(l, eye) : std::vector<Bounds>();
            if (frame == 12) schedule.reset(), windows.assign(windows.size(), {});
            const bool first = frame == 0 || frame == 12;
            const ClipmapUpdate update = schedule.next(eye, moved);
            EXPECT_EQ(update.all, first);
            EXPECT_EQ(schedule.waiting(), 0);
            for (int level = 0; level < l.levels; ++level) {
                const auto at = static_cast<std::size_t>(level);
                const VoxelBox wanted = clipmapWindow(l, level, eye);
                EXPECT_EQ(update.windows[at], wanted);
                const std::vector<VoxelBox> slabs = exposedSlabs(windows[at], wanted);
                EXPECT_EQ(ofLevel(update.fixed, level), slabs);
                windows[at] = wanted;

                std::vector<VoxelBox> touched = slabs;
                if (!first)
                    for (const Bounds& b : moved) touched.push_back(voxelBox(b, l.voxelSizeOf(level)));
                const std::vector<VoxelBox> moving = ofLevel(update.moving, level);
                disjointVolume(moving);
                if (!anyMoving) {
                    EXPECT_TRUE(moving.empty());
                }
                for (const VoxelBox& box : moving) EXPECT_EQ(intersection(box, wanted), box);
                for (int k = 0; anyMoving && k < 30; ++k) {
                    const glm::ivec3 voxel = indexIn(wanted);
                    EXPECT_EQ(anyContains(moving, voxel), anyContains(touched, voxel));
                }
                EXPECT_EQ(update.touches(level), !slabs.empty() || !moving.empty());
            }
        }
    }
}

TEST_F(Schedule, WhatWasPutElsewhereIsRenewedInBothLayers) {
    for (int run = 0; run < 200; ++run) {
        const ClipmapLayout l = layout(run % 2);
        const bool anyMoving = run % 3 != 0;
        ClipmapSchedule schedule(l, 0, anyMoving);
        glm::dvec3 eye = camera(l);
        std::vector<VoxelBox> windows = schedule.next(eye, {}, moves(l, eye)).windows;
        for (int frame = 0; frame < 5; ++frame) {
            eye = step(l, eye);
            const std::vector<Bounds> placed = moves(l, eye);
            const ClipmapUpdate update = schedule.next(eye, {}, placed);
            for (int level = 0; level < l.levels; ++level) {
                const VoxelBox wanted = clipmapWindow(l, level, eye);
                std::vector<VoxelBox> touched = exposedSlabs(windows[static_cast<std::size_t>(level)], wanted);
                for (const Bounds& b : placed) touched.push_back(voxelBox(b, l.voxelSizeOf(level)));
                const std::vector<VoxelBox> fixed = ofLevel(update.fixed, level);
                disjointVolume(fixed);
                for (const VoxelBox& box : fixed) EXPECT_EQ(intersection(box, wanted), box);
                const std::vector<VoxelBox> moving = ofLevel(update.moving, level);
                for (int k = 0; k < 30; ++k) {
                    const glm::ivec3 voxel = indexIn(wanted);
                    EXPECT_EQ(anyContains(fixed, voxel), anyContains(touched, voxel));
                    EXPECT_EQ(anyContains(moving, voxel), anyMoving && anyContains(touched, voxel));
                }
            }
            windows = update.windows;
        }
        EXPECT_TRUE(schedule.next(eye, {}).empty());
    }
}

TEST_F(Schedule, ABudgetIsKeptUnlessALevelCannotWait) {
    for (int run = 0; run < 200; ++run) {
        const ClipmapLayout l = layout(run % 2);
        const int budget = integer(1, 8);
        const bool anyMoving = run % 3 != 0;
        ClipmapSchedule schedule(l, budget, anyMoving);
        glm::dvec3 eye = camera(l);
        ClipmapUpdate last = schedule.next(eye, {});
        // What things have moved in since a level was voxelized last.
        std::vector<std::vector<Bounds>> pending(static_cast<std::size_t>(l.levels));
        for (int frame = 0; frame < 30; ++frame) {
            eye = step(l, eye);
            const std::vector<Bounds> moved = anyMoving ? moves(l, eye) : std::vector<Bounds>();
            const ClipmapUpdate update = schedule.next(eye, moved);
            int chosen = 0, urgent = 0, waiting = 0;
            for (int level = 0; level < l.levels; ++level) {
                const auto at = static_cast<std::size_t>(level);
                const VoxelBox wanted = clipmapWindow(l, level, eye), before = last.windows[at],
                               now = update.windows[at];
                const glm::dvec3 c = eye / l.voxelSizeOf(level);
                const auto reach = [&](const VoxelBox& window) {
                    const glm::dvec3 r = glm::min(c - glm::dvec3(window.low), glm::dvec3(window.high) - c);
                    return std::min({r.x, r.y, r.z});
                };
                pending[at].insert(pending[at].end(), moved.begin(), moved.end());
                const bool stale = before != wanted || !pending[at].empty();
                const bool isUrgent = l.moves(level) && reach(before) <= 0.25 * l.resolution;
                urgent += isUrgent;
                if (l.moves(level)) {
                    EXPECT_GT(reach(now), 0.25 * l.resolution);
                }
                // A level is brought up to date, or stays as it was.
                if (update.touches(level)) {
                    EXPECT_EQ(now, wanted);
                }
                if (now == wanted && before != wanted) {
                    EXPECT_EQ(ofLevel(update.fixed, level), exposedSlabs(before, wanted));
                }
                if (now == before) {
                    EXPECT_TRUE(ofLevel(update.fixed, level).empty());
                }
                const bool follows = update.touches(level) || now != before;
                chosen += follows;
                if (follows) {
                    std::vector<VoxelBox> touched = exposedSlabs(before, wanted);
                    for (const Bounds& b : pending[at]) touched.push_back(voxelBox(b, l.voxelSizeOf(level)));
                    const std::vector<VoxelBox> moving = ofLevel(update.moving, level);
                    for (int k = 0; anyMoving && k < 30; ++k) {
                        const glm::ivec3 voxel = indexIn(wanted);
                        EXPECT_EQ(anyContains(moving, voxel), anyContains(touched, voxel));
                    }
                    pending[at].clear();
                } else if (stale) {
                    // Chosen without anything to voxelize in its window, or left behind.
                    std::vector<VoxelBox> touched;
                    for (const Bounds& b : pending[at])
                        touched.push_back(intersection(voxelBox(b, l.voxelSizeOf(level)), wanted));
                    const bool nothing = now == wanted && disjoint(touched).empty();
                    if (nothing) {
                        pending[at].clear();
                    } else {
                        ++waiting;
                    }
                }
            }
            EXPECT_LE(chosen, std::max(budget, urgent));
            EXPECT_GE(schedule.waiting(), waiting);
            if (budget >= l.levels) {
                EXPECT_EQ(schedule.waiting(), 0);
            }
            last = update;
        }
    }
}

TEST_F(Schedule, EveryLevelHasItsTurn) {
    for (int run = 0; run < 200; ++run) {
        const ClipmapLayout l = layout(run % 2);
        const int budget = integer(1, 3);
        ClipmapSchedule schedule(l, budget, true);
        glm::dvec3 eye = point(0.3, 0.7) * l.sizeOf(l.levels - 1);  // in the last level's window, should that stay
        schedule.next(eye, {});
        // The camera moves a little, then rests while something moves in front of it without end.
        for (int frame = integer(1, 9); frame > 0; --frame) {
            eye += point(-1, 1) * 4.0 * l.voxelSize;
            schedule.next(eye, {});
        }
        const Bounds thing = boundsOf(eye, eye + l.voxelSize);
        std::vector<int> age(static_cast<std::size_t>(l.levels), 0);
        for (int frame = 0; frame < 30; ++frame) {
            const ClipmapUpdate update = schedule.next(eye, {thing});
            int updated = 0;
            for (int level = 0; level < l.levels; ++level) {
                int& a = age[static_cast<std::size_t>(level)];
                const bool now = update.touches(level);
                updated += now;
                a = now ? 0 : a + 1;
                EXPECT_LT(a, (l.levels + budget - 1) / budget + (frame < l.levels ? 1 : 0)) << "level " << level;
            }
            EXPECT_EQ(updated, std::min(budget, l.levels));
            EXPECT_EQ(schedule.waiting(), l.levels - updated);
        }
        // When all is still, what waits is done within a round.
        for (int frame = 0; frame < (l.levels + budget - 1) / budget; ++frame) schedule.next(eye, {});
        EXPECT_EQ(schedule.waiting(), 0);
        EXPECT_TRUE(schedule.next(eye, {}).empty());
        for (int level = 0; level < l.levels; ++level)
            EXPECT_EQ(schedule.next(eye, {}).windows[static_cast<std::size_t>(level)], clipmapWindow(l, level, eye));
    }
}

}  // namespace
}  // namespace voxcone
