// A scene that is scaled, moved, turned or mirrored has voxels that are scaled, moved, turned or mirrored.
#include <gtest/gtest.h>

#include <cstdio>

#include "voxelize_lab.h"

namespace voxcone {
namespace {

using namespace test;

class VoxelInvariance : public GlTest {
  protected:
    static SceneBuilder scene() {
        SceneBuilder builder;
        builder.add(sphere(0.7, 3), lambert({0.8f, 0.3f, 0.1f}, {0, 2, 0}), translation({0.25, 0.5, -0.125}));
        builder.add(quad(2.5, 2.5, 3), lambert(0.4f), translation({0, -0.375, 0.125}) * rotation(11, {1, 0.2, 0.3}));
        builder.add(box({0.8, 0.3, 0.5}), glossy({0.9f, 0.7f, 0.2f}, 1, 0.4f),
                    translation({-0.5, 0.75, 0.25}) * rotation(33, {1, 2, 3}));
        return builder;
    }
    static VoxelizeLab& lab() {
        static const Scene model = scene().build();
        static VoxelizeLab lab(voxelSettings(32), model);
        return lab;
    }
};

TEST_F(VoxelInvariance, ScaledByPowersOfTwo) {
    const Scene base = scene().build();
    const VoxelGrid grid = fitGrid(base.bounds(), 32, 2);
    const VoxelMap expected = lab().voxelize(base, grid);
    EXPECT_GT(expected.voxels.size(), 1000u);
    for (int k = -13; k <= 20; ++k) {
        const double scale = std::exp2(k);
        const Scene scaled = scene().transform(scaling(glm::dvec3(scale))).build();
        const VoxelGrid scaledGrid = fitGrid(scaled.bounds(), 32, 2);
        EXPECT_EQ(scaledGrid.voxelSize, grid.voxelSize * scale);
        EXPECT_EQ(scaledGrid.origin, grid.origin * scale);
        EXPECT_TRUE(lab().voxelize(scaled, scaledGrid) == expected) << "2^" << k;
    }
}

TEST_F(VoxelInvariance, MovedByWholeVoxels) {
    // Voxels of 1/8 m, and moves that doubles hold exactly.
    const double size = 0.125;
    const Scene base = scene().build();
    const VoxelGrid grid = fitGrid(base.bounds(), 32, 2, size);
    const VoxelMap expected = lab().voxelize(base, grid);
    for (const glm::dvec3 move : {glm::dvec3(1, 0, 0), glm::dvec3(-7, 1024, 33), glm::dvec3(8e6, -8e6, 7654321),
                                  glm::dvec3(-7999999, 3, 8000001)}) {
        const Scene moved = scene().transform(translation(size * move)).build();
        const VoxelGrid movedGrid = fitGrid(moved.bounds(), 32, 2, size);
        EXPECT_EQ(movedGrid.origin, grid.origin + size * move);
        EXPECT_TRUE(lab().voxelize(moved, movedGrid) == expected) << move.x << " " << move.y << " " << move.z;
    }
}

/// Voxels of `map` after `axis[a]` says which axis goes to axis a, and `mirror` which of the new axes are turned round.
Cell carried(const Cell& cell, const glm::ivec3& axis, const glm::bvec3& mirror, int resolution) {
    Cell out;
    for (int a = 0; a < 3; ++a) {
        const int value = cell[static_cast<std::size_t>(axis[a])];
        out[static_cast<std::size_t>(a)] = mirror[a] ? resolution - 1 - value : value;
    }
    return out;
}

TEST_F(VoxelInvariance, PermutedAndMirroredAxes) {
    const VoxelGrid grid{32, 0.125, glm::dvec3(-2)};
    // Off the lattice: half-open cells are not symmetric for a vertex that lies in the face of a voxel.
    const glm::dmat4 aside = translation({0.0137, 0.0071, 0.0219});
    const VoxelMap base = lab().voxelize(scene().transform(aside).build(), grid);
    double worst = 0;
    for (const glm::ivec3 axis : {glm::ivec3(0, 1, 2), glm::ivec3(1, 2, 0), glm::ivec3(2, 0, 1), glm::ivec3(1, 0, 2)}) {
        for (int signs = 0; signs < 8; ++signs) {
            const glm::bvec3 mirror((signs & 1) != 0, (signs & 2) != 0, (signs & 4) != 0);
            glm::dmat4 matrix(0);
            matrix[3][3] = 1;
            for (int a = 0; a < 3; ++a) matrix[axis[a]][a] = mirror[a] ? -1 : 1;
            const VoxelMap turned = lab().voxelize(scene().transform(matrix * aside).build(), grid);
            EXPECT_EQ(turned.voxels.size(), base.voxels.size());
            for (const auto& [cell, faces] : base.voxels) {
                const auto found = turned.voxels.find(carried(cell, axis, mirror, 32));
                ASSERT_TRUE(found != turned.voxels.end()) << signs;
                for (int a = 0; a < 3; ++a) {
                    for (int side = 0; side < 2; ++side) {
                        const auto from = static_cast<std::size_t>(2 * axis[a] + side);
                        const auto to = static_cast<std::size_t>(2 * a + (side ^ static_cast<int>(mirror[a])));
                        worst = std::max(
                            worst, std::abs(static_cast<double>(faces[from].coverage - found->second[to].coverage)));
                    }
                }
            }
        }
    }
    std::printf("permuted and mirrored: coverage differs by %.1e at most (a fixed-point step is %.1e)\n", worst,
                0x1p-15);
    // Every triangle in a voxel is rounded by a step at most; some twenty meet in a voxel of the sphere. Either result
    // is stored to ten bits.
    EXPECT_LT(worst, 20 * 0x1p-15 + 2 * kCoverageRounding);
}

}  // namespace
}  // namespace voxcone
