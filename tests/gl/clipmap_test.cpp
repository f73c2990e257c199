// The clipmap's voxels depend on scene, time and camera alone: an update of what has changed gives, bit for bit, what
// voxelizing from nothing gives.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <random>
#include <set>

#include "gl/gpu_scene.h"
#include "support/shapes.h"
#include "support/voxel_lab.h"

namespace voxcone::test {
namespace {

/// Voxels of 1/16 m in three levels of 32: windows of 2, 4 and 8 m.
Settings clipmapSettings(int snap = 4) {
    Settings settings;
    settings.voxel.resolution = 32;
    settings.voxel.size = 1.0 / 16;
    settings.cascade.levels = 3;
    settings.cascade.snap = snap;
    return settings;
}
constexpr double kVoxel = 1.0 / 16;

const gl::ShaderLibrary& shaders() {
    static const gl::ShaderLibrary library;
    return library;
}

/// Bodies, sheets and an emitter; with a ground of 14 m the last level moves too, with one of 5 m it stays.
SceneBuilder courtyard(double ground) {
    SceneBuilder builder;
    builder.add(quad(ground, ground, 8), lambert({0.6f, 0.5f, 0.4f}), translation({0.02, -0.63, 0.01}));
    builder.add(sphere(0.8, 3), lambert({0.8f, 0.3f, 0.1f}, {0, 2, 0}), translation({0.25, 0.4, -0.3}));
    builder.add(box({0.8, 0.3, 0.5}), glossy({0.9f, 0.7f, 0.2f}, 1, 0.4f),
                translation({-1.5, 0.2, 0.6}) * rotation(33, {1, 2, 3}));
    builder.add(quad(1.5, 1.5, 3), lambert(0.4f), translation({1.4, 0.5, 1.1}) * rotation(77, {1, 0.2, 0.3}));
    return builder;
}

/// Adds a sphere on a node that moves through the others from (-1, 0.3, 0.3) to (1, 0.5, 0.3) within a second, and
/// stays there.
Scene withMovingSphere(Scene scene) {
    const Scene sphere_ = oneObject(sphere(0.4, 3), lambert({0.2f, 0.3f, 0.9f}, {1, 0, 0.5f}));
    Mesh mesh = sphere_.meshes[0];
    mesh.material = static_cast<int>(scene.materials.size());
    scene.materials.push_back(sphere_.materials[0]);
    const int node = static_cast<int>(scene.nodes.size());
    scene.nodes.emplace_back();
    scene.instances.push_back({static_cast<int>(scene.meshes.size()), node, -1});
    scene.meshes.push_back(std::move(mesh));
    AnimationChannel channel;
    channel.node = node;
    channel.property = AnimatedProperty::translation;
    channel.times = {0, 1};
    channel.values = {glm::vec4(-1, 0.3f, 0.3f, 0), glm::vec4(1, 0.5f, 0.3f, 0)};
    scene.animations.push_back({"", {channel}});
    return scene;
}

/// All that cones read: records, and the texels of the coverage volumes with mips and borders.
struct Snapshot {
    std::map<VoxelName, VoxelFaces> records;
    std::vector<float> positive, negative;

    explicit Snapshot(const Voxels& voxels)
        : records(readRecords(voxels)), positive(voxels.coveragePositive.readFloats()) {
        if (voxels.sixFace()) negative = voxels.coverageNegative.readFloats();
    }
    int count(int level, bool moving = false) const {
        return static_cast<int>(std::count_if(records.begin(), records.end(), [&](const auto& record) {
            return record.first[0] == level && record.first[1] == static_cast<int>(moving);
        }));
    }
};

void expectSame(const Snapshot& a, const Snapshot& b) {
    std::map<int, int> different;  // by level
    for (const auto& [name, faces] : a.records) {
        const auto found = b.records.find(name);
        different[name[0]] += found == b.records.end() || found->second != faces;
    }
    for (const auto& [name, faces] : b.records) different[name[0]] += !a.records.contains(name);
    for (const auto& [level, count] : different) EXPECT_EQ(count, 0) << "records of level " << level;
    const auto texels = [](const std::vector<float>& x, const std::vector<float>& y) {
        EXPECT_EQ(x.size(), y.size());
        int count = 0;
        for (std::size_t i = 0; i < std::min(x.size(), y.size()); ++i) count += x[i] != y[i];
        return count;
    };
    EXPECT_EQ(texels(a.positive, b.positive), 0);
    EXPECT_EQ(texels(a.negative, b.negative), 0);
}

class Clipmap : public GlTest {
  protected:
    std::mt19937 random_{3};
    double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
    glm::dvec3 point(double reach) { return {uniform(-reach, reach), uniform(-reach, reach), uniform(-reach, reach)}; }
};

TEST_F(Clipmap, VolumesHoldBothLayersAndRepeatTheirEnds) {
    for (const double ground : {14.0, 5.0}) {
        const Scene scene = withMovingSphere(courtyard(ground).build());
        ClipmapLab lab(glContext(), shaders(), scene, clipmapSettings());
        const ClipmapLayout& layout = lab.layout();
        ASSERT_EQ(layout.levels, 3);
        ASSERT_EQ(layout.fixedLast, ground < 14);
        lab.show({0.37, 0.41, -0.22}, 0.5);
        const Snapshot found(lab.voxels());
        for (int level = 0; level < layout.count(); ++level) EXPECT_GT(found.count(level), 5) << level;

        // Coverage of both layers by face, at most 1.
        std::map<VoxelName, std::array<float, 6>> coverage;
        int shared = 0;
        for (const auto& [name, faces] : found.records) {
            const VoxelName place{name[0], 0, name[2], name[3], name[4]};
            shared += coverage.contains(place);
            std::array<float, 6>& sum = coverage[place];
            for (std::size_t f = 0; f < 6; ++f) sum[f] = std::min(sum[f] + faces[f].coverage, 1.0f);
        }
        EXPECT_GT(shared, 50) << "static and moving geometry do not meet";

        const ClipmapVolume shape(layout, 1);
        const glm::ivec3 size = shape.size();
        std::vector<float> positive(found.positive.size()), negative(found.negative.size());
        for (const auto& [name, faces] : coverage) {
            const glm::ivec3 i(name[2], name[3], name[4]);
            const int level = name[0], edge = layout.resolutionOf(level);
            // Every texel of the level's box with its border that stands for this voxel.
            for (int copy = 0; copy < 27; ++copy) {
                const glm::ivec3 shift = edge * (glm::ivec3(copy % 3, copy / 3 % 3, copy / 9) - 1);
                if (shift != glm::ivec3(0) && level >= layout.firstFixed()) continue;
                const glm::ivec3 inside = toroidal(i, edge) + shift;
                if (glm::any(glm::lessThan(inside, glm::ivec3(-1))) ||
                    glm::any(glm::greaterThan(inside, glm::ivec3(edge))))
                    continue;
                const glm::ivec3 t = shape.levelOrigin(level) + inside;
                const auto at = 4 * static_cast<std::size_t>(t.x + size.x * (t.y + size.y * t.z));
                for (std::size_t a = 0; a < 3; ++a) {
                    positive[at + a] = faces[2 * a];
                    negative[at + a] = faces[2 * a + 1];
                }
            }
            // A mip's surfaces fill half of its children.
            if (level < layout.levels) continue;
            for (std::size_t f = 0; f < 6; ++f) {
                double sum = 0;
                for (int k = 0; k < 8; ++k) {
                    const glm::ivec3 child = 2 * i + glm::ivec3(k & 1, (k >> 1) & 1, k >> 2);
                    const auto there = coverage.find({level - 1, 0, child.x, child.y, child.z});
                    if (there != coverage.end()) sum += static_cast<double>(there->second[f]);
                }
                ASSERT_NEAR(faces[f], std::min(sum / 4, 1.0), kCoverageRounding) << level;
            }
        }
        for (std::size_t i = 0; i < positive.size(); ++i) {
            ASSERT_NEAR(found.positive[i], positive[i], 1e-6) << i;
            ASSERT_NEAR(found.negative[i], negative[i], 1e-6) << i;
        }
    }
}

TEST_F(Clipmap, MovesBySnapsAndBackChangeNothing) {
    for (const double ground : {14.0, 5.0}) {
        const Scene scene = courtyard(ground).build();
        for (const int snap : {1, 4, 8}) {
            ClipmapLab lab(glContext(), shaders(), scene, clipmapSettings(snap));
            const glm::dvec3 start(0.11, 0.23, -0.17);
            lab.show(start);
            const Snapshot first(lab.voxels());
            for (int axis = 0; axis < 3; ++axis)
                for (const double sign : {1.0, -1.0}) {
                    glm::dvec3 eye = start;
                    eye[axis] += sign * snap * kVoxel;
                    lab.show(eye);
                    const Snapshot moved(lab.voxels());
                    expectSame(moved, Snapshot(lab.anew()));
                    // What both windows hold has kept its bits and its texels.
                    int kept = 0;
                    for (const auto& [name, faces] : first.records) {
                        const auto found = moved.records.find(name);
                        const VoxelBox& window = lab.voxels().windows[static_cast<std::size_t>(name[0])];
                        if (!window.contains({name[2], name[3], name[4]})) continue;
                        ASSERT_TRUE(found != moved.records.end());
                        ASSERT_TRUE(found->second == faces);
                        ++kept;
                    }
                    EXPECT_GT(kept, 1000);
                    lab.show(start);
                    expectSame(Snapshot(lab.voxels()), first);
                }
        }
    }
}

TEST_F(Clipmap, RandomWalksGiveTheVoxelsOfTheirEnd) {
    for (const double ground : {14.0, 5.0}) {
        const Scene scene = courtyard(ground).build();
        for (const int snap : {1, 4, 8}) {
            ClipmapLab lab(glContext(), shaders(), scene, clipmapSettings(snap));
            glm::dvec3 eye(0);
            for (int step = 0; step < 12; ++step) {
                // Steps of a snap, of half a window, and jumps that leave nothing of any window.
                eye = step % 6 == 5 ? point(5) : eye + point(step % 3 == 2 ? 1.0 : 0.3);
                lab.show(eye);
                expectSame(Snapshot(lab.voxels()), Snapshot(lab.anew()));
            }
        }
    }
}

TEST_F(Clipmap, OtherStorages) {
    const Scene scene = courtyard(14).build();
    Settings isotropic = clipmapSettings(), binary = clipmapSettings();
    isotropic.voxel.storage = VoxelStorage::isotropic;
    binary.voxel.coverage = VoxelCoverage::binary;
    for (const Settings& settings : {isotropic, binary}) {
        ClipmapLab lab(glContext(), shaders(), scene, settings);
        glm::dvec3 eye(0);
        for (int step = 0; step < 4; ++step) {
            lab.show(eye += point(0.6));
            expectSame(Snapshot(lab.voxels()), Snapshot(lab.anew()));
        }
    }
}

TEST_F(Clipmap, APlaceFarAwayHasTheSameVoxels) {
    const glm::dvec3 eye(0.37, 0.41, -0.22);
    for (const double ground : {14.0, 5.0}) {
        const auto voxelsAt = [&](const glm::dvec3& offset) {
            const Scene scene = courtyard(ground).transform(translation(offset)).build();
            ClipmapLab lab(glContext(), shaders(), scene, clipmapSettings());
            lab.show(eye + offset + glm::dvec3(0.3));
            lab.show(eye + offset);
            return Snapshot(lab.voxels());
        };
        const Snapshot here = voxelsAt(glm::dvec3(0));
        const double coarsest = 32 * kVoxel;  // the edge of the third mip's voxels
        for (const glm::dvec3& steps :
             {glm::dvec3(1, 0, 0), glm::dvec3(-3, 2, 5), glm::dvec3(1e6, -1e6, 1), glm::dvec3(-1e6, 3, 999'999)})
            expectSame(voxelsAt(coarsest * steps), here);
    }
}

TEST_F(Clipmap, TheOriginFollowsThroughALargeScene) {
    // Some houses along a road of 5 km: more voxels than floats tell apart.
    SceneBuilder builder = courtyard(14);
    builder.add(quad(5000, 10, 100), lambert(0.3f), translation({0, -0.7, 0}));
    for (int i = -5; i <= 5; ++i)
        builder.add(box({1, 1, 1}), lambert(0.8f), translation({400.0 * i + 1, 0.1, 0.3}) * rotation(40, {1, 2, 3}));
    const Scene scene = builder.build();
    ClipmapLab lab(glContext(), shaders(), scene, clipmapSettings());
    const glm::dvec3 start(0.37, -0.1, -0.22);
    lab.show(start);
    const Snapshot first(lab.voxels());
    std::set<double> origins;
    for (const double x : {3.0, 400.0, 401.0, -1200.0, 2000.0, 100.0}) {
        lab.show(start + glm::dvec3(x, 0, 0));
        origins.insert(lab.voxels().origin.x);
        // Indices stay small: a float tells 1/512 of a voxel apart.
        EXPECT_LT(std::abs(lab.voxels().center.x) / kVoxel, 1 << 14);
        const Snapshot found(lab.voxels());
        EXPECT_GT(found.count(0), 100) << x;
        expectSame(found, Snapshot(lab.anew()));
    }
    EXPECT_GT(origins.size(), 2u);
    lab.show(start);
    expectSame(Snapshot(lab.voxels()), first);
}

TEST_F(Clipmap, ScaledByPowersOfTwo) {
    const glm::dvec3 eye(0.37, 0.41, -0.22);
    const auto voxelsAt = [&](double scale) {
        const Scene scene = courtyard(14).transform(scaling(glm::dvec3(scale))).build();
        Settings settings = clipmapSettings();
        settings.voxel.size *= scale;
        ClipmapLab lab(glContext(), shaders(), scene, settings);
        lab.show(scale * (eye + 0.3));
        lab.show(scale * eye);
        return Snapshot(lab.voxels());
    };
    const Snapshot one = voxelsAt(1);
    for (const int k : {-13, -1, 3, 20}) expectSame(voxelsAt(std::exp2(k)), one);
}

TEST_F(Clipmap, MovingGeometryGivesTheVoxelsOfItsTime) {
    for (const double ground : {14.0, 5.0}) {
        const Scene scene = withMovingSphere(courtyard(ground).build());
        for (const int snap : {1, 4, 8}) {
            ClipmapLab lab(glContext(), shaders(), scene, clipmapSettings(snap));
            glm::dvec3 eye(-0.3, 0.4, 0.8);
            lab.show(eye);
            EXPECT_GT(Snapshot(lab.voxels()).count(0, true), 100);
            for (const double time : {0.02, 1.0, 0.0}) {
                lab.show(eye, time);
                expectSame(Snapshot(lab.voxels()), Snapshot(lab.anew()));
                // Camera and geometry at once.
                lab.show(eye += point(0.4), time + 0.3);
                expectSame(Snapshot(lab.voxels()), Snapshot(lab.anew()));
            }
        }
    }
}

TEST_F(Clipmap, StaticRecordsKeepTheirSlots) {
    const Scene scene = withMovingSphere(courtyard(14).build());
    ClipmapLab lab(glContext(), shaders(), scene, clipmapSettings());
    const glm::dvec3 eye(-0.3, 0.4, 0.8);
    lab.show(eye);
    const auto surfaces = [&](bool moving) {
        std::map<VoxelName, std::uint32_t> out;
        for (const auto& [name, slot] : readSlots(lab.voxels()))
            if (name[0] < lab.layout().levels && name[1] == static_cast<int>(moving)) out[name] = slot;
        return out;
    };
    const auto before = surfaces(false), movingBefore = surfaces(true);
    std::uint32_t most = lab.voxels().slots;
    for (const double time : {0.1, 0.5, 1.0, 0.7, 0.0}) {
        lab.show(eye, time);
        EXPECT_EQ(surfaces(false), before) << time;
        if (time > 0) {
            EXPECT_NE(surfaces(true), movingBefore) << time;
        }
        EXPECT_GT(lab.voxels().freshCount, 0u);
        // Slots that one place of the sphere leaves serve the next.
        EXPECT_LT(lab.voxels().slots, most + most / 10);
        most = std::max(most, lab.voxels().slots);
    }
    lab.show(eye, 0.0);
    EXPECT_EQ(lab.voxels().freshCount, 0u) << "nothing has moved";
}

TEST_F(Clipmap, SlotsComeBack) {
    // readSlots() counts what is in use; a camera that goes round and round needs no more slots than once.
    const Scene scene = courtyard(14).build();
    ClipmapLab lab(glContext(), shaders(), scene, clipmapSettings());
    std::uint32_t most = 0, occupied = 0;
    for (int round = 0; round < 3; ++round)
        for (const glm::dvec3& eye : {glm::dvec3(0), glm::dvec3(1, 0, 0), glm::dvec3(1, 0, 1), glm::dvec3(0, 0.5, 1)}) {
            lab.show(eye);
            EXPECT_EQ(readSlots(lab.voxels()).size(), lab.voxels().occupied());
            if (round == 0) most = std::max(most, lab.voxels().slots);
            if (round == 0) occupied = std::max(occupied, lab.voxels().occupied());
            EXPECT_LE(lab.voxels().slots, most);
        }
    EXPECT_EQ(most, occupied) << "free slots are taken before new ones";
}

TEST_F(Clipmap, NothingThereLeavesNothing) {
    const Scene scene = courtyard(14).build();
    ClipmapLab lab(glContext(), shaders(), scene, clipmapSettings());
    // Above everything, but the last level still reaches the ground: 4 m around the camera.
    lab.show({0, 3, 0});
    const Snapshot above(lab.voxels());
    EXPECT_EQ(above.count(0), 0);
    EXPECT_GT(above.count(2), 0);
    for (const glm::dvec3& eye : {glm::dvec3(0, 40, 0), glm::dvec3(-1e5, 1e5, 3), glm::dvec3(1e30, -1e30, 1e30)}) {
        lab.show(eye);
        EXPECT_EQ(lab.voxels().occupied(), 0u);
        const Snapshot far(lab.voxels());
        EXPECT_TRUE(far.records.empty());
        EXPECT_TRUE(std::all_of(far.positive.begin(), far.positive.end(), [](float c) { return c == 0; }));
        EXPECT_TRUE(std::all_of(far.negative.begin(), far.negative.end(), [](float c) { return c == 0; }));
    }
    lab.show({0, 3, 0});
    expectSame(Snapshot(lab.voxels()), above);
}

TEST_F(Clipmap, AMoveDrawsFewerTriangles) {
    const Scene scene = courtyard(14).build();
    for (const int snap : {1, 4}) {
        ClipmapLab lab(glContext(), shaders(), scene, clipmapSettings(snap));
        lab.show({0.11, 0.23, -0.17});
        const std::uint64_t all = lab.voxels().trianglesDrawn;
        lab.show({0.11 + snap * kVoxel, 0.23, -0.17});
        const std::uint64_t moved = lab.voxels().trianglesDrawn;
        std::printf("snap %d: a move draws %llu of %llu triangles\n", snap, static_cast<unsigned long long>(moved),
                    static_cast<unsigned long long>(all));
        EXPECT_LT(moved, all);
        lab.show({0.11 + snap * kVoxel, 0.23, -0.17});
        EXPECT_EQ(lab.voxels().trianglesDrawn, 0u) << "nothing has moved";
    }
}

}  // namespace
}  // namespace voxcone::test
