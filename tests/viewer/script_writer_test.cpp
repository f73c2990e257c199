// Views written as capture scripts are read back as they were.
#include "viewer/script_writer.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>

#include "viewer/camera_control.h"
#include "viewer/settings_history.h"

namespace voxcone {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

class ScriptWriter : public testing::Test {
  protected:
    ScriptWriter() {
        std::string name = (fs::temp_directory_path() / "voxcone_writer_XXXXXX").string();
        folder_ = mkdtemp(name.data());
    }
    ~ScriptWriter() override { fs::remove_all(folder_); }

    /// Opens `file`, writes a script of `views` and reads that.
    CaptureScript roundTrip(const fs::path& file, const std::vector<SavedView>& views, const Settings& settings,
                            const std::function<void(std::vector<Light>&)>& move = {}) {
        const CaptureScript given = loadCaptureScript(file);
        std::vector<Light> lights = given.scene.lights;
        if (move) move(lights);
        const json tree = captureScript({file, {}, &given.scene}, lights, placed_, settings, views);
        const fs::path written = folder_ / "script.json";
        std::ofstream(written) << tree.dump(2);
        return loadCaptureScript(written);
    }

    static SavedView someView() {
        CameraControl control;
        Camera camera;
        camera.position = {1.1, 2.3, 4.7};
        camera.target = {0.1, 0.7, -0.3};
        control.set(camera);
        control.orbit(0.123, 0.05);
        SavedView view;
        view.name = "view1";
        view.camera = control.camera();
        view.camera.up = control.up();
        view.camera.verticalFovDeg = 37.25;
        view.channel = "voxel_albedo:1";
        view.time = 1.0 / 3;
        return view;
    }

    fs::path folder_;
    std::map<int, Placement> placed_;
};

const fs::path kCaptures = VOXCONE_SOURCE_DIR "/assets/captures";

TEST_F(ScriptWriter, ViewsComeBackBitForBit) {
    const SavedView view = someView();
    Settings settings;
    settings.cone.gain = 1.0 / 7;
    settings.voxel.resolution = 32;
    const CaptureScript script = roundTrip(kCaptures / "cornell.json", {view}, settings);
    ASSERT_EQ(script.shots.size(), 1u);
    const Shot& shot = script.shots[0];
    EXPECT_EQ(shot.channels, std::vector<std::string>{"voxel_albedo:1"});
    EXPECT_EQ(shot.timeOf(shot.firstFrame), view.time);
    CameraControl control;
    control.set(view.camera);
    const Camera read = cameraAt(shot, script.scene, view.time), wanted = control.camera();
    EXPECT_EQ(read.position, wanted.position);
    EXPECT_EQ(read.target, wanted.target);
    EXPECT_EQ(read.up, wanted.up);
    EXPECT_EQ(read.verticalFovDeg, wanted.verticalFovDeg);
    EXPECT_TRUE(sameSettings(script.settings, settings));
}

TEST_F(ScriptWriter, TheSceneStaysAsTheScriptHasIt) {
    for (const char* name : {"cornell.json", "basic.json", "spheres.json", "walk.json", "glass.json"}) {
        const CaptureScript given = loadCaptureScript(kCaptures / name);
        const CaptureScript read = roundTrip(kCaptures / name, {someView()}, given.settings);
        EXPECT_EQ(read.scene.lights, given.scene.lights) << name;
        EXPECT_EQ(read.scene.environment.color, given.scene.environment.color) << name;
        EXPECT_EQ(read.scene.environment.rotationDeg, given.scene.environment.rotationDeg) << name;
        EXPECT_EQ(read.scene.environment.radiance, given.scene.environment.radiance) << name;
        EXPECT_EQ(read.scene.animations.size(), given.scene.animations.size()) << name;
    }
}

TEST_F(ScriptWriter, ABareSceneKeepsTheSunItWasGiven) {
    const fs::path file = VOXCONE_SOURCE_DIR "/assets/scenes/basic.gltf";
    const CaptureScript given = loadCaptureScript(file);
    ASSERT_FALSE(given.scene.lights.empty());
    const CaptureScript read = roundTrip(file, {someView()}, given.settings);
    EXPECT_EQ(read.scene.lights, given.scene.lights);
    EXPECT_EQ(read.scene.environment.color, given.scene.environment.color);
}

TEST_F(ScriptWriter, MovedLightsAreWritten) {
    const CaptureScript read =
        roundTrip(kCaptures / "cornell.json", {someView()}, Settings{}, [](std::vector<Light>& lights) {
            lights[0].position = {0.1, 4.9, -2.0};
            lights[0].intensity = {1, 2, 3};
        });
    ASSERT_EQ(read.scene.lights.size(), 1u);
    EXPECT_EQ(read.scene.lights[0].position, glm::dvec3(0.1, 4.9, -2.0));
    EXPECT_EQ(read.scene.lights[0].intensity, glm::vec3(1, 2, 3));
    EXPECT_EQ(read.scene.lights[0].width, 1.30);
}

TEST_F(ScriptWriter, MovedObjectsAreWritten) {
    placed_[4] = {glm::dvec3(0.1, 0, 1.0 / 3), glm::dvec3(0, 17.1, 0), {}};
    placed_[1] = {{}, {}, glm::dvec3(0.5, 1, 0.7)};
    const CaptureScript given = loadCaptureScript(kCaptures / "cornell.json");
    const CaptureScript read = roundTrip(kCaptures / "cornell.json", {someView()}, Settings{});
    for (std::size_t i = 0; i < given.scene.nodes.size(); ++i) {
        Node wanted = given.scene.nodes[i];
        if (placed_.contains(static_cast<int>(i))) {
            ASSERT_TRUE(place(wanted, placed_[static_cast<int>(i)]));
        }
        const Node& node = read.scene.nodes[i];
        EXPECT_EQ(node.translation, wanted.translation) << node.name;
        EXPECT_EQ(node.rotation, wanted.rotation) << node.name;
        EXPECT_EQ(node.scale, wanted.scale) << node.name;
    }
    // Written again, with something else moved, both stand.
    json tree = json::parse(std::ifstream(folder_ / "script.json"));
    fs::rename(folder_ / "script.json", folder_ / "first.json");
    placed_ = {{4, {glm::dvec3(0, 1, 0), {}, {}}}};
    const CaptureScript again = roundTrip(folder_ / "first.json", {someView()}, Settings{});
    EXPECT_EQ(again.scene.nodes[4].translation, glm::dvec3(0, 1, 0));
    EXPECT_EQ(again.scene.nodes[4].rotation, read.scene.nodes[4].rotation);
    EXPECT_EQ(again.scene.nodes[1].scale, read.scene.nodes[1].scale);
    EXPECT_EQ(json::parse(std::ifstream(folder_ / "script.json"))["objects"].size(), 2u);
}

TEST_F(ScriptWriter, MovedLightsOfTheSceneAreWritten) {
    // The basic scene with a spot on its cube.
    json scene = json::parse(std::ifstream(VOXCONE_SOURCE_DIR "/assets/scenes/basic.gltf"));
    for (json& buffer : scene["buffers"])
        if (!buffer["uri"].get<std::string>().starts_with("data:"))
            fs::copy(fs::path(VOXCONE_SOURCE_DIR "/assets/scenes") / buffer["uri"], folder_);
    scene["extensionsUsed"] = {"KHR_lights_punctual"};
    scene["extensions"]["KHR_lights_punctual"]["lights"] =
        json::parse(R"([{"type": "spot", "spot": {}}, {"type": "point"}])");
    scene["nodes"][2]["extensions"]["KHR_lights_punctual"]["light"] = 0;
    scene["nodes"][1]["extensions"]["KHR_lights_punctual"]["light"] = 1;
    std::ofstream(folder_ / "lit.gltf") << scene.dump();
    const glm::dvec3 direction = glm::normalize(glm::dvec3(0.3, -1, 0.2));
    const auto change = [&](std::vector<Light>& lights) {
        ASSERT_EQ(lights.size(), 2u);
        lights[1].direction = direction;
        lights[1].position = {0.1, 0.7, 0};
        lights[0].intensity = {0.1f, 0.2f, 0.3f};
    };
    const CaptureScript read = roundTrip(folder_ / "lit.gltf", {someView()}, Settings{}, change);
    std::vector<Light> wanted = loadCaptureScript(folder_ / "lit.gltf").scene.lights;
    change(wanted);
    EXPECT_EQ(read.scene.lights, wanted) << "bit for bit";
    const json written = json::parse(std::ifstream(folder_ / "script.json"));
    EXPECT_FALSE(written.contains("lights"));
    EXPECT_EQ(written["scene_lights"].size(), 2u);
    EXPECT_FALSE(written["scene_lights"][0].contains("position"));
}

TEST_F(ScriptWriter, TurnedRectanglesKeepTheirBits) {
    const glm::dvec3 direction = glm::normalize(glm::dvec3(0.3, -1, 0.2));
    const glm::dvec3 up = uprightOf(glm::dvec3(0.2, 0.1, 1), direction);
    const CaptureScript read =
        roundTrip(kCaptures / "cornell.json", {someView()}, Settings{}, [&](std::vector<Light>& lights) {
            lights[0].direction = direction;
            lights[0].up = up;
        });
    EXPECT_EQ(read.scene.lights[0].direction, direction);
    EXPECT_EQ(read.scene.lights[0].up, up);
}

TEST_F(ScriptWriter, APathIsReplayedAsItWasRecorded) {
    SavedView view = someView();
    view.name = "path1";
    view.time = 0.5;
    for (int i = 0; i < 6; ++i) {
        view.path.position.times.push_back(0.1 * i);
        view.path.target.times.push_back(0.1 * i);
        view.path.position.values.push_back({0.3 * i, 1 + 0.01 * i * i, 5});
        view.path.target.values.push_back({0, 1, 0});
    }
    view.path.position.interpolation = view.path.target.interpolation = Interpolation::catmull_rom;
    EXPECT_EQ(view.frames(), 13);
    const CaptureScript script = roundTrip(kCaptures / "cornell.json", {view}, Settings{});
    const Shot& shot = script.shots.at(0);
    EXPECT_EQ(shot.frameCount(), 13);
    EXPECT_EQ(shot.timeOf(0), 0.5);
    for (int frame : {0, 5, 12}) {
        const double time = shot.timeOf(frame);
        const Camera camera = cameraAt(shot, script.scene, time);
        EXPECT_LT(glm::length(camera.position - view.path.position.at(time - 0.5)), 1e-12);
    }
}

}  // namespace
}  // namespace voxcone
