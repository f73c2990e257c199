#include "cascade/grid.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace voxcone {
namespace {

Bounds boundsOf(const glm::dvec3& low, const glm::dvec3& high) {
    Bounds bounds;
    bounds.add(low);
    bounds.add(high);
    return bounds;
}

class Grid : public testing::Test {
  protected:
    double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
    glm::dvec3 point(double low, double high) { return {uniform(low, high), uniform(low, high), uniform(low, high)}; }
    Bounds bounds(double spread) { return boundsOf(point(-spread, spread), point(-spread, spread)); }
    std::mt19937 random_{1};
};

TEST_F(Grid, LeavesTheMarginOnEverySide) {
    for (int i = 0; i < 5000; ++i) {
        const Bounds box = bounds(std::exp2(uniform(-10, 20)));
        const int resolution = 16 << (i % 5), margin = i % 7;
        const VoxelGrid grid = fitGrid(box, resolution, margin);
        for (int a = 0; a < 3; ++a) {
            // Voxels from the grid's sides, but for the rounding of divisions.
            EXPECT_GE((box.min[a] - grid.origin[a]) / grid.voxelSize, margin - 1e-9);
            EXPECT_LT((box.max[a] - grid.origin[a]) / grid.voxelSize, resolution - margin + 1e-9);
        }
        const double extent = std::max({box.size().x, box.size().y, box.size().z});
        EXPECT_DOUBLE_EQ(grid.voxelSize, extent / (resolution - 2 * margin - 1));
        EXPECT_DOUBLE_EQ(grid.size(), resolution * grid.voxelSize);
    }
}

TEST_F(Grid, StartsAtAWholeVoxel) {
    for (int i = 0; i < 1000; ++i) {
        const VoxelGrid grid = fitGrid(bounds(100), 64, 2, i % 2 ? 0.25 : 0);
        for (int a = 0; a < 3; ++a) {
            const double voxels = grid.origin[a] / grid.voxelSize;
            EXPECT_NEAR(voxels, std::round(voxels), 1e-9);
        }
    }
}

TEST_F(Grid, ScalesExactlyWithPowersOfTwo) {
    for (int i = 0; i < 1000; ++i) {
        const Bounds box = bounds(10);
        const VoxelGrid grid = fitGrid(box, 64, 2);
        for (const int k : {-13, -1, 5, 20}) {
            const double scale = std::exp2(k);
            const VoxelGrid scaled = fitGrid(boundsOf(box.min * scale, box.max * scale), 64, 2);
            EXPECT_EQ(scaled.voxelSize, grid.voxelSize * scale);
            EXPECT_EQ(scaled.origin, grid.origin * scale);
        }
    }
}

TEST_F(Grid, MovesByWholeVoxels) {
    for (int i = 0; i < 1000; ++i) {
        // Bounds on a lattice that doubles hold exactly, wherever they are moved.
        const auto lattice = [&](double v) { return std::round(v * 1024) / 1024; };
        const glm::dvec3 low(lattice(uniform(-9, 0)), lattice(uniform(-9, 0)), lattice(uniform(-9, 0)));
        const glm::dvec3 high(lattice(uniform(0, 9)), lattice(uniform(0, 9)), lattice(uniform(0, 9)));
        const glm::dvec3 move = 0.125 * glm::round(point(-8e6, 8e6));
        const VoxelGrid grid = fitGrid(boundsOf(low, high), 128, 2, 0.125);
        EXPECT_EQ(fitGrid(boundsOf(low + move, high + move), 128, 2, 0.125).origin, grid.origin + move);
    }
}

TEST_F(Grid, AGivenVoxelSizeIsKeptAndCentred) {
    const VoxelGrid grid = fitGrid(boundsOf({-10, 2, 3}, {30, 4, 5}), 16, 2, 0.5);
    EXPECT_EQ(grid.voxelSize, 0.5);
    for (int a = 0; a < 3; ++a) EXPECT_LE(std::abs(grid.origin[a] + 4 - glm::dvec3(10, 3, 4)[a]), 0.25);
}

TEST_F(Grid, NothingAndAPoint) {
    const VoxelGrid empty = fitGrid(Bounds(), 64, 2);
    EXPECT_EQ(empty.size(), 1);
    EXPECT_EQ(empty.origin, glm::dvec3(-0.5));
    const VoxelGrid point = fitGrid(boundsOf({7, 7, 7}, {7, 7, 7}), 64, 2);
    EXPECT_EQ(point.size(), 1);
    for (int a = 0; a < 3; ++a) {
        EXPECT_LT(point.origin[a], 7);
        EXPECT_GT(point.origin[a] + 1, 7);
    }
}

}  // namespace
}  // namespace voxcone
