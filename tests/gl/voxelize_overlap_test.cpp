// Which voxels are touched, and how much of each face is covered, against clipping in double precision.
#include <gtest/gtest.h>

#include <cstdio>
#include <functional>
#include <random>

#include "voxelize_truth.h"

namespace voxcone {
namespace {

using namespace test;
using Random = std::mt19937;

constexpr int kResolution = 16;

double uniform(Random& random, double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
}
glm::vec3 randomPoint(Random& random, double low, double high) {
    return glm::vec3(uniform(random, low, high), uniform(random, low, high), uniform(random, low, high));
}
glm::dvec3 randomUnit(Random& random) {
    const double z = uniform(random, -1, 1), phi = uniform(random, 0, 6.283185307179586);
    const double r = std::sqrt(1 - z * z);
    return {r * std::cos(phi), r * std::sin(phi), z};
}

/// Both coverages over the same triangles, each triangle voxelized alone.
class Overlap : public GlTest, public testing::WithParamInterface<VoxelCoverage> {
  protected:
    static VoxelizeLab& lab(VoxelCoverage coverage) {
        static const Scene model = oneObject(quad(1, 1), lambert(0.5f));
        static VoxelizeLab area(voxelSettings(kResolution, VoxelCoverage::area), model);
        static VoxelizeLab binary(voxelSettings(kResolution, VoxelCoverage::binary), model);
        return coverage == VoxelCoverage::area ? area : binary;
    }

    Agreement check(const char* name, int count, const std::function<Triangle(Random&)>& make) {
        Random random(7);
        Agreement sum;
        for (int i = 0; i < count; ++i) {
            const Triangle triangle = make(random);
            const Scene scene = oneObject(triangleMesh({triangle}), lambert(0.5f));
            const int before = sum.missedBeyond + sum.surplusBeyond + sum.badCoverage;
            compare(sum, lab(GetParam()).voxelize(scene, unitGrid(kResolution)), triangle, kResolution,
                    GetParam() == VoxelCoverage::area);
            if (sum.missedBeyond + sum.surplusBeyond + sum.badCoverage > before && before == 0)
                for (const glm::vec3& p : triangle) std::printf("  first bad: %a %a %a\n", p.x, p.y, p.z);
        }
        std::printf("%s: %d triangles, %d voxels; missed %d, surplus %d (rounding only); worst coverage error %.2g\n",
                    name, sum.triangles, sum.voxels, sum.missed, sum.surplus, sum.worstCoverage);
        EXPECT_GT(sum.voxels, 0);
        EXPECT_EQ(sum.missedBeyond, 0);
        EXPECT_EQ(sum.surplusBeyond, 0);
        EXPECT_EQ(sum.badCoverage, 0);
        return sum;
    }
};

TEST_P(Overlap, RandomTriangles) {
    const Agreement sum = check("random", 150, [](Random& random) {
        return Triangle{randomPoint(random, 0, 16), randomPoint(random, 0, 16), randomPoint(random, 0, 16)};
    });
    // Random vertices meet no face: rounding decides nowhere.
    EXPECT_LE(sum.missed + sum.surplus, sum.voxels / 2000);
}

TEST_P(Overlap, SmallTriangles) {
    check("a voxel or two", 200, [](Random& random) {
        const glm::vec3 p = randomPoint(random, 1, 15);
        return Triangle{p, p + randomPoint(random, -1, 1), p + randomPoint(random, -1, 1)};
    });
}

TEST_P(Overlap, Slivers) {
    check("slivers of aspect 1e3 to 3e6", 700, [](Random& random) {
        const glm::dvec3 a = randomPoint(random, 0, 16), b = randomPoint(random, 0, 16);
        const double width = glm::distance(a, b) / std::pow(10, uniform(random, 3, 6.5));
        const glm::dvec3 c = glm::mix(a, b, uniform(random, -0.2, 1.2)) + width * randomUnit(random);
        return Triangle{a, b, c};
    });
}

TEST_P(Overlap, AxisAlignedTriangles) {
    check("axis-aligned", 100, [](Random& random) {
        Triangle t{randomPoint(random, 0, 16), randomPoint(random, 0, 16), randomPoint(random, 0, 16)};
        const int axis = static_cast<int>(random() % 3);
        t[1][axis] = t[2][axis] = t[0][axis];
        if (random() % 2) t[1][(axis + 1) % 3] = t[0][(axis + 1) % 3], t[2][(axis + 2) % 3] = t[0][(axis + 2) % 3];
        return t;
    });
}

TEST_P(Overlap, VerticesOnFacesEdgesAndCorners) {
    const Agreement sum = check("on the lattice of half voxels", 250, [](Random& random) {
        Triangle t;
        do {
            for (glm::vec3& p : t)
                for (int a = 0; a < 3; ++a) p[a] = 0.5f * static_cast<float>(random() % 33);
        } while (glm::length(vectorArea({t[0], t[1], t[2]})) < 1e-6);
        return t;
    });
    EXPECT_LE(sum.missed + sum.surplus, sum.voxels / 50) << "edges through corners at thirds and fifths of a voxel";
}

TEST_P(Overlap, AxisAlignedOnTheLatticeIsExact) {
    const Agreement sum = check("axis-aligned on the lattice", 60, [](Random& random) {
        const int axis = static_cast<int>(random() % 3);
        Triangle t;
        for (glm::vec3& p : t) p = glm::vec3(static_cast<float>(random() % 17));
        const auto at = [&] { return static_cast<float>(random() % 17); };
        const float u = at(), v = at();
        t[0][(axis + 1) % 3] = u, t[0][(axis + 2) % 3] = v;
        t[1][(axis + 1) % 3] = u + 4, t[1][(axis + 2) % 3] = v;
        t[2][(axis + 1) % 3] = u, t[2][(axis + 2) % 3] = v + 4;
        t[1][axis] = t[2][axis] = t[0][axis] = at();
        if (u == 16 || v == 16 || t[0][axis] == 16) t[0] = glm::vec3(0), t[1] = {4, 0, 0}, t[2] = {0, 4, 0};
        return t;
    });
    EXPECT_EQ(sum.missed, 0);
    EXPECT_EQ(sum.surplus, 0);
}

TEST_P(Overlap, LargerThanTheGrid) {
    check("larger than the grid", 60, [](Random& random) {
        // Through a point inside, so that the grid is met.
        const glm::dvec3 p = randomPoint(random, 2, 14), u = randomUnit(random), v = randomUnit(random);
        const double size = std::pow(10, uniform(random, 1.5, 4));
        return Triangle{p - size * u - size * v, p + 2 * size * u, p + 2 * size * v};
    });
}

TEST_P(Overlap, PartlyOutside) {
    check("partly outside", 120, [](Random& random) {
        return Triangle{randomPoint(random, -12, 28), randomPoint(random, -12, 28), randomPoint(random, 0, 16)};
    });
}

TEST_P(Overlap, FarSmallerThanAVoxel) {
    check("far smaller than a voxel", 150, [](Random& random) {
        // Around the origin corner of the grid's middle, where floats resolve 1e-6, and around 0, where they resolve
        // all.
        const bool atZero = random() % 2 == 0;
        const double size = std::pow(10, atZero ? uniform(random, -17, -1) : uniform(random, -5, -1));
        const glm::vec3 base = atZero ? glm::vec3(0) : randomPoint(random, 0, 15);
        return Triangle{base + randomPoint(random, 0, size), base + randomPoint(random, 0, size),
                        base + randomPoint(random, 0, size)};
    });
}

TEST_P(Overlap, TiesOfTheDominantAxis) {
    check("normals at 45 degrees and along diagonals", 120, [](Random& random) {
        // Planes x ± y = c and x ± y ± z = c on quarters of a voxel: ties are exact in floats.
        const auto quarter = [&](int n) { return 0.25f * static_cast<float>(random() % static_cast<unsigned>(n)); };
        const float s = random() % 2 ? 1.0f : -1.0f;
        const glm::vec3 e1 = random() % 2 ? glm::vec3(1, -s, 0) : glm::vec3(s, -1, 0);
        const glm::vec3 e2 = random() % 2 ? glm::vec3(0, 0, 1) : glm::vec3(0, -s, 1);
        const glm::vec3 p(4 + quarter(16), 4 + quarter(16), 4 + quarter(16));
        Triangle t{p, p + quarter(16) * e1 + (1 + quarter(12)) * e2, p + (1 + quarter(12)) * e1};
        const int turn = static_cast<int>(random() % 3);
        for (glm::vec3& q : t) q = turn == 0 ? q : turn == 1 ? glm::vec3(q.y, q.z, q.x) : glm::vec3(q.z, q.x, q.y);
        return t;
    });
}

TEST_P(Overlap, ATriangleIsItsTessellation) {
    // Vertices on a lattice of 1/8 so that all midpoints are exact floats.
    Random random(3);
    int differences = 0, voxels = 0;
    for (int i = 0; i < 10; ++i) {
        const auto at = [&] { return 0.125f * static_cast<float>(static_cast<int>(random() % 2048)) - 120; };
        const Triangle whole{glm::vec3(at(), at(), 8 + at() / 64), glm::vec3(at(), 8 + at() / 64, at()),
                             glm::vec3(8 + at() / 64, at(), at())};
        std::vector<Triangle> parts{whole};
        for (int level = 0; level < 4; ++level) {
            std::vector<Triangle> finer;
            for (const auto& [a, b, c] : parts) {
                const glm::vec3 ab = 0.5f * (a + b), bc = 0.5f * (b + c), ca = 0.5f * (c + a);
                finer.insert(finer.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
            }
            parts = std::move(finer);
        }
        const VoxelMap one = lab(GetParam()).voxelize(oneObject(triangleMesh({whole}), lambert(0.5f)), unitGrid(16));
        const VoxelMap many = lab(GetParam()).voxelize(oneObject(triangleMesh(parts), lambert(0.5f)), unitGrid(16));
        voxels += static_cast<int>(one.voxels.size());
        const double tolerance = roundingOf(whole);
        const auto compareSets = [&](const VoxelMap& a, const VoxelMap& b) {
            for (const auto& [cell, faces] : a.voxels) {
                if (b.voxels.contains(cell)) continue;
                ++differences;
                const glm::dvec3 c(cell[0], cell[1], cell[2]);
                EXPECT_TRUE(clippedToBox(whole, c + tolerance, c + 1.0 - tolerance).empty());
            }
        };
        compareSets(one, many);
        compareSets(many, one);
        if (GetParam() == VoxelCoverage::area) {
            for (std::size_t f = 0; f < 6; ++f)
                EXPECT_NEAR(summedCoverage(one, f), summedCoverage(many, f), 1e-4 * summedCoverage(one, f) + 1e-2);
        }
    }
    std::printf("triangle against its 256 parts: %d voxels, %d differences (rounding only)\n", voxels, differences);
    EXPECT_GT(voxels, 100);
}

INSTANTIATE_TEST_SUITE_P(Coverage, Overlap, testing::Values(VoxelCoverage::area, VoxelCoverage::binary),
                         [](const auto& i) { return i.param == VoxelCoverage::area ? "area" : "binary"; });

}  // namespace
}  // namespace voxcone
