// The window, driven by the events that GLFW would send: on a display, with a small scene.
#include "viewer/viewer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>
// After the loader of OpenGL's functions.
#include <GLFW/glfw3.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numeric>
#include <optional>
#include <thread>

#include "capture/capture.h"
#include "capture/output.h"
#include "display_density.h"
#include "gl/context.h"
#include "metric/flip.h"
#include "metric/heatmap.h"
#include "scene/extract.h"

namespace voxcone {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::HasSubstr;
using Clock = std::chrono::steady_clock;

/// Three levels around a camera near the cube, small and quick.
json basicScript() {
    json script = json::parse(R"({ "version": 1,
        "environment": {"color": [0.2, 0.2, 0.3]},
        "lights": [{"type": "directional", "direction": [-0.3, -1, -0.45], "intensity": 2.5},
                   {"type": "point", "position": [0.6, 1.3, 0.9], "intensity": 0.4, "name": "lamp"}],
        "settings": {
            "output": {"width": 200, "height": 112}, "voxel": {"resolution": 16}, "cascade": {"levels": 3, "snap": 1},
            "light": {"shadow_resolution": 128, "bounces": 1, "bounce_cones": 1},
            "cone": {"diffuse": 1, "near_field": 0}, "specular": {"enabled": false} },
        "shots": [{"name": "front", "camera": {"position": [0.3, 1.6, 4.1], "target": [0.2, 0.6, 0], "fov_deg": 45},
                   "channels": ["beauty"]}]})");
    script["scene"] = VOXCONE_SOURCE_DIR "/assets/scenes/basic.gltf";
    return script;
}

/// One window for all tests, as a user has one.
class ViewerTest : public testing::Test {
  protected:
    static void SetUpTestSuite() {
        std::string name = (fs::temp_directory_path() / "voxcone_viewer_XXXXXX").string();
        folder() = mkdtemp(name.data());
        std::ofstream(folder() / "basic.json") << basicScript().dump(1);
        ViewerOptions options;
        options.file = folder() / "basic.json";
        options.prepare = [](Settings& settings) {
            applyJson(settings, basicScript()["settings"], "test", "settings");
        };
        options.folders = {folder(), folder() / "config"};
        fs::copy(VOXCONE_SOURCE_DIR "/shaders", folder() / "shaders", fs::copy_options::recursive);
        options.shaders = folder() / "shaders";
        options.width = 900;
        options.height = 600;
        options.debug = true;
        shared() = std::make_unique<Viewer>(options);
    }
    static void TearDownTestSuite() {
        shared().reset();
        fs::remove_all(folder());
    }
    static fs::path& folder() {
        static fs::path path;
        return path;
    }
    static std::unique_ptr<Viewer>& shared() {
        static std::unique_ptr<Viewer> viewer;
        return viewer;
    }

    /// Each test begins with the script as it was opened.
    void SetUp() override {
        if (session().sceneSerial != 0) session().open(folder() / "basic.json");
        const std::uint64_t before = session().sceneSerial;
        ASSERT_TRUE(turnUntil([&] { return session().sceneSerial > before && session().settled(); }));
        session().channel = "beauty";
        session().level = session().voxelFace = session().voxelBounce = -1;
        ASSERT_TRUE(settle());
        session().messages.clear();
    }

    Viewer& viewer() { return *shared(); }
    Session& session() { return viewer().session(); }

    bool turnUntil(const std::function<bool()>& done, double seconds = 120) {
        const auto end = Clock::now() + std::chrono::duration<double>(seconds);
        while (!done()) {
            if (Clock::now() > end) return false;
            viewer().turn(0.01);
        }
        return true;
    }
    bool settle() {
        viewer().turn(0);
        return turnUntil([&] { return session().settled(); });
    }
    void turns(int count) {
        for (int i = 0; i < count; ++i) viewer().turn(0);
    }
    /// Turns that draw.
    void draws(int count) {
        for (int i = 0; i < count; ++i) {
            moveTo(glm::dvec2(1 + i % 2));
            viewer().turn(0);
        }
    }

    void key(int code, int mods = 0) {
        for (const int action : {GLFW_PRESS, GLFW_RELEASE}) {
            Event event;
            event.type = Event::Type::key;
            event.code = code, event.action = action, event.mods = mods;
            viewer().post(event);
        }
        turns(2);
    }
    void moveTo(const glm::dvec2& place) {
        Event event;
        event.type = Event::Type::cursor;
        event.position = place;
        viewer().post(event);
    }
    void press(int button, int action, int mods = 0) {
        Event event;
        event.type = Event::Type::button;
        event.code = button, event.action = action, event.mods = mods;
        viewer().post(event);
    }
    void drag(int button, const glm::dvec2& from, const glm::dvec2& to, int mods = 0) {
        moveTo(from);
        turns(2);
        press(button, GLFW_PRESS, mods);
        turns(1);
        moveTo(0.5 * (from + to));
        moveTo(to);
        turns(1);
        press(button, GLFW_RELEASE, mods);
        turns(2);
    }
    void drop(const fs::path& file) {
        Event event;
        event.type = Event::Type::drop;
        event.files = {file};
        viewer().post(event);
    }
    glm::dvec2 inPicture(double x, double y) {
        return viewer().pictureRect().low + viewer().pictureRect().size * glm::dvec2(x, y);
    }
    std::string lastMessage() { return session().messages.empty() ? "" : session().messages.back().text; }

    /// Presses P and gives the files without extension.
    fs::path screenshot() {
        session().messages.clear();
        key(GLFW_KEY_P);
        EXPECT_TRUE(turnUntil([&] { return lastMessage().starts_with("wrote "); })) << lastMessage();
        const std::string line = lastMessage(), png = line.substr(6, line.find(".png") - 6);
        return png;
    }
    /// The first shot of a script, rendered without a window.
    static fs::path capture(const fs::path& script) {
        CaptureScript read = loadCaptureScript(script);
        extractLights(read.scene, read.settings.light);
        const fs::path out = folder() / "capture";
        fs::remove_all(out);
        fs::path stem;
        // This thread has the window's context.
        std::thread([&] {
            const auto context = gl::Context::createHeadless(true);
            stem = runCapture(read, *context, out).front();
        }).join();
        return stem.replace_extension();
    }
    void expectSamePictures(const fs::path& window, const fs::path& headless) {
        const Image a = readImage(window.string() + ".exr"), b = readImage(headless.string() + ".exr");
        EXPECT_EQ(a.width, b.width);
        EXPECT_TRUE(a.data == b.data) << "EXR files differ";
        const Image c = readImage(window.string() + ".png"), d = readImage(headless.string() + ".png");
        EXPECT_TRUE(c.data == d.data) << "PNG files differ";
        EXPECT_GT(*std::max_element(a.data.begin(), a.data.end()), 0.1f);
    }
};

TEST_F(ViewerTest, ScreenshotIsTheCaptureBitForBit) {
    expectSamePictures(screenshot(), capture(folder() / "basic.json"));
}

TEST_F(ViewerTest, TheWindowShowsThePixelsOfTheScreenshot) {
    const Image png = readImage(screenshot().string() + ".png");
    turns(3);
    const Image shown = viewer().readWindow();
    const glm::ivec2 low(viewer().pictureRect().low), size(viewer().pictureRect().size);
    const int scale = size.x / png.width;
    ASSERT_EQ(size, scale * glm::ivec2(png.width, png.height)) << "whole pixels";
    double worst = 0;
    for (int y = 0; y < png.height; ++y)
        for (int x = 0; x < png.width; ++x)
            for (int c = 0; c < 3; ++c)
                worst =
                    std::max(worst, std::abs(static_cast<double>(shown.pixel(low.x + scale * x, low.y + scale * y)[c]) -
                                             static_cast<double>(srgbFromLinear(png.pixel(x, y)[c]))));
    EXPECT_LT(worst, 1.5 / 255);
}

TEST_F(ViewerTest, WrittenScriptReplaysToTheSamePicture) {
    drag(GLFW_MOUSE_BUTTON_LEFT, inPicture(0.5, 0.5), inPicture(0.62, 0.45));
    drag(GLFW_MOUSE_BUTTON_RIGHT, inPicture(0.5, 0.5), inPicture(0.52, 0.5));
    session().lights[0].direction = glm::normalize(glm::dvec3(0.2, -1, -0.3));
    for (const char* channel : {"beauty", "voxel_radiance", "voxel_lobes"}) {
        session().channel = channel;
        session().voxelBounce = std::string(channel) == "voxel_radiance" ? 1 : -1;
        session().voxelFace = 2;
        ASSERT_TRUE(settle());
        const fs::path picture = screenshot();
        key(GLFW_KEY_S, GLFW_MOD_CONTROL);
        ASSERT_TRUE(lastMessage().starts_with("wrote ")) << lastMessage();
        expectSamePictures(picture, capture(lastMessage().substr(6)));
    }
    EXPECT_EQ(session().shownChannel(), "voxel_lobes");
    session().channel = "voxel_radiance";
    session().voxelBounce = 1;
    session().level = 2;
    EXPECT_EQ(session().shownChannel(), "voxel_radiance:b1:+y:2");
    key(GLFW_KEY_1, GLFW_MOD_CONTROL);
    session().channel = "beauty";
    session().level = session().voxelBounce = session().voxelFace = -1;
    session().recallView(session().views.back());
    EXPECT_EQ(session().shownChannel(), "voxel_radiance:b1:+y:2");
}

TEST_F(ViewerTest, ARecordedPathReplaysToTheSamePicture) {
    key(GLFW_KEY_R);
    EXPECT_TRUE(session().recording);
    for (int i = 0; i < 4; ++i) {
        drag(GLFW_MOUSE_BUTTON_LEFT, inPicture(0.5, 0.5), inPicture(0.53, 0.5));
        turnUntil([start = Clock::now()] { return Clock::now() - start > std::chrono::milliseconds(120); });
    }
    key(GLFW_KEY_R);
    ASSERT_EQ(session().views.size(), 1u);
    const SavedView recorded = session().views[0];
    ASSERT_GE(recorded.path.position.times.size(), 3u);
    key(GLFW_KEY_S, GLFW_MOD_CONTROL);
    const fs::path script = lastMessage().substr(6);
    // The first frame, as the window shows it.
    session().recallView(recorded);
    ASSERT_TRUE(settle());
    const fs::path picture = screenshot();
    const CaptureScript read = loadCaptureScript(script);
    EXPECT_EQ(read.shots.at(0).frameCount(), recorded.frames());
    expectSamePictures(picture, capture(script));
    // And the script itself can be dropped on the window and played.
    const std::uint64_t before = session().sceneSerial;
    drop(script);
    ASSERT_TRUE(turnUntil([&] { return session().sceneSerial > before && session().settled(); }));
    EXPECT_TRUE(session().followShot);
    const glm::dvec3 start = session().camera.camera().position;
    key(GLFW_KEY_SPACE);
    ASSERT_TRUE(turnUntil([&] { return session().camera.camera().position != start; }));
    key(GLFW_KEY_SPACE);
    EXPECT_FALSE(session().playing);
}

TEST_F(ViewerTest, CameraFollowsMouseAndKeys) {
    const Camera before = session().camera.camera();
    drag(GLFW_MOUSE_BUTTON_LEFT, inPicture(0.5, 0.5), inPicture(0.7, 0.5));
    Camera after = session().camera.camera();
    EXPECT_EQ(after.target, before.target);
    EXPECT_NE(after.position, before.position);

    drag(GLFW_MOUSE_BUTTON_RIGHT, inPicture(0.5, 0.5), inPicture(0.4, 0.5));
    EXPECT_EQ(session().camera.camera().position, after.position);
    EXPECT_NE(session().camera.camera().target, after.target);

    // What lies at the target stays below the cursor.
    session().takeShot(0);
    drag(GLFW_MOUSE_BUTTON_MIDDLE, inPicture(0.5, 0.5), inPicture(0.6, 0.4));
    const Projection projection(session().camera.camera(), viewer().pictureRect());
    const auto place = projection.point(before.target);
    ASSERT_TRUE(place.has_value());
    EXPECT_NEAR(place->x, inPicture(0.6, 0.4).x, 1);
    EXPECT_NEAR(place->y, inPicture(0.6, 0.4).y, 1);

    session().takeShot(0);
    Event event;
    event.type = Event::Type::key;
    event.code = GLFW_KEY_W, event.action = GLFW_PRESS;
    viewer().post(event);
    turnUntil([start = Clock::now()] { return Clock::now() - start > std::chrono::milliseconds(200); });
    event.action = GLFW_RELEASE;
    viewer().post(event);
    turns(2);
    after = session().camera.camera();
    EXPECT_GT(glm::dot(after.position - before.position, before.target - before.position), 0);
    turns(3);
    EXPECT_EQ(session().camera.camera().position, after.position) << "flies on without a key";

    event.type = Event::Type::scroll;
    event.position = {0, 2};
    moveTo(inPicture(0.5, 0.5));
    turns(2);
    viewer().post(event);
    turns(2);
    EXPECT_LT(session().camera.distance(), glm::length(before.target - before.position));
}

TEST_F(ViewerTest, ADoubleClickFocusesTheSurface) {
    moveTo(inPicture(0.3, 0.8));
    turns(2);
    const auto surface = session().surfaceAt({0.3, 0.8});
    ASSERT_TRUE(surface.has_value());
    for (int i = 0; i < 2; ++i) {
        press(GLFW_MOUSE_BUTTON_LEFT, GLFW_PRESS);
        press(GLFW_MOUSE_BUTTON_LEFT, GLFW_RELEASE);
    }
    turns(5);
    EXPECT_EQ(session().camera.camera().target, *surface);
    // It is seen in the middle now.
    ASSERT_TRUE(settle());
    const auto middle = session().surfaceAt({0.5, 0.5});
    ASSERT_TRUE(middle.has_value());
    EXPECT_LT(glm::length(*middle - *surface), 0.05 * session().camera.distance());
}

TEST_F(ViewerTest, ABrokenFileSaysWhyAndKeepsTheScene) {
    const auto facts = session().facts;
    std::ofstream(folder() / "broken.gltf") << "{ \"asset\": 3";
    std::ofstream(folder() / "broken.json") << R"({"version": 1, "scene": "nowhere.gltf", "shots": []})";
    std::ofstream(folder() / "broken.hdr") << "no picture";
    for (const char* name : {"broken.gltf", "broken.json", "broken.hdr", "absent.glb", "notes.txt"}) {
        session().messages.clear();
        drop(folder() / name);
        ASSERT_TRUE(turnUntil([&] { return !session().messages.empty(); })) << name;
        EXPECT_THAT(lastMessage(), HasSubstr(name));
        EXPECT_TRUE(session().messages.back().error);
        EXPECT_EQ(lastMessage().find('\n'), std::string::npos);
        ASSERT_TRUE(settle());
        EXPECT_EQ(session().facts->file, facts->file);
    }
    expectSamePictures(screenshot(), capture(folder() / "basic.json"));
}

TEST_F(ViewerTest, DropsSceneAndEnvironment) {
    drop(VOXCONE_SOURCE_DIR "/assets/scenes/basic.gltf");
    ASSERT_TRUE(turnUntil([&] { return session().facts->file.filename() == "basic.gltf"; }));
    EXPECT_TRUE(session().followWindow);
    session().followWindow = false;
    ASSERT_TRUE(settle());
    const fs::path before = screenshot();
    drop(VOXCONE_SOURCE_DIR "/assets/scenes/spheres.hdr");
    turns(2);
    ASSERT_TRUE(turnUntil([&] { return session().settled(); }));
    const fs::path after = screenshot();
    EXPECT_FALSE(readImage(before.string() + ".exr").data == readImage(after.string() + ".exr").data);
    key(GLFW_KEY_S, GLFW_MOD_CONTROL);
    expectSamePictures(after, capture(lastMessage().substr(6)));
    // Both are remembered, the script too.
    ASSERT_GE(session().recent.size(), 2u);
    EXPECT_EQ(session().recent[0].filename(), "basic.gltf");
    EXPECT_EQ(session().recent[1].filename(), "basic.json");
    EXPECT_TRUE(fs::exists(folder() / "config" / "recent.json"));
}

TEST_F(ViewerTest, EverySettingHasAControl) {
    static std::set<std::string> drawn;
    viewer().panels().push_back({"test", GLFW_KEY_F25, [](Session& s) { drawn = drawSettings(s); }, true});
    session().settingsFilter = ".";
    draws(3);
    viewer().panels().pop_back();
    std::set<std::string> all;
    Settings settings;
    for (const Field& field : fields(settings)) all.insert(field.key);
    EXPECT_EQ(drawn, all);
    session().settingsFilter = "gain";
    viewer().panels().push_back({"test", GLFW_KEY_F25, [](Session& s) { drawn = drawSettings(s); }, true});
    draws(3);
    viewer().panels().pop_back();
    EXPECT_EQ(drawn, std::set<std::string>{"cone.gain"});
    session().settingsFilter.clear();
}

TEST_F(ViewerTest, SettingsAreUndoneAndPresetsLoaded) {
    const Settings before = session().settings.now();
    Settings brighter = before;
    brighter.output.exposure = 1;
    session().settings.change(brighter, "output.exposure");
    ASSERT_TRUE(settle());
    EXPECT_EQ(session().picture->view.settings.output.exposure, 1);
    key(GLFW_KEY_Z, GLFW_MOD_CONTROL);
    EXPECT_TRUE(sameSettings(session().settings.now(), before));
    key(GLFW_KEY_Y, GLFW_MOD_CONTROL);
    EXPECT_TRUE(sameSettings(session().settings.now(), brighter));
    session().savePreset("mine");
    session().applyPresetByName("thesis");
    EXPECT_EQ(session().settings.now().cone.compositing, Compositing::alpha);
    EXPECT_EQ(session().settings.now().output.width, before.output.width);
    session().applyPresetByName((folder() / "mine.json").string());
    EXPECT_TRUE(sameSettings(session().settings.now(), brighter));
    session().applyPresetByName("no such");
    EXPECT_THAT(lastMessage(), HasSubstr("unknown preset"));
}

TEST_F(ViewerTest, EveryPanelOpensAndDraws) {
    for (const char* channel : {"beauty", "cascade", "voxel_normal"}) {
        session().channel = channel;
        for (const Panel& panel : std::vector<Panel>(viewer().panels())) {
            const bool before = panel.open;
            key(panel.key);
            const auto now = std::find_if(viewer().panels().begin(), viewer().panels().end(),
                                          [&](const Panel& p) { return p.key == panel.key; });
            EXPECT_NE(now->open, before) << panel.name;
            turns(2);
            key(panel.key);
        }
    }
    for (Panel& panel : viewer().panels()) panel.open = true;
    draws(4);
    key(GLFW_KEY_F1);
    EXPECT_TRUE(viewer().helpOpen());
    key(GLFW_KEY_ESCAPE);
    EXPECT_FALSE(viewer().helpOpen());
    const double before = viewer().pictureRect().size.x;
    key(GLFW_KEY_TAB);
    EXPECT_FALSE(viewer().sideBar());
    EXPECT_GT(viewer().pictureRect().size.x, before) << "there is more place";
    key(GLFW_KEY_TAB);
    const Image shown = viewer().readWindow();
    EXPECT_GT(*std::max_element(shown.data.begin(), shown.data.end()), 0.5f);
}

TEST_F(ViewerTest, AFrozenClipmapStaysAndSteps) {
    const auto lowest = [&] { return session().picture->clipmap.update.windows.at(0).low; };
    const glm::ivec3 start = lowest();
    key(GLFW_KEY_C);
    ASSERT_TRUE(session().frozen());
    const double voxel = session().picture->clipmap.layout.voxelSize;
    const int snap = session().picture->clipmap.layout.snapOf(0);
    session().camera.fly({0, 0, 6 * snap * voxel});
    ASSERT_TRUE(settle());
    EXPECT_EQ(lowest(), start);
    // Step by step to where the camera is; a step is one snap of the finest level at most.
    session().flashes.clear();
    bool moved = false;
    for (int i = 0; i < 8; ++i) {
        const glm::ivec3 before = lowest();
        key(GLFW_KEY_N);
        ASSERT_TRUE(settle());
        const glm::ivec3 step = glm::abs(lowest() - before);
        EXPECT_LE(std::max({step.x, step.y, step.z}), snap);
        moved |= step != glm::ivec3(0);
    }
    EXPECT_TRUE(moved);
    EXPECT_GT(session().history.voxels.at(0).size(), 1u);
    const glm::ivec3 stepped = lowest();
    key(GLFW_KEY_C);
    EXPECT_FALSE(session().frozen());
    ASSERT_TRUE(settle());
    EXPECT_EQ(lowest(), stepped) << "all steps together lead to the camera";
    EXPECT_NE(stepped, start);
}

TEST_F(ViewerTest, WhatIsVoxelizedFlashes) {
    session().flashes.clear();
    session().camera.fly({0, 0, 4 * session().picture->clipmap.layout.voxelSize});
    session().showLevels = session().showSnapGrid = true;
    viewer().turn(0);
    ASSERT_TRUE(turnUntil([&] { return !session().flashes.empty(); }, 20));
    const Flash flash = session().flashes.front();
    EXPECT_LT(flash.level, 2);
    turns(2);
    ASSERT_TRUE(turnUntil([&] { return session().flashes.empty(); }, 20));
    session().showLevels = session().showSnapGrid = false;
}

TEST_F(ViewerTest, FollowsTheWindowsSizeAndSurvivesMinimising) {
    session().followWindow = true;
    viewer().window().resize(760, 500);
    ASSERT_TRUE(turnUntil([&] {
        return viewer().window().framebufferSize() == glm::ivec2(760, 500) && session().settled() &&
               session().picture->view.settings.output.width == 380;
    }));
    EXPECT_EQ(session().picture->view.settings.output.height, static_cast<int>(viewer().pictureRect().size.y));
    EXPECT_FALSE(session().settings.canUndo());
    viewer().window().minimize(true);
    turns(5);
    viewer().window().minimize(false);
    turns(5);
    // What was uncovered is drawn again, and then no more.
    ASSERT_TRUE(turnUntil([&, drawn = std::uint64_t{0}]() mutable {
        return std::exchange(drawn, viewer().drawn()) == viewer().drawn();
    }));
    const std::uint64_t drawn = viewer().drawn();
    Event uncovered;
    uncovered.type = Event::Type::refresh;
    viewer().post(uncovered);
    turns(1);
    EXPECT_GT(viewer().drawn(), drawn);
    viewer().window().resize(900, 600);
    ASSERT_TRUE(turnUntil([&] { return viewer().window().framebufferSize() == glm::ivec2(900, 600); }));
    session().followWindow = false;
}

TEST_F(ViewerTest, APixelsConesAddUpToItsPicture) {
    Settings settings = session().settings.now();
    settings.cone.diffuse = 6;
    settings.cone.rotate = false;  // no mean over neighbours
    settings.cone.nearField = 4;
    settings.reference.samples = 64;
    session().settings.change(settings, "test");
    session().channel = "ao";
    ASSERT_TRUE(settle());
    const Image ao = session().picture->image;
    for (const glm::dvec2 place : {glm::dvec2(0.3, 0.8), glm::dvec2(0.5, 0.55), glm::dvec2(0.6, 0.9)}) {
        moveTo(inPicture(place.x, place.y));
        turns(1);
        session().forgetInspection();
        key(GLFW_KEY_I);
        ASSERT_TRUE(turnUntil([&] { return session().inspection != nullptr; }));
        const Inspection& asked = *session().inspection;
        ASSERT_EQ(asked.lobes.size(), 1u) << "diffuse light alone";
        const PixelCones& lobe = asked.lobes[0];
        ASSERT_EQ(lobe.cones.size(), 6u);
        const auto surface = session().surfaceAt(place);
        ASSERT_TRUE(surface.has_value());
        EXPECT_LT(glm::length(lobe.position - *surface), 1e-4 * glm::length(*surface) + 1e-5);
        double weights = 0, openness = 0;
        for (const InspectedCone& cone : lobe.cones) {
            weights += cone.weight;
            openness += cone.weight * cone.openness;
            EXPECT_FALSE(cone.truncated);
            ASSERT_FALSE(cone.samples.empty());
            double before = 1;
            for (const ConeSample& sample : cone.samples) {
                EXPECT_LE(sample.transmittance, before);
                before = sample.transmittance;
                EXPECT_GE(sample.footprint, session().picture->clipmap.layout.voxelSize * 0.999);
            }
            EXPECT_EQ(cone.samples.back().transmittance, cone.transmittance);
            EXPECT_LT(glm::length(cone.samples.back().radiance - cone.radiance), 1e-5f);
        }
        EXPECT_NEAR(weights, 1, 1e-5);
        EXPECT_NEAR(openness, static_cast<double>(ao.pixel(asked.pixel.x, asked.pixel.y)[0]), 1e-5);
        EXPECT_LT(glm::length(lobe.outgoing() - asked.terms.at(2).second), 1e-5f) << "of indirect_diffuse";
        glm::vec3 sum(0), beauty(0);
        for (const auto& [name, value] : asked.terms) (name == "beauty" ? beauty : sum) += value;
        EXPECT_LT(glm::length(sum - beauty), 1e-4f);
        ASSERT_TRUE(turnUntil([&] { return asked.traced("beauty").has_value(); }));
        const json tree = json::parse(asked.json());
        EXPECT_EQ(tree["lobes"]["diffuse"]["cones"].size(), 6u);
        EXPECT_TRUE(tree["terms"]["direct"].contains("path_traced"));
        // A sun and a constant sky on a plane: both renderers know that.
        const glm::vec3 voxels = asked.terms.at(1).second, traced = *asked.traced("direct");
        EXPECT_NEAR(voxels.x, traced.x, 0.05 * static_cast<double>(voxels.x + traced.x) + 1e-3);
    }
    for (Panel& panel : viewer().panels()) panel.open = std::string(panel.name) == "Inspector";
    draws(4);
    session().forgetInspection();
}

TEST_F(ViewerTest, SpecularConesAreAskedForToo) {
    // The scene with a floor that reflects.
    json scene = json::parse(std::ifstream(VOXCONE_SOURCE_DIR "/assets/scenes/basic.gltf")), script = basicScript();
    scene["materials"][0].erase("extensions");
    scene["materials"][0]["pbrMetallicRoughness"]["roughnessFactor"] = 0.4;
    std::ofstream(folder() / "glossy.gltf") << scene;
    fs::copy(VOXCONE_SOURCE_DIR "/assets/scenes/basic.bin", folder() / "basic.bin");
    script["scene"] = (folder() / "glossy.gltf").string();
    std::ofstream(folder() / "glossy.json") << script;
    const std::uint64_t before = session().sceneSerial;
    drop(folder() / "glossy.json");
    ASSERT_TRUE(turnUntil([&] { return session().sceneSerial > before && session().settled(); }));
    Settings settings = session().settings.now();
    settings.specular.enabled = true;
    settings.cone.rotate = false;
    session().settings.change(settings, "test");
    ASSERT_TRUE(settle());
    for (Panel& panel : viewer().panels()) panel.open = std::string(panel.name) == "Inspector";
    moveTo(inPicture(0.3, 0.9));
    turns(1);
    key(GLFW_KEY_I);
    ASSERT_TRUE(turnUntil([&] { return session().inspection != nullptr; }));
    Inspection& asked = *session().inspection;
    ASSERT_EQ(asked.lobes.size(), 2u);
    EXPECT_EQ(asked.lobes[1].lobe, ConeLobe::specular);
    const glm::vec3 channel = asked.terms.at(3).second;
    EXPECT_GT(glm::length(channel), 0);
    EXPECT_LT(glm::length(asked.lobes[1].outgoing() - channel), 1e-5f);
    const json tree = json::parse(asked.json());
    EXPECT_EQ(tree["lobes"]["specular"]["cones"].size(), asked.lobes[1].cones.size());
    EXPECT_EQ(tree["lobes"]["specular"]["channel"], "indirect_specular");
    asked.lobe = 1;
    asked.selected = 99;
    draws(3);
    EXPECT_EQ(asked.selected, static_cast<int>(asked.lobes[1].cones.size()) - 1);
    session().forgetInspection();
}

TEST_F(ViewerTest, SlicesHoldAllVoxelsOfALevel) {
    session().channel = "voxel_albedo";
    session().level = 0;
    session().sliceShown = true;
    for (Panel& panel : viewer().panels()) panel.open = std::string(panel.name) == "Voxels";
    draws(3);
    ASSERT_TRUE(turnUntil([&] { return session().slice != nullptr; }));
    draws(3);
    EXPECT_EQ(session().slice->width, 16);
    // Slices show the light of single bounces too, which add up to all of it.
    const auto light = [&] {
        double sum = 0;
        for (const VoxelFacts& voxel : session().slice->voxels)
            for (const VoxelFace& face : voxel.faces) sum += static_cast<double>(face.coverage * face.radiance.y);
        return sum;
    };
    session().channel = "voxel_radiance";
    session().level = 2;
    double all = 0;
    for (session().sliceDepth = 0; session().sliceDepth < 16 && all == 0; ++session().sliceDepth) {
        session().askSlice();
        ASSERT_TRUE(turnUntil([&] { return !session().slicePending(); }));
        all = light();
    }
    --session().sliceDepth;
    EXPECT_GT(all, 0);
    double sum = 0;
    for (const int bounce : {0, 1}) {
        session().voxelBounce = bounce;
        ASSERT_TRUE(settle());
        draws(3);
        ASSERT_TRUE(turnUntil([&] { return !session().slicePending() && !session().sliceStale(); }));
        EXPECT_LT(light(), 0.999 * all);
        sum += light();
    }
    EXPECT_NEAR(sum, all, 0.01 * all);
    session().sliceShown = false;
    std::uint64_t found = 0, wanted = 0;
    bool done = false;
    session().thread.now([&](RenderThread::Desk& desk) {
        for (int axis = 0; axis < 3; ++axis) {
            for (int depth = 0; depth < 16; ++depth) {
                const VoxelSlice slice = desk.renderer.voxelSlice(2, axis, depth);
                for (const VoxelFacts& voxel : slice.voxels) {
                    found += voxel.occupied ? 1 : 0;
                    EXPECT_EQ(voxel.occupied, voxel.opacity() > 0);
                }
            }
        }
        wanted = desk.renderer.stats().counts.at("level_2_voxels");
        session().thread.deliver([&] { done = true; });
    });
    ASSERT_TRUE(turnUntil([&] { return done; }));
    EXPECT_GT(wanted, 0u);
    EXPECT_EQ(found, 3 * wanted);
    session().askOccupancy(2);
    ASSERT_TRUE(turnUntil([&] { return session().occupancy.has_value(); }));
    const Occupancy& level2 = *session().occupancy;
    EXPECT_EQ(level2.occupied, wanted);
    EXPECT_EQ(level2.voxels, 16u * 16u * 16u);
    EXPECT_EQ(std::accumulate(level2.histogram.begin(), level2.histogram.end(), std::uint64_t{0}), wanted);
}

TEST_F(ViewerTest, SamplesOfTheFinishedPictureAreCounted) {
    session().countSamples = true;
    for (Panel& panel : viewer().panels()) panel.open = std::string(panel.name) == "Figures";
    ASSERT_TRUE(settle());
    const auto counted = [&] { return session().samplesSerial == session().picture->serial; };
    ASSERT_TRUE(turnUntil(counted));
    const Image before = session().picture->image;
    std::optional<std::uint64_t> samples;
    session().thread.afterPicture([&](RenderThread::Desk& desk) {
        session().thread.deliver([&, n = desk.renderer.coneSamples()] { samples = n; });
    });
    ASSERT_TRUE(turnUntil([&] { return samples.has_value(); }));
    const double pixels = static_cast<double>(before.width) * before.height;
    EXPECT_GT(*samples, 0u);
    EXPECT_EQ(*session().samplesPerPixel, static_cast<double>(*samples) / pixels);
    EXPECT_EQ(session().picture->image.data, before.data) << "counting changes nothing";
    // Views without cones have none.
    session().channel = "albedo";
    ASSERT_TRUE(settle());
    ASSERT_TRUE(turnUntil(counted));
    EXPECT_EQ(*session().samplesPerPixel, 0);
    session().countSamples = false;
}

TEST_F(ViewerTest, ACutLeavesVoxelsAway) {
    const auto lit = [&] {
        EXPECT_TRUE(settle());
        const auto& data = session().picture->image.data;
        return std::count_if(data.begin(), data.end(), [](float v) { return v > 0; });
    };
    session().channel = "voxel_albedo";
    session().level = 2;
    const auto all = lit();
    EXPECT_GT(all, 0);
    session().cutAxis = 1;
    session().cutPlace = 1.01;  // above everything, by less than half a voxel
    session().cutFlipped = false;
    const auto some = lit();
    session().cutPlace = -1;
    EXPECT_EQ(lit(), 0);
    session().cutFlipped = true;
    EXPECT_EQ(lit(), all);
    EXPECT_LE(some, all);
    session().cutAxis = -1;
    session().voxels.edges = true;
    EXPECT_GT(lit(), 0);
    session().triangles = 0.5;
    ASSERT_TRUE(settle());
    session().voxels.edges = false;
    session().triangles = 0;
}

TEST_F(ViewerTest, LightsAreDraggedInThePicture) {
    const Image before = session().picture->image;
    const glm::dvec3 start = session().lights[1].position;
    const auto place = [&] {
        return *Projection(session().camera.camera(), viewer().pictureRect()).point(session().lights[1].position);
    };
    // Without handles the camera turns.
    const Camera camera = session().camera.camera();
    drag(GLFW_MOUSE_BUTTON_LEFT, place(), place() + glm::dvec2(20, 0));
    EXPECT_NE(session().camera.camera().position, camera.position);
    session().takeShot(0);
    key(GLFW_KEY_G);
    const glm::dvec2 to = place() + glm::dvec2(-30, 18);
    drag(GLFW_MOUSE_BUTTON_LEFT, place(), to);
    EXPECT_EQ(session().camera.camera().position, camera.position);
    EXPECT_LT(glm::length(place() - to), 0.5) << "the light stays below the cursor";
    EXPECT_GT(glm::length(session().lights[1].position - start), 0.01);
    ASSERT_TRUE(settle());
    EXPECT_NE(session().picture->image.data, before.data) << "and lights the scene from there";
    // Along an axis only that coordinate changes.
    const glm::dvec3 second = session().lights[1].position;
    const glm::dvec2 grip = place() + glm::dvec2(0, -40);
    drag(GLFW_MOUSE_BUTTON_LEFT, grip, grip + glm::dvec2(0, -25));
    EXPECT_EQ(session().lights[1].position.x, second.x);
    EXPECT_EQ(session().lights[1].position.z, second.z);
    EXPECT_GT(session().lights[1].position.y, second.y);
    ASSERT_TRUE(settle());
    const fs::path picture = screenshot();
    key(GLFW_KEY_S, GLFW_MOD_CONTROL);
    expectSamePictures(picture, capture(lastMessage().substr(6)));
    key(GLFW_KEY_G);
}

/// A glTF whose nodes stand as those of `scene` do, beside the one it was read from.
void writePlaced(const fs::path& from, const fs::path& to, const Scene& scene) {
    json tree = json::parse(std::ifstream(from));
    for (json& buffer : tree["buffers"])
        buffer["uri"] = fs::relative(from.parent_path() / buffer["uri"], to.parent_path());
    for (const Node& node : scene.nodes) {
        json& n = tree["nodes"][static_cast<std::size_t>(node.fileIndex)];
        n["translation"] = {node.translation.x, node.translation.y, node.translation.z};
        n["rotation"] = {node.rotation.x, node.rotation.y, node.rotation.z, node.rotation.w};
        n["scale"] = {node.scale.x, node.scale.y, node.scale.z};
    }
    std::ofstream(to) << tree.dump();
}

TEST_F(ViewerTest, ObjectsAreDraggedInThePicture) {
    const Camera camera = session().camera.camera();
    // A click with Alt selects what lies there.
    const auto node = [&](const char* name) {
        const auto& nodes = session().facts->outline.nodes;
        return static_cast<int>(
            std::find_if(nodes.begin(), nodes.end(), [&](const Node& n) { return n.name == name; }) - nodes.begin());
    };
    const int cube = node("cube"), sphere = node("sphere");
    const auto middle = [&] {
        return *Projection(session().camera.camera(), viewer().pictureRect())
                    .point(session().nodeCenter(session().selectedNode));
    };
    const auto pick = [&](const glm::dvec3& at) {
        moveTo(*Projection(session().camera.camera(), viewer().pictureRect()).point(at));
        turns(2);
        press(GLFW_MOUSE_BUTTON_LEFT, GLFW_PRESS, GLFW_MOD_ALT);
        press(GLFW_MOUSE_BUTTON_LEFT, GLFW_RELEASE, GLFW_MOD_ALT);
        turns(3);
    };
    pick(session().nodeCenter(sphere));
    ASSERT_TRUE(turnUntil([&] { return session().selectedNode == sphere; }));
    pick(session().nodeCenter(cube));
    ASSERT_TRUE(turnUntil([&] { return session().selectedNode == cube; }));
    EXPECT_EQ(session().camera.camera().position, camera.position);

    // By its middle it follows the cursor, and light with it before the button is released.
    const Image before = session().picture->image;
    const glm::dvec2 from = middle(), to = from + glm::dvec2(-22, -9);
    moveTo(from);
    turns(2);
    press(GLFW_MOUSE_BUTTON_LEFT, GLFW_PRESS);
    turns(1);
    moveTo(to);
    ASSERT_TRUE(turnUntil([&] {
        return session().picture->view.placing && !session().picture->view.placed.empty() &&
               session().picture->divisor == 1;
    }));
    EXPECT_FALSE(session().picture->finished) << "while it is dragged";
    EXPECT_LT(glm::length(middle() - to), 1.0) << "stays below the cursor";
    press(GLFW_MOUSE_BUTTON_LEFT, GLFW_RELEASE);
    turns(2);
    ASSERT_TRUE(settle());
    EXPECT_NE(session().picture->image.data, before.data);

    // Turned by the ring about y, which is seen from above, and stretched along x.
    const glm::dvec3 center = session().nodeCenter(cube);
    key(GLFW_KEY_T);
    const Projection projection(session().camera.camera(), viewer().pictureRect());
    const double length = 70 / projection.scaleAt(center);
    const glm::dvec2 front = *projection.point(center + length * glm::normalize(glm::dvec3(1, 0, 1)));
    drag(GLFW_MOUSE_BUTTON_LEFT, front, front + glm::dvec2(20, -5));
    ASSERT_TRUE(session().placed[cube].rotation.has_value());
    EXPECT_GT(session().placed[cube].rotation->y, 5) << "counter-clockwise, as its front goes to the right";
    EXPECT_LT(glm::length(session().nodeCenter(cube) - center), 1e-9) << "about its middle";
    key(GLFW_KEY_T);
    const glm::dmat4 pose = session().scene().worldMatrices(0)[static_cast<std::size_t>(cube)];
    const glm::dvec2 tip = *projection.point(center + length * glm::normalize(glm::dvec3(pose[0])));
    drag(GLFW_MOUSE_BUTTON_LEFT, tip, tip + 0.5 * (tip - middle()));
    ASSERT_TRUE(session().placed[cube].scale.has_value());
    EXPECT_GT(session().placed[cube].scale->x, 1.2);
    EXPECT_EQ(session().placed[cube].scale->y, 1);
    key(GLFW_KEY_T);
    EXPECT_EQ(session().camera.camera().position, camera.position);

    // The script and a glTF that is edited so give the same picture, bit for bit.
    ASSERT_TRUE(settle());
    const fs::path picture = screenshot();
    key(GLFW_KEY_S, GLFW_MOD_CONTROL);
    ASSERT_TRUE(lastMessage().starts_with("wrote ")) << lastMessage();
    const fs::path script = lastMessage().substr(6);
    EXPECT_TRUE(json::parse(std::ifstream(script)).contains("objects"));
    expectSamePictures(picture, capture(script));
    json edited = json::parse(std::ifstream(script));
    edited.erase("objects");
    writePlaced(edited["scene"].get<std::string>(), folder() / "edited.gltf", session().scene());
    edited["scene"] = "edited.gltf";
    std::ofstream(folder() / "edited.json") << edited.dump();
    expectSamePictures(picture, capture(folder() / "edited.json"));

    // Each drag is one step, and all the way back is the picture as it was opened.
    for (int i = 0; i < 3; ++i) {
        EXPECT_FALSE(session().placed.empty());
        key(GLFW_KEY_Z, GLFW_MOD_CONTROL);
    }
    EXPECT_TRUE(session().placed.empty());
    ASSERT_TRUE(settle());
    EXPECT_EQ(session().picture->image.data, before.data);
    key(GLFW_KEY_Y, GLFW_MOD_CONTROL);
    EXPECT_TRUE(session().placed.contains(cube));
    key(GLFW_KEY_ESCAPE);
    EXPECT_EQ(session().selectedNode, -1);
}

TEST_F(ViewerTest, AMovedEmitterShinesFromWhereItIs) {
    // A cube that shines; its sides are extracted as lights as long as they are small beside the scene.
    json scene = json::parse(std::ifstream(VOXCONE_SOURCE_DIR "/assets/scenes/basic.gltf"));
    for (json& buffer : scene["buffers"])
        buffer["uri"] = fs::relative(fs::path(VOXCONE_SOURCE_DIR "/assets/scenes") / buffer["uri"], folder());
    const int mesh = scene["nodes"][2]["mesh"];
    const int material = scene["meshes"][mesh]["primitives"][0]["material"];
    scene["materials"][material]["emissiveFactor"] = {1, 0.8, 0.5};
    std::ofstream(folder() / "shining.gltf") << scene.dump();
    json script = basicScript();
    script["scene"] = "shining.gltf";
    script["environment"]["color"] = {0, 0, 0};
    script.erase("lights");
    std::ofstream(folder() / "shining.json") << script.dump();
    const std::uint64_t serial = session().sceneSerial;
    drop(folder() / "shining.json");
    ASSERT_TRUE(turnUntil([&] { return session().sceneSerial > serial && session().settled(); }));
    const std::size_t extracted = session().lights.size();
    ASSERT_GT(extracted, 0u);
    // Higher than the scene was before, and then so large that voxels keep its light.
    for (const double scale : {1.0, 2.5}) {
        session().placeNode(2, {glm::dvec3(0.4, 1.9, 0.1), {}, glm::dvec3(scale)});
        ASSERT_TRUE(settle());
        // What was extracted anew is shown with the view that follows.
        ASSERT_TRUE(settle());
        EXPECT_EQ(session().lights.size(), scale == 1 ? extracted : 0u);
        const fs::path picture = screenshot();
        key(GLFW_KEY_S, GLFW_MOD_CONTROL);
        expectSamePictures(picture, capture(lastMessage().substr(6)));
    }
    key(GLFW_KEY_Z, GLFW_MOD_CONTROL);
    ASSERT_TRUE(settle());
    ASSERT_TRUE(settle());
    EXPECT_EQ(session().lights.size(), extracted);
    EXPECT_EQ(*session().placed.at(2).scale, glm::dvec3(1));
}

TEST_F(ViewerTest, LightsOfTheSceneAreDraggedTurnedAndWritten) {
    json scene = json::parse(std::ifstream(VOXCONE_SOURCE_DIR "/assets/scenes/basic.gltf"));
    for (json& buffer : scene["buffers"])
        buffer["uri"] = fs::relative(fs::path(VOXCONE_SOURCE_DIR "/assets/scenes") / buffer["uri"], folder());
    scene["extensionsUsed"] = {"KHR_lights_punctual"};
    scene["extensions"]["KHR_lights_punctual"]["lights"] =
        json::parse(R"([{"type": "spot", "name": "lamp", "intensity": 4, "spot": {"outerConeAngle": 0.6}}])");
    scene["scenes"][0]["nodes"].push_back(scene["nodes"].size());
    scene["nodes"].push_back({{"translation", {0.3, 1.4, 0.3}}, {"rotation", {-0.6, 0, 0, 0.8}}, {"scale", {2, 2, 2}}});
    scene["nodes"].back()["extensions"]["KHR_lights_punctual"]["light"] = 0;
    std::ofstream(folder() / "lit.gltf") << scene.dump();
    json script = basicScript();
    script["scene"] = "lit.gltf";
    script.erase("lights");
    std::ofstream(folder() / "lit.json") << script.dump();
    const std::uint64_t serial = session().sceneSerial;
    drop(folder() / "lit.json");
    ASSERT_TRUE(turnUntil([&] { return session().sceneSerial > serial && session().settled(); }));
    const Image before = session().picture->image;
    const auto place = [&] {
        return *Projection(session().camera.camera(), viewer().pictureRect()).point(*session().lightPosition(0));
    };
    key(GLFW_KEY_G);
    const glm::dvec2 to = place() + glm::dvec2(-25, 14);
    drag(GLFW_MOUSE_BUTTON_LEFT, place(), to);
    EXPECT_LT(glm::length(place() - to), 0.5);
    key(GLFW_KEY_T);
    const glm::dvec3 was = *session().lightDirection(0);
    const Projection projection(session().camera.camera(), viewer().pictureRect());
    const glm::dvec3 at = *session().lightPosition(0);
    const glm::dvec2 grip = *projection.point(at + glm::dvec3(0, 70 / projection.scaleAt(at), 0));
    drag(GLFW_MOUSE_BUTTON_LEFT, grip, grip + glm::dvec2(15, 0));
    EXPECT_LT(glm::dot(*session().lightDirection(0), was), 0.999);
    EXPECT_NEAR(glm::length(*session().lightDirection(0)), 1, 1e-12);
    ASSERT_TRUE(settle());
    EXPECT_NE(session().picture->image.data, before.data);
    const fs::path picture = screenshot();
    key(GLFW_KEY_S, GLFW_MOD_CONTROL);
    ASSERT_TRUE(lastMessage().starts_with("wrote ")) << lastMessage();
    EXPECT_FALSE(session().messages.back().error);
    const fs::path written = lastMessage().substr(6);
    EXPECT_EQ(json::parse(std::ifstream(written))["scene_lights"][0]["light"], "lamp");
    expectSamePictures(picture, capture(written));
    // Two steps back.
    key(GLFW_KEY_Z, GLFW_MOD_CONTROL);
    EXPECT_LT(glm::length(*session().lightDirection(0) - was), 1e-12);
    key(GLFW_KEY_Z, GLFW_MOD_CONTROL);
    EXPECT_EQ(session().lights, session().facts->outline.lights);
    ASSERT_TRUE(settle());
    EXPECT_EQ(session().picture->image.data, before.data);
    session().gizmoMode = GizmoMode::move;
    key(GLFW_KEY_G);
}

TEST_F(ViewerTest, HeldPicturesAreCompared) {
    // The present picture's errors, by the controls as they are.
    const auto measured = [&] {
        return turnUntil([&] {
            const Errors* errors = session().presentToHeld.errorsOf(session().presentImage(session().picture));
            return session().settled() && errors != nullptr;
        });
    };
    key(GLFW_KEY_H);
    ASSERT_TRUE(session().held.has_value());
    ASSERT_TRUE(measured());
    EXPECT_EQ(session().presentToHeld.errors()->linear.rmse, 0);
    Settings brighter = session().settings.now();
    brighter.output.exposure = 1;
    session().settings.change(brighter, "brighter");
    ASSERT_TRUE(settle());
    ASSERT_TRUE(measured());
    EXPECT_NEAR(session().presentToHeld.errors()->linear.relativeBias, 1, 1e-3) << "twice as bright";
    // The split shows the held picture on its left.
    session().split = 0.5;
    draws(2);
    const Image shown = viewer().readWindow();
    const auto light = [&](double x) {
        const glm::ivec2 p(inPicture(x, 0.9));
        return static_cast<double>(shown.pixel(p.x, p.y)[1]);
    };
    EXPECT_LT(light(0.47), light(0.53));

    Settings quick = session().settings.now();
    quick.output.exposure = 0;
    quick.reference.samples = 8;
    session().settings.change(quick, "quick");
    ASSERT_TRUE(settle());
    session().holdReference();
    ASSERT_TRUE(turnUntil([&] { return session().held.has_value(); }));
    ASSERT_TRUE(measured());
    EXPECT_GT(session().presentToHeld.errors()->linear.rmse, 0);
    EXPECT_LT(std::abs(session().presentToHeld.errors()->linear.relativeBias), 0.3);
    for (Panel& panel : viewer().panels()) panel.open = std::string(panel.name) == "Comparison";
    draws(3);
    session().releaseHeld();
    session().holdFile(folder() / "absent.exr");
    EXPECT_THAT(lastMessage(), HasSubstr("absent.exr"));
    session().holdFile(screenshot().string() + ".exr");
    ASSERT_TRUE(session().held.has_value());
    ASSERT_TRUE(measured());
    EXPECT_EQ(session().presentToHeld.errors()->linear.rmse, 0);
    session().releaseHeld();
}

TEST_F(ViewerTest, MapsOfTheErrorLieOverThePicture) {
    key(GLFW_KEY_H);
    Settings other = session().settings.now();
    other.cone.gain = 1.5;
    session().settings.change(other, "gain");
    ASSERT_TRUE(settle());
    session().split = 0.25;
    session().errorScale = 0.5;
    const auto mapOf = [&](ErrorMap kind) {
        session().errorMap = kind;
        std::shared_ptr<const Image> map;
        EXPECT_TRUE(turnUntil([&] {
            const Errors* errors = session().presentToHeld.errorsOf(session().presentImage(session().picture));
            return errors && errors->kind == kind && (map = errors->map) != nullptr;
        }));
        return map;
    };
    const auto expectShown = [&](const Image& colors) {
        turns(3);
        const Image shown = viewer().readWindow();
        for (const glm::ivec2 pixel : {glm::ivec2(120, 90), glm::ivec2(160, 70), glm::ivec2(90, 60)}) {
            const glm::ivec2 p(inPicture((pixel.x + 0.5) / 200, (pixel.y + 0.5) / 112));
            for (int c = 0; c < 3; ++c)
                EXPECT_NEAR(shown.pixel(p.x, p.y)[c], srgbFromLinear(colors.pixel(pixel.x, pixel.y)[c]), 1.5f / 255);
        }
    };
    const Image held = *session().held->image, now = session().picture->image;
    moveTo(inPicture(0.8, 0.6));
    const auto relative = mapOf(ErrorMap::relative);
    EXPECT_EQ(relative->data, relativeErrorMap(held, now).data);
    expectShown(signedHeatmap(*relative, 0.5));
    const auto hdr = mapOf(ErrorMap::hdr_flip);
    EXPECT_EQ(hdr->data, hdrFlip(held, now).error.data);
    expectShown(heatmap(*hdr, 0.5));
    session().errorMap = ErrorMap::none;
    session().errorScale = 1;
    session().split = 0.5;
    session().releaseHeld();
}

TEST_F(ViewerTest, TwoSettingsAreRenderedSideBySide) {
    const Settings a = session().settings.now();
    key(GLFW_KEY_H);
    session().compareWith("");
    ASSERT_NE(session().other, nullptr);
    ASSERT_TRUE(session().controlsOther) << "the controls change B from the start";
    Settings b = a;
    b.cone.diffuse = 6;
    b.light.bounces = 2;
    session().settings.change(b, "B");
    drag(GLFW_MOUSE_BUTTON_LEFT, inPicture(0.5, 0.5), inPicture(0.6, 0.5));
    session().lights[1].position.x += 0.3;
    const std::vector<Light> lights = session().lights;
    const auto both = [&] { return turnUntil([&] { return session().settled() && session().other->settled(); }); };
    turns(1);
    ASSERT_TRUE(both());
    const std::shared_ptr<const Picture> left = session().picture, right = session().other->picture();
    EXPECT_EQ(right->view.camera.position, left->view.camera.position);
    EXPECT_TRUE(sameSettings(left->view.settings, a));
    EXPECT_TRUE(sameSettings(right->view.settings, b));
    // Figures of all three pairs.
    ASSERT_TRUE(turnUntil([&] {
        return session().otherToPresent.errorsOf(session().otherImage(right)) &&
               session().presentToHeld.errorsOf(session().presentImage(left)) &&
               session().otherToHeld.errorsOf(session().otherImage(right));
    }));
    EXPECT_EQ(session().otherToPresent.errors()->linear.relMse, linearError(left->image, right->image).relMse);
    EXPECT_EQ(session().otherToHeld.errors()->linear.relMse, linearError(*session().held->image, right->image).relMse);
    EXPECT_GT(session().otherToPresent.errors()->linear.relMse, 0);
    session().releaseHeld();
    // A is left of the split, B right of it.
    ASSERT_TRUE(turnUntil([&] { return session().flashes.empty(); }));
    turns(3);
    const Image shown = viewer().readWindow();
    for (const double x : {0.3, 0.7}) {
        const Image& image = x < 0.5 ? left->image : right->image;
        const glm::ivec2 pixel(glm::dvec2(x, 0.8) * glm::dvec2(image.width, image.height));
        const glm::ivec2 p(inPicture((pixel.x + 0.5) / image.width, (pixel.y + 0.5) / image.height));
        const Image display = displayOf(image, a.output.toneMap);
        for (int c = 0; c < 3; ++c)
            EXPECT_NEAR(shown.pixel(p.x, p.y)[c], srgbFromLinear(display.pixel(pixel.x, pixel.y)[c]), 1.5f / 255);
    }
    // Each is the capture of its settings; screenshots and scripts are of those that the controls change.
    for (const auto& picture : {right, left}) {
        const fs::path file = screenshot();
        key(GLFW_KEY_S, GLFW_MOD_CONTROL);
        const fs::path headless = capture(lastMessage().substr(6));
        expectSamePictures(file, headless);
        EXPECT_EQ(readImage(headless.string() + ".exr").data, picture->image.data);
        key(GLFW_KEY_X);
    }
    EXPECT_TRUE(session().controlsOther);
    for (Panel& panel : viewer().panels()) panel.open = std::string(panel.name) == "Comparison";
    draws(3);
    // Each tree has its own way back, in turn with what was moved since.
    key(GLFW_KEY_Z, GLFW_MOD_CONTROL);
    EXPECT_NE(session().lights, lights);
    EXPECT_TRUE(sameSettings(session().settingsB(), b));
    key(GLFW_KEY_Z, GLFW_MOD_CONTROL);
    EXPECT_TRUE(sameSettings(session().settingsB(), a));
    for (int i = 0; i < 2; ++i) key(GLFW_KEY_Y, GLFW_MOD_CONTROL);
    EXPECT_EQ(session().lights, lights);
    session().endOther(true);
    EXPECT_EQ(session().other, nullptr);
    EXPECT_FALSE(session().controlsOther);
    EXPECT_TRUE(sameSettings(session().settings.now(), b));
    ASSERT_TRUE(settle());
    EXPECT_EQ(session().picture->image.data, right->image.data);
    key(GLFW_KEY_Z, GLFW_MOD_CONTROL);
    EXPECT_TRUE(sameSettings(session().settings.now(), a));
}

TEST_F(ViewerTest, OtherSettingsMayExtractOtherLights) {
    Image sun(64, 32, 3);
    std::fill(sun.data.begin(), sun.data.end(), 0.2f);
    for (int c = 0; c < 3; ++c) sun.pixel(20, 8)[c] = 2000;
    writeExr(folder() / "sun.exr", sun);
    const std::size_t before = session().facts->outline.lights.size();
    drop(folder() / "sun.exr");
    ASSERT_TRUE(turnUntil([&] { return session().settled() && session().lights.size() > before; }));
    const std::size_t lights = session().facts->outline.lights.size();
    session().compareWith("no such preset");
    EXPECT_EQ(session().other, nullptr);
    EXPECT_THAT(lastMessage(), HasSubstr("no such preset"));
    session().compareWith("");
    Settings b = session().settings.now();
    b.light.extractEnvironment = 0;
    session().settings.change(b, "B");
    turns(1);
    ASSERT_TRUE(turnUntil([&] { return session().settled() && session().other->settled(); }));
    EXPECT_LT(session().other->thread().scene()->outline.lights.size(), lights);
    EXPECT_EQ(session().facts->outline.lights.size(), lights);
    const Image image = session().other->picture()->image;
    EXPECT_NE(image.data, session().picture->image.data);
    for (const Image& shown : {image, session().picture->image}) {
        key(GLFW_KEY_S, GLFW_MOD_CONTROL);
        EXPECT_EQ(readImage(capture(lastMessage().substr(6)).string() + ".exr").data, shown.data);
        key(GLFW_KEY_X);
    }
    // Another scene ends it.
    session().open(folder() / "basic.json");
    ASSERT_TRUE(turnUntil([&] { return session().other == nullptr; }));
    EXPECT_FALSE(session().controlsOther);
}

TEST_F(ViewerTest, ChangesFromPictureToPictureAreShownAndHeld) {
    const auto watched = [&] { return settle() && turnUntil([&] { return session().flicker.idle(); }); };
    const Image before = session().picture->image;
    session().freeze(true);
    session().camera.fly({0, 0, 6 * session().picture->clipmap.layout.voxelSize});
    ASSERT_TRUE(settle());
    const Image plain = session().picture->image;
    key(GLFW_KEY_J);
    ASSERT_TRUE(watched());
    EXPECT_EQ(session().picture->image.data, plain.data) << "watching changes no picture";
    EXPECT_EQ(session().flicker.shown(), nullptr) << "there is nothing before";
    const std::shared_ptr<const WatchedFrame> start = session().picture->watched;
    ASSERT_NE(start, nullptr);
    // A step of the clipmap, the camera standing still: all surfaces are compared.
    key(GLFW_KEY_N);
    ASSERT_TRUE(watched());
    const Picture& picture = *session().picture;
    ASSERT_NE(session().flicker.latest(), nullptr);
    FlickerPicture latest = *session().flicker.latest();
    ASSERT_EQ(latest.change.data.size(), picture.image.data.size() / 3);
    EXPECT_EQ(latest.change.data, changeMap(start->frame, picture.watched->frame).change.data);
    EXPECT_GT(latest.figures.rms, 0) << "voxels of another level light the surfaces now";
    EXPECT_EQ(
        std::count_if(latest.change.data.begin(), latest.change.data.end(), [](float v) { return std::isnan(v); }), 0);
    const Image firstHeld = latest.held;
    key(GLFW_KEY_N);
    ASSERT_TRUE(watched());
    latest = *session().flicker.latest();
    for (std::size_t i = 0; i < firstHeld.data.size(); ++i) {
        EXPECT_GE(std::abs(latest.held.data[i]), std::abs(firstHeld.data[i]));
        EXPECT_GE(std::abs(latest.held.data[i]), std::abs(latest.change.data[i]));
    }
    // In the window, exaggerated.
    session().flicker.exaggeration = 20;
    for (Panel& panel : viewer().panels()) panel.open = std::string(panel.name) == "Comparison";
    ASSERT_TRUE(turnUntil([&] { return session().flashes.empty(); }));
    draws(3);
    const Image colors = signedHeatmap(latest.held, 1.0 / 20), shown = viewer().readWindow();
    for (const glm::ivec2 pixel : {glm::ivec2(150, 80), glm::ivec2(60, 60), glm::ivec2(100, 40)}) {
        const glm::ivec2 p(inPicture((pixel.x + 0.5) / 200, (pixel.y + 0.5) / 112));
        for (int c = 0; c < 3; ++c)
            EXPECT_NEAR(shown.pixel(p.x, p.y)[c], srgbFromLinear(colors.pixel(pixel.x, pixel.y)[c]), 1.5f / 255);
    }
    // A flying camera: most surfaces are found again, some were not seen before.
    session().freeze(false);
    ASSERT_TRUE(watched());
    session().clearChanges();
    EXPECT_EQ(session().flicker.shown(), nullptr);
    ASSERT_TRUE(watched());
    session().camera.fly({0.4, 0, 0});
    ASSERT_TRUE(watched());
    latest = *session().flicker.latest();
    EXPECT_GT(latest.figures.valid, 0.5);
    const auto unseen =
        std::count_if(latest.change.data.begin(), latest.change.data.end(), [](float v) { return std::isnan(v); });
    EXPECT_GT(unseen, 10);
    EXPECT_LT(unseen, static_cast<std::ptrdiff_t>(latest.change.data.size() / 3));
    // The seam by the same controls.
    session().watch(Watched::seam);
    session().channel = "seam";
    ASSERT_TRUE(watched());
    ASSERT_NE(session().flicker.latest(), nullptr);
    EXPECT_EQ(session().flicker.latest()->change.data, session().picture->image.data);
    EXPECT_TRUE(std::any_of(session().flicker.latest()->held.data.begin(), session().flicker.latest()->held.data.end(),
                            [](float v) { return std::abs(v) > 0; }));
    key(GLFW_KEY_J);
    EXPECT_EQ(session().flicker.shown(), nullptr);
    session().channel = "beauty";
    session().takeShot(0);
    ASSERT_TRUE(settle());
    EXPECT_EQ(session().picture->image.data, before.data);
    session().flicker.exaggeration = 10;
}

TEST_F(ViewerTest, AnswersWhileItCompares) {
    Settings large = session().settings.now();
    large.output.width = 640, large.output.height = 360;
    session().settings.change(large, "large");
    ASSERT_TRUE(settle());
    key(GLFW_KEY_H);
    session().compareWith("");
    Settings b = large;
    b.cone.gain = 1;
    session().settings.change(b, "B");
    session().errorMap = ErrorMap::hdr_flip;
    // Both pictures are measured against what is held, and against each other.
    std::vector<double> gaps;
    const auto start = Clock::now();
    auto before = start;
    const auto measured = [&] {
        const auto done = [&](const Measurement& m, const std::shared_ptr<const Image>& image) {
            const Errors* errors = m.errorsOf(image);
            return errors && errors->kind == ErrorMap::hdr_flip;
        };
        return session().settled() && session().other->settled() &&
               done(session().presentToHeld, session().presentImage(session().picture)) &&
               done(session().otherToHeld, session().otherImage(session().other->picture())) &&
               done(session().otherToPresent, session().otherImage(session().other->picture()));
    };
    int i = 0;
    while (!measured() && Clock::now() - start < std::chrono::seconds(120)) {
        moveTo(inPicture(0.2 + 0.001 * (++i % 500), 0.5));
        viewer().turn(0.05);
        const auto now = Clock::now();
        gaps.push_back(std::chrono::duration<double>(now - before).count());
        before = now;
    }
    ASSERT_TRUE(measured());
    const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
    std::sort(gaps.begin(), gaps.end());
    std::printf("turns: %zu in %.1f s, median %.0f ms, 95 %% below %.0f ms, worst %.0f ms\n", gaps.size(), seconds,
                1e3 * gaps[gaps.size() / 2], 1e3 * gaps[gaps.size() * 95 / 100], 1e3 * gaps.back());
    EXPECT_GE(static_cast<double>(gaps.size()) / seconds, 10) << "turns a second";
    session().errorMap = ErrorMap::none;
    session().releaseHeld();
    session().endOther();
}

TEST_F(ViewerTest, ShadersAreReloadedAndMistakesShown) {
    const fs::path file = folder() / "shaders" / "frame" / "composite.comp";
    std::ifstream in(file);
    const std::string good((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
    const auto write = [&](const std::string& text) {
        std::ofstream(file) << text;
        // Some file systems count in seconds.
        fs::last_write_time(file, fs::file_time_type::clock::now() + std::chrono::seconds(2));
        viewer().turn(0);
    };
    const Image before = session().picture->image;
    session().messages.clear();
    write(good + "\nmistake;\n");
    ASSERT_TRUE(turnUntil([&] { return !session().messages.empty(); }));
    EXPECT_THAT(lastMessage(), HasSubstr("shaders/frame/composite.comp:"));
    EXPECT_TRUE(session().messages.back().error);
    ASSERT_TRUE(settle());
    EXPECT_EQ(session().picture->image.data, before.data) << "the old shaders stay";

    std::string twice = good;
    const std::string store = "imageStore(u_output, pixel, vec4(radiance";
    ASSERT_NE(twice.find(store), std::string::npos);
    twice.replace(twice.find(store), store.size(), "imageStore(u_output, pixel, vec4(2.0 * radiance");
    session().messages.clear();
    std::ofstream(file) << twice;
    key(GLFW_KEY_F5);
    ASSERT_TRUE(turnUntil([&] { return !session().messages.empty(); }));
    EXPECT_EQ(lastMessage(), "shaders compiled");
    ASSERT_TRUE(turnUntil([&] { return session().settled() && session().picture->image.data != before.data; }));
    EXPECT_NEAR(session().picture->image.data.back(), 2 * before.data.back(), 1e-4f);
    session().messages.clear();
    std::ofstream(file) << good;
    key(GLFW_KEY_F5);
    ASSERT_TRUE(turnUntil([&] { return !session().messages.empty(); }));
}

TEST_F(ViewerTest, AnswersWhileItRenders) {
    Settings heavy = session().settings.now();
    heavy.output.width = 640, heavy.output.height = 360;
    heavy.cone.diffuse = 32;
    session().settings.change(heavy, "heavy");
    turns(1);
    ASSERT_TRUE(turnUntil([&] { return session().picture->view.settings.output.width == 640; })) << "compiled";
    // An event every turn, as a hand on the mouse gives; the camera moves, so that the picture is always begun anew.
    std::vector<double> gaps;
    std::uint64_t pictures = 0;
    auto last = session().picture;
    const auto start = Clock::now();
    auto before = start;
    int i = 0;
    moveTo(inPicture(0.5, 0.5));
    turns(1);
    press(GLFW_MOUSE_BUTTON_LEFT, GLFW_PRESS);
    while (Clock::now() - start < std::chrono::seconds(4)) {
        // Two seconds of motion, two of rest.
        if (Clock::now() - start < std::chrono::seconds(2)) moveTo(inPicture(0.5 + 0.002 * ++i, 0.5));
        viewer().turn(0.05);
        const auto now = Clock::now();
        gaps.push_back(std::chrono::duration<double>(now - before).count());
        before = now;
        if (session().picture != last) ++pictures, last = session().picture;
    }
    press(GLFW_MOUSE_BUTTON_LEFT, GLFW_RELEASE);
    turns(1);
    std::sort(gaps.begin(), gaps.end());
    const double median = gaps[gaps.size() / 2], worst = gaps.back();
    RecordProperty("median_ms", std::to_string(1e3 * median));
    RecordProperty("worst_ms", std::to_string(1e3 * worst));
    std::printf("turns: %zu in 4 s, median %.0f ms, 95 %% below %.0f ms, worst %.0f ms; %llu pictures\n", gaps.size(),
                1e3 * median, 1e3 * gaps[gaps.size() * 95 / 100], 1e3 * worst,
                static_cast<unsigned long long>(pictures));
    EXPECT_GE(gaps.size(), 40u) << "ten turns a second";
    EXPECT_GE(pictures, 2u);
}

/// Times from an event to the first picture that shows it, and between turns, for a script that is opened.
struct Delays {
    std::vector<double> camera, light, gaps;  ///< seconds, sorted
    bool unsettledFinished = false;           ///< a picture was called finished before its light was whole
    std::size_t unsettled = 0;                ///< pictures whose light was not whole
};

double quantile(const std::vector<double>& sorted, double share) {
    return sorted.empty() ? 0
                          : sorted[std::min(sorted.size() - 1,
                                            static_cast<std::size_t>(share * static_cast<double>(sorted.size())))];
}

/// Moves the light (`lights` times) or the camera, each time when a picture shows the last move, for `seconds`.
class Following : public ViewerTest {
  protected:
    Delays follow(double seconds, int lights) {
        Delays delays;
        auto last = session().picture;
        auto before = Clock::now();
        const auto turn = [&] {
            viewer().turn(0.01);
            const auto now = Clock::now();
            delays.gaps.push_back(std::chrono::duration<double>(now - before).count());
            before = now;
            if (session().picture == last) return;
            last = session().picture;
            if (!last->light.whole) ++delays.unsettled;
            if (!last->light.whole && last->finished) delays.unsettledFinished = true;
        };
        const auto until = [&](const std::function<bool()>& shown, std::vector<double>& into) {
            const auto start = Clock::now();
            while (!shown() && Clock::now() - start < std::chrono::seconds(60)) turn();
            into.push_back(std::chrono::duration<double>(Clock::now() - start).count());
        };
        const auto end = Clock::now() + std::chrono::duration<double>(seconds);
        for (int i = 0; i < lights || Clock::now() < end; ++i) {
            if (i < lights) {
                session().moveLight(0, *session().lightPosition(0) + glm::dvec3(0.05, 0, 0));
                until([&] { return last->view.lights == session().lights; }, delays.light);
            }
            moveTo(inPicture(0.5, 0.5));
            turn();
            press(GLFW_MOUSE_BUTTON_LEFT, GLFW_PRESS);
            turn();
            for (int j = 1; j <= 4; ++j) {
                moveTo(inPicture(0.5 + 0.01 * j, 0.5));
                turn();
                const glm::dvec3 wanted = session().camera.camera().position;
                until([&] { return last->view.camera.position == wanted; }, delays.camera);
            }
            press(GLFW_MOUSE_BUTTON_LEFT, GLFW_RELEASE);
            turn();
        }
        for (auto* values : {&delays.camera, &delays.light, &delays.gaps}) std::sort(values->begin(), values->end());
        std::printf(
            "camera to picture: median %.0f ms, worst %.0f ms of %zu; light to picture: median %.0f ms, worst %.0f ms "
            "of %zu; %zu turns: median %.0f ms, 95 %% below %.0f ms, worst %.0f ms; 1/%d of the size, %s\n",
            1e3 * quantile(delays.camera, 0.5), 1e3 * quantile(delays.camera, 1), delays.camera.size(),
            1e3 * quantile(delays.light, 0.5), 1e3 * quantile(delays.light, 1), delays.light.size(), delays.gaps.size(),
            1e3 * quantile(delays.gaps, 0.5), 1e3 * quantile(delays.gaps, 0.95), 1e3 * quantile(delays.gaps, 1),
            last->divisor, lightText(last->light).c_str());
        return delays;
    }
};

// While bounces are gathered that take seconds, each move of camera and light has its picture.
TEST_F(Following, PicturesFollowWhileLightGathers) {
    Settings slow = session().settings.now();
    slow.voxel.resolution = 32;
    slow.light.bounces = 8;
    slow.light.bounceCones = 9;
    slow.light.tolerance = 0;
    session().settings.change(slow, "slow");
    session().lights[1].intensity *= 2;
    turns(2);
    ASSERT_TRUE(turnUntil([&] { return session().picture->view.settings.light.bounces == 8; }));
    const Delays delays = follow(1, 2);
    EXPECT_FALSE(delays.unsettledFinished);
    EXPECT_GT(delays.unsettled, 2u) << "pictures while light gathers";
    ASSERT_TRUE(settle());
    EXPECT_TRUE(session().picture->light.whole);
    EXPECT_EQ(session().picture->stats.counts.at("light_bounces"), 8u);
    // The finished picture after all of that is the capture's.
    const fs::path window = screenshot();
    key(GLFW_KEY_S, GLFW_MOD_CONTROL);
    ASSERT_TRUE(lastMessage().starts_with("wrote ")) << lastMessage();
    expectSamePictures(window, capture(lastMessage().substr(6)));
}

// Figures of docs/viewer.md; takes a minute.
TEST_F(Following, DISABLED_CornellAtDefaultSettings) {
    json script = json::parse(std::ifstream(VOXCONE_SOURCE_DIR "/assets/captures/cornell.json"));
    script["scene"] = VOXCONE_SOURCE_DIR "/assets/scenes/cornell.gltf";
    script["settings"]["output"]["width"] = 640;
    script["settings"]["output"]["height"] = 360;
    std::ofstream(folder() / "cornell.json") << script.dump(1);
    const std::uint64_t before = session().sceneSerial;
    session().thread.open(folder() / "cornell.json");
    ASSERT_TRUE(turnUntil([&] {
        return session().sceneSerial > before && session().picture->view.scene > before && !session().picture->surfaces;
    }));
    const Delays delays = follow(30, 5);
    EXPECT_FALSE(delays.unsettledFinished);
    EXPECT_LT(quantile(delays.gaps, 0.95), 0.1) << "ten turns a second";
}

/// The same window on a display of 192 dots an inch.
class HighDensity : public ViewerTest {
  protected:
    static std::unique_ptr<DisplayDensity>& density() {
        static std::unique_ptr<DisplayDensity> density;
        return density;
    }
    static void SetUpTestSuite() {
        density() = std::make_unique<DisplayDensity>(192);
        ViewerTest::SetUpTestSuite();
    }
    static void TearDownTestSuite() {
        ViewerTest::TearDownTestSuite();
        density().reset();
    }
};

TEST_F(HighDensity, ControlsGrowAndPicturesStay) {
    EXPECT_EQ(viewer().window().contentScale(), 2);
    EXPECT_GE(viewer().pictureRect().low.y, 2 * 19);
    EXPECT_EQ(viewer().pictureRect().size, glm::dvec2(200, 112)) << "whole pixels beside the side bar";
    const Image png = readImage(screenshot().string() + ".png");
    turns(3);
    const Image window = viewer().readWindow();
    const glm::ivec2 low(viewer().pictureRect().low);
    float worst = 0;
    for (int y = 0; y < png.height; ++y)
        for (int x = 0; x < png.width; ++x)
            for (int c = 0; c < 3; ++c)
                worst = std::max(worst, std::abs(static_cast<float>(srgbFromLinear(png.pixel(x, y)[c])) -
                                                 window.pixel(low.x + x, low.y + y)[c]));
    EXPECT_LT(worst, 1.5f / 255);
    const Camera before = session().camera.camera();
    drag(GLFW_MOUSE_BUTTON_LEFT, inPicture(0.5, 0.5), inPicture(0.7, 0.5));
    EXPECT_NE(session().camera.camera().position, before.position);
    for (Panel& panel : viewer().panels()) panel.open = true;
    turns(3);
    ASSERT_TRUE(settle());
    const fs::path moved = screenshot();
    key(GLFW_KEY_S, GLFW_MOD_CONTROL);
    expectSamePictures(moved, capture(lastMessage().substr(6)));
}

TEST_F(ViewerTest, SettingsThatTheDeviceRefusesAreToldAndTakenBack) {
    Settings huge = session().settings.now();
    huge.output.width = huge.output.height = 16384;
    huge.output.supersample = 8;
    session().settings.change(huge, "huge");
    ASSERT_TRUE(turnUntil([&] { return !session().messages.empty() && session().messages.back().error; }));
    key(GLFW_KEY_Z, GLFW_MOD_CONTROL);
    ASSERT_TRUE(settle());
    session().messages.clear();
    expectSamePictures(screenshot(), capture(folder() / "basic.json"));
}

}  // namespace
}  // namespace voxcone
