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
        lost_.clear();
        const json tree = captureScript({file, {}, &given.scene}, lights, settings, views, lost_);
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
    std::vector<std::string> lost_;
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
        EXPECT_TRUE(lost_.empty());
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
