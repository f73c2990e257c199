// voxcone capture, reference and info, small.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>
#include <thread>

#include "cli/program.h"
#include "metric/image.h"

namespace voxcone {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;

const std::string kBasic = VOXCONE_SOURCE_DIR "/assets/captures/basic.json";
const std::vector<std::string> kSmall = {"--set", "output.width=64",     "--set", "output.height=36",
                                         "--set", "voxel.resolution=32", "--set", "light.shadow_resolution=256",
                                         "--set", "light.bounces=1"};
const std::vector<std::string> kChannels = {"beauty", "direct", "indirect_diffuse", "ao", "albedo", "normal", "depth"};

Outcome run(const std::string& command, const fs::path& out, std::vector<std::string> more = {}) {
    std::vector<std::string> arguments = {command, kBasic, "--out", out.string()};
    arguments.insert(arguments.end(), kSmall.begin(), kSmall.end());
    arguments.insert(arguments.end(), more.begin(), more.end());
    return voxcone(arguments);
}

/// All files below `folder`, relative.
std::set<std::string> filesOf(const fs::path& folder) {
    std::set<std::string> files;
    for (const auto& entry : fs::recursive_directory_iterator(folder)) {
        if (entry.is_regular_file()) files.insert(entry.path().lexically_relative(folder).string());
    }
    return files;
}

std::set<std::string> expectedFiles() {
    std::set<std::string> files;
    for (const char* shot : {"view1", "view2"}) {
        for (const std::string& channel : kChannels) {
            for (const char* extension : {".0000.exr", ".0000.png"})
                files.insert(std::string(shot) + "/" + channel + extension);
        }
        files.insert(std::string(shot) + "/stats.json");
    }
    return files;
}

/// One capture and one reference for all tests: they are the slow part.
class Pictures : public testing::Test {
  protected:
    static void SetUpTestSuite() {
        folder_ = new TemporaryFolder;
        capture_ = run("capture", folder_->path() / "capture");
        reference_ = run("reference", folder_->path() / "reference", {"--spp", "32"});
    }
    static void TearDownTestSuite() { delete folder_; }
    static fs::path path(const std::string& name) { return folder_->path() / name; }

    static inline TemporaryFolder* folder_ = nullptr;
    static inline Outcome capture_, reference_;
};

TEST_F(Pictures, FilesAreThoseOfTheScriptAndAreNamedOnStandardOutput) {
    for (const auto& [outcome, name] : {std::pair(capture_, "capture"), std::pair(reference_, "reference")}) {
        ASSERT_EQ(outcome.status, 0) << outcome.err;
        EXPECT_EQ(filesOf(path(name)), expectedFiles()) << name;
        for (const std::string& file : expectedFiles())
            EXPECT_THAT(outcome.out, HasSubstr((path(name) / file).string() + "\n"));
    }
}

TEST_F(Pictures, HaveTheSizeAskedForAndOnlyFiniteValues) {
    for (const char* name : {"capture", "reference"}) {
        for (const std::string& channel : kChannels) {
            const Image image = readImage(path(name) / "view1" / (channel + ".0000.exr"));
            EXPECT_EQ(image.width, 64);
            EXPECT_EQ(image.height, 36);
            EXPECT_EQ(image.channels, channel == "ao" || channel == "depth" ? 1 : 3) << name << " " << channel;
            double sum = 0;
            for (const float value : image.data) sum += std::abs(value);
            EXPECT_TRUE(std::isfinite(sum)) << name << " " << channel;
            EXPECT_GT(sum, 0) << name << " " << channel;
        }
    }
}

// Geometry channels have one answer. Direct light has too, but for the edges of shadows.
TEST_F(Pictures, CaptureAgreesWithTheReference) {
    const Outcome outcome = voxcone({"compare", path("reference").string(), path("capture").string(), "--json"});
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    const json pairs = json::parse(outcome.out)["pairs"];
    EXPECT_EQ(pairs.size(), 2 * kChannels.size());
    for (const json& pair : pairs) {
        const auto name = pair["name"].get<std::string>();
        const double relMse = pair["metrics"]["relmse"];
        if (name.find("albedo") != std::string::npos || name.find("depth") != std::string::npos) {
            EXPECT_LT(relMse, 0.01) << name;
        }
        if (name.find("/direct") != std::string::npos) {
            EXPECT_LT(std::abs(pair["metrics"]["relative_bias"].get<double>()), 0.02) << name;
        }
        if (name.find("beauty") != std::string::npos) {
            EXPECT_LT(relMse, 0.2) << name;
            EXPECT_EQ(pair["displayed"], "the .png files beside them");
        }
    }
}

TEST_F(Pictures, StatsOfACaptureSayWhatAFrameCostAndOnWhat) {
    const json stats = json::parse(contentOf(path("capture") / "view1/stats.json"));
    EXPECT_EQ(stats["program"]["command"], "capture");
    EXPECT_FALSE(stats["device"]["renderer"].get<std::string>().empty());
    EXPECT_EQ(stats["settings"]["voxel"]["resolution"], 32);
    EXPECT_EQ(stats["shot"]["name"], "view1");
    EXPECT_EQ(stats["scene"]["triangles"], 2232);
    ASSERT_EQ(stats["frames"].size(), 1u);
    const json& frame = stats["frames"][0];
    EXPECT_THAT(frame["timer"].get<std::string>(), testing::AnyOf("query", "finish"));
    double passes = 0;
    for (const json& pass : frame["passes"]) {
        EXPECT_GE(pass["ms"].get<double>(), 0) << pass;
        passes += pass["ms"].get<double>();
    }
    const double whole = frame["frame_ms"];
    EXPECT_GT(whole, 0);
    EXPECT_NEAR(passes / whole, 1, 0.05);
    EXPECT_GT(frame["memory_bytes"].get<std::uint64_t>(), 0u);
}

TEST_F(Pictures, StatsOfAReferenceSayItsOwnError) {
    const json stats = json::parse(contentOf(path("reference") / "view2/stats.json"));
    EXPECT_EQ(stats["program"]["command"], "reference");
    const json& frame = stats["frames"][0];
    EXPECT_EQ(frame["samples"], 32);
    EXPECT_GT(frame["beauty_error"].get<double>(), 0);
    EXPECT_LT(frame["beauty_error"].get<double>(), 1);
    EXPECT_GT(frame["indirect_diffuse_error"].get<double>(), 0);
}

TEST_F(Pictures, TheSameCaptureTwiceIsTheSameBitForBit) {
    ASSERT_EQ(run("capture", path("again")).status, 0);
    for (const char* shot : {"view1", "view2"}) {
        for (const std::string& channel : kChannels) {
            const std::string name = shot + std::string("/") + channel + ".0000.exr";
            EXPECT_EQ(readImage(path("capture") / name).data, readImage(path("again") / name).data) << name;
        }
    }
}

TEST_F(Pictures, TheSameReferenceTwiceIsTheSameBitForBit) {
    ASSERT_EQ(run("reference", path("reference2"), {"--spp", "32"}).status, 0);
    const std::string name = "view1/beauty.0000.exr";
    EXPECT_EQ(readImage(path("reference") / name).data, readImage(path("reference2") / name).data);
}

TEST(Capture, ThatCannotWriteLeavesNothing) {
    const TemporaryFolder folder;
    std::ofstream(folder.path() / "file") << "in the way";
    const Outcome outcome = run("capture", folder.path() / "file");
    EXPECT_EQ(outcome.status, 3);
    EXPECT_THAT(outcome.err, HasSubstr("cannot create the folder"));
    EXPECT_EQ(filesOf(folder.path()), std::set<std::string>{"file"});
}

TEST(Capture, OfABareSceneMakesUpACameraAndALight) {
    const TemporaryFolder folder;
    std::vector<std::string> arguments = {"capture", VOXCONE_SOURCE_DIR "/assets/scenes/basic.gltf", "--out",
                                          folder.path().string()};
    arguments.insert(arguments.end(), kSmall.begin(), kSmall.end());
    const Outcome outcome = voxcone(arguments);
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr("lit by a sun and a sky"));
    const Image beauty = readImage(folder.path() / "default/beauty.0000.exr");
    EXPECT_GT(*std::max_element(beauty.data.begin(), beauty.data.end()), 0.1f);
}

/// A cube that moves and turns, a camera on its way past it: frames `first` to `last`.
json motionScript(int first, int last) {
    json script = json::parse(R"({ "version": 1,
        "lights": [{"type": "directional", "direction": [-0.3, -1, -0.45], "intensity": 2.5}],
        "objects": [{"node": "cube", "path": [
            {"time": 0, "translation": [0.95, 0, 0], "rotation": [0, 0, 0]},
            {"time": 0.5, "translation": [0.4, 0.2, 0.6], "rotation": [0, 60, 0]},
            {"time": 1, "translation": [0.95, 0, 1], "rotation": [20, 90, 0]}]}],
        "shots": [{"name": "past", "channels": ["beauty", "indirect_diffuse", "depth"], "fps": 4, "temporal": true,
            "camera": {"path": [
                {"time": 0, "position": [-0.6, 3, 5.6], "target": [-0.1, 0.55, 0]},
                {"time": 0.5, "position": [0.6, 2.5, 5.4], "target": [0, 0.55, 0]},
                {"time": 1, "position": [1.6, 2, 4.6], "target": [0.1, 0.55, 0]}]}}]})");
    script["scene"] = VOXCONE_SOURCE_DIR "/assets/scenes/basic.gltf";
    script["shots"][0]["frames"] = {{"first", first}, {"last", last}};
    if (first == last) script["shots"][0].erase("temporal");
    return script;
}

class Motion : public testing::Test {
  protected:
    Outcome run(const std::string& command, const std::string& name, const json& script,
                std::vector<std::string> more = {}) {
        const fs::path file = folder_.path() / (name + ".json");
        std::ofstream(file) << script.dump(1);
        std::vector<std::string> arguments = {command, file.string(), "--out", path(name).string()};
        arguments.insert(arguments.end(), kSmall.begin(), kSmall.end());
        arguments.insert(arguments.end(), more.begin(), more.end());
        return voxcone(arguments);
    }
    fs::path path(const std::string& name) const { return folder_.path() / name; }

    TemporaryFolder folder_;
};

// With objects that move everything is built anew for every frame; without, only the camera moves.
TEST_F(Motion, AFrameIsTheSameWithAndWithoutThoseBeforeIt) {
    for (const std::string scene : {"still", "moving"}) {
        json scripts[] = {motionScript(0, 3), motionScript(3, 3)};
        for (json& script : scripts) {
            if (scene == "still") script.erase("objects");
        }
        const Outcome all = run("capture", scene, scripts[0]), last = run("capture", scene + " last", scripts[1]);
        ASSERT_EQ(all.status, 0) << all.err;
        ASSERT_EQ(last.status, 0) << last.err;
        EXPECT_EQ(filesOf(path(scene + " last")),
                  (std::set<std::string>{"past/beauty.0003.exr", "past/beauty.0003.png", "past/depth.0003.exr",
                                         "past/depth.0003.png", "past/indirect_diffuse.0003.exr",
                                         "past/indirect_diffuse.0003.png", "past/stats.json"}));
        for (const char* channel : {"beauty", "indirect_diffuse", "depth"}) {
            const std::string name = std::string("past/") + channel;
            const Image third = readImage(path(scene) / (name + ".0003.exr"));
            EXPECT_EQ(third.data, readImage(path(scene + " last") / (name + ".0003.exr")).data)
                << scene << " " << channel;
            EXPECT_NE(third.data, readImage(path(scene) / (name + ".0002.exr")).data) << scene << " " << channel;
        }
    }
}

TEST_F(Motion, StatsSayTheChangeFromFrameToFrame) {
    ASSERT_EQ(run("capture", "all", motionScript(0, 3)).status, 0);
    ASSERT_EQ(run("capture", "last", motionScript(3, 3)).status, 0);
    const json stats = json::parse(contentOf(path("all") / "past/stats.json"));
    ASSERT_EQ(stats["frames"].size(), 4u);
    EXPECT_EQ(stats["frames"][3]["frame"], 3);
    EXPECT_EQ(stats["frames"][3]["time_s"], 0.75);
    EXPECT_FALSE(stats["frames"][0].contains("temporal"));
    double squared = 0, mean = 0, worst = 0;
    for (std::size_t i = 1; i < 4; ++i) {
        const json& change = stats["frames"][i]["temporal"];
        EXPECT_GT(change["valid"].get<double>(), 0.2);
        squared += std::pow(change["rms"].get<double>(), 2) / 3;
        mean += change["mean"].get<double>() / 3;
        worst = std::max(worst, change["jump"].get<double>());
    }
    EXPECT_NEAR(stats["temporal"]["F"].get<double>(), std::sqrt(squared) / mean, 1e-9);
    EXPECT_EQ(stats["temporal"]["worst_jump"].get<double>(), worst);
    EXPECT_FALSE(json::parse(contentOf(path("last") / "past/stats.json")).contains("temporal"));
}

TEST_F(Motion, LightsOfTheReferenceMoveToo) {
    json script = motionScript(1, 2);
    script.erase("objects");
    script["shots"][0].erase("temporal");
    script["shots"][0]["channels"] = {"direct", "depth"};
    script["shots"][0]["camera"] = {{"position", {-0.6, 3, 5.6}}, {"target", {0, 0.5, 0}}};
    script["lights"] = json::parse(R"([{"type": "sphere", "radius": 0.1, "position": [-2, 2, 1],
        "path": [{"time": 0.25, "intensity": 2}, {"time": 0.5, "intensity": 4}]}])");
    ASSERT_EQ(run("reference", "reference", script, {"--spp", "2"}).status, 0);
    const auto pixels = [&](const char* name) { return readImage(path("reference") / "past" / name).data; };
    EXPECT_EQ(pixels("depth.0001.exr"), pixels("depth.0002.exr"));
    const std::vector<float> dim = pixels("direct.0001.exr"), bright = pixels("direct.0002.exr");
    for (std::size_t i = 0; i < dim.size(); ++i) ASSERT_NEAR(bright[i], 2 * dim[i], 1e-5f * bright[i]) << i;
}

// Geometry has one answer, so the two see the same places at the same times.
TEST_F(Motion, TheReferenceRendersTheSameFrames) {
    json script = motionScript(1, 2);
    script["shots"][0]["channels"] = {"depth"};
    ASSERT_EQ(run("capture", "capture", script).status, 0);
    ASSERT_EQ(run("reference", "reference", script, {"--spp", "2"}).status, 0);
    EXPECT_EQ(filesOf(path("capture")), filesOf(path("reference")));
    const Outcome outcome = voxcone({"compare", path("reference").string(), path("capture").string(), "--json"});
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    const json pairs = json::parse(outcome.out)["pairs"];
    ASSERT_EQ(pairs.size(), 2u);
    for (const json& pair : pairs) EXPECT_LT(pair["metrics"]["relmse"].get<double>(), 0.01) << pair["name"];
}

TEST(Interrupted, ReferenceLeavesNoPartOfAFile) {
    const TemporaryFolder folder;
    const std::string out = (folder.path() / "out").string();
    const pid_t child = fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
        execl(VOXCONE_PROGRAM, "voxcone", "reference", kBasic.c_str(), "--out", out.c_str(), "--spp", "1000000",
              nullptr);
        _exit(127);
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(1500));
    ASSERT_EQ(kill(child, SIGINT), 0);
    int status = 0;
    ASSERT_EQ(waitpid(child, &status, 0), child);
    EXPECT_TRUE(WIFEXITED(status));
    EXPECT_EQ(WEXITSTATUS(status), 128 + SIGINT);
    EXPECT_TRUE(filesOf(folder.path()).empty());
}

TEST(Info, NamesTheDeviceAndTheScene) {
    const Outcome device = voxcone({"info", "--json"});
    ASSERT_EQ(device.status, 0) << device.err;
    const json parsed = json::parse(device.out);
    EXPECT_GE(parsed["device"]["limits"]["texture_3d"].get<int>(), 256);
    EXPECT_FALSE(parsed.contains("scene"));

    const Outcome scene = voxcone({"info", kBasic, "--json"});
    ASSERT_EQ(scene.status, 0) << scene.err;
    const json facts = json::parse(scene.out);
    EXPECT_EQ(facts["scene"]["triangles"], 2232);
    EXPECT_EQ(facts["scene"]["closed_triangles"], 2232);
    EXPECT_EQ(facts["scene"]["lights"]["directional"], 1);
    EXPECT_TRUE(facts["left_out"].is_array());
    for (const json& item : facts["left_out"]) EXPECT_FALSE(item["why"].get<std::string>().empty()) << item;

    const Outcome text = voxcone({"info", kBasic});
    EXPECT_THAT(text.out,
                AllOf(HasSubstr("triangles"), HasSubstr("2232"), HasSubstr("renderer"), HasSubstr("left_out")));
}

}  // namespace
}  // namespace voxcone
