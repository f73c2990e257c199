// Levels around the camera, and things that move, as the built program shows them: a frame is what scene, time and
// camera make of it, whatever was shown before.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <random>
#include <set>

#include "cli/program.h"
#include "metric/image.h"
#include "unit/gltf_builder.h"

namespace voxcone {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::HasSubstr;

/// Three levels of 16³ around a camera near the cube of the scene.
json basicScript() {
    json script = json::parse(R"({ "version": 1,
        "environment": {"color": [0.2, 0.2, 0.3]},
        "lights": [{"type": "directional", "direction": [-0.3, -1, -0.45], "intensity": 2.5}],
        "settings": {
            "output": {"width": 40, "height": 30}, "voxel": {"resolution": 16}, "cascade": {"levels": 3},
            "light": {"shadow_resolution": 128, "bounces": 1, "bounce_cones": 1},
            "cone": {"diffuse": 6, "rotate": false}, "specular": {"enabled": false} },
        "shots": [{"name": "shot", "fps": 4}]})");
    script["scene"] = VOXCONE_SOURCE_DIR "/assets/scenes/basic.gltf";
    return script;
}

const std::vector<std::string> kLevelChannels = {"indirect_diffuse", "cascade", "voxel_radiance", "seam"};

class Cascade : public testing::Test {
  protected:
    Outcome run(const std::string& name, const json& script) const {
        const fs::path file = folder_.path() / (name + ".json");
        std::ofstream(file) << script.dump(1);
        return voxcone({"capture", file.string(), "--out", (folder_.path() / name).string()});
    }
    /// Pixels of a channel ("voxel_albedo:1" too) of a shot.
    Image picture(const std::string& name, const std::string& shot, std::string channel, int frame) const {
        std::replace(channel.begin(), channel.end(), ':', '_');
        return readImage(folder_.path() / name / shot / (channel + ".000" + std::to_string(frame) + ".exr"));
    }
    json stats(const std::string& name, const std::string& shot) const {
        return json::parse(contentOf(folder_.path() / name / shot / "stats.json"));
    }

    TemporaryFolder folder_;
};

/// `shot` twice: its last frame alone, which comes first and so finds nothing made, then all of its frames.
void aloneAndAfterOthers(json& script, int last) {
    json alone = script["shots"][0], after = alone;
    alone["name"] = "alone";
    alone["frames"] = {{"first", last}, {"last", last}};
    after["name"] = "after";
    after["frames"] = last + 1;
    script["shots"] = {alone, after};
}

// ---- a moving camera

TEST_F(Cascade, ACameraThatComesBackSeesWhatItSawBefore) {
    // Fitted, the last level holds the scene; with voxels of 0.15 m it follows the camera like the others.
    for (const double size : {0.0, 0.15}) {
        const std::string name = size > 0 ? "given" : "fitted";
        json script = basicScript();
        script["settings"]["voxel"]["size"] = size;
        json& shot = script["shots"][0];
        shot["channels"] = kLevelChannels;
        shot["frames"] = 5;
        shot["camera"]["path"] = json::parse(R"([
            {"time": 0, "position": [1.8, 0.9, 1.6], "target": [0.3, 0.2, 0]},
            {"time": 0.5, "position": [-1.5, 1.2, 2.6], "target": [0.3, 0.2, 0]},
            {"time": 1, "position": [1.8, 0.9, 1.6], "target": [0.3, 0.2, 0]}])");
        const Outcome outcome = run(name, script);
        ASSERT_EQ(outcome.status, 0) << outcome.err;
        for (const std::string& channel : kLevelChannels) {
            const std::vector<float> first = picture(name, "shot", channel, 0).data;
            EXPECT_EQ(first, picture(name, "shot", channel, 4).data) << name << " " << channel;
            EXPECT_NE(first, picture(name, "shot", channel, 2).data) << name << " " << channel;
        }
        for (const json& frame : stats(name, "shot")["frames"])
            for (const char* level : {"level_0_voxels", "level_1_voxels", "level_2_voxels"})
                EXPECT_GT(frame["counts"][level].get<int>(), 0) << name << " " << frame["frame"] << " " << level;
    }
}

TEST_F(Cascade, AFrameIsTheSameAloneAndAfterOthersWithAnySettings) {
    const char* storages[] = {"six_face", "isotropic", "sh1"};
    for (unsigned seed = 0; seed < 4; ++seed) {
        std::mt19937 random(seed);
        const auto between = [&](double low, double high) {
            return std::uniform_real_distribution<double>(low, high)(random);
        };
        const auto oneOf = [&](const std::vector<double>& values) { return values[random() % values.size()]; };
        json script = basicScript();
        json& settings = script["settings"];
        settings["voxel"]["storage"] = storages[seed % 3];
        settings["voxel"]["size"] = oneOf({0, 0.06, 0.1});
        settings["cascade"]["levels"] = seed == 0 ? 4 : 1 + static_cast<int>(random() % 4);
        settings["cascade"]["snap"] = static_cast<int>(oneOf({1, 4, 8}));
        settings["cascade"]["band"] = oneOf({0.05, 0.1, 0.2});
        settings["light"]["bounces"] = static_cast<int>(oneOf({1, 3}));
        if (seed != 1)
            script["objects"] = json::parse(R"([{"node": "cube", "path": [
            {"time": 0, "translation": [0.95, 0, 0], "rotation": [0, 0, 0]},
            {"time": 0.6, "translation": [0.4, 0.3, 0.6], "rotation": [0, 80, 10]}]}])");
        if (seed != 2)
            script["lights"] = json::parse(R"([{"type": "directional", "intensity": 2.5, "path": [
            {"time": 0, "direction": [-0.3, -1, -0.45]}, {"time": 0.7, "direction": [0.4, -1, 0.3]}]}])");
        json& shot = script["shots"][0];
        shot["channels"] = kLevelChannels;
        for (int key = 0; key < 3; ++key)
            shot["camera"]["path"].push_back({{"time", 0.375 * key},
                                              {"position", {between(-2, 2), between(0.4, 2.5), between(1.2, 4.5)}},
                                              {"target", {0.5, 0.4, 0}}});
        aloneAndAfterOthers(script, 3);
        const std::string name = "seed" + std::to_string(seed);
        const Outcome outcome = run(name, script);
        ASSERT_EQ(outcome.status, 0) << outcome.err;
        for (const std::string& channel : kLevelChannels)
            EXPECT_EQ(picture(name, "alone", channel, 3).data, picture(name, "after", channel, 3).data)
                << channel << " " << settings;
    }
}

// ---- a box above a floor, seen from the side along -z

/// Floor of 6 m in y = 0, and a red box in front of the sky that is 0.6 m wide and 1 m to the left of x = 0. `extend`
/// adds what moves it to the box's primitive and node.
class Stage : public Cascade {
  protected:
    void write(const std::function<void(json& primitive, json& node)>& extend = nullptr) {
        const int floor = builder.append("materials", {{"pbrMetallicRoughness", {{"metallicFactor", 0}}}});
        const int red = builder.append(
            "materials", {{"pbrMetallicRoughness", {{"baseColorFactor", {1, 0.1, 0.1, 1}}, {"metallicFactor", 0}}}});
        const int still =
            builder.show({{"attributes", {{"POSITION", builder.positions({-3, 0, -3, 3, 0, -3, 3, 0, 3, -3, 0, 3})}}},
                          {"indices", builder.indices({0, 2, 1, 0, 3, 2})},
                          {"material", floor}});
        std::vector<float> corners;
        for (int i = 0; i < 8; ++i)
            corners.insert(corners.end(), {i & 1 ? -0.7f : -1.3f, i & 2 ? 1.5f : 0.9f, i & 4 ? 0.3f : -0.3f});
        json primitive = {{"attributes", {{"POSITION", builder.positions(corners)}}},
                          {"indices", builder.indices({0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 4, 6, 0, 6, 2,
                                                       1, 3, 7, 1, 7, 5, 0, 1, 5, 0, 5, 4, 2, 6, 7, 2, 7, 3})},
                          {"material", red}};
        json node = json::object();
        if (extend) extend(primitive, node);
        const int moving = builder.show(primitive, node);
        builder.json["scenes"] = json::array({{{"nodes", {still, moving}}}});
        if (skeleton_ >= 0) builder.json["scenes"][0]["nodes"].push_back(skeleton_);
        std::ofstream(folder_.path() / "stage.gltf") << builder.text();
    }
    void animate(int node, const char* path, const std::vector<float>& values, const char* type) {
        const int times = builder.accessor<float>({0, 1}, "SCALAR", test::kFloat, 2, {{"min", {0}}, {"max", {1}}});
        const int keys = builder.accessor(values, type, test::kFloat, 2);
        builder.append("animations",
                       {{"samplers", json::array({{{"input", times}, {"output", keys}}})},
                        {"channels", json::array({{{"sampler", 0}, {"target", {{"node", node}, {"path", path}}}}})}});
    }
    /// Shows the stage at 0 s and 1 s; the sun stands overhead.
    json script() const {
        json script = basicScript();
        script["scene"] = "stage.gltf";
        script["lights"][0] = {{"type", "directional"}, {"direction", {0, -1, 0}}, {"intensity", 3}};
        script["settings"]["output"] = {{"width", 80}, {"height", 60}};
        script["settings"]["voxel"]["resolution"] = 32;
        script["settings"]["cascade"]["levels"] = 1;
        script["shots"][0]["fps"] = 1;
        script["shots"][0]["camera"] = {{"position", {0, 1, 5}}, {"target", {0, 0.75, 0}}};
        script["shots"][0]["channels"] = {"albedo", "depth", "direct", "voxel_opacity:0", "indirect_diffuse"};
        return script;
    }

    using Shown = std::function<bool(int x, int y)>;
    /// Mean x of the pixels that `shown` holds for, from -1 (left) to 1.
    static double middle(const Image& image, const Shown& shown) {
        double sum = 0;
        int count = 0;
        for (int y = 0; y < image.height; ++y)
            for (int x = 0; x < image.width; ++x)
                if (shown(x, y)) sum += (x + 0.5) / image.width * 2 - 1, ++count;
        EXPECT_GE(count, 8) << "too few pixels to be what is looked for";
        return count > 0 ? sum / count : 0;
    }
    /// Where the box is in a frame: in the G-buffer (by colour, by depth), in the voxels, and by its shadow.
    struct Places {
        double albedo, depth, voxels, shadow;
    };
    Places places(const std::string& name, const std::string& shot, int frame) const {
        const Image albedo = picture(name, shot, "albedo", frame), depth = picture(name, shot, "depth", frame),
                    voxels = picture(name, shot, "voxel_opacity:0", frame),
                    direct = picture(name, shot, "direct", frame);
        // The floor's far edge is at 4/8 of the way down to the floor under the camera: all above is the sky's.
        const int horizon = albedo.height / 2 - 2;
        const auto floor = [&](int x, int y) { return albedo.pixel(x, y)[1] > 0.5f; };
        return {middle(albedo, [&](int x, int y) { return albedo.pixel(x, y)[0] > 2 * albedo.pixel(x, y)[1]; }),
                middle(albedo, [&](int x, int y) { return y < horizon && depth.pixel(x, y)[0] > 0; }),
                middle(albedo, [&](int x, int y) { return y < horizon && voxels.pixel(x, y)[0] > 0; }),
                middle(albedo, [&](int x, int y) { return floor(x, y) && direct.pixel(x, y)[1] < 0.4f; })};
    }

    test::GltfBuilder builder;
    int skeleton_ = -1;
};

// The sun's rays pass the box at its place to either side, and with them shadow, direct light and the light of voxels.
TEST_F(Stage, AMovingLightTakesItsShadowAlong) {
    write();
    json moving = script();
    // The box is 1.2 m above the floor: a slope of 1/2 puts its shadow 0.6 m aside.
    moving["lights"][0].erase("direction");
    moving["lights"][0]["path"] = {{{"time", 0}, {"direction", {-0.5, -1, 0}}},
                                   {{"time", 1}, {"direction", {0.5, -1, 0}}},
                                   {{"time", 2}, {"direction", {1, -1, 0}}}};
    aloneAndAfterOthers(moving, 1);
    json still = script();
    still["lights"][0]["direction"] = {0.5, -1, 0};
    for (const auto& [name, document] : {std::pair("moving", moving), std::pair("still", still)}) {
        const Outcome outcome = run(name, document);
        ASSERT_EQ(outcome.status, 0) << outcome.err;
    }
    for (const char* channel : {"direct", "indirect_diffuse"}) {
        const std::vector<float> after = picture("moving", "after", channel, 1).data;
        EXPECT_EQ(after, picture("still", "shot", channel, 0).data) << channel;
        EXPECT_EQ(after, picture("moving", "alone", channel, 1).data) << channel;
        EXPECT_NE(after, picture("moving", "after", channel, 0).data) << channel;
    }
    const Places before = places("moving", "after", 0), after = places("moving", "after", 1);
    EXPECT_EQ(before.albedo, after.albedo);
    EXPECT_EQ(before.voxels, after.voxels);
    EXPECT_LT(before.shadow, -0.3);
    EXPECT_GT(after.shadow - before.shadow, 0.2);
}

// From 1 m on the left to 1 m on the right, by a joint that turns half around and by a target 2 m aside.
TEST_F(Stage, DeformingMeshesMoveInPicturesVoxelsAndShadowsAlike) {
    std::vector<float> depths[2];
    for (const std::string by : {"skin", "morph"}) {
        builder = test::GltfBuilder();
        skeleton_ = -1;
        write([&](json& primitive, json& node) {
            if (by == "skin") {
                std::vector<float> weights;
                for (int i = 0; i < 8; ++i) weights.insert(weights.end(), {1, 0, 0, 0});
                primitive["attributes"]["JOINTS_0"] =
                    builder.accessor(std::vector<std::uint8_t>(32, 0), "VEC4", test::kUByte, 8);
                primitive["attributes"]["WEIGHTS_0"] = builder.accessor(weights, "VEC4", test::kFloat, 8);
                skeleton_ = builder.append("nodes", json::object());
                node["skin"] = builder.append("skins", {{"joints", {skeleton_}}});
                animate(skeleton_, "rotation", {0, 0, 0, 1, 0, 1, 0, 0}, "VEC4");
            } else {
                std::vector<float> aside;
                for (int i = 0; i < 8; ++i) aside.insert(aside.end(), {2, 0, 0});
                primitive["targets"] = json::array({{{"POSITION", builder.positions(aside)}}});
                animate(static_cast<int>(builder.json["nodes"].size()), "weights", {0, 1}, "SCALAR");
            }
        });
        json document = script();
        aloneAndAfterOthers(document, 1);
        const Outcome outcome = run(by, document);
        ASSERT_EQ(outcome.status, 0) << by << ": " << outcome.err;
        for (const json& channel : document["shots"][0]["channels"])
            EXPECT_EQ(picture(by, "alone", channel, 1).data, picture(by, "after", channel, 1).data)
                << by << " " << channel;
        const Places left = places(by, "after", 0), right = places(by, "after", 1);
        const auto expectMirrored = [&](const char* what, double a, double b) {
            EXPECT_LT(a, -0.2) << by << " " << what;
            EXPECT_NEAR(b, -a, 0.03) << by << " " << what;
        };
        expectMirrored("albedo", left.albedo, right.albedo);
        expectMirrored("depth", left.depth, right.depth);
        expectMirrored("voxels", left.voxels, right.voxels);
        expectMirrored("shadow", left.shadow, right.shadow);
    }
}

// ---- channels and figures

TEST_F(Cascade, LevelsHaveChannelsAndFigures) {
    json script = basicScript();
    json& shot = script["shots"][0];
    shot["frames"] = 2;
    shot["temporal"] = true;
    shot["channels"] = {"cascade", "seam", "voxel_albedo:1", "voxel_albedo:15"};
    shot["camera"]["path"] = json::parse(R"([{"time": 0, "position": [2, 1.6, 2.4], "target": [0.3, 0.4, 0]},
                                             {"time": 1, "position": [0, 2, 3], "target": [0.3, 0.4, 0]}])");
    const Outcome outcome = run("levels", script);
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    std::set<std::string> files, expected = {"stats.json"};
    for (const auto& entry : fs::directory_iterator(folder_.path() / "levels/shot"))
        files.insert(entry.path().filename().string());
    for (const char* channel : {"cascade", "seam", "voxel_albedo_1", "voxel_albedo_15"})
        for (const char* ending : {".0000.exr", ".0000.png", ".0001.exr", ".0001.png"})
            expected.insert(std::string(channel) + ending);
    EXPECT_EQ(files, expected);

    const auto largest = [&](const char* channel) {
        const std::vector<float> pixels = picture("levels", "shot", channel, 0).data;
        return *std::max_element(pixels.begin(), pixels.end());
    };
    EXPECT_GT(largest("cascade"), 0);
    EXPECT_GT(largest("voxel_albedo:1"), 0.1);
    EXPECT_EQ(largest("voxel_albedo:15"), 0) << "a level that there is not is black";
    EXPECT_EQ(picture("levels", "shot", "cascade", 0).channels, 3);
    EXPECT_EQ(picture("levels", "shot", "seam", 0).channels, 1);

    const json figures = stats("levels", "shot");
    for (const json& frame : figures["frames"]) {
        ASSERT_FALSE(frame["seam"].empty());
        for (const json& step : frame["seam"]) {
            EXPECT_THAT(step["level"].get<int>(), testing::AnyOf(0, 1));
            EXPECT_GT(step["pixels"].get<int>(), 0);
            EXPECT_LE(std::abs(step["mean"].get<double>()), step["rms"].get<double>() * (1 + 1e-6));
        }
    }
    EXPECT_FALSE(figures["frames"][0].contains("temporal"));
    const auto keysOf = [](const json& object) {
        std::set<std::string> keys;
        for (const auto& [key, value] : object.items()) keys.insert(key);
        return keys;
    };
    const json &change = figures["frames"][1]["temporal"], &figure = figures["temporal"];
    EXPECT_EQ(keysOf(change), (std::set<std::string>{"jump", "mean", "picture", "rms", "valid"}));
    EXPECT_EQ(keysOf(change["picture"]), (std::set<std::string>{"jump", "mean", "rms", "valid"}));
    EXPECT_EQ(keysOf(figure), (std::set<std::string>{"F", "mean", "picture", "valid", "worst_jump", "worst_rms"}));
    EXPECT_EQ(keysOf(figure["picture"]), (std::set<std::string>{"F", "mean", "valid", "worst_jump", "worst_rms"}));
    EXPECT_GT(change["valid"].get<double>(), 0.5);
    EXPECT_NEAR(figure["F"].get<double>(), change["rms"].get<double>() / change["mean"].get<double>(), 1e-9);

    shot["channels"] = {"voxel_albedo:16"};
    const Outcome beyond = run("beyond", script);
    EXPECT_EQ(beyond.status, 3);
    EXPECT_THAT(beyond.err, HasSubstr("shots[0].channels[0]"));
}

TEST_F(Cascade, InfoListsTheLevelsThatAreLeftOut) {
    json script = basicScript();
    script["shots"][0]["camera"] = {{"position", {2, 2, 3}}, {"target", {0, 0, 0}}};
    script["shots"][0]["channels"] = {"beauty"};
    // 16 voxels of 1 m hold the scene of 8 m at once.
    script["settings"]["voxel"]["size"] = 1;
    const fs::path file = folder_.path() / "script.json";
    std::ofstream(file) << script.dump(1);
    const Outcome outcome = voxcone({"info", file.string(), "--json"});
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    int allocated = 0, leftOut = 0;
    const json facts = json::parse(outcome.out);
    for (const json& level : facts["levels"]) {
        if (level["kind"] == "mip") continue;
        if (level["left_out"] == "") {
            ++allocated;
            EXPECT_EQ(level["level"], 0);
            EXPECT_GT(level["volume_bytes"].get<int>(), 0);
        } else {
            ++leftOut;
            EXPECT_EQ(level["left_out"], "level 0 holds the whole scene");
            EXPECT_EQ(level["volume_bytes"], 0);
        }
    }
    EXPECT_EQ(allocated, 1);
    EXPECT_EQ(leftOut, 2);
    EXPECT_THAT(voxcone({"info", file.string()}).out, HasSubstr("not allocated, level 0 holds the whole scene"));
}

}  // namespace
}  // namespace voxcone
