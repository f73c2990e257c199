// voxcone compare on pictures of a few pixels.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "cli/program.h"
#include "metric/image.h"

namespace voxcone {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;

Image grey(float value, int width = 8, int height = 4, int channels = 3) {
    Image image(width, height, channels);
    for (float& v : image.data) v = value;
    return image;
}

class Compare : public testing::Test {
  protected:
    std::string exr(const char* name, const Image& image) {
        writeExr(folder_.path() / name, image);
        return (folder_.path() / name).string();
    }
    std::string png(const char* name, const Image& image) {
        writePng(folder_.path() / name, image);
        return (folder_.path() / name).string();
    }
    TemporaryFolder folder_;
};

TEST_F(Compare, TwoFiles) {
    const std::string r = exr("r.exr", grey(1)), t = exr("t.exr", grey(1.1f));
    const Outcome outcome = voxcone({"compare", r, t, "--json"});
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    const json result = json::parse(outcome.out);
    const json& metrics = result["pairs"][0]["metrics"];
    EXPECT_NEAR(metrics["rmse"].get<double>(), 0.1, 1e-6);
    EXPECT_NEAR(metrics["relative_bias"].get<double>(), 0.1, 1e-6);
    EXPECT_NEAR(metrics["relmse"].get<double>(), 0.01 / 1.01, 1e-6);
    EXPECT_GT(metrics["hdr_flip"].get<double>(), 0);
    EXPECT_EQ(result["pairs"][0]["width"], 8);
    EXPECT_EQ(result["mean"], metrics);
    EXPECT_EQ(result["pairs"][0]["displayed"], "values clipped to 0..1");
    EXPECT_TRUE(metrics["psnr"].is_null());  // both are white

    const Outcome table = voxcone({"compare", r, t});
    EXPECT_THAT(table.out,
                AllOf(HasSubstr("relmse"), HasSubstr("hdr_flip"), HasSubstr("epsilon        0.01"), HasSubstr("8x4")));
    EXPECT_EQ(table.err, "");
}

TEST_F(Compare, DisplayedPictureIsThePngBesideTheExr) {
    const std::string r = exr("r.exr", grey(8)), t = exr("t.exr", grey(9));
    png("r.png", grey(linearFromSrgb(0.4f))), png("t.png", grey(linearFromSrgb(0.5f)));
    const json pair = json::parse(voxcone({"compare", r, t, "--json"}).out)["pairs"][0];
    EXPECT_EQ(pair["displayed"], "the .png files beside them");
    EXPECT_NEAR(pair["metrics"]["psnr"].get<double>(), 20, 0.5);
    EXPECT_NEAR(pair["metrics"]["rmse"].get<double>(), 1, 1e-6);
}

TEST_F(Compare, TwoPngs) {
    const Outcome outcome = voxcone({"compare", png("r.png", grey(0.5f)), png("t.png", grey(0.5f)), "--json"});
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    const json metrics = json::parse(outcome.out)["pairs"][0]["metrics"];
    EXPECT_EQ(metrics["flip"], 0);
    EXPECT_NEAR(metrics["ssim"].get<double>(), 1, 1e-6);
    EXPECT_FALSE(metrics.contains("hdr_flip"));
}

TEST_F(Compare, BoundsDecideTheExitStatus) {
    const std::string r = exr("r.exr", grey(1)), t = exr("t.exr", grey(0.5f));
    EXPECT_EQ(voxcone({"compare", r, t, "--fail-above", "rmse=0.6"}).status, 0);
    EXPECT_EQ(voxcone({"compare", r, t, "--fail-above", "rmse=0.4"}).status, 1);
    EXPECT_EQ(voxcone({"compare", r, t, "--fail-above", "rmse=0.6", "--fail-above", "p99=0.1"}).status, 1);
    const Outcome bias = voxcone({"compare", r, t, "--fail-above", "bias=0.4"});  // -0.5: too far in either direction
    EXPECT_EQ(bias.status, 1);
    EXPECT_THAT(bias.err, HasSubstr("bias 0.5 is above 0.4"));
    EXPECT_THAT(bias.out, HasSubstr("rmse"));  // the figures are printed all the same
    EXPECT_EQ(voxcone({"compare", r, t, "--fail-below", "ssim=0.99"}).status, 1);
    EXPECT_EQ(voxcone({"compare", r, r, "--fail-below", "ssim=0.99", "--fail-above", "relmse=0"}).status, 0);
}

TEST_F(Compare, HeatmapIsWrittenWholeOrNotAtAll) {
    const std::string r = exr("r.exr", grey(1)), t = exr("t.exr", grey(0.2f));
    const fs::path heatmap = folder_.path() / "maps" / "h.png";
    ASSERT_EQ(voxcone({"compare", r, t, "--heatmap", heatmap.string()}).status, 0);
    const Image image = readImage(heatmap);
    EXPECT_EQ(image.width, 8);
    EXPECT_EQ(image.channels, 3);
    EXPECT_GT(image.data[0], image.data[2]);  // a large error is on magma's warm half

    const Outcome refused = voxcone({"compare", r, t, "--heatmap", (folder_.path() / "r.exr" / "h.png").string()});
    EXPECT_EQ(refused.status, 3);
    EXPECT_EQ(std::distance(fs::directory_iterator(folder_.path() / "maps"), {}), 1);
}

TEST_F(Compare, WhatCannotBeComparedIsBadInput) {
    const std::string r = exr("r.exr", grey(1));
    Image nan = grey(1);
    nan.pixel(5, 2)[1] = std::nanf("");
    std::ofstream(folder_.path() / "broken.exr") << "broken";
    const std::pair<std::string, const char*> cases[] = {
        {exr("size.exr", grey(1, 4, 8)), "size.exr: is 4x8 pixels, the reference"},
        {exr("channels.exr", grey(1, 8, 4, 1)), "channels.exr: has 1 channels"},
        {exr("nan.exr", nan), "nan.exr: pixel (5, 2) channel 1: is NaN"},
        {(folder_.path() / "broken.exr").string(), "broken.exr: "},
        {(folder_.path() / "absent.exr").string(), "absent.exr: no such file"},
    };
    for (const auto& [file, said] : cases) {
        const Outcome outcome = voxcone({"compare", r, file});
        EXPECT_EQ(outcome.status, 3) << file;
        EXPECT_THAT(outcome.err, HasSubstr(said));
        EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
        EXPECT_EQ(outcome.out, "");
    }
    // A NaN in the reference is no better.
    EXPECT_EQ(voxcone({"compare", (folder_.path() / "nan.exr").string(), r}).status, 3);
}

TEST_F(Compare, FoldersAreMatchedByShotChannelAndFrame) {
    exr("r/a/beauty.0000.exr", grey(1)), exr("r/a/ao.0000.exr", grey(0.5f, 8, 4, 1)),
        exr("r/b/depth.0000.exr", grey(3, 8, 4, 1));
    exr("t/a/beauty.0000.exr", grey(1.5f)), exr("t/a/ao.0000.exr", grey(0.5f, 8, 4, 1)),
        exr("t/b/depth.0000.exr", grey(4, 8, 4, 1));
    exr("t/a/soft_shadow.0000.exr", grey(0, 8, 4, 1));
    const std::string r = (folder_.path() / "r").string(), t = (folder_.path() / "t").string();
    const Outcome outcome = voxcone({"compare", r, t, "--json", "--heatmap", (folder_.path() / "h").string()});
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr("1 pictures"));
    const json result = json::parse(outcome.out);
    ASSERT_EQ(result["pairs"].size(), 3u);
    EXPECT_EQ(result["pairs"][0]["name"], "a/ao.0000");
    EXPECT_EQ(result["pairs"][1]["name"], "a/beauty.0000");
    EXPECT_EQ(result["pairs"][2]["name"], "b/depth.0000");
    EXPECT_FALSE(result["pairs"][2]["metrics"].contains("flip"));  // depth is no colour
    EXPECT_NEAR(result["mean"]["rmse"].get<double>(), (0 + 0.5 + 1) / 3, 1e-6);
    EXPECT_TRUE(fs::exists(folder_.path() / "h/a/beauty.0000.png"));
    EXPECT_TRUE(fs::exists(folder_.path() / "h/b/depth.0000.png"));
    EXPECT_THAT(voxcone({"compare", r, t}).out, AllOf(HasSubstr("a/beauty.0000"), HasSubstr("mean")));

    fs::create_directories(folder_.path() / "empty");
    EXPECT_EQ(voxcone({"compare", r, (folder_.path() / "empty").string()}).status, 3);
}

}  // namespace
}  // namespace voxcone
