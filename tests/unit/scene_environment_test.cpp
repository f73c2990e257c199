// Panoramas: which direction sees which texel, and which files are refused.
#include <OpenImageIO/imageio.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "core/error.h"
#include "scene/environment.h"
#include "unit/gltf_builder.h"

namespace voxcone {
namespace {

void expectUv(const glm::vec2& uv, float u, float v) {
    EXPECT_NEAR(uv.x, u, 1e-6);
    EXPECT_NEAR(uv.y, v, 1e-6);
}

TEST(EnvironmentUv, AxesAndRotation) {
    Environment sky;
    expectUv(environmentUv(sky, {0, 0, -1}), 0.5f, 0.5f);
    expectUv(environmentUv(sky, {1, 0, 0}), 0.75f, 0.5f);
    expectUv(environmentUv(sky, {-1, 0, 0}), 0.25f, 0.5f);
    EXPECT_EQ(environmentUv(sky, {0, 1, 0}).y, 0);
    EXPECT_NEAR(environmentUv(sky, {0, -1, 0}).y, 1, 1e-6);
    // Turned a quarter counter-clockwise from above, what was ahead (−z) is now on the left (−x).
    sky.rotationDeg = 90;
    expectUv(environmentUv(sky, {-1, 0, 0}), 0.5f, 0.5f);
    sky.rotationDeg = -450;
    expectUv(environmentUv(sky, {1, 0, 0}), 0.5f, 0.5f);
}

TEST(EnvironmentUv, StaysBelowOneForAnyDirection) {
    std::mt19937 random(1);
    std::normal_distribution<float> normal;
    Environment sky;
    for (int i = 0; i < 100000; ++i) {
        sky.rotationDeg = static_cast<double>(i);
        const glm::vec2 uv =
            environmentUv(sky, glm::normalize(glm::vec3(normal(random), normal(random), normal(random))));
        ASSERT_TRUE(uv.x >= 0 && uv.x < 1 && uv.y >= 0 && uv.y < 1) << uv.x << " " << uv.y;
    }
    sky.rotationDeg = 0;
    for (const float x : {-1e-30f, -0.0f, 0.0f, 1e-30f}) EXPECT_LT(environmentUv(sky, {x, 0, 1}).x, 1);
}

TEST(EnvironmentRadiance, WrapsInLongitudeAndClampsAtThePoles) {
    Environment sky;
    sky.color = glm::vec3(2);
    sky.width = 4;
    sky.height = 2;
    for (int i = 0; i < 8; ++i) sky.radiance.emplace_back(static_cast<float>(i));
    // Behind (+z) lies the seam between columns 3 and 0, half way between the rows.
    EXPECT_NEAR(environmentRadiance(sky, {0, 0, 1}).x, 2 * (3 + 0 + 7 + 4) / 4.0, 1e-4);
    // Straight ahead: between columns 1 and 2.
    EXPECT_NEAR(environmentRadiance(sky, {0, 0, -1}).x, 2 * (1 + 2 + 5 + 6) / 4.0, 1e-4);
    // Above everything only row 0 counts.
    EXPECT_NEAR(environmentRadiance(sky, glm::normalize(glm::vec3(0, 1, -1e-4f))).x, 2 * 1.5, 1e-3);
    sky.radiance.clear();
    EXPECT_EQ(environmentRadiance(sky, {0, 1, 0}), glm::vec3(2));
}

class EnvironmentFileTest : public testing::Test {
  protected:
    std::filesystem::path write(const std::string& name, std::vector<float> texels, int width, int channels = 3) {
        const std::filesystem::path file = folder.path() / name;
        const int height = static_cast<int>(texels.size()) / channels / width;
        const auto output = OIIO::ImageOutput::create(file.string());
        EXPECT_TRUE(output && output->open(file.string(), OIIO::ImageSpec(width, height, channels, OIIO::TypeFloat)) &&
                    output->write_image(OIIO::TypeFloat, texels.data()) && output->close());
        return file;
    }
    std::string refusal(const std::filesystem::path& file) {
        try {
            loadEnvironment(file);
        } catch (const InputError& error) {
            return error.what();
        }
        return "loaded";
    }
    test::TemporaryFolder folder{"voxcone_environment_test"};
};

TEST_F(EnvironmentFileTest, ExrAndHdrGiveLinearRadianceRowZeroOnTop) {
    const std::vector<float> texels = {0, 1, 2, 4, 8, 1024, 0.5, 0.25, 16, 1, 1, 1};
    for (const char* name : {"sky.exr", "sky.hdr"}) {
        const Environment sky = loadEnvironment(write(name, texels, 2));
        EXPECT_EQ(sky.width, 2);
        EXPECT_EQ(sky.height, 2);
        ASSERT_EQ(sky.radiance.size(), 4u);
        EXPECT_EQ(sky.color, glm::vec3(1));
        // Shared exponents keep eight bits of the brightest component.
        EXPECT_NEAR(sky.radiance[1].z, 1024, 4);
        EXPECT_NEAR(sky.radiance[2].z, 16, 0.1);
        EXPECT_NEAR(sky.radiance[0].y, 1, 0.01);
    }
}

TEST_F(EnvironmentFileTest, BadTexelsAreCounted) {
    const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
    const std::string message = refusal(write("bad.exr", {nan, 0, 0, 1, 1, 1, 0, -1, inf, 2, 2, 2}, 2));
    EXPECT_THAT(message, testing::HasSubstr("bad.exr: 2 of 4 texels are NaN, infinite or negative"));
}

TEST_F(EnvironmentFileTest, UnreadableFilesAreRefusedInOneLine) {
    writeTextFile(folder.path() / "text.hdr", "#?RADIANCE\nnot a panorama\n");
    writeTextFile(folder.path() / "empty.exr", "");
    for (const char* name : {"absent.exr", "text.hdr", "empty.exr"}) {
        const std::string message = refusal(folder.path() / name);
        EXPECT_THAT(message, testing::HasSubstr(name));
        EXPECT_THAT(message, testing::HasSubstr("cannot be"));
        EXPECT_EQ(message.find('\n'), std::string::npos);
    }
}

}  // namespace
}  // namespace voxcone
