// Pictures of voxels against what their records hold: faces, lobes by direction, the light of single bounces.
#include "frame/voxel_view.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "frame/renderer.h"
#include "frame/voxel_slice.h"
#include "support/gl_context.h"
#include "support/shapes.h"

namespace voxcone::test {
namespace {

using VoxelViewTest = GlTest;

constexpr int kSize = 33;  // the middle pixel's ray is the view's axis

Settings small() {
    Settings settings;
    settings.output.width = settings.output.height = kSize;
    settings.voxel.resolution = 16;
    settings.light.shadowResolution = 128;
    settings.light.bounces = 2;
    settings.light.extrapolate = false;
    settings.light.bounceCones = 5;
    settings.cone.diffuse = 1;
    settings.cone.nearField = 0;
    settings.specular.enabled = false;
    return settings;
}

glm::vec3 middle(const Image& image) {
    const float* p = image.pixel(kSize / 2, kSize / 2);
    return {p[0], p[1], p[2]};
}

/// Red light upwards and blue light along +x, which share the voxels of an edge, and white light from below.
Scene corner() {
    return SceneBuilder()
        .add(quad(2, 2), lambert({0.5f, 0.5f, 0.5f}, {2, 0, 0}))
        .add(quad(2, 2), lambert({0.2f, 0.4f, 0.6f}, {0, 0, 1}), translation({-1, 1, 0}) * yTo({1, 0, 0}))
        .sky(glm::vec3(0.5f))
        .build();
}

struct Found {
    VoxelFacts facts;
    glm::dvec3 centre{0};
    double edge = 0;
};

/// A voxel in which both surfaces shine.
Found sharedVoxel(Renderer& renderer) {
    for (int depth = 0; depth < 16; ++depth) {
        const VoxelSlice slice = renderer.voxelSlice(0, 1, depth);
        for (int v = 0; v < slice.height; ++v)
            for (int u = 0; u < slice.width; ++u) {
                const VoxelFacts& facts = slice.at(u, v);
                if (facts.faces[0].coverage < 0.2f || facts.faces[2].coverage < 0.2f) continue;
                if (facts.faces[0].radiance.z < 0.5f || facts.faces[2].radiance.x < 0.5f) continue;
                return {facts, slice.origin + slice.voxelSize * (glm::dvec3(slice.index(u, v)) + 0.5), slice.voxelSize};
            }
    }
    ADD_FAILURE() << "there is no such voxel";
    return {};
}

/// A camera that looks along −n at the voxel's centre from just outside of it: voxels around the eye are not drawn.
Camera besides(const Found& voxel, const glm::dvec3& n) {
    const double most = std::max({std::abs(n.x), std::abs(n.y), std::abs(n.z)});
    return camera(voxel.centre + 0.55 / most * voxel.edge * n, voxel.centre, 45, {0, 0, 1});
}

/// What cones along −n should take of a record (docs/architecture.md, "What a voxel is").
glm::vec3 lobe(const VoxelFacts& facts, VoxelStorage storage, const glm::vec3& n) {
    glm::vec4 sum(0);
    float most = 0;
    for (int f = 0; f < 6; ++f) {
        const VoxelFace& face = facts.faces[static_cast<std::size_t>(f)];
        const float along = f % 2 == 0 ? n[f / 2] : -n[f / 2];
        float weight = face.coverage;
        if (storage == VoxelStorage::sh1) weight *= 0.5f + 0.75f * glm::dot(n, face.normal);
        if (storage == VoxelStorage::six_face) {
            if (along * face.coverage <= most) continue;
            most = along * face.coverage;
            sum = glm::vec4(0);
            weight = 1;
        }
        sum += weight * glm::vec4(face.radiance, 1);
    }
    return glm::max(glm::vec3(sum), glm::vec3(0)) / sum.w;
}

TEST_F(VoxelViewTest, LobesAreWhatConesRead) {
    const Scene scene = corner();
    for (const VoxelStorage storage : {VoxelStorage::six_face, VoxelStorage::isotropic, VoxelStorage::sh1}) {
        Settings settings = small();
        settings.voxel.storage = storage;
        settings.light.bounces = 0;
        Renderer renderer(glContext(), scene, settings);
        renderer.render(camera({3, 3, 3}, {0, 0, 0}));
        const Found voxel = sharedVoxel(renderer);
        // From above, from the side, and obliquely.
        for (const glm::dvec3 n : {glm::dvec3(0, 1, 0), glm::dvec3(1, 0, 0), glm::normalize(glm::dvec3(0.4, 1, 0.1))}) {
            renderer.render(besides(voxel, n));
            const glm::vec3 shown = middle(renderer.channel("voxel_lobes:0"));
            const glm::vec3 wanted = lobe(voxel.facts, storage, glm::vec3(n));
            EXPECT_LT(glm::length(shown - wanted), 4e-3f * glm::length(wanted))
                << static_cast<int>(storage) << ": " << shown.x << " " << shown.y << " " << shown.z << ", not "
                << wanted.x << " " << wanted.y << " " << wanted.z;
        }
    }
}

TEST_F(VoxelViewTest, AFaceIsShownFromWhereverOneLooks) {
    const Scene scene = corner();
    Renderer renderer(glContext(), scene, small());
    renderer.render(camera({3, 3, 3}, {0, 0, 0}));
    const Found voxel = sharedVoxel(renderer);
    renderer.render(besides(voxel, {0, 1, 0}));
    for (std::size_t f = 0; f < 6; ++f) {
        const VoxelFace& face = voxel.facts.faces[f];
        const std::string which = std::string(":") + VoxelChannel::kFaces[f] + ":0";
        EXPECT_EQ(middle(renderer.channel("voxel_opacity" + which)), glm::vec3(face.coverage)) << f;
        if (face.coverage <= 0) continue;
        EXPECT_LT(glm::length(middle(renderer.channel("voxel_albedo" + which)) - face.albedo), 1e-5f);
        EXPECT_LT(glm::length(middle(renderer.channel("voxel_normal" + which)) - face.normal), 1e-5f);
        EXPECT_LT(glm::length(middle(renderer.channel("voxel_radiance" + which)) - face.radiance), 1e-5f);
    }
}

TEST_F(VoxelViewTest, BouncesAddUpToAllLight) {
    const Scene scene = corner();
    for (const int levels : {1, 2}) {
        Settings settings = small();
        settings.cascade.levels = levels;
        Renderer renderer(glContext(), scene, settings);
        const Camera view = camera({1.2, 1.5, 1.4}, {-0.5, 0.3, 0});
        renderer.render(view);
        const auto memory = [&] {
            const auto& all = renderer.stats().memory;
            return std::count_if(all.begin(), all.end(),
                                 [](const auto& item) { return item.name == "voxel radiance of a bounce"; });
        };
        for (const std::string base : {"voxel_radiance", "voxel_lobes"}) {
            const Image all = renderer.channel(base);
            Image sum(kSize, kSize, 3);
            std::vector<double> light;
            for (int n = 0; n <= settings.light.bounces; ++n) {
                const Image one = renderer.channel(base + ":b" + std::to_string(n));
                light.push_back(0);
                for (std::size_t i = 0; i < sum.data.size(); ++i) {
                    sum.data[i] += one.data[i];
                    light.back() += static_cast<double>(one.data[i]);
                }
            }
            for (int n = 1; n <= settings.light.bounces; ++n) {
                EXPECT_GT(light[static_cast<std::size_t>(n)], 0) << base << " " << n;
                EXPECT_LT(light[static_cast<std::size_t>(n)], light[static_cast<std::size_t>(n - 1)])
                    << base << " " << n;
            }
            for (std::size_t i = 0; i < sum.data.size(); ++i)
                ASSERT_NEAR(sum.data[i], all.data[i], 2e-3f + 5e-3f * all.data[i]) << base << " " << levels << " " << i;
        }
        // It is there while it is looked at.
        renderer.render(view);
        EXPECT_EQ(memory(), 1);
        renderer.render(view);
        EXPECT_EQ(memory(), 0);
    }
}

// Walls that emit Le and reflect the share ρ of what they see of each other: bounce n brings Le·ρⁿ.
TEST_F(VoxelViewTest, BouncesInAFurnaceAreAGeometricSeries) {
    const double voxel = 0.1;
    const Scene scene = oneObject(hollowBox({2, 2, 2}, voxel), lambert(0.5f, 1), translation({0.03, 0.04, 0.05}));
    Settings settings = small();
    settings.voxel.resolution = 32;
    settings.light.bounces = 0;  // the renderer's own does not matter
    Renderer renderer(glContext(), scene, settings);
    renderer.render(camera({0, 0, 0}, {0.4, -0.3, 1}));
    for (const int n : {0, 1, 3}) {
        const Image image = renderer.channel("voxel_radiance:b" + std::to_string(n));
        double mean = 0;
        for (const float v : image.data) mean += static_cast<double>(v) / static_cast<double>(image.data.size());
        EXPECT_NEAR(mean, std::pow(0.5, n), 0.02 * std::pow(0.5, n)) << n;
    }
}

}  // namespace
}  // namespace voxcone::test
