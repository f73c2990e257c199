// Help, wrong usage, bad input: exit statuses and what is said.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "cli/program.h"
#include "core/settings.h"

namespace voxcone {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;

const std::string kCornell = VOXCONE_SOURCE_DIR "/assets/captures/cornell.json";
const std::string kScene = VOXCONE_SOURCE_DIR "/assets/scenes/basic.gltf";

TEST(Help, OfEveryCommandIsComplete) {
    const Outcome whole = voxcone({"--help"});
    EXPECT_EQ(whole.status, 0);
    EXPECT_EQ(whole.err, "");
    for (const char* command : {"capture", "reference", "compare", "info"}) {
        EXPECT_THAT(whole.out, HasSubstr(command));
        const Outcome help = voxcone({command, "--help"});
        EXPECT_EQ(help.status, 0);
        EXPECT_EQ(help.err, "");
        EXPECT_THAT(help.out, HasSubstr("--help"));
    }
    for (const char* command : {"capture", "reference"}) {
        const Outcome help = voxcone({command, "--help"});
        Settings settings;
        for (const Field& field : fields(settings)) EXPECT_THAT(help.out, HasSubstr(field.key)) << command;
        EXPECT_THAT(help.out, AllOf(HasSubstr("--out"), HasSubstr("--set"), HasSubstr("balanced")));
    }
    EXPECT_THAT(voxcone({"reference", "--help"}).out, AllOf(HasSubstr("--spp"), HasSubstr("--error")));
    EXPECT_THAT(voxcone({"compare", "--help"}).out,
                AllOf(HasSubstr("--heatmap"), HasSubstr("--fail-above"), HasSubstr("relmse")));
}

TEST(Help, VersionGoesToStandardOutput) {
    const Outcome version = voxcone({"--version"});
    EXPECT_EQ(version.status, 0);
    EXPECT_THAT(version.out, testing::MatchesRegex("voxcone [0-9]+\\.[0-9]+\\.[0-9]+\n"));
}

struct Mistake {
    std::vector<std::string> arguments;
    const char* said;
};

TEST(WrongUsage, Exits2AndSaysTheRightUsage) {
    const Mistake mistakes[] = {
        {{}, "usage: voxcone"},
        {{"frobnicate"}, "usage: voxcone"},
        {{"capture"}, "usage: voxcone capture SCRIPT.json|SCENE.gltf --out DIR"},
        {{"capture", kCornell}, "--out is required"},
        {{"capture", kCornell, "--out", "x", "--bogus"}, "--bogus"},
        {{"capture", kCornell, "--out", "x", "--set", "voxel.resolutoin=64"}, "did you mean \"voxel.resolution\"?"},
        {{"capture", kCornell, "--out", "x", "--set", "voxel.resolution=65"}, "16, 32, 64, 128, 256"},
        {{"capture", kCornell, "--out", "x", "--set", "voxel.resolution"}, "key=value"},
        {{"capture", kCornell, "--out", "x", "--set", "preset=best"}, "balanced"},
        {{"reference", kCornell, "--out", "x", "--spp", "none"}, "reference.samples"},
        {{"reference", kCornell, "--out", "x", "--spp", "0"}, "reference.samples"},
        {{"compare", "a.exr"}, "usage: voxcone compare REFERENCE TEST"},
        {{"compare", kCornell, kCornell, "--fail-above", "relmse"}, "expected metric=value"},
        {{"compare", kCornell, kCornell, "--fail-above", "rmsee=1"}, "did you mean \"rmse\"?"},
        {{"compare", kCornell, VOXCONE_SOURCE_DIR "/assets"}, "two files or two folders"},
    };
    for (const Mistake& mistake : mistakes) {
        const Outcome outcome = voxcone(mistake.arguments);
        EXPECT_EQ(outcome.status, 2) << testing::PrintToString(mistake.arguments) << outcome.err;
        EXPECT_THAT(outcome.err, AllOf(HasSubstr(mistake.said), HasSubstr("usage: voxcone")));
        EXPECT_EQ(outcome.out, "");
    }
    EXPECT_FALSE(fs::exists("x"));
}

TEST(BadInput, Exits3WithOneLineThatNamesTheFile) {
    const TemporaryFolder folder;
    const auto file = [&](const char* name, const std::string& text) {
        std::ofstream(folder.path() / name) << text;
        return (folder.path() / name).string();
    };
    const std::string shots =
        R"("shots": [{"name": "a", "camera": {"position": [0,0,1], "target": [0,0,0]}, "channels": ["beauty"]}])";
    const std::string scene = "\"scene\": \"" + kScene + "\"";
    const Mistake mistakes[] = {
        {{"/absent/script.json"}, "/absent/script.json: no such file"},
        {{file("a.json", "{\n  \"version\" 1 }")}, "a.json: line 2, column 13: not valid JSON"},
        {{file("b.json", R"({"version": 1, "scene": "none.gltf", )" + shots + "}")}, "b.json: scene: no such file"},
        {{file("c.json", R"({"version": 1, "scne": "none.gltf", )" + shots + "}")}, "c.json: scene: is missing"},
        {{file("d.json", "{\"version\": 1, " + scene + R"(, "shots": []})")}, "d.json: shots: must be an array"},
        {{file("e.json", "{\"version\": 1, " + scene + R"(, "light": [], )" + shots + "}")},
         "did you mean \"lights\"?"},
        {{file("f.gltf", "{\"asset\": {}}")}, "f.gltf"},
        {{file("g.glb", "glTF")}, "g.glb"},
        {{file("h.txt", "")}, "h.txt: is neither"},
        {{folder.path().string()}, "is neither"},
    };
    for (const Mistake& mistake : mistakes) {
        for (const char* command : {"capture", "reference"}) {
            const Outcome outcome = voxcone({command, mistake.arguments[0], "--out", (folder.path() / "out").string()});
            EXPECT_EQ(outcome.status, 3) << mistake.arguments[0] << outcome.err;
            EXPECT_THAT(outcome.err, HasSubstr(mistake.said));
            EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
            EXPECT_EQ(outcome.out, "");
        }
    }
    EXPECT_FALSE(fs::exists(folder.path() / "out"));
}

TEST(NoDevice, Exits4AndSaysWhatWasTried) {
    const TemporaryFolder folder;
    // The vendor-neutral EGL loader finds no driver.
    const std::string environment = "__EGL_VENDOR_LIBRARY_FILENAMES=/nonexistent.json";
    for (const auto& arguments :
         {std::vector<std::string>{"info"},
          std::vector<std::string>{"capture", kCornell, "--out", (folder.path() / "out").string()}}) {
        const Outcome outcome = voxcone(arguments, environment);
        EXPECT_EQ(outcome.status, 4) << outcome.err;
        EXPECT_THAT(outcome.err, HasSubstr("EGL"));
        EXPECT_EQ(outcome.out, "");
    }
    EXPECT_FALSE(fs::exists(folder.path() / "out"));
}

}  // namespace
}  // namespace voxcone
