// Laws of coverage: areas add up, bodies store one side and sheets two, planes in the faces of voxels have one owner.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <limits>
#include <set>

#include "gl/gpu_scene.h"
#include "voxelize_truth.h"

namespace voxcone {
namespace {

using namespace test;

class VoxelCoverageLaws : public GlTest {
  protected:
    static VoxelizeLab& lab() {
        static const Scene model = oneObject(quad(1, 1), lambert(0.5f));
        static VoxelizeLab lab(voxelSettings(16), model);
        return lab;
    }
    static VoxelMap voxelize(const Scene& scene) { return lab().voxelize(scene, unitGrid(16)); }
};

TEST_F(VoxelCoverageLaws, ProjectedAreasAddUp) {
    // Each triangle alone stays below a full face in every voxel, so that nothing is clamped.
    const std::vector<Triangle> triangles{{glm::vec3(1.3f, 2.1f, 3.7f), {13.9f, 4.4f, 6.1f}, {5.2f, 14.3f, 11.8f}},
                                          {glm::vec3(2, 2, 2), {14, 2, 9.5f}, {2, 14, 4.25f}},
                                          {glm::vec3(0.1f, 8, 8), {15.9f, 8.01f, 8}, {8, 8, 15.7f}}};
    for (const Triangle& t : triangles) {
        const VoxelMap map = voxelize(oneObject(triangleMesh({t}), lambert(0.5f)));
        const glm::dvec3 area = glm::abs(vectorArea({t[0], t[1], t[2]}));
        for (std::size_t f = 0; f < 6; ++f) {
            const double sum = summedCoverage(map, f), exact = area[static_cast<int>(f / 2)];
            // A fixed-point step in each voxel at worst, and their square root on average.
            const double step = std::sqrt(static_cast<double>(map.voxels.size())) * 0x1p-15;
            EXPECT_NEAR(sum, exact, 4 * step + 1e-5 * exact + storageRounding(map, f)) << f;
            std::printf("face %zu: %.6f of %.6f\n", f, sum, exact);
        }
    }
}

TEST_F(VoxelCoverageLaws, BodiesStoreOneSideSheetsBoth) {
    for (const bool closed : {true, false}) {
        Mesh mesh = box({6, 6, 6});
        mesh.closed.assign(mesh.closed.size(), closed);
        const VoxelMap map = voxelize(oneObject(mesh, lambert(0.5f), translation({8.25, 8.25, 8.25})));
        // The +x wall lies at 11.25 with y, z from 5.25 to 11.25; voxel (11, 8, 8) holds nothing else.
        const VoxelFaces& plusX = map.at(11, 8, 8);
        const VoxelFaces& minusX = map.at(5, 8, 8);
        for (std::size_t f = 0; f < 6; ++f) {
            EXPECT_EQ(plusX[f].coverage, f == 0 || (f == 1 && !closed) ? 1 : 0) << closed << f;
            EXPECT_EQ(minusX[f].coverage, f == 1 || (f == 0 && !closed) ? 1 : 0) << closed << f;
            EXPECT_EQ(plusX[f].held(), plusX[f].coverage > 0);
        }
        EXPECT_NEAR(plusX[0].normal().x, 1, 1e-4);
        if (!closed) {
            EXPECT_NEAR(plusX[1].normal().x, -1, 1e-4);
        }
        for (std::size_t f = 0; f < 6; ++f) EXPECT_NEAR(summedCoverage(map, f), closed ? 36 : 72, 1e-2);
        EXPECT_FALSE(map.has(8, 8, 8));
    }
}

TEST_F(VoxelCoverageLaws, AMirroredBodyLooksOutwards) {
    Mesh mesh = box({6, 6, 6});
    const VoxelMap map =
        voxelize(oneObject(mesh, lambert(0.5f), translation({8.25, 8.25, 8.25}) * scaling({-1, 1, 1})));
    EXPECT_EQ(map.at(11, 8, 8)[0].coverage, 1);
    EXPECT_EQ(map.at(11, 8, 8)[1].coverage, 0);
    EXPECT_NEAR(map.at(11, 8, 8)[0].normal().x, 1, 1e-4);
    EXPECT_EQ(map.at(5, 8, 8)[1].coverage, 1);
}

TEST_F(VoxelCoverageLaws, SheetsEmitFromTheirFrontUnlessDoubleSided) {
    for (const bool doubleSided : {false, true}) {
        Material material = lambert(0.5f, 3);
        material.doubleSided = doubleSided;
        const Scene scene = oneObject(quad(8, 8), material, translation({8, 8.5, 8}));
        const VoxelMap map = voxelizeOnce(scene, unitGrid(16), voxelSettings(16));
        const VoxelFaces& faces = map.at(8, 8, 8);
        EXPECT_NEAR(faces[2].emission().x, 3, 0.01);
        EXPECT_NEAR(faces[3].emission().x, doubleSided ? 3 : 0, doubleSided ? 0.01 : 0);
        EXPECT_EQ(faces[2].coverage, 1);
        EXPECT_EQ(faces[3].coverage, 1);
    }
}

TEST_F(VoxelCoverageLaws, APlaneInTheFacesOfVoxelsHasOneOwner) {
    const Mesh sheet = quad(8, 8);
    for (int axis = 0; axis < 3; ++axis) {
        for (const int ulp : {-1, 0, 1}) {
            std::vector<Triangle> triangles;
            const float at = ulp == 0 ? 7.0f : std::nextafter(7.0f, ulp < 0 ? 0.0f : 16.0f);
            for (std::size_t k = 0; k < sheet.indices.size(); k += 3) {
                Triangle t;
                for (std::size_t c = 0; c < 3; ++c) {
                    const glm::vec3 p = sheet.positions[sheet.indices[k + c]] + 8.5f;
                    t[c][axis] = at;
                    t[c][(axis + 1) % 3] = p.z;
                    t[c][(axis + 2) % 3] = p.x;
                }
                triangles.push_back(t);
            }
            const VoxelMap map = voxelize(oneObject(triangleMesh(triangles), lambert(0.5f)));
            std::set<int> layers;
            for (const auto& [cell, faces] : map.voxels) layers.insert(cell[static_cast<std::size_t>(axis)]);
            EXPECT_EQ(layers, (std::set<int>{ulp < 0 ? 6 : 7})) << "axis " << axis << ", " << ulp << " ulp";
            EXPECT_EQ(map.voxels.size(), 81u);
            const auto front = 2 * static_cast<std::size_t>(axis);
            EXPECT_NEAR(summedCoverage(map, front), 64, 1e-2 + storageRounding(map, front));
        }
    }
}

TEST_F(VoxelCoverageLaws, ZeroAreaWritesNothing) {
    const glm::vec3 a(3, 4, 5), b(9, 8, 7);
    const std::vector<std::vector<Triangle>> degenerate{{{a, a, a}},
                                                        {{a, a, b}},
                                                        {{a, b, a}},
                                                        {{b, a, a}},
                                                        {{a, b, 0.5f * (a + b)}},
                                                        {{glm::vec3(1, 1, 1), {2, 2, 2}, {9, 9, 9}}}};
    for (const auto& triangles : degenerate) {
        const VoxelMap map = voxelize(oneObject(triangleMesh(triangles), lambert(0.5f)));
        EXPECT_EQ(map.voxels.size(), 0u);
        EXPECT_EQ(map.counters.fragments, 0u);
    }
    // Flattened by its transform.
    EXPECT_EQ(voxelize(oneObject(quad(4, 4), lambert(0.5f), translation({8, 8, 8}) * scaling({0, 1, 1}))).voxels.size(),
              0u);
}

TEST_F(VoxelCoverageLaws, NothingIsAnEmptySetOfVoxels) {
    EXPECT_EQ(voxelize(Scene()).voxels.size(), 0u);
    // And a scene wholly outside the grid.
    EXPECT_EQ(voxelize(oneObject(quad(4, 4), lambert(0.5f), translation({8, 17, 8}))).voxels.size(), 0u);
    EXPECT_EQ(voxelize(oneObject(quad(4, 4), lambert(0.5f), translation({8, 16, 8}))).voxels.size(), 0u);
    EXPECT_EQ(voxelize(oneObject(quad(4, 4), lambert(0.5f), translation({8, 0, 8}))).voxels.size(), 25u);
    EXPECT_EQ(voxelize(oneObject(quad(4, 4), lambert(0.5f), translation({8, -1e-6, 8}))).voxels.size(), 0u);
}

TEST_F(VoxelCoverageLaws, DuplicatesAddUpToOneFaceAtMost) {
    // Three sheets in the same place, and a half-covered voxel: coverage is summed, then clamped.
    std::vector<Triangle> triangles;
    for (int i = 0; i < 3; ++i) triangles.push_back({glm::vec3(4, 4.5f, 4), {4, 4.5f, 5}, {5, 4.5f, 4}});
    const VoxelMap map = voxelize(oneObject(triangleMesh(triangles), lambert(0.5f)));
    EXPECT_EQ(map.at(4, 4, 4)[2].coverage, 1);
    triangles.pop_back(), triangles.pop_back();
    EXPECT_NEAR(voxelize(oneObject(triangleMesh(triangles), lambert(0.5f))).at(4, 4, 4)[2].coverage, 0.5,
                kCoverageRounding);
}

TEST_F(VoxelCoverageLaws, ABinaryVoxelIsFullHoweverSmallWhatTouchesIt) {
    VoxelizeLab binary(voxelSettings(16, VoxelCoverage::binary), oneObject(quad(1, 1), lambert(0.5f)));
    for (const float size : {0.25f, 1e-6f, 1e-10f, 1e-15f}) {
        for (const bool normals : {true, false}) {
            Mesh mesh = triangleMesh({{glm::vec3(0), {0, 0, size}, {size, 0, 0}}});
            if (!normals) mesh.normals.clear();
            const VoxelMap map = binary.voxelize(oneObject(mesh, lambert(0.25f)), unitGrid(16));
            ASSERT_EQ(map.voxels.size(), 1u) << size;
            const VoxelFaces& faces = map.at(0, 0, 0);
            EXPECT_EQ(faces[2].coverage, 1) << size;
            EXPECT_EQ(faces[3].coverage, 1) << size;
            EXPECT_EQ(faces[0].coverage, 0) << size;
            EXPECT_EQ(faces[4].coverage, 0) << size;
            EXPECT_NEAR(faces[2].albedo().y, 0.25, 1e-3) << size;
            EXPECT_NEAR(faces[2].normal().y, 1, 1e-4) << size;
            EXPECT_NEAR(faces[3].normal().y, -1, 1e-4) << size;
            EXPECT_LT(glm::length(faces[2].position()), size * 2 + 1e-3f) << size;
        }
    }
}

TEST_F(VoxelCoverageLaws, TheVolumesHoldTheCoverageAndItsMips) {
    SceneBuilder builder;
    builder.add(sphere(5, 3), lambert(0.5f), translation({8.1, 7.7, 8.3}));
    builder.add(quad(12, 12), lambert(0.5f), translation({8, 2.5, 8}));
    for (int i = 0; i < 4; ++i) builder.add(quad(4, 4), lambert(0.5f), translation({4, 12.1 + 0.2 * i, 4}));
    const Scene scene = builder.build();
    const Voxels voxels = lab().run(scene, unitGrid(16));
    const ClipmapVolume shape(voxels.layout, 1);
    const std::map<VoxelName, VoxelFaces> records = readRecords(voxels);
    ASSERT_EQ(voxels.layout.mips, 2);
    for (const bool positive : {true, false}) {
        const gl::Texture& volume = positive ? voxels.coveragePositive : voxels.coverageNegative;
        ASSERT_EQ(glm::ivec3(volume.width(), volume.height(), volume.depth()), shape.size());
        const std::vector<float> found = volume.readFloats();
        std::vector<float> expected(found.size(), 0.0f);
        const auto at = [&](const glm::ivec3& texel, std::size_t c) {
            return 4 * static_cast<std::size_t>(texel.x + shape.size().x * (texel.y + shape.size().y * texel.z)) + c;
        };
        for (const auto& [name, faces] : records)
            for (std::size_t a = 0; a < 3; ++a)
                expected[at(shape.texel({name[2], name[3], name[4]}, name[0]), a)] =
                    faces[2 * a + (positive ? 0 : 1)].coverage;
        // Borders too: around a level that stays there is nothing.
        for (std::size_t i = 0; i < found.size(); ++i) ASSERT_NEAR(found[i], expected[i], 1e-6) << i;

        // A surface that crosses a coarse cell fills half of its children: their mean covers half of a coarse face.
        int clamped = 0;
        for (int level = 1; level < voxels.layout.count(); ++level)
            for (int z = 0; z < 16 >> level; ++z)
                for (int y = 0; y < 16 >> level; ++y)
                    for (int x = 0; x < 16 >> level; ++x)
                        for (std::size_t c = 0; c < 3; ++c) {
                            double sum = 0;
                            for (int k = 0; k < 8; ++k) {
                                const glm::ivec3 child =
                                    2 * glm::ivec3(x, y, z) + glm::ivec3(k & 1, (k >> 1) & 1, k >> 2);
                                sum += static_cast<double>(found[at(shape.texel(child, level - 1), c)]);
                            }
                            clamped += sum / 4 > 1;
                            ASSERT_NEAR(found[at(shape.texel({x, y, z}, level), c)], std::min(sum / 4, 1.0),
                                        kCoverageRounding)
                                << level << ": " << x << " " << y << " " << z;
                        }
        EXPECT_GT(clamped, 0) << "the scene does not test the clamp";
    }
}

}  // namespace
}  // namespace voxcone
