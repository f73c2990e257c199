// Pictures through files: what is written is read back.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>

#include "core/error.h"
#include "metric/image.h"

namespace voxcone {
namespace {

class ImageFiles : public testing::Test {
  protected:
    ImageFiles() { std::filesystem::create_directories(folder_); }
    ~ImageFiles() override { std::filesystem::remove_all(folder_); }
    std::filesystem::path folder_ =
        std::filesystem::temp_directory_path() / ("voxcone_image_" + std::to_string(getpid()));
};

Image ramp(int width, int height, int channels) {
    Image image(width, height, channels);
    for (std::size_t i = 0; i < image.data.size(); ++i)
        image.data[i] = static_cast<float>(i) / static_cast<float>(image.data.size());
    return image;
}

TEST_F(ImageFiles, ExrKeepsEveryBitOfOneToFourChannels) {
    for (int channels = 1; channels <= 4; ++channels) {
        Image image = ramp(7, 5, channels);
        image.data[0] = -1e30f, image.data[1] = 3e38f, image.data[2] = 1e-40f;
        writeExr(folder_ / "a.exr", image);
        const Image back = readImage(folder_ / "a.exr");
        EXPECT_EQ(back.width, 7);
        EXPECT_EQ(back.height, 5);
        EXPECT_EQ(back.channels, channels);
        EXPECT_EQ(back.data, image.data);
    }
}

TEST_F(ImageFiles, PngIsSrgbEncodedAndWithinHalfAStep) {
    const Image image = ramp(16, 16, 3);
    writePng(folder_ / "a.png", image);
    const Image back = readImage(folder_ / "a.png");
    ASSERT_EQ(back.data.size(), image.data.size());
    for (std::size_t i = 0; i < image.data.size(); ++i)
        EXPECT_NEAR(srgbFromLinear(back.data[i]), srgbFromLinear(image.data[i]), 0.5 / 255 + 1e-5);
}

TEST_F(ImageFiles, PngClipsAndShowsNaNAsMagenta) {
    Image image(3, 1, 3);
    image.data = {-1, 0, 2, std::nanf(""), 0.5f, 0.5f, 1, std::numeric_limits<float>::infinity(), 0};
    writePng(folder_ / "a.png", image);
    EXPECT_EQ(readImage(folder_ / "a.png").data, (std::vector<float>{0, 0, 1, 1, 0, 1, 1, 1, 0}));
}

TEST_F(ImageFiles, BadFilesAreNamedInOneLine) {
    std::ofstream(folder_ / "text.exr") << "this is no picture";
    std::ofstream(folder_ / "noise.xyz") << "nor is this";
    writeExr(folder_ / "cut.exr", ramp(64, 64, 3));
    std::filesystem::resize_file(folder_ / "cut.exr", 3000);
    for (const char* name : {"text.exr", "noise.xyz", "absent.png", "cut.exr", "."}) {
        try {
            readImage(folder_ / name);
            FAIL() << name;
        } catch (const InputError& error) {
            const std::string line = error.what();
            EXPECT_NE(line.find((folder_ / name).string()), std::string::npos) << line;
            EXPECT_EQ(line.find('\n'), std::string::npos) << line;
            EXPECT_EQ(error.exitCode, ExitCode::bad_input);
        }
    }
}

TEST_F(ImageFiles, FailedWriteLeavesNothing) {
    EXPECT_THROW(writePng(folder_ / "a.unknown", ramp(4, 4, 3)), InputError);
    EXPECT_TRUE(std::filesystem::is_empty(folder_));
}

TEST(Srgb, EncodingAndDecodingAreInverse) {
    EXPECT_FLOAT_EQ(srgbFromLinear(0), 0);
    EXPECT_NEAR(srgbFromLinear(1), 1, 1e-6);
    EXPECT_NEAR(srgbFromLinear(0.2140f), 0.5, 1e-4);  // middle grey of the encoded scale
    for (int i = 0; i <= 255; ++i) {
        const float value = static_cast<float>(i) / 255;
        EXPECT_NEAR(srgbFromLinear(linearFromSrgb(value)), value, 1e-6);
    }
}

}  // namespace
}  // namespace voxcone
