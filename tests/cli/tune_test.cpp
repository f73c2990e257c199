// voxcone tune on a picture of a few pixels.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "cli/program.h"

namespace voxcone {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

class Tune : public testing::Test {
  protected:
    Outcome tune(const std::string& bound, const std::vector<std::string>& more = {},
                 const std::string& channel = "indirect_diffuse") {
        std::vector<std::string> arguments = {"tune",      script_, "--max-error", bound,
                                              "--channel", channel, "--cache",     (folder_.path() / "cache").string(),
                                              "--repeats", "1",     "--budget",    "6"};
        for (const char* setting : {"output.width=16", "output.height=16", "voxel.resolution=16",
                                    "light.shadow_resolution=128", "light.bounces=1", "reference.samples=16"})
            arguments.insert(arguments.end(), {"--set", setting});
        for (const char* knob : {"cone.diffuse=5,16", "cone.step=2,1"})
            arguments.insert(arguments.end(), {"--vary", knob});
        arguments.insert(arguments.end(), more.begin(), more.end());
        return voxcone(arguments);
    }

    const std::string script_ = VOXCONE_SOURCE_DIR "/assets/captures/cornell.json";
    TemporaryFolder folder_;
};

TEST_F(Tune, WritesAPresetThatCapturesUse) {
    const fs::path preset = folder_.path() / "tuned.json";
    const Outcome outcome = tune("relmse=100", {"--out", preset.string()});
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_THAT(outcome.out,
                AllOf(HasSubstr("trade-offs of cornell, 16 x 16 pixels, relmse of indirect_diffuse"), HasSubstr("\n* "),
                      HasSubstr("cheapest with relmse <= 100"), HasSubstr(preset.string() + "\n")));
    EXPECT_THAT(outcome.err, HasSubstr("1/6"));
    const json tuned = json::parse(contentOf(preset));
    EXPECT_TRUE(tuned["cone"]["diffuse"] == 5 || tuned["cone"]["diffuse"] == 16);
    EXPECT_FALSE(tuned.contains("output"));

    const fs::path out = folder_.path() / "out";
    const Outcome capture = voxcone({"capture", script_, "--out", out.string(), "--set", "preset=" + preset.string(),
                                     "--set", "output.width=16", "--set", "output.height=16"});
    ASSERT_EQ(capture.status, 0) << capture.err;
    const json stats = json::parse(contentOf(out / "front" / "stats.json"));
    for (const char* group : {"voxel", "cone", "light", "specular"})
        EXPECT_EQ(stats["settings"][group], tuned[group]) << group;
}

TEST_F(Tune, SaysWhenNothingMeetsTheBound) {
    const fs::path preset = folder_.path() / "tuned.json";
    const Outcome least = tune("relmse=1e-9", {"--out", preset.string()});
    EXPECT_EQ(least.status, 1) << least.err;
    EXPECT_THAT(least.out,
                AllOf(HasSubstr("nothing found meets relmse <= 1e-09"), HasSubstr("the least error found is")));
    EXPECT_FALSE(fs::exists(preset));

    const Outcome slow = tune("relmse=100", {"--max-ms", "1e-6", "--out", preset.string()});
    EXPECT_EQ(slow.status, 1) << slow.err;
    EXPECT_THAT(slow.out, AllOf(HasSubstr("within 1e-06 ms; the cheapest that meets the error takes"),
                                HasSubstr("nothing found is as fast as that")));
    EXPECT_FALSE(fs::exists(preset));
}

std::size_t countOf(const std::string& what, const std::string& text) {
    std::size_t count = 0;
    for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++count;
    return count;
}

TEST_F(Tune, BeginsWithWhatAnEarlierSearchMeasured) {
    const Outcome first = tune("relmse=100");
    ASSERT_EQ(first.status, 0) << first.err;
    EXPECT_EQ(countOf("kept from an earlier", first.err), 0u) << first.err;
    std::size_t files = 0;
    for (const auto& entry : fs::directory_iterator(folder_.path() / "cache" / "measurements")) {
        EXPECT_EQ(entry.path().extension(), ".json");
        ++files;
    }
    EXPECT_GE(files, 2u);  // the script's settings and the cheapest ones
    // What is confirmed is rendered again.
    const Outcome second = tune("relmse=100");
    ASSERT_EQ(second.status, 0) << second.err;
    EXPECT_EQ(countOf("kept from an earlier", second.err), files) << second.err;
    // Another metric needs the same pictures.
    const Outcome other = tune("rmse=100");
    ASSERT_EQ(other.status, 0) << other.err;
    EXPECT_GE(countOf("kept from an earlier", other.err), 2u) << other.err;
    EXPECT_THAT(second.err, HasSubstr(" measurements of an earlier search, from "));
}

TEST_F(Tune, SettingsThatEndedTheProgramHaveFailed) {
    ASSERT_EQ(tune("relmse=100").status, 0);
    // As if one of them had crashed.
    fs::path crashed;
    for (const auto& entry : fs::directory_iterator(folder_.path() / "cache" / "measurements")) crashed = entry.path();
    fs::remove(crashed);
    crashed.replace_extension("measuring");
    std::ofstream(crashed).close();
    const Outcome outcome = tune("relmse=100");
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr("the program was ended while it measured this"));
    EXPECT_THAT(outcome.out, HasSubstr("1 of which failed"));
    EXPECT_FALSE(fs::exists(crashed));
}

TEST_F(Tune, WrongUsage) {
    const auto fails = [&](const char* bound, const char* reason) {
        const Outcome outcome = tune(bound);
        EXPECT_EQ(outcome.status, 2) << bound;
        EXPECT_THAT(outcome.err, AllOf(HasSubstr(reason), HasSubstr("usage: voxcone tune")));
        EXPECT_EQ(outcome.out, "");
    };
    fails("relmsee=0.1", "did you mean \"relmse\"");
    fails("ssim=0.9", "no metric \"ssim\"");
    fails("relmse", "expected METRIC=VALUE");
    fails("relmse=-1", "expected METRIC=VALUE");
    fails("relmse=0.1x", "expected METRIC=VALUE");
    EXPECT_EQ(tune("relmse=0.1", {"--vary", "cone.diffuse=5,7"}).status, 2);
    EXPECT_EQ(tune("relmse=0.1", {}, "albedo").status, 2);
}

TEST_F(Tune, AChannelThatIsBlackCannotBeTuned) {
    const Outcome outcome = tune("relmse=0.1", {}, "transmission");
    EXPECT_EQ(outcome.status, 3);
    EXPECT_THAT(outcome.err, HasSubstr("transmission of shot front is black"));
}

}  // namespace
}  // namespace voxcone
