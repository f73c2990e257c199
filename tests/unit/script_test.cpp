// Capture scripts: what they give, and what is said about wrong ones.
#include "capture/script.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "core/voxel_channel.h"
#include "scene/placement.h"

namespace voxcone {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::StartsWith;

const fs::path kAssets = fs::path(VOXCONE_SOURCE_DIR) / "assets";

/// A glTF with one triangle and two cameras; `emissive` and `light` are added on demand.
json triangleScene(bool emissive, bool camera) {
    json scene = json::parse(R"({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}],
        "materials": [{"name": "m"}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0,0,0], "max": [1,1,0]}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "buffers": [{"byteLength": 36,
            "uri": "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]})");
    if (emissive) scene["materials"][0]["emissiveFactor"] = {1, 1, 1};
    if (camera) {
        scene["cameras"] =
            json::parse(R"([{"name": "left", "type": "perspective", "perspective": {"yfov": 0.5, "znear": 0.1}},
                                           {"name": "right", "type": "perspective", "perspective": {"yfov": 1, "znear": 0.1}}])");
        scene["nodes"].push_back({{"camera", 0}, {"translation", {0, 0, 3}}});
        scene["nodes"].push_back({{"camera", 1}, {"translation", {1, 0, 3}}});
        scene["scenes"][0]["nodes"] = {0, 1, 2};
    }
    return scene;
}

class Script : public testing::Test {
  protected:
    Script() {
        fs::create_directories(folder_);
        write("scene.gltf", triangleScene(false, true).dump());
        script_ = json::parse(R"({ "version": 1, "scene": "scene.gltf",
            "environment": {"color": [1, 2, 3], "intensity": 2, "rotation_deg": 90},
            "lights": [
              {"type": "directional", "direction": [0, -2, 0], "intensity": 3, "angular_radius_deg": 0.27},
              {"type": "point", "position": [1, 2, 3], "intensity": [1, 1, 1], "range": 7},
              {"type": "spot", "position": [0, 1, 0], "direction": [0, -1, 0], "intensity": [1, 1, 1],
               "inner_cone_deg": 10, "outer_cone_deg": 30},
              {"type": "sphere", "position": [0, 1.8, 0], "radius": 0.1, "intensity": [4, 4, 4]},
              {"type": "rectangle", "position": [0, 2, 0], "direction": [0, -1, 0], "up": [0, 3, 1], "width": 2, "height": 1,
               "intensity": [5, 5, 5]}],
            "settings": {"preset": "fast", "output": {"width": 64, "height": 36}},
            "shots": [
              {"name": "a", "camera": {"position": [0, 1, 3], "target": [0, 1, 0], "fov_deg": 50}, "channels": ["beauty", "ao"]},
              {"name": "b", "camera": {"scene_camera": "right"}, "channels": ["depth"], "frames": 3},
              {"name": "c", "camera": {"scene_camera": 0}, "channels": ["voxel_opacity"]}]})");
    }
    ~Script() override { fs::remove_all(folder_); }

    void write(const std::string& name, const std::string& text) { std::ofstream(folder_ / name) << text; }

    CaptureScript load() {
        write("script.json", script_.dump(1));
        return loadCaptureScript(folder_ / "script.json");
    }

    /// The message without the folder, or "" when the script loads.
    std::string messageOf(const fs::path& file) {
        try {
            loadCaptureScript(file);
            return "";
        } catch (const InputError& error) {
            std::string line = error.what();
            EXPECT_EQ(line.find('\n'), std::string::npos) << line;
            const std::string folder = folder_.string() + "/";
            return line.starts_with(folder) ? line.substr(folder.size()) : line;
        }
    }

    /// The message after `value` was put at the JSON pointer `at`.
    std::string with(const char* at, const json& value) {
        const json before = script_;
        script_[json::json_pointer(at)] = value;
        write("script.json", script_.dump(1));
        script_ = before;
        return messageOf(folder_ / "script.json");
    }

    std::string without(const char* parent, const char* key) {
        const json before = script_;
        script_[json::json_pointer(parent)].erase(key);
        write("script.json", script_.dump(1));
        script_ = before;
        return messageOf(folder_ / "script.json");
    }

    fs::path folder_ = fs::temp_directory_path() / ("voxcone_script_" + std::to_string(getpid()));
    json script_;
};

TEST_F(Script, GivesSceneLightsEnvironmentSettingsAndShots) {
    const CaptureScript script = load();
    EXPECT_EQ(script.scene.triangleCount(), 1u);
    EXPECT_EQ(script.scene.environment.color, glm::vec3(2, 4, 6));
    EXPECT_EQ(script.scene.environment.rotationDeg, 90);
    ASSERT_EQ(script.scene.lights.size(), 5u);
    const auto& lights = script.scene.lights;
    EXPECT_EQ(lights[0].type, LightType::directional);
    EXPECT_EQ(lights[0].direction, glm::dvec3(0, -1, 0));
    EXPECT_EQ(lights[0].intensity, glm::vec3(3));
    EXPECT_DOUBLE_EQ(lights[0].angularRadius, glm::radians(0.27));
    EXPECT_EQ(lights[1].range, 7);
    EXPECT_NEAR(lights[2].outerConeAngle, 0.5236, 1e-4);
    EXPECT_NEAR(lights[2].innerConeAngle, 0.17453, 1e-4);
    EXPECT_EQ(lights[3].radius, 0.1);
    EXPECT_EQ(lights[3].position, glm::dvec3(0, 1.8, 0));
    EXPECT_EQ(lights[4].up, glm::dvec3(0, 0, 1));  // made perpendicular to the direction
    EXPECT_EQ(lights[4].width, 2);
    EXPECT_EQ(script.settings.output.width, 64);
    EXPECT_EQ(script.settings.cone.diffuse, 6);
    ASSERT_EQ(script.shots.size(), 3u);
    EXPECT_THAT(script.shots[0].channels, ElementsAre("beauty", "ao"));
    EXPECT_EQ(script.shots[0].camera.verticalFovDeg, 50);
    EXPECT_EQ(script.shots[0].frameCount(), 1);
    EXPECT_TRUE(script.shots[0].path.empty());
    EXPECT_EQ(script.shots[1].camera.name, "right");
    EXPECT_EQ(script.shots[1].firstFrame, 0);
    EXPECT_EQ(script.shots[1].lastFrame, 2);
    EXPECT_EQ(script.shots[1].fps, 24);
    EXPECT_EQ(script.shots[2].camera.name, "left");
}

TEST_F(Script, SyntaxErrorsHaveLineAndColumn) {
    write("s.json", "{ \"version\": 1,\n  \"scene\": }\n");
    EXPECT_THAT(messageOf(folder_ / "s.json"), StartsWith("s.json: line 2, column 12: not valid JSON: "));
    write("s.json", "");
    EXPECT_THAT(messageOf(folder_ / "s.json"), StartsWith("s.json: line 1, column 1: not valid JSON: "));
    write("s.json", "{ \"version\": 1e999 }");
    EXPECT_THAT(messageOf(folder_ / "s.json"), HasSubstr("not valid JSON"));
    write("s.json", "{ \"version\": 1, \"version\": 1 }");
    EXPECT_THAT(messageOf(folder_ / "s.json"), HasSubstr("\"version\" stands twice"));
    write("s.json", "[1, 2]");
    EXPECT_THAT(messageOf(folder_ / "s.json"), HasSubstr("must be an object, is an array"));
}

TEST_F(Script, UnknownKeysNameTheNearestRightOne) {
    EXPECT_THAT(with("/shoots", 1),
                AllOf(StartsWith("script.json: shoots: unknown key"), HasSubstr("did you mean \"shots\"?")));
    EXPECT_THAT(with("/shots/1/chanels", 1),
                AllOf(StartsWith("script.json: shots[1].chanels: "), HasSubstr("did you mean \"channels\"?")));
    EXPECT_THAT(with("/shots/0/camera/fov", 1),
                AllOf(StartsWith("script.json: shots[0].camera.fov: "), HasSubstr("\"fov_deg\"")));
    EXPECT_THAT(with("/lights/3/radios", 1),
                AllOf(StartsWith("script.json: lights[3].radios: "), HasSubstr("\"radius\"")));
    EXPECT_THAT(with("/lights/1/radius", 1), HasSubstr("unknown key"));  // a point light has none
    EXPECT_THAT(with("/environment/colour", 1), HasSubstr("environment.colour: unknown key; did you mean \"color\"?"));
    EXPECT_THAT(with("/settings/voxels", 1), StartsWith("script.json: settings.voxels: "));
}

TEST_F(Script, MissingKeysAreNamed) {
    EXPECT_EQ(without("", "version"), "script.json: version: is missing");
    EXPECT_EQ(without("", "scene"), "script.json: scene: is missing");
    EXPECT_EQ(without("", "shots"), "script.json: shots: is missing");
    EXPECT_EQ(without("/shots/0", "camera"), "script.json: shots[0].camera: is missing");
    EXPECT_EQ(without("/shots/0", "channels"), "script.json: shots[0].channels: is missing");
    EXPECT_EQ(without("/shots/0/camera", "target"), "script.json: shots[0].camera.target: is missing");
    EXPECT_EQ(without("/lights/3", "radius"), "script.json: lights[3].radius: is missing");
    EXPECT_EQ(without("/lights/0", "intensity"), "script.json: lights[0].intensity: is missing");
    EXPECT_EQ(without("", "lights"), "");
    EXPECT_EQ(without("", "environment"), "");
    EXPECT_EQ(without("", "settings"), "");
}

TEST_F(Script, WrongTypesAndRangesAreNamed) {
    EXPECT_THAT(with("/version", 2), StartsWith("script.json: version: 2 is not supported"));
    EXPECT_THAT(with("/version", "1"), StartsWith("script.json: version: must be a number, is a string"));
    EXPECT_THAT(with("/scene", "none.gltf"), StartsWith("script.json: scene: no such file: "));
    EXPECT_THAT(with("/scene", nullptr), StartsWith("script.json: scene: must be a string, is null"));
    EXPECT_THAT(with("/lights", json::object()), StartsWith("script.json: lights: must be an array"));
    EXPECT_THAT(with("/lights/0", 5), StartsWith("script.json: lights[0]: must be an object"));
    EXPECT_THAT(with("/lights/0/type", "spote"),
                AllOf(StartsWith("script.json: lights[0].type: "), HasSubstr("\"spot\"")));
    EXPECT_THAT(with("/lights/0/direction", {0, 0, 0}),
                StartsWith("script.json: lights[0].direction: must not be zero"));
    EXPECT_THAT(with("/lights/0/direction", {0, 0}), HasSubstr("array of 3 numbers"));
    EXPECT_THAT(with("/lights/0/direction", {0, "x", 0}),
                StartsWith("script.json: lights[0].direction[1]: must be a number"));
    EXPECT_THAT(with("/lights/0/intensity", -1), StartsWith("script.json: lights[0].intensity: -1 is out of range"));
    EXPECT_THAT(with("/lights/0/angular_radius_deg", 50), HasSubstr("0 to 45 degrees"));
    EXPECT_THAT(with("/lights/2/outer_cone_deg", 120), HasSubstr("0 to 90 degrees"));
    EXPECT_THAT(with("/lights/2/inner_cone_deg", 40), HasSubstr("must be below outer_cone_deg"));
    EXPECT_THAT(with("/lights/3/radius", 0), StartsWith("script.json: lights[3].radius: must be above 0"));
    EXPECT_THAT(with("/lights/4/up", {0, 1, 0}), StartsWith("script.json: lights[4].up: must not be parallel"));
    EXPECT_THAT(with("/environment/image", "a.hdr"), HasSubstr("either \"image\" or \"color\""));
    EXPECT_THAT(with("/environment", json::object()), HasSubstr("either \"image\" or \"color\""));
    EXPECT_THAT(with("/environment", {{"image", "absent.hdr"}}), HasSubstr("absent.hdr"));
    EXPECT_THAT(with("/shots", json::array()), StartsWith("script.json: shots: must be an array with at least one"));
    EXPECT_THAT(with("/shots/0/camera/fov_deg", 180),
                StartsWith("script.json: shots[0].camera.fov_deg: 180 is out of range"));
    EXPECT_THAT(with("/shots/0/camera/target", {0, 1, 3}), HasSubstr("must differ from position"));
    EXPECT_THAT(with("/shots/0/camera/up", {0, 0, 1}),
                StartsWith("script.json: shots[0].camera.up: must not be parallel"));
    EXPECT_THAT(with("/shots/0/channels", json::array()), HasSubstr("at least one channel"));
    EXPECT_THAT(with("/shots/0/channels/1", "aoo"),
                AllOf(StartsWith("script.json: shots[0].channels[1]: "), HasSubstr("\"ao\"")));
    EXPECT_THAT(with("/shots/0/channels/1", "beauty"), HasSubstr("twice"));
    EXPECT_THAT(with("/shots/0/frames", 0), StartsWith("script.json: shots[0].frames: 0 is out of range"));
    EXPECT_THAT(with("/shots/0/frames", 1.5), HasSubstr("whole number"));
    EXPECT_THAT(with("/shots/1/name", "a"), StartsWith("script.json: shots[1].name: \"a\" is another shot's name"));
    for (const char* name : {"", "..", "a/b", "a b", ".hidden"})
        EXPECT_THAT(with("/shots/0/name", name), StartsWith("script.json: shots[0].name: ")) << name;
    EXPECT_THAT(with("/shots/1/camera/scene_camera", "rigth"),
                AllOf(HasSubstr("no camera \"rigth\""), HasSubstr("\"left\", \"right\"")));
    EXPECT_THAT(with("/shots/1/camera/scene_camera", 2), HasSubstr("0 to 1"));
    EXPECT_THAT(with("/settings/output/width", -5), StartsWith("script.json: settings.output.width: "));
}

const char* const kPath = R"({"up": [0, 2, 0], "fov_deg": 60, "path": [
    {"time": 0, "position": [0, 0, 0], "target": [0, 0, -1]},
    {"time": 1, "position": [1, 0, 0], "target": [1, 0, -1]},
    {"time": 3, "position": [1, 0, 4], "target": [9, 0, 4]}]})";

TEST_F(Script, FramesAreANumberOrARangeAtTimesOfTheirOwn) {
    script_["shots"][0]["frames"] = {{"first", 7}, {"last", 9}};
    script_["shots"][0]["fps"] = 10;
    script_["shots"][0]["start"] = -0.5;
    script_["shots"][0]["temporal"] = true;
    const Shot shot = load().shots[0];
    EXPECT_EQ(shot.firstFrame, 7);
    EXPECT_EQ(shot.lastFrame, 9);
    EXPECT_EQ(shot.frameCount(), 3);
    EXPECT_TRUE(shot.temporal);
    EXPECT_EQ(shot.timeOf(0), -0.5);
    EXPECT_EQ(shot.timeOf(9), -0.5 + 9 / 10.0);

    EXPECT_THAT(with("/shots/0/frames", {{"first", 3}, {"last", 2}}),
                StartsWith("script.json: shots[0].frames.last: 2 is out of range: 3 to "));
    EXPECT_EQ(with("/shots/0/frames", {{"first", 3}}), "script.json: shots[0].frames.last: is missing");
    EXPECT_THAT(with("/shots/0/frames", {{"first", -1}, {"last", 2}}), HasSubstr("frames.first: -1 is out of range"));
    EXPECT_THAT(with("/shots/0/frames", {{"first", 0}, {"last", 2}, {"step", 2}}),
                HasSubstr("frames.step: unknown key"));
    EXPECT_THAT(with("/shots/0/frames", "all"), HasSubstr("frames: must be a number, is a string"));
    EXPECT_THAT(with("/shots/0/fps", 0), StartsWith("script.json: shots[0].fps: 0 is out of range"));
    EXPECT_THAT(with("/shots/0/temporal", 1), HasSubstr("temporal: must be true or false, is a number"));
    EXPECT_THAT(with("/shots/0/frames", 1), StartsWith("script.json: shots[0].temporal: needs more than one frame"));
}

TEST_F(Script, CameraPathsPassThroughTheirKeysAndStayAtTheirEnds) {
    script_["shots"][0]["camera"] = json::parse(kPath);
    for (const char* interpolation : {"catmull_rom", "linear"}) {
        script_["shots"][0]["camera"]["interpolation"] = interpolation;
        const CaptureScript script = load();
        const Shot& shot = script.shots[0];
        const auto at = [&](double time) { return cameraAt(shot, script.scene, time); };
        EXPECT_EQ(at(0).position, glm::dvec3(0));
        EXPECT_EQ(at(1).position, glm::dvec3(1, 0, 0));
        EXPECT_EQ(at(1).target, glm::dvec3(1, 0, -1));
        EXPECT_EQ(at(-5).position, glm::dvec3(0));
        EXPECT_EQ(at(50).target, glm::dvec3(9, 0, 4));
        EXPECT_EQ(at(2).verticalFovDeg, 60);
        for (const double time : {0.0, 0.3, 1.7, 2.9}) {
            const Camera camera = at(time);
            EXPECT_NEAR(glm::length(camera.up), 1, 1e-12);
            EXPECT_NEAR(glm::dot(camera.up, camera.target - camera.position), 0, 1e-12);
        }
    }
    // Half way of the first piece: Hermite with the slopes 1 (one-sided) and (1 − 0)/(3 − 0); linear is at 0.5.
    EXPECT_EQ(cameraAt(load().shots[0], load().scene, 0.5).position.x, 0.5);
    script_["shots"][0]["camera"].erase("interpolation");
    EXPECT_NEAR(cameraAt(load().shots[0], load().scene, 0.5).position.x, 0.5 + (1 - 1.0 / 3) / 8, 1e-12);
}

TEST_F(Script, WrongCameraPathsAreNamed) {
    script_["shots"][0]["camera"] = json::parse(kPath);
    const std::string path = "script.json: shots[0].camera.path";
    EXPECT_EQ(with("/shots/0/camera/path", json::array()), path + ": must be an array of at least two keys");
    EXPECT_EQ(with("/shots/0/camera/path", {script_["shots"][0]["camera"]["path"][0]}),
              path + ": must be an array of at least two keys");
    EXPECT_EQ(with("/shots/0/camera/path/2/time", 1),
              path + "[2].time: 1 must be later than that of the key before, 1");
    EXPECT_EQ(without("/shots/0/camera/path/1", "time"), path + "[1].time: is missing");
    EXPECT_EQ(without("/shots/0/camera/path/1", "target"), path + "[1].target: is missing");
    EXPECT_THAT(with("/shots/0/camera/path/1/fov", 3), StartsWith(path + "[1].fov: unknown key"));
    EXPECT_THAT(with("/shots/0/camera/path/1/position", {0, 1e300, 0}),
                StartsWith(path + "[1].position[1]: 1e+300 is out of range"));
    EXPECT_THAT(with("/shots/0/camera/position", {0, 0, 0}), HasSubstr("stands instead of position and target"));
    EXPECT_THAT(with("/shots/0/camera/interpolation", "catmul"), HasSubstr("did you mean \"catmull_rom\"?"));
    EXPECT_EQ(with("/shots/0/camera/path/0/target", {0, 0, 0}),
              path + ": in frame 0, at 0 s, the camera is at its target");
    EXPECT_EQ(with("/shots/0/camera/path/0/target", {0, 1, 0}),
              path + ": in frame 0, at 0 s, the camera looks along its up direction");
    EXPECT_THAT(with("/shots/0/camera/up", {0, 0, 0}), HasSubstr("camera.up: must not be zero"));
}

TEST_F(Script, LightsMoveTurnAndChange) {
    script_["lights"] = json::parse(R"([
        {"type": "sphere", "radius": 0.1, "intensity": 6, "interpolation": "linear",
         "path": [{"time": 1, "position": [0, 2, 0]}, {"time": 2, "position": [4, 2, 0]}]},
        {"type": "rectangle", "position": [0, 2, 0], "up": [0, 0, 1], "width": 2, "height": 1,
         "path": [{"time": 0, "direction": [0, -3, 0], "intensity": 1}, {"time": 2, "direction": [0, 0, 1], "intensity": [3, 5, 7]}]}])");
    const CaptureScript script = load();
    EXPECT_EQ(script.scene.lights[0].position, glm::dvec3(0, 2, 0));
    EXPECT_EQ(script.scene.lights[1].direction, glm::dvec3(0, -1, 0));
    EXPECT_EQ(script.scene.lights[1].intensity, glm::vec3(1));
    const std::vector<Light> lights = script.scene.lightsAt(1.25);
    EXPECT_EQ(lights[0].position, glm::dvec3(1, 2, 0));
    EXPECT_EQ(lights[0].intensity, glm::vec3(6));
    // Half way between two keys, a spline with one-sided slopes is the mean of them.
    const Light half = script.scene.lightsAt(1)[1];
    EXPECT_EQ(half.intensity, glm::vec3(2, 3, 4));
    EXPECT_NEAR(glm::dot(half.direction, glm::normalize(glm::dvec3(0, -1, 1))), 1, 1e-12);
    EXPECT_NEAR(glm::dot(half.direction, half.up), 0, 1e-12);
}

TEST_F(Script, WrongLightPathsAreNamed) {
    const json two = json::parse(R"([{"time": 0, "position": [0, 0, 0]}, {"time": 1, "position": [1, 0, 0]}])");
    EXPECT_EQ(with("/lights/1/path", two), "script.json: lights[1].position: is given by the path");
    script_["lights"][1].erase("position");
    EXPECT_EQ(with("/lights/1/path", two), "");
    EXPECT_EQ(without("/lights/1", "intensity"), "script.json: lights[1].intensity: is missing");
    script_["lights"][1]["path"] = two;
    EXPECT_EQ(with("/lights/1/path", json::array()),
              "script.json: lights[1].path: must be an array of at least two keys");
    EXPECT_EQ(with("/lights/1/path/1/time", 0),
              "script.json: lights[1].path[1].time: 0 must be later than that of the key before, 0");
    EXPECT_EQ(with("/lights/1/path/1/intensity", 1),
              "script.json: lights[1].path[1].intensity: is absent from the keys before; all must have the same");
    EXPECT_THAT(with("/lights/1/path/1/direction", {0, 1, 0}), HasSubstr("path[1].direction: unknown key"));
    EXPECT_EQ(with("/lights/1/path", json::parse(R"([{"time": 0}, {"time": 1}])")),
              "script.json: lights[1].path: has keys without position, direction or intensity");
    EXPECT_THAT(with("/lights/0/interpolation", "linear"), HasSubstr("lights[0].interpolation: unknown key"));
}

/// The triangle's node is called "triangle" and turned by the file; its object of the script moves it.
class ScriptObjects : public Script {
  protected:
    ScriptObjects() {
        json scene = triangleScene(false, true);
        scene["nodes"][0]["name"] = "triangle";
        scene["nodes"][1]["name"] = scene["nodes"][2]["name"] = "twin";
        // Times 0 and 1, then quaternions: identity and a half turn about y. Scales share them: (0,0,0), (1,0,1).
        scene["buffers"].push_back({{"byteLength", 40},
                                    {"uri",
                                     "data:application/octet-stream;base64,"
                                     "AAAAAAAAgD8AAAAAAAAAAAAAAAAAAIA/AAAAAAAAgD8AAAAAAAAAAA=="}});
        scene["bufferViews"].push_back({{"buffer", 1}, {"byteLength", 40}});
        scene["accessors"].push_back(
            {{"bufferView", 1}, {"componentType", 5126}, {"count", 2}, {"type", "SCALAR"}, {"min", {0}}, {"max", {1}}});
        scene["accessors"].push_back(
            {{"bufferView", 1}, {"byteOffset", 8}, {"componentType", 5126}, {"count", 2}, {"type", "VEC4"}});
        scene["animations"] = json::parse(R"([{"samplers": [{"input": 1, "output": 2}],
            "channels": [{"sampler": 0, "target": {"node": 0, "path": "rotation"}}]}])");
        write("scene.gltf", scene.dump());
        script_["objects"] = json::parse(R"([{"node": "triangle", "path": [
            {"time": 0, "translation": [0, 0, 0], "scale": [1, 1, 1]},
            {"time": 1, "translation": [2, 0, 0], "scale": [3, 1, 1]},
            {"time": 3, "translation": [2, 8, 0], "scale": [3, 1, 1]}]}])");
    }

    glm::dvec3 moved(const CaptureScript& script, double time, const glm::dvec3& point) {
        return {script.scene.worldMatrices(time)[0] * glm::dvec4(point, 1)};
    }
};

void expectNear(const glm::dvec3& a, const glm::dvec3& b) {
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(a[i], b[i], 1e-6) << i;
}

TEST_F(ScriptObjects, BecomeAnimationsBesideThoseOfTheFile) {
    const CaptureScript script = load();
    ASSERT_EQ(script.scene.animations.size(), 2u);
    expectNear(moved(script, 0, {1, 0, 0}), {1, 0, 0});
    // The file's half turn about y is kept: x goes to −x.
    expectNear(moved(script, 1, {1, 0, 0}), {2 - 3, 0, 0});
    expectNear(moved(script, 9, {0, 1, 0}), {2, 9, 0});
    // As a track of the same keys, at any time.
    const Track track{Interpolation::catmull_rom, {0, 1, 3}, {{0, 0, 0}, {2, 0, 0}, {2, 8, 0}}};
    for (double time = 0; time < 3; time += 0.125) expectNear(moved(script, time, {0, 0, 0}), track.at(time));
}

TEST_F(ScriptObjects, ReplaceWhatTheFileAnimatesThere) {
    script_["objects"][0]["interpolation"] = "linear";
    script_["objects"][0]["path"] =
        json::parse(R"([{"time": 0, "rotation": [0, 0, 0]}, {"time": 2, "rotation": [90, 0, 90]}])");
    const CaptureScript script = load();
    ASSERT_EQ(script.scene.animations.size(), 1u);
    EXPECT_EQ(script.scene.animations[0].name, "script");
    // About x first: y goes to z and stays; z goes to −y, then to x.
    expectNear(moved(script, 2, {0, 1, 0}), {0, 0, 1});
    expectNear(moved(script, 2, {0, 0, 1}), {1, 0, 0});
    expectNear(moved(script, 2, {1, 0, 0}), {0, 1, 0});
    expectNear(moved(script, 0, {1, 2, 3}), {1, 2, 3});
    // The turn as a whole is one of 120 degrees about (1, 1, 1); half of it keeps that axis.
    expectNear(moved(script, 1, {1, 1, 1}), {1, 1, 1});
}

TEST_F(ScriptObjects, RotationsAboutOneAxisGoOn) {
    // 90 degrees a second, beyond a full turn: quaternions change their sign on the way.
    json path = json::array();
    for (int i = 0; i <= 6; ++i) path.push_back({{"time", i}, {"rotation", {0, 0, 90 * i}}});
    for (const char* interpolation : {"linear", "catmull_rom"}) {
        script_["objects"][0] = {{"node", "triangle"}, {"path", path}, {"interpolation", interpolation}};
        const CaptureScript script = load();
        for (int i = 0; i <= 12; ++i) {
            // Splines are symmetric about the middles of all pieces but the two at the ends, which have one-sided
            // slopes.
            if (interpolation == std::string("catmull_rom") && (i == 1 || i == 11)) continue;
            const double angle = glm::radians(45.0 * i);
            expectNear(moved(script, i / 2.0, {1, 0, 0}), {std::cos(angle), std::sin(angle), 0});
        }
    }
}

TEST_F(ScriptObjects, AMatrixIsTakenApartUnlessItShears) {
    json scene = json::parse(std::ifstream(folder_ / "scene.gltf"));
    scene.erase("animations");
    // Columns: y · 2, −x · 3, z · −4; origin (5, 6, 7).
    scene["nodes"][0]["matrix"] = {0, 2, 0, 0, -3, 0, 0, 0, 0, 0, -4, 0, 5, 6, 7, 1};
    write("scene.gltf", scene.dump());
    script_["objects"][0]["path"] =
        json::parse(R"([{"time": 0, "translation": [0, 0, 0]}, {"time": 1, "translation": [1, 0, 0]}])");
    const CaptureScript script = load();
    expectNear(moved(script, 1, {1, 1, 1}), {1 - 3, 2, -4});

    scene["nodes"][0]["matrix"] = {1, 0, 0, 0, 1, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    write("scene.gltf", scene.dump());
    EXPECT_EQ(with("/version", 1), "script.json: objects[0].node: has a matrix with shear, which keys cannot replace");
}

TEST_F(ScriptObjects, WrongOnesAreNamed) {
    EXPECT_EQ(with("/objects/0/node", "triange"),
              "script.json: objects[0].node: the scene has no node \"triange\"; did you mean \"triangle\"?");
    EXPECT_EQ(
        with("/objects/0/node", "twin"),
        "script.json: objects[0].node: the scene has several nodes \"twin\"; an index of the file's nodes is unique");
    EXPECT_EQ(with("/objects", json::object()), "script.json: objects: must be an array");
    EXPECT_EQ(with("/objects", {script_["objects"][0], script_["objects"][0]}),
              "script.json: objects[1].node: is moved by an object before");
    EXPECT_EQ(without("/objects/0/path/1", "scale"),
              "script.json: objects[0].path[1].scale: is missing; the keys before have it");
    EXPECT_EQ(with("/objects/0/path/1/rotation", {0, 0, 0}),
              "script.json: objects[0].path[1].rotation: is absent from the keys before; all must have the same");
    EXPECT_THAT(with("/objects/0/path/1/scale", {1, 0, 1}), HasSubstr("path[1].scale[1]: 0 is out of range"));
    EXPECT_EQ(with("/objects/0/path", json::parse(R"([{"time": 0}, {"time": 1}])")),
              "script.json: objects[0].path: has keys without translation, rotation or scale");
    EXPECT_EQ(
        with("/objects/0/path",
             json::parse(R"([{"time": 0, "rotation": [0, 10, 0]}, {"time": 1, "rotation": [0, 190, 0]}])")),
        "script.json: objects[0].path[1].rotation: must differ by less than 180 degrees from that of the key before");
    write("scene.gltf", triangleScene(false, true).dump());
    EXPECT_EQ(with("/version", 1), "script.json: objects[0].node: the scene has no nodes with names");
}

TEST_F(ScriptObjects, ArePutElsewhereWithoutAPath) {
    script_["objects"] = json::parse(R"([{"node": "triangle", "translation": [2, 0.1, 0], "scale": [1, 3, 1]}])");
    CaptureScript script = load();
    // The file still turns it about y.
    ASSERT_EQ(script.scene.animations.size(), 1u);
    expectNear(moved(script, 0, {1, 1, 0}), {3, 3.1, 0});
    expectNear(moved(script, 1, {1, 1, 0}), {1, 3.1, 0});
    EXPECT_EQ(script.scene.nodes[0].translation, glm::dvec3(2, 0.1, 0)) << "bit for bit";
    EXPECT_EQ(script.scene.nodes[1].translation, glm::dvec3(0, 0, 3)) << "others stay";

    // A rotation replaces that of the file, and then nothing moves any more. About x, then y, then z.
    script_["objects"] = json::parse(R"([{"node": 0, "rotation": [90, 0, 90]}])");
    script = load();
    EXPECT_TRUE(script.scene.animations.empty());
    for (const double time : {0.0, 1.0}) expectNear(moved(script, time, {0, 1, 0}), {0, 0, 1});
    EXPECT_EQ(script.scene.movingInstances(), std::vector<std::uint8_t>{0});

    // Nodes without a unique name have an index in the file; a path may leave properties to a place.
    script_["objects"] = json::parse(R"([{"node": 2, "translation": [5, 6, 7]}, {"node": "triangle",
        "scale": [2, 2, 2], "path": [{"time": 0, "translation": [0, 0, 0]}, {"time": 1, "translation": [1, 0, 0]}]}])");
    script = load();
    EXPECT_EQ(script.scene.nodes[2].translation, glm::dvec3(5, 6, 7));
    expectNear(moved(script, 0, {1, 1, 0}), {2, 2, 0});
    expectNear(moved(script, 1, {1, 1, 0}), {1 - 2, 2, 0});
}

TEST_F(ScriptObjects, WrongPlacesAreNamed) {
    const auto object = [&](const char* text) { return with("/objects", json::array({json::parse(text)})); };
    EXPECT_EQ(object(R"({"node": "triangle"})"),
              "script.json: objects[0]: has neither translation, rotation or scale nor a path of them");
    EXPECT_EQ(object(R"({"node": 7, "translation": [0, 0, 0]})"),
              "script.json: objects[0].node: the scene that is shown has no nodes[7]");
    EXPECT_THAT(object(R"({"node": true, "translation": [0, 0, 0]})"), HasSubstr("objects[0].node: must be a string"));
    EXPECT_THAT(object(R"({"node": 0, "scale": [1, 0, 1]})"), HasSubstr("objects[0].scale[1]: 0 is out of range"));
    EXPECT_THAT(object(R"({"node": 0, "scale": 2})"), HasSubstr("objects[0].scale: must be"));
    EXPECT_THAT(object(R"({"node": 0, "translation": [1, 2]})"), HasSubstr("objects[0].translation: must be"));
    EXPECT_THAT(object(R"({"node": 0, "rotation": [0, 1e6, 0]})"), HasSubstr("objects[0].rotation[1]: 1000000.0 is"));
    EXPECT_THAT(object(R"({"node": 0, "translate": [1, 2, 3]})"), HasSubstr("did you mean \"translation\"?"));
    EXPECT_EQ(
        object(R"({"node": 0, "translation": [1, 2, 3], "interpolation": "linear"})").find("script.json: objects[0]"),
        0u);
    EXPECT_EQ(object(R"({"node": 0, "translation": [1, 2, 3],
                         "path": [{"time": 0, "translation": [0, 0, 0]}, {"time": 1, "translation": [1, 0, 0]}]})"),
              "script.json: objects[0].translation: is given by the path");
    EXPECT_EQ(with("/objects", json::parse(R"([{"node": "triangle", "translation": [0, 0, 0]},
                                               {"node": 0, "scale": [1, 1, 1]}])")),
              "script.json: objects[1].node: is moved by an object before");
}

/// A scene with a point light "bulb", a spot "lamp" and two suns of one name, on nodes that are moved.
class SceneLights : public Script {
  protected:
    SceneLights() {
        json scene = triangleScene(false, true);
        scene["extensions"]["KHR_lights_punctual"]["lights"] = json::parse(R"([
            {"type": "point", "name": "bulb", "intensity": 5, "range": 9}, {"type": "directional", "name": "sun"},
            {"type": "spot", "name": "lamp", "spot": {"innerConeAngle": 0.1, "outerConeAngle": 0.5}}])");
        scene["extensionsUsed"] = {"KHR_lights_punctual"};
        for (const int light : {0, 1, 2, 1}) {
            scene["scenes"][0]["nodes"].push_back(scene["nodes"].size());
            scene["nodes"].push_back({{"translation", {0, 2, 0}}});
            scene["nodes"].back()["extensions"]["KHR_lights_punctual"]["light"] = light;
        }
        write("scene.gltf", scene.dump());
    }
    std::string entry(const char* text) { return with("/scene_lights", json::array({json::parse(text)})); }
};

TEST_F(SceneLights, AreChangedByNameOrIndex) {
    script_["scene_lights"] = json::parse(R"([
        {"light": "bulb", "position": [0.1, 0, 0], "intensity": [1, 2, 3], "range": 4},
        {"light": "lamp", "direction": [0, -2, 0], "outer_cone_deg": 60},
        {"light": 3, "direction": [0, -1, 0], "angular_radius_deg": 0.5}, {"light": 1, "off": true}])");
    const CaptureScript script = load();
    const std::vector<Light>& lights = script.scene.lights;
    ASSERT_EQ(lights.size(), 4u + 5u) << "those of the script come after those of the glTF";
    EXPECT_EQ(lights[0].position, glm::dvec3(0.1, 0, 0));
    EXPECT_EQ(lights[0].intensity, glm::vec3(1, 2, 3));
    EXPECT_EQ(lights[0].range, 4);
    // The place is one in the node's space.
    expectNear(script.scene.lightsAt()[0].position, {0.1, 2, 0});
    EXPECT_EQ(lights[2].direction, glm::dvec3(0, -1, 0));
    EXPECT_EQ(lights[2].outerConeAngle, glm::radians(60.0));
    EXPECT_EQ(lights[2].innerConeAngle, 0.1) << "what is absent stays";
    EXPECT_EQ(lights[1].intensity, glm::vec3(0));
    EXPECT_EQ(lights[3].intensity, glm::vec3(1));
    EXPECT_EQ(lights[3].angularRadius, glm::radians(0.5));
}

TEST_F(SceneLights, WrongChangesAreNamed) {
    EXPECT_EQ(entry(R"({"light": "bulp"})"),
              "script.json: scene_lights[0].light: the glTF has no light \"bulp\"; it has \"bulb\", \"sun\", "
              "\"lamp\", \"sun\"");
    EXPECT_EQ(entry(R"({"light": "sun", "off": true})"),
              "script.json: scene_lights[0].light: the glTF has several lights \"sun\"; an index is unique");
    EXPECT_THAT(entry(R"({"light": 4, "off": true})"), HasSubstr("scene_lights[0].light: 4 is out of range: 0 to 3"));
    EXPECT_THAT(entry(R"({"off": true})"), HasSubstr("scene_lights[0].light: is missing"));
    EXPECT_THAT(entry(R"({"light": 1, "position": [0, 0, 0]})"), HasSubstr("scene_lights[0].position: unknown key"));
    EXPECT_THAT(entry(R"({"light": 0, "direction": [0, 1, 0]})"), HasSubstr("scene_lights[0].direction: unknown key"));
    EXPECT_THAT(entry(R"({"light": 2, "direction": [0, 0, 0]})"), HasSubstr("direction: must not be zero"));
    EXPECT_THAT(entry(R"({"light": 2, "inner_cone_deg": 50})"), HasSubstr("inner_cone_deg: must be below"));
    EXPECT_THAT(entry(R"({"light": 0, "intensity": -1})"), HasSubstr("scene_lights[0].intensity: -1 is out of range"));
    EXPECT_THAT(entry(R"({"light": 0, "intensity": 1, "off": true})"), HasSubstr("scene_lights[0].intensity: is that"));
    EXPECT_EQ(with("/scene_lights", json::parse(R"([{"light": 0, "off": true}, {"light": "bulb", "off": true}])")),
              "script.json: scene_lights[1].light: is changed by an entry before");
    EXPECT_EQ(with("/scene_lights", json::object()), "script.json: scene_lights: must be an array");
    write("scene.gltf", triangleScene(false, true).dump());
    EXPECT_EQ(entry(R"({"light": 0, "off": true})"), "script.json: scene_lights[0].light: the glTF has no lights");
}

TEST(Placement, DegreesAreThoseOfTheRotation) {
    for (double x = -180; x <= 180; x += 45) {
        for (double y = -90; y <= 90; y += 30) {
            for (double z = -170; z <= 180; z += 70) {
                const glm::dquat q = rotationFromDegrees({x, y, z}), back = rotationFromDegrees(degreesOf(q));
                EXPECT_NEAR(std::abs(glm::dot(q, back)), 1, 1e-12) << x << " " << y << " " << z;
            }
        }
    }
    const glm::dvec3 plain(20, -30, 140), same = degreesOf(rotationFromDegrees(plain));
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(same[i], plain[i], 1e-10);
}

TEST_F(Script, VoxelViewsHaveBouncesFacesAndLevels) {
    const std::vector<std::string> good = {"cascade",
                                           "seam",
                                           "voxel_albedo",
                                           "voxel_albedo:0",
                                           "voxel_opacity:15",
                                           "voxel_opacity:+x",
                                           "voxel_opacity:-z:3",
                                           "voxel_radiance:b0",
                                           "voxel_radiance:b12:-y:2",
                                           "voxel_lobes",
                                           "voxel_lobes:b1:4"};
    script_["shots"][0]["channels"] = good;
    EXPECT_EQ(load().shots[0].channels, good);
    EXPECT_EQ(baseChannel("voxel_albedo:2"), "voxel_albedo");
    EXPECT_EQ(baseChannel("voxel_radiance:b2:+x:0"), "voxel_radiance");
    EXPECT_EQ(baseChannel("ao"), "ao");
    VoxelChannel parts;
    EXPECT_EQ(VoxelChannel::parse("voxel_radiance:b12:-y:2", parts), "");
    EXPECT_EQ(parts.base, "voxel_radiance");
    EXPECT_EQ(parts.bounce, 12);
    EXPECT_EQ(parts.face, 3);
    EXPECT_EQ(parts.level, 2);
    for (const char* level : {"16", "-1", "02", "", "x", "b", "b01", "+w", "1:x"})
        EXPECT_THAT(with("/shots/0/channels/0", std::string("voxel_radiance:") + level),
                    AllOf(StartsWith("script.json: shots[0].channels[0]: "), HasSubstr("is no level: 0 to 15")))
            << level;
    // Each view has one name.
    for (const char* name :
         {"voxel_radiance:2:b1", "voxel_radiance:1:2", "voxel_radiance:+x:b1", "voxel_radiance:+x:+y"})
        EXPECT_THAT(with("/shots/0/channels/0", name), HasSubstr("must stand as in \"voxel_radiance:")) << name;
    EXPECT_THAT(with("/shots/0/channels/0", "ao:1"), HasSubstr("\"ao\" has no levels"));
    EXPECT_THAT(with("/shots/0/channels/0", "voxel_albedo:b1"), HasSubstr("\"voxel_albedo\" has no bounces"));
    EXPECT_THAT(with("/shots/0/channels/0", "voxel_lobes:+x"), HasSubstr("\"voxel_lobes\" has no faces"));
    EXPECT_THAT(with("/shots/0/channels/0", "voxel_radiance:b65"), HasSubstr("\"b65\" is no bounce: b0 to b64"));
    EXPECT_THAT(with("/shots/0/channels/0", "voxel_albed:1"), HasSubstr("did you mean \"voxel_albedo\"?"));
    EXPECT_THAT(with("/shots/0/channels/0", "voxel_opacity:15"), HasSubstr("twice"));
}

TEST_F(Script, BareSceneUsesItsCameraAndGetsASunOnlyWhenDark) {
    const CaptureScript dark = loadCaptureScript(folder_ / "scene.gltf");
    ASSERT_EQ(dark.shots.size(), 1u);
    EXPECT_EQ(dark.shots[0].camera.name, "left");
    ASSERT_EQ(dark.scene.lights.size(), 1u);
    EXPECT_EQ(dark.scene.lights[0].type, LightType::directional);
    EXPECT_FALSE(dark.scene.environment.black());

    write("glow.gltf", triangleScene(true, false).dump());
    const CaptureScript glow = loadCaptureScript(folder_ / "glow.gltf");
    EXPECT_TRUE(glow.scene.lights.empty());
    EXPECT_TRUE(glow.scene.environment.black());
    // The camera that was made up sees every corner of the scene's box.
    const glm::dmat4 view = viewMatrix(glow.shots[0].camera);
    for (const glm::dvec3& corner : {glm::dvec3(0, 0, 0), glm::dvec3(1, 0, 0), glm::dvec3(0, 1, 0)}) {
        const glm::dvec4 p = view * glm::dvec4(corner, 1);
        EXPECT_LT(p.z, 0);
        EXPECT_LT(std::abs(p.y / p.z), std::tan(glm::radians(glow.shots[0].camera.verticalFovDeg / 2)));
        EXPECT_LT(std::abs(p.x / p.z), std::tan(glm::radians(glow.shots[0].camera.verticalFovDeg / 2)));
    }
}

TEST_F(Script, OtherFilesAreRefused) {
    write("a.txt", "x");
    EXPECT_THAT(messageOf(folder_ / "a.txt"), HasSubstr("neither a capture script (.json) nor a scene"));
    EXPECT_EQ(messageOf(folder_ / "absent.json"), "absent.json: no such file");
    fs::create_directories(folder_ / "folder.json");
    EXPECT_THAT(messageOf(folder_ / "folder.json"), HasSubstr("is a folder"));
}

TEST(Assets, EveryCaptureScriptLoads) {
    int scripts = 0;
    for (const auto& entry : fs::directory_iterator(kAssets / "captures")) {
        if (entry.path().extension() != ".json") continue;
        const CaptureScript script = loadCaptureScript(entry.path());
        EXPECT_GT(script.scene.triangleCount(), 0u) << entry.path();
        ++scripts;
    }
    EXPECT_GE(scripts, 5);
}

// Solids are solids: light can never see their insides. Only the room of the Cornell box and cloth are sheets.
TEST(Assets, SolidsAreClosed) {
    for (const char* name : {"basic", "furnace", "leak", "atrium"}) {
        const CaptureScript script = loadCaptureScript(kAssets / "captures" / (std::string(name) + ".json"));
        for (const Mesh& mesh : script.scene.meshes) {
            const bool cloth = script.scene.materials[static_cast<std::size_t>(mesh.material)].doubleSided;
            EXPECT_THAT(mesh.closed, testing::Each(cloth ? 0 : 1)) << name << " " << mesh.name;
        }
    }
}

TEST(Assets, SceneFactsAreAsDocumented) {
    const auto size = [](const char* name) {
        return loadCaptureScript(kAssets / "captures" / (std::string(name) + ".json")).scene.bounds().size();
    };
    EXPECT_NEAR(size("cornell").y, 5.488, 1e-4);
    EXPECT_NEAR(size("cornell").z, 5.592, 1e-4);
    EXPECT_NEAR(size("atrium").x, 30, 0.5);
    EXPECT_NEAR(size("atrium").y, 12, 0.5);
    EXPECT_NEAR(size("atrium").z, 18, 0.5);
    const CaptureScript atrium = loadCaptureScript(kAssets / "captures/atrium.json");
    EXPECT_GE(atrium.scene.triangleCount(), 20000u);
    EXPECT_LE(atrium.scene.triangleCount(), 60000u);
}

}  // namespace
}  // namespace voxcone
