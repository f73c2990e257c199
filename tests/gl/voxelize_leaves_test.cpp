// Leaves are kept apart from what is solid: their depth against closed forms, the same bits by any way, and coverage of
// cut-out textures in every mip.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>

#include "voxelize_lab.h"

namespace voxcone {
namespace {

using namespace test;

Material leaf(float opacity = 1, const glm::vec3& emission = glm::vec3(0)) {
    Material material = lambert({0.2f, 0.6f, 0.1f}, emission);
    material.baseColor.a = opacity;
    material.alphaMode = AlphaMode::blend;
    material.matter = Matter::leaves;
    return material;
}

/// A sheet that covers 8×8 whole voxels at y = 8 of unitGrid(16), in triangles of 2 m.
Scene sheet(const Material& material) {
    return oneObject(quad(8, 8, 4), material, translation({8, 8.5, 8}));
}

/// What the filtered volumes and the records hold.
struct Stored {
    std::vector<float> positive, negative, leaves;
    std::map<VoxelName, std::array<std::uint32_t, 4>> matter;
    bool operator==(const Stored&) const = default;

    explicit Stored(const Voxels& voxels)
        : positive(voxels.coveragePositive.readFloats()),
          negative(voxels.coverageNegative.readFloats()),
          leaves(voxels.leafDepth.readFloats()) {
        const auto words = voxels.matter.read<glm::uvec4>(0, voxels.slots);
        for (const auto& [name, slot] : readSlots(voxels)) {
            const glm::uvec4& w = words[slot];
            matter[name] = {w.x, w.y, w.z, w.w};
        }
    }
};

/// Walls and a thicket of leaves that meet.
SceneBuilder garden(bool walls, bool thicket) {
    std::mt19937 random(5);
    const auto uniform = [&](double low, double high) {
        return std::uniform_real_distribution<double>(low, high)(random);
    };
    SceneBuilder builder;
    if (walls) {
        builder.add(box({14, 1.3, 14}), lambert(0.5f), translation({8.1, 3.2, 7.9}));
        builder.add(quad(9, 9, 3), lambert({0.8f, 0.3f, 0.2f}), translation({8, 8, 8}) * rotation(77, {1, 0.2, 0.3}));
    }
    std::vector<Triangle> triangles;
    for (int i = 0; i < 600; ++i) {
        const glm::vec3 middle(uniform(1, 15), uniform(2, 13), uniform(1, 15));
        Triangle t;
        for (glm::vec3& corner : t) corner = middle + glm::vec3(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1));
        triangles.push_back(t);
    }
    if (thicket) builder.add(triangleMesh(triangles), leaf(0.8f));
    return builder;
}

class VoxelLeaves : public GlTest {
  protected:
    static VoxelizeLab& lab() {
        static const Scene model = oneObject(quad(1, 1), leaf());
        static VoxelizeLab lab(voxelSettings(16), model);
        return lab;
    }
    static Voxels run(const Scene& scene) { return lab().run(scene, unitGrid(16)); }
};

TEST_F(VoxelLeaves, SolidsAndLeavesDoNotTouchEachOther) {
    const Scene walls = garden(true, false).build();
    const Voxels both = run(garden(true, true).build()), solid = run(walls), leaves = run(garden(false, true).build());
    EXPECT_GT(both.counters.fragments, solid.counters.fragments + 1000);
    EXPECT_EQ(both.coveragePositive.readFloats(), solid.coveragePositive.readFloats());
    EXPECT_EQ(both.coverageNegative.readFloats(), solid.coverageNegative.readFloats());
    EXPECT_EQ(both.leafDepth.readFloats(), leaves.leafDepth.readFloats());
    // Without leaves nothing of this is made, and the volumes are the same.
    VoxelizeLab plain(voxelSettings(16), walls);
    const Voxels without = plain.run(walls, unitGrid(16));
    EXPECT_FALSE(without.leaves);
    EXPECT_EQ(without.leafDepth.bytes() + without.matter.bytes(), 0u);
    EXPECT_EQ(without.coveragePositive.readFloats(), solid.coveragePositive.readFloats());
    EXPECT_EQ(without.coverageNegative.readFloats(), solid.coverageNegative.readFloats());
    EXPECT_TRUE(readVoxels(without) == readVoxels(solid));
}

TEST_F(VoxelLeaves, OtherSettingsTakeAllMatterForOneKind) {
    const Scene scene = sheet(leaf(0.5f));
    for (const int variant : {0, 1, 2}) {
        Settings settings =
            voxelSettings(16, variant == 0 ? VoxelCoverage::binary : VoxelCoverage::area,
                          variant == 1 ? VoxelAveraging::compare_and_swap : VoxelAveraging::integer_sum);
        if (variant == 2) settings.cone.compositing = Compositing::exponential;
        VoxelizeLab one(settings, scene);
        const Voxels voxels = one.run(scene, unitGrid(16));
        EXPECT_FALSE(voxels.leaves) << variant;
        EXPECT_GT(readVoxels(voxels).at(8, 8, 8)[2].coverage, 0) << variant;
    }
}

TEST_F(VoxelLeaves, DepthIsTheLogarithmOfWhatALeafLetsPass) {
    for (const float opacity : {0.25f, 0.5f, 1.0f}) {
        const double edge = 1 - 0.4 * opacity * opacity;
        const auto depth = [&](double weight) { return -std::log(1 - edge * weight) / edge; };
        // Whole voxels of one triangle, away from the diagonals of the sheet's cells.
        const Voxels full =
            run(oneObject(triangleMesh({{glm::vec3(2, 8.5f, 2), {2, 8.5f, 14}, {14, 8.5f, 2}}}), leaf(opacity)));
        const std::vector<float> found = full.leafDepth.readFloats();
        const ClipmapVolume shape(full.layout, 1);
        const auto at = [&](const glm::ivec3& i, std::size_t axis) {
            const glm::ivec3 t = shape.texel(i, 0), size = shape.size();
            return static_cast<double>(found[3 * static_cast<std::size_t>(t.x + size.x * (t.y + size.y * t.z)) + axis]);
        };
        // The volume keeps 6 bits of a mantissa.
        EXPECT_NEAR(at({4, 8, 4}, 1), depth(static_cast<double>(opacity)), 0.01 * depth(static_cast<double>(opacity)));
        EXPECT_EQ(at({4, 8, 4}, 0), 0);
        EXPECT_EQ(at({4, 8, 4}, 2), 0);
        EXPECT_EQ(at({4, 7, 4}, 1), 0);
        // Small leaves add their areas, and many fill more than a voxel's face.
        std::vector<Triangle> small;
        for (int i = 0; i < 3000; ++i) {
            const float x = 4.1f + 0.025f * static_cast<float>(i % 30),
                        z = 4.1f + 0.025f * static_cast<float>(i / 30 % 30);
            small.push_back({glm::vec3(x, 8.5f, z), {x, 8.5f, z + 0.04f}, {x + 0.04f, 8.5f, z}});
        }
        const Voxels many = run(oneObject(triangleMesh(small), leaf(opacity)));
        const auto matter = Stored(many).matter.at({0, 0, 4, 8, 4});
        const float stored = glm::unpackHalf2x16(matter[2]).y;
        const double area = 3000 * 0.5 * 0.04 * 0.04 * static_cast<double>(opacity);
        EXPECT_NEAR(static_cast<double>(stored), area, 2e-3 * area);
        EXPECT_EQ(matter[0], 0u) << "solid coverage";
        EXPECT_NEAR(static_cast<double>(readVoxels(many).at(4, 8, 4)[2].coverage), std::min(area, 1.0),
                    kCoverageRounding + 1e-4)
            << "coverage by which light is weighted";
    }
}

TEST_F(VoxelLeaves, MipsLetPassTheMean) {
    const Voxels voxels = run(garden(false, true).build());
    const std::vector<float> found = voxels.leafDepth.readFloats();
    const ClipmapVolume shape(voxels.layout, 1);
    const glm::ivec3 size = shape.size();
    ASSERT_EQ(voxels.layout.mips, 2);
    int deep = 0;
    for (int level = 1; level < voxels.layout.count(); ++level) {
        const auto depth = [&](const glm::ivec3& i, int l, int axis) {
            const glm::ivec3 t = shape.texel(i, l);
            return static_cast<double>(found[3 * static_cast<std::size_t>(t.x + size.x * (t.y + size.y * t.z)) +
                                             static_cast<std::size_t>(axis)]);
        };
        const int n = 16 >> level;
        for (int k = 0; k < n * n * n; ++k) {
            const glm::ivec3 i(k % n, k / n % n, k / n / n);
            for (int axis = 0; axis < 3; ++axis) {
                double passed = 0;
                for (int column = 0; column < 4; ++column) {
                    glm::ivec3 near = 2 * i;
                    near[(axis + 1) % 3] += column & 1;
                    near[(axis + 2) % 3] += column >> 1;
                    glm::ivec3 far = near;
                    far[axis] += 1;
                    passed += std::exp(-depth(near, level - 1, axis) - depth(far, level - 1, axis)) / 4;
                }
                const double exact = -std::log(passed);
                // Either is rounded to 6 bits, 5 along z.
                ASSERT_NEAR(depth(i, level, axis), exact, (axis == 2 ? 0.032 : 0.016) * exact + 1e-6)
                    << level << " " << k;
                deep += exact > 0.05;
            }
        }
    }
    EXPECT_GT(deep, 100);
}

TEST_F(VoxelLeaves, TheSameBitsInAnyOrderAndByParts) {
    const Scene scene = garden(true, true).build();
    VoxelizeLab one(voxelSettings(16), scene);
    const Stored whole(one.run(scene, unitGrid(16)));
    EXPECT_TRUE(Stored(one.run(scene, unitGrid(16), true)) == whole) << "reversed";
    one.voxelizer().limitRecordBytes(97 * 6 * 4 * faceWords(false, false, true) + 5);
    EXPECT_TRUE(Stored(one.run(scene, unitGrid(16))) == whole) << "in parts";
}

TEST_F(VoxelLeaves, ACameraThatWalksAndLeavesThatMoveChangeNoBit) {
    // Static and moving leaves and walls, all three of which share voxels.
    Scene scene = garden(true, true).transform(scaling(glm::dvec3(1.0 / 8)) * translation({-8, -8, -8})).build();
    Mesh thicket = scene.meshes.back();
    const int node = static_cast<int>(scene.nodes.size());
    scene.nodes.emplace_back();
    scene.nodes.back().scale = glm::dvec3(1.0 / 24);
    scene.instances.push_back({static_cast<int>(scene.meshes.size()), node, -1});
    scene.meshes.push_back(std::move(thicket));
    AnimationChannel channel;
    channel.node = node;
    channel.property = AnimatedProperty::translation;
    channel.times = {0, 1};
    channel.values = {glm::vec4(-1, -0.5f, -0.3f, 0), glm::vec4(0.6f, 0.2f, 0.1f, 0)};
    scene.animations.push_back({"", {channel}});
    Settings settings;
    settings.voxel.resolution = 16;
    settings.voxel.size = 1.0 / 16;
    settings.cascade.levels = 3;
    for (const bool stays : {true, false}) {
        if (!stays) settings.voxel.size = 1.0 / 40;
        const gl::ShaderLibrary shaders;
        ClipmapLab clipmap(glContext(), shaders, scene, settings);
        ASSERT_EQ(clipmap.layout().fixedLast, stays);
        for (int i = 0; i < 4; ++i) {
            clipmap.show({-0.3 + 0.3 * i, 0.1 * i, 0.2 - 0.13 * i}, 0.3 * i);
            ASSERT_TRUE(clipmap.voxels().leaves && clipmap.voxels().anyMoving());
            const Stored stored(clipmap.voxels());
            EXPECT_TRUE(stored == Stored(clipmap.anew())) << i;
            EXPECT_GT(*std::max_element(stored.leaves.begin(), stored.leaves.end()), 0.5f);
        }
    }
}

// Every mip of a cut-out texture covers what its shapes do, whatever the size of the voxels: a texel's alpha counts by
// which side of the cutoff it is on (MASK) or as it is (BLEND).
TEST_F(VoxelLeaves, CutOutsCoverTheirMeanInEveryMip) {
    struct Case {
        const char* name;
        AlphaMode mode;
        float cutoff;
        int (*alpha)(int x, int y);
    };
    const auto disc = [](int x, int y) {  // soft discs, eight texels apart
        const double r = std::hypot((x & 7) - 3.5, (y & 7) - 3.5);
        return static_cast<int>(255 * std::clamp(1.2 - r / 4, 0.0, 1.0));
    };
    const auto stripes = [](int x, int) { return x % 4 == 0 ? 255 : 90; };
    for (const Case& c :
         {Case{"hard", AlphaMode::mask, 0.5f, [](int x, int y) { return (x ^ y) & 3 ? 0 : 255; }},
          Case{"soft discs", AlphaMode::mask, 0.3f, disc}, Case{"soft discs", AlphaMode::mask, 0.8f, disc},
          Case{"blend", AlphaMode::blend, 0.5f, disc}, Case{"stripes", AlphaMode::mask, 0.5f, stripes}}) {
        const int size = 256;
        Texture texture;
        texture.width = texture.height = size;
        double mean = 0;
        for (int y = 0; y < size; ++y)
            for (int x = 0; x < size; ++x) {
                const int alpha = c.alpha(x, y);
                for (const int value : {90, 160, 40, alpha}) texture.rgba8.push_back(static_cast<std::uint8_t>(value));
                mean += (c.mode == AlphaMode::blend ? alpha / 255.0 : alpha >= 255 * static_cast<double>(c.cutoff)) /
                        (size * size);
            }
        for (const double edge : {16.0, 8.0, 2.0, 0.7}) {  // of the sheet, in voxels: 16 to 366 texels a voxel
            Material material = leaf();
            material.alphaMode = c.mode;
            material.alphaCutoff = c.cutoff;
            Scene scene =
                oneObject(quad(edge, edge), material, translation({16.1, 16.3, 15.8}) * rotation(25, {1, 0.4, 0.2}));
            scene.textures.push_back(texture);
            scene.materials[0].baseColorTexture.texture = 0;
            VoxelizeLab one(voxelSettings(32), scene);
            const Voxels voxels = one.run(scene, unitGrid(32));
            double worst = 0;
            for (int level = 0; level < voxels.layout.count(); ++level) {
                // Faces of a sheet are never full, so that mips keep the sum of what their children cover.
                const VoxelMap map = readVoxels(voxels, level);
                glm::dvec3 sum(0), rounding(0);
                for (const auto& [cell, faces] : map.voxels)
                    for (std::size_t f = 0; f < 6; ++f)
                        sum[static_cast<int>(f / 2)] += 0.5 * static_cast<double>(faces[f].coverage);
                rounding = glm::dvec3(static_cast<double>(map.voxels.size()) * kCoverageRounding);
                const glm::dmat3 turned(rotation(25, {1, 0.4, 0.2}));
                for (int a = 0; a < 3; ++a) {
                    const double exact = edge * edge * std::abs(turned[1][a]) * mean, unit = std::exp2(2 * level);
                    const double slack = (1 + level) * unit * rounding[a];
                    worst = std::max(worst, std::abs(sum[a] * unit - exact) / exact - slack / exact);
                    EXPECT_NEAR(sum[a] * unit, exact, 0.02 * exact + slack)
                        << c.name << " " << edge << " level " << level << " axis " << a;
                }
            }
            std::printf("%s, cutoff %.1f, sheet of %.1f voxels: mean %.3f, worst %+.1e\n", c.name,
                        static_cast<double>(c.cutoff), edge, mean, worst);
        }
    }
}

}  // namespace
}  // namespace voxcone
