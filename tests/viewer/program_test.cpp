// voxcone view from outside: a real window, a real keyboard.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cstdlib>
#include <thread>

#include "cli/program.h"
#include "metric/image.h"

namespace voxcone {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

TEST(ViewProgram, WithoutADisplayNamesTheWayThatNeedsNone) {
    const Outcome outcome = voxcone({"view"}, "DISPLAY=");
    EXPECT_EQ(outcome.status, 4);
    EXPECT_THAT(outcome.err, HasSubstr("voxcone capture"));
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1);
}

TEST(ViewProgram, AWrongSettingIsToldBeforeAWindowOpens) {
    const Outcome outcome = voxcone({"view", "--set", "cone.gian=2"}, "DISPLAY=");
    EXPECT_EQ(outcome.status, 2);
    EXPECT_THAT(outcome.err, HasSubstr("cone.gain"));
}

TEST(ViewProgram, KeysReachItAndItEnds) {
    const TemporaryFolder folder;
    const std::string out = folder.path().string();
    // Keys go to the window that has the focus; without a window manager that is the one below the pointer.
    const std::string keys =
        "(for i in $(seq 100); do sleep 0.2; xdotool search --sync --onlyvisible --name '^voxcone' >/dev/null && "
        "break; "
        "done; sleep 1; xdotool mousemove 200 200 click 1; xdotool key Tab; xdotool key p; "
        "for i in $(seq 100); do ls '" +
        out +
        "'/*.png >/dev/null 2>&1 && break; sleep 0.2; done; xdotool key ctrl+s; sleep 0.5; xdotool key ctrl+q) & ";
    const Outcome outcome = voxcone({"view", VOXCONE_SOURCE_DIR "/assets/scenes/cornell.gltf", "--out", out, "--set",
                                     "voxel.resolution=16", "--set", "light.bounces=0", "--set", "cone.diffuse=1",
                                     "--set", "cone.near_field=0", "--set", "specular.enabled=false"},
                                    keys + "HOME='" + out + "' XDG_CONFIG_HOME= timeout 60");
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    const fs::path png = folder.path() / "cornell_beauty_001.png";
    ASSERT_TRUE(fs::exists(png)) << outcome.err;
    const Image image = readImage(png);
    EXPECT_GT(*std::max_element(image.data.begin(), image.data.end()), 0.1f);
    EXPECT_TRUE(fs::exists(folder.path() / "cornell_001.json"));
    EXPECT_TRUE(fs::exists(folder.path() / ".config" / "voxcone" / "recent.json"));
}

}  // namespace
}  // namespace voxcone
