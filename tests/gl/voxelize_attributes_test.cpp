// What the voxels say of their surfaces: albedo, normal, place, emission, opacity.
#include <gtest/gtest.h>

#include <cstdio>
#include <random>

#include "scene/brdf.h"
#include "voxelize_truth.h"

namespace voxcone {
namespace {

using namespace test;

class VoxelAttributes : public GlTest {
  protected:
    static VoxelMap voxelize(const Scene& scene, int resolution = 16) {
        return voxelizeOnce(scene, unitGrid(resolution), voxelSettings(resolution));
    }
};

TEST_F(VoxelAttributes, AlbedoIsWhatTheWholeBrdfReflects) {
    const Material materials[] = {lambert({0.8f, 0.3f, 0.05f}), glossy({0.9f, 0.6f, 0.3f}, 1, 0.3f),
                                  glossy({0.5f, 0.5f, 0.9f}, 0, 0.6f), glossy({0.7f, 0.2f, 0.4f}, 0.5f, 0.9f)};
    for (const Material& m : materials) {
        const VoxelMap map = voxelize(oneObject(quad(8, 8), m, translation({8, 8.5, 8})));
        const Surface surface = surfaceFromMaterial(glm::vec3(m.baseColor), m.metallic, m.roughness, m.ior,
                                                    m.specularFactor, m.specularColor);
        const glm::vec3 expected = voxelAlbedo(surface);
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(map.at(8, 8, 8)[2].albedo()[c], expected[c], 1e-3) << m.name;
        EXPECT_TRUE(map.at(8, 8, 8)[3].record.albedo == map.at(8, 8, 8)[2].record.albedo) << "both sides alike";
    }
}

TEST_F(VoxelAttributes, InterpolatedOverTheTriangle) {
    // One triangle with its own normal and colour at each corner: each voxel holds those of the middle of its piece.
    const Triangle t{glm::vec3(1.3f, 4.1f, 2.2f), {4.2f, 8.3f, 14.1f}, {14.6f, 5.2f, 6.9f}};
    Mesh mesh = triangleMesh({t});
    const glm::vec3 plane = mesh.normals[0];
    mesh.normals = {glm::normalize(plane + glm::vec3(0.4f, 0, 0)), glm::normalize(plane + glm::vec3(0, 0.2f, 0.3f)),
                    glm::normalize(plane - glm::vec3(0.2f, 0, 0.1f))};
    mesh.colors = {glm::vec4(1, 0.1f, 0.3f, 1), glm::vec4(0.2f, 0.9f, 0.3f, 1), glm::vec4(0.1f, 0.2f, 1, 1)};
    const VoxelMap map = voxelize(oneObject(mesh, lambert(0.8f)));
    const std::size_t up = plane.y > 0 ? 2 : 3;
    int checked = 0;
    for (const auto& [cell, faces] : map.voxels) {
        const glm::dvec3 corner(cell[0], cell[1], cell[2]);
        const Outline piece = clippedToBox(t, corner, corner + 1.0);
        if (std::abs(vectorArea(piece).y) < 0.05) continue;  // few fixed-point steps
        ++checked;
        glm::dvec3 middle(0);
        double total = 0;
        for (std::size_t i = 2; i < piece.size(); ++i) {
            const double area = glm::length(glm::cross(piece[i - 1] - piece[0], piece[i] - piece[0]));
            middle += area * (piece[0] + piece[i - 1] + piece[i]) / 3.0;
            total += area;
        }
        middle /= total;
        const auto share = [&](int a, int b) {
            return glm::length(glm::cross(glm::dvec3(t[static_cast<std::size_t>(a)]) - middle,
                                          glm::dvec3(t[static_cast<std::size_t>(b)]) - middle));
        };
        glm::dvec3 weight(share(1, 2), share(2, 0), share(0, 1));
        weight /= weight.x + weight.y + weight.z;
        glm::vec3 normal(0), color(0);
        for (std::size_t k = 0; k < 3; ++k) {
            normal += static_cast<float>(weight[static_cast<int>(k)]) * mesh.normals[k];
            color += static_cast<float>(weight[static_cast<int>(k)]) * glm::vec3(mesh.colors[k]);
        }
        for (const std::size_t f : {up, up ^ 1}) {
            EXPECT_LT(glm::distance(faces[f].position(), glm::vec3(middle - corner)), 2e-3f);
            EXPECT_LT(glm::distance(faces[f].albedo(), 0.8f * color), 2e-3f);
            EXPECT_LT(glm::distance(faces[f].normal(), (f == up ? 1.0f : -1.0f) * glm::normalize(normal)), 3e-3f);
        }
    }
    EXPECT_GT(checked, 50);
}

TEST_F(VoxelAttributes, SliversStayWithinTheirCorners) {
    std::mt19937 random(11);
    std::uniform_real_distribution<float> place(1, 15), tiny(-1, 1), exponent(-7, -3);
    std::vector<Triangle> triangles;
    for (int i = 0; i < 300; ++i) {
        const glm::vec3 a(place(random), place(random), place(random)), b(place(random), place(random), place(random));
        const float width = std::pow(10.0f, exponent(random));
        triangles.push_back({a, b, 0.5f * (a + b) + width * glm::vec3(tiny(random), tiny(random), tiny(random))});
    }
    Mesh mesh = triangleMesh(triangles);
    mesh.normals.assign(mesh.positions.size(), glm::vec3(0));
    for (std::size_t i = 0; i < mesh.positions.size(); ++i)
        mesh.colors.emplace_back(i % 3 == 0 ? 0.4f : 0.6f, 0.5f, i % 3 == 1 ? 0.3f : 0.2f, 1.0f);
    const Scene scene = oneObject(mesh, lambert(1));
    const VoxelMap map = voxelizeOnce(scene, unitGrid(16), voxelSettings(16, VoxelCoverage::binary));
    EXPECT_GT(map.voxels.size(), 1000u);
    for (const auto& [cell, faces] : map.voxels) {
        for (const VoxelFace& face : faces) {
            if (!face.held()) continue;
            EXPECT_NEAR(face.albedo().x, 0.5, 0.1 + 1e-3);
            EXPECT_NEAR(face.albedo().y, 0.5, 1e-3);
            EXPECT_NEAR(face.albedo().z, 0.25, 0.05 + 1e-3);
        }
    }
}

TEST_F(VoxelAttributes, NormalsThatLookAwayAreThePlanes) {
    Mesh mesh = quad(8, 8);
    for (glm::vec3& n : mesh.normals) n = {0.6f, -0.8f, 0};
    const VoxelMap away = voxelize(oneObject(mesh, lambert(0.5f), translation({8, 8.5, 8})));
    EXPECT_NEAR(away.at(8, 8, 8)[2].normal().y, 1, 1e-4);
    mesh.normals.assign(mesh.normals.size(), glm::vec3(0));
    const VoxelMap none = voxelize(oneObject(mesh, lambert(0.5f), translation({8, 8.5, 8})));
    EXPECT_NEAR(none.at(8, 8, 8)[2].normal().y, 1, 1e-4);
    EXPECT_NEAR(none.at(8, 8, 8)[3].normal().y, -1, 1e-4);
}

TEST_F(VoxelAttributes, BrightAndDimEmittersKeepTheirRadiance) {
    const std::vector<float> radiance{6e4f, 1e3f, 1, 0.1f};
    SceneBuilder builder;
    for (std::size_t i = 0; i < radiance.size(); ++i)
        builder.add(quad(2, 2), lambert(0.5f, radiance[i]), translation({3 + 3 * static_cast<double>(i), 8.5, 8.5}));
    const VoxelMap map = voxelize(builder.build());
    EXPECT_EQ(map.counters.clamped, 0u);
    for (std::size_t i = 0; i < radiance.size(); ++i) {
        const glm::vec3 e = map.at(3 + 3 * static_cast<int>(i), 8, 8)[2].emission();
        const double error = std::abs(static_cast<double>(e.x / radiance[i]) - 1);
        std::printf("emitter of %g beside one of 6e4: off by %.2e\n", static_cast<double>(radiance[i]), error);
        // A step of the shared exponent, and of the 2^-8 in fixed point that 6e4 leaves.
        EXPECT_LT(error, 0x1p-9 + 0x1p-9 / static_cast<double>(radiance[i]) + 1e-4);
        EXPECT_EQ(e.x, e.y);
    }
}

TEST_F(VoxelAttributes, EmissionBeyondItsStorageIsClampedAndCounted) {
    SceneBuilder builder;
    builder.add(quad(0.5, 0.5), lambert(0.5f, 1e6f), translation({3.5, 8.5, 8.5}));
    builder.add(quad(0.5, 0.5), lambert(0.5f, 1), translation({9.5, 8.5, 8.5}));
    const VoxelMap map = voxelize(builder.build());
    EXPECT_EQ(map.at(3, 8, 8)[2].emission().x, kMaxRgb9e5);
    EXPECT_EQ(map.counters.clamped, 1u);
    const float dim = map.at(9, 8, 8)[2].emission().x;
    std::printf("emitter of 1 beside one of 1e6: %.4f\n", static_cast<double>(dim));
    EXPECT_NEAR(dim, 1, 0.06);
}

TEST_F(VoxelAttributes, SmallPiecesOfDimEmittersAreRightOnAverage) {
    // 2e-4 of a voxel face each, and an emission of less than a step: only the dither can store it.
    SceneBuilder builder;
    builder.add(quad(1, 1), lambert(0.5f, 5e4f), translation({1.5, 1.5, 1.5}));
    builder.add(quad(4, 4, 200), lambert(0.5f, 1), translation({8.013, 8.5, 8.007}));
    const VoxelMap map = voxelize(builder.build());
    double sum = 0, coverage = 0;
    for (const auto& [cell, faces] : map.voxels) {
        if (cell[1] != 8) continue;
        sum += static_cast<double>(faces[2].emission().x * faces[2].coverage);
        coverage += static_cast<double>(faces[2].coverage);
    }
    EXPECT_NEAR(coverage, 16, 0.05);
    EXPECT_NEAR(sum / coverage, 1, 0.01);
}

TEST_F(VoxelAttributes, UnlitSurfacesEmitTheirColour) {
    for (const float shade : {0.5f, 0.0f}) {
        Material material;
        material.unlit = true;
        material.baseColor = {shade, 0.5f * shade, 0, 1};
        const VoxelMap map = voxelize(oneObject(quad(8, 8), material, translation({8, 8.5, 8})));
        const VoxelFace& face = map.at(8, 8, 8)[2];
        EXPECT_EQ(face.coverage, 1);
        EXPECT_NEAR(face.emission().x, shade, 1e-3);
        EXPECT_NEAR(face.emission().y, 0.5f * shade, 1e-3);
        EXPECT_EQ(face.albedo(), glm::vec3(0));
        EXPECT_EQ(map.at(8, 8, 8)[3].emission(), glm::vec3(0));
    }
}

/// A square of 8×8 voxels with a texture of `size`² texels over all of it.
template <class Texel>
Scene textured(int size, Material material, const Texel& texel) {
    Scene scene = oneObject(quad(8, 8), material, translation({8, 8.5, 8}));
    Texture texture;
    texture.width = texture.height = size;
    for (int y = 0; y < size; ++y)
        for (int x = 0; x < size; ++x)
            for (const int value : texel(x, y)) texture.rgba8.push_back(static_cast<std::uint8_t>(value));
    scene.textures.push_back(texture);
    scene.materials[0].baseColorTexture.texture = 0;
    return scene;
}
using Rgba = std::array<int, 4>;

TEST_F(VoxelAttributes, FineTexturesAreAveragedInLinearLight) {
    const VoxelMap map = voxelize(textured(256, lambert(1), [](int x, int y) {
        return (x + y) % 2 ? Rgba{255, 255, 0, 255} : Rgba{0, 255, 0, 255};
    }));
    double worst = 0;
    for (int z = 4; z < 12; ++z)
        for (int x = 4; x < 12; ++x) {
            const glm::vec3 albedo = map.at(x, 8, z)[2].albedo();
            worst = std::max(worst, std::abs(static_cast<double>(albedo.x) - 0.5));
            EXPECT_NEAR(albedo.x, 0.5, 0.005);
            EXPECT_NEAR(albedo.y, 1, 0.005);
            EXPECT_NEAR(albedo.z, 0, 0.005);
        }
    std::printf("checkerboard of 32 texels a voxel: mean off by %.1e\n", worst);
}

TEST_F(VoxelAttributes, TheMipFitsTheVoxel) {
    // A noisy texture whose mean differs from voxel to voxel: neither blurred over neighbours nor aliased.
    const auto base = [](int column, int row) { return 40 + 20 * ((3 * column + 5 * row) % 8); };
    const Scene scene = textured(256, lambert(1), [&](int x, int y) {
        const int value = base(x / 32, y / 32) + ((x + y) % 2 ? 40 : -40);
        return Rgba{value, value, value, 255};
    });
    const VoxelMap map = voxelize(scene);
    const auto linear = [](int srgb) {
        const double s = srgb / 255.0;
        return s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
    };
    for (int row = 0; row < 8; ++row)
        for (int column = 0; column < 8; ++column) {
            const int value = base(column, row);
            const double mean = 0.5 * (linear(value + 40) + linear(value - 40));
            // The middles of the two triangles that share a voxel may lie beside its centre, where neighbours blend in.
            if (column == row || column + row == 7) continue;
            EXPECT_NEAR(map.at(4 + column, 8, 4 + row)[2].albedo().x, mean, 0.01) << column << " " << row;
        }
}

TEST_F(VoxelAttributes, OpacityIsCoverage) {
    const auto coverage = [](AlphaMode mode, float factor, int even, int odd) {
        Material material = lambert(0.7f);
        material.alphaMode = mode;
        material.baseColor.a = factor;
        const VoxelMap map = voxelize(textured(256, material, [&](int x, int y) {
            return Rgba{255, 255, 255, (x + y) % 2 ? odd : even};
        }));
        EXPECT_NEAR(map.at(8, 8, 8)[2].coverage, map.at(8, 8, 8)[3].coverage, 1e-4 + 2 * kCoverageRounding);
        if (map.at(8, 8, 8)[2].held()) {
            EXPECT_NEAR(map.at(8, 8, 8)[2].albedo().x, 0.7, 2e-3);
        }
        return map.at(7, 8, 9)[2].coverage;
    };
    EXPECT_NEAR(coverage(AlphaMode::mask, 1, 0, 255), 0.5, 0.005);
    EXPECT_NEAR(coverage(AlphaMode::blend, 0.5f, 0, 255), 0.25, 0.005);
    EXPECT_EQ(coverage(AlphaMode::opaque, 0.5f, 0, 255), 1);
}

TEST_F(VoxelAttributes, AMaskWithoutATextureIsAllOrNothing) {
    const auto coverage = [](AlphaMode mode, float alpha) {
        Material material = lambert(0.7f);
        material.alphaMode = mode;
        material.baseColor.a = alpha;
        return voxelize(oneObject(quad(8, 8), material, translation({8, 8.5, 8}))).at(8, 8, 8)[2].coverage;
    };
    EXPECT_EQ(coverage(AlphaMode::mask, 0.4f), 0);
    EXPECT_EQ(coverage(AlphaMode::mask, 0.5f), 1);
    EXPECT_EQ(coverage(AlphaMode::mask, 0.8f), 1);
    EXPECT_NEAR(coverage(AlphaMode::blend, 0.4f), 0.4, 1e-4 + kCoverageRounding);
}

}  // namespace
}  // namespace voxcone
