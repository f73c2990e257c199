// The voxels depend on the scene alone: not on the order of drawing, nor on how many fragments fall into one, nor on
// how the sums are split over buffers.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <random>

#include "voxelize_lab.h"

namespace voxcone {
namespace {

using namespace test;

class VoxelOrder : public GlTest {};

/// Bodies and sheets that cross, coplanar duplicates of other colours, emitters.
Scene crowded() {
    SceneBuilder builder;
    builder.add(sphere(6, 3), lambert({0.8f, 0.3f, 0.1f}), translation({14.3, 15.1, 16.7}));
    builder.add(sphere(5, 2), lambert({0.1f, 0.6f, 0.9f}, {0, 20, 3}), translation({17.3, 14.1, 15.7}));
    for (const float shade : {0.1f, 0.5f, 0.9f})
        builder.add(quad(20, 20, 5), lambert({shade, 1 - shade, 0.4f}, glm::vec3(shade)),
                    translation({16, 9, 16}) * rotation(20, {1, 0, 0.3}));
    builder.add(box({9, 3, 5}), glossy({0.9f, 0.7f, 0.2f}, 1, 0.4f),
                translation({16, 20, 15}) * rotation(33, {1, 2, 3}));
    return builder.build();
}

Scene shuffled(Scene scene, unsigned seed) {
    std::mt19937 random(seed);
    for (Mesh& mesh : scene.meshes) {
        std::vector<std::size_t> order(mesh.indices.size() / 3);
        for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
        std::shuffle(order.begin(), order.end(), random);
        Mesh copy = mesh;
        for (std::size_t i = 0; i < order.size(); ++i) {
            for (std::size_t k = 0; k < 3; ++k) mesh.indices[3 * i + k] = copy.indices[3 * order[i] + k];
            mesh.closed[i] = copy.closed[order[i]];
        }
    }
    std::shuffle(scene.instances.begin(), scene.instances.end(), random);
    return scene;
}

TEST_F(VoxelOrder, TheSameVoxelsBitForBit) {
    const Scene scene = crowded();
    for (const VoxelCoverage coverage : {VoxelCoverage::area, VoxelCoverage::binary}) {
        VoxelizeLab lab(voxelSettings(32, coverage), scene);
        const VoxelMap first = lab.voxelize(scene, unitGrid(32));
        EXPECT_GT(first.voxels.size(), 500u);
        EXPECT_EQ(first.counters.saturated, 0u);
        EXPECT_TRUE(lab.voxelize(scene, unitGrid(32)) == first) << "again";
        EXPECT_TRUE(lab.voxelize(scene, unitGrid(32), true) == first) << "reversed";
        for (const unsigned seed : {1u, 2u}) {
            const Scene other = shuffled(scene, seed);
            const VoxelMap map = lab.voxelize(other, unitGrid(32));
            EXPECT_TRUE(map == first) << "shuffled";
            EXPECT_EQ(map.counters.fragments, first.counters.fragments);
        }
    }
}

TEST_F(VoxelOrder, PartsOfTheSumsMakeTheSameVoxels) {
    const Scene scene = crowded();
    VoxelizeLab lab(voxelSettings(32), scene);
    const VoxelMap whole = lab.voxelize(scene, unitGrid(32));
    const std::int64_t recordBytes = 6 * 4 * faceWords(false, true, false);
    for (const std::int64_t records : {std::int64_t{400}, std::int64_t{97}}) {
        lab.voxelizer().limitRecordBytes(records * recordBytes + 5);
        const VoxelMap parts = lab.voxelize(scene, unitGrid(32));
        EXPECT_TRUE(parts == whole) << records;
        EXPECT_EQ(parts.counters.fragments, whole.counters.fragments);
    }
}

/// `layers` triangles on each other, half in one colour and half in another; each fills the voxel (4, 4, 4).
/// Seen from above alone when `closed`.
Scene pile(int layers, const glm::vec3& first, const glm::vec3& second, bool emission, bool closed) {
    SceneBuilder builder;
    for (const glm::vec3& color : {first, second}) {
        Mesh mesh = triangleMesh({{glm::vec3(4, 4.25f, 4), {4, 4.25f, 6}, {6, 4.25f, 4}}});
        for (int i = 1; i < layers / 2; ++i) mesh.indices.insert(mesh.indices.end(), {0u, 1u, 2u});
        mesh.closed.assign(mesh.indices.size() / 3, closed);
        builder.add(mesh, lambert(color, (emission ? 3.0f : 0.0f) * color));
    }
    return builder.build();
}

/// Settings for long piles: plain rasterisation runs fewer fragments in the voxels around, which are not looked at.
Settings quickSettings() {
    Settings settings = voxelSettings(16);
    settings.voxel.conservative = false;
    return settings;
}

TEST_F(VoxelOrder, ManyFragmentsHaveTheExactMean) {
    const glm::vec3 a(0.9f, 0.2f, 0.05f), b(0.1f, 0.6f, 0.95f), mean = 0.5f * (a + b);
    for (const int layers : {2, 300, 3000, 100'002}) {
        const bool many = layers > 3000;  // a long run: one side, without emission
        const Scene scene = pile(layers, a, b, !many, many);
        const VoxelMap map = voxelizeOnce(scene, unitGrid(16), many ? quickSettings() : voxelSettings(16));
        EXPECT_EQ(map.counters.saturated, 0u);
        EXPECT_GE(map.counters.fragments, static_cast<std::uint32_t>(layers));
        for (std::size_t f = 2; f < (many ? 3u : 4u); ++f) {
            const VoxelFace& face = map.at(4, 4, 4)[f];
            EXPECT_EQ(face.coverage, 1);
            const float front = f == 2 && !many ? 1.0f : 0.0f;
            double worst = 0;
            for (int c = 0; c < 3; ++c) {
                EXPECT_NEAR(face.albedo()[c], mean[c], 1e-3) << layers;
                // Shared exponent: half a step is 1/512 of the largest channel.
                EXPECT_NEAR(face.emission()[c], front * 3 * mean[c], 3 * 0.6 / 256) << layers;
                worst = std::max(worst, std::abs(static_cast<double>(face.albedo()[c] - mean[c])));
            }
            EXPECT_NEAR(face.normal().y, f == 2 ? 1 : -1, 1e-3);
            EXPECT_LT(glm::distance(face.position(), glm::vec3(0.5f, 0.25f, 0.5f)), 2e-3f);
            if (f == 2) std::printf("%d layers: albedo off by %.1e\n", layers, worst);
        }
    }
}

TEST_F(VoxelOrder, BeyondTheBoundItSaturatesAndCounts) {
    const glm::vec3 a(0.9f, 0.2f, 0.05f), b(0.1f, 0.6f, 0.95f);
    const int layers = 108'000, bound = 106'496;
    const VoxelMap map = voxelizeOnce(pile(layers, a, b, false, true), unitGrid(16), quickSettings());
    // Additions that run together at the bound may be a few more.
    EXPECT_NEAR(map.counters.saturated, layers - bound, 64);
    const VoxelFace& face = map.at(4, 4, 4)[2];
    EXPECT_EQ(face.coverage, 1);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(face.albedo()[c], 0.5f * (a[c] + b[c]), 0.06f) << "both colours count";
    EXPECT_NEAR(face.normal().y, 1, 1e-3);
    EXPECT_LT(glm::distance(face.position(), glm::vec3(0.5f, 0.25f, 0.5f)), 2e-3f);
}

TEST_F(VoxelOrder, IsotropicStorageKeepsOneOpacity) {
    const Scene scene = crowded();
    Settings settings = voxelSettings(32);
    const VoxelMap sixFace = voxelizeOnce(scene, unitGrid(32), settings);
    settings.voxel.storage = VoxelStorage::isotropic;
    VoxelizeLab lab(settings, scene);
    const Voxels voxels = lab.run(scene, unitGrid(32));
    EXPECT_FALSE(voxels.sixFace());
    EXPECT_FALSE(voxels.coverageNegative);
    EXPECT_TRUE(readVoxels(voxels) == sixFace);

    const ClipmapVolume shape(voxels.layout, 1);
    const std::vector<float> found = voxels.coveragePositive.readFloats();
    const auto opacity = [&](const glm::ivec3& i, int level) {
        const glm::ivec3 texel = shape.texel(i, level);
        return static_cast<double>(
            found[4 * static_cast<std::size_t>(texel.x + shape.size().x * (texel.y + shape.size().y * texel.z))]);
    };
    for (int level = 0; level < voxels.layout.count(); ++level)
        for (int z = 0; z < 32 >> level; ++z)
            for (int y = 0; y < 32 >> level; ++y)
                for (int x = 0; x < 32 >> level; ++x) {
                    double expected = 0;
                    if (level > 0) {
                        for (int k = 0; k < 8; ++k)
                            expected +=
                                opacity({2 * x + (k & 1), 2 * y + ((k >> 1) & 1), 2 * z + (k >> 2)}, level - 1) / 8;
                    } else if (sixFace.has(x, y, z)) {
                        for (const VoxelFace& face : sixFace.at(x, y, z))
                            expected = std::max(expected, static_cast<double>(face.coverage));
                    }
                    ASSERT_NEAR(opacity({x, y, z}, level), expected, kCoverageRounding) << level;
                }
}

TEST_F(VoxelOrder, CompareAndSwapFindsTheSameVoxels) {
    const Scene scene = crowded();
    const VoxelMap sums = voxelizeOnce(scene, unitGrid(32), voxelSettings(32));
    const VoxelMap swaps =
        voxelizeOnce(scene, unitGrid(32), voxelSettings(32, VoxelCoverage::binary, VoxelAveraging::compare_and_swap));
    ASSERT_EQ(swaps.voxels.size(), sums.voxels.size());
    double albedo = 0, emission = 0, normal = 0;
    int faces = 0;
    for (const auto& [cell, one] : sums.voxels) {
        ASSERT_TRUE(swaps.voxels.contains(cell));
        const VoxelFaces& other = swaps.voxels.at(cell);
        for (std::size_t f = 0; f < 6; ++f) {
            if (one[f].coverage < 0.3f) continue;
            ASSERT_TRUE(other[f].held());
            EXPECT_EQ(other[f].coverage, 1);
            ++faces;
            albedo += static_cast<double>(glm::distance(one[f].albedo(), other[f].albedo()));
            emission += static_cast<double>(glm::distance(one[f].emission(), other[f].emission()));
            normal += static_cast<double>(glm::distance(one[f].normal(), other[f].normal()));
        }
    }
    std::printf("compare and swap against sums over %d faces: albedo %.4f, normal %.4f, emission %.4f (of 20)\n", faces,
                albedo / faces, normal / faces, emission / faces);
    // One mean is weighted by area and one is not: they agree on the whole, not face by face.
    EXPECT_LT(albedo / faces, 0.05);
    EXPECT_LT(normal / faces, 0.1);
    EXPECT_LT(emission / faces, 1.0);
}

TEST_F(VoxelOrder, CompareAndSwapStopsAt255) {
    const glm::vec3 a(0.9f, 0.2f, 0.05f), b(0.1f, 0.6f, 0.95f);
    const VoxelMap map = voxelizeOnce(pile(2000, a, b, true, false), unitGrid(16),
                                      voxelSettings(16, VoxelCoverage::binary, VoxelAveraging::compare_and_swap));
    const glm::vec3 albedo = map.at(4, 4, 4)[2].albedo();
    for (int c = 0; c < 3; ++c) {
        EXPECT_GE(albedo[c], std::min(a[c], b[c]) - 0.005f);
        EXPECT_LE(albedo[c], std::max(a[c], b[c]) + 0.005f);
    }
}

}  // namespace
}  // namespace voxcone
