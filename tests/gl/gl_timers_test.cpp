#include <gmock/gmock.h>

#include <chrono>
#include <thread>

#include "gl/pass_timers.h"
#include "support/gl_context.h"

namespace voxcone {
namespace {

using gl::PassTimers;
using gl::TimerMode;
using test::GlTest;

void sleepMilliseconds(int ms) {
    std::this_thread::sleep_for(std::chrono::milliseconds(ms));
}

TEST_F(GlTest, FinishTimersAddUpToTheFrame) {
    PassTimers timers(TimerMode::finish);
    timers.beginFrame();
    for (const char* name : {"one", "two", "one"}) {
        const auto scope = timers.pass(name);
        sleepMilliseconds(10);
    }
    timers.endFrame();
    ASSERT_EQ(timers.results().size(), 2u);
    EXPECT_EQ(timers.results()[0].name, "one");
    EXPECT_EQ(timers.results()[1].name, "two");
    EXPECT_GE(timers.results()[0].milliseconds, 20);
    EXPECT_GE(timers.results()[1].milliseconds, 10);
    const double sum = timers.results()[0].milliseconds + timers.results()[1].milliseconds;
    EXPECT_LE(sum, timers.frameMilliseconds());
    EXPECT_LE(timers.frameMilliseconds() - sum, 0.05 * timers.frameMilliseconds() + 0.5);
}

TEST_F(GlTest, QueryTimersArriveInOrder) {
    PassTimers timers(TimerMode::query);
    for (int frame = 0; frame < 3; ++frame) {
        timers.beginFrame();
        { const auto scope = timers.pass("draw"); }
        { const auto scope = timers.pass("resolve"); }
        timers.endFrame();
    }
    timers.wait();
    ASSERT_EQ(timers.results().size(), 2u);
    EXPECT_EQ(timers.results()[0].name, "draw");
    EXPECT_GE(timers.frameMilliseconds(), 0);
}

TEST_F(GlTest, APassOutsideAFrameIsNotTimed) {
    PassTimers timers(TimerMode::finish);
    { const auto scope = timers.pass("alone"); }
    EXPECT_TRUE(timers.results().empty());
}

TEST_F(GlTest, SoftwareRasterisersAreTimedWithFinish) {
    gl::DeviceInfo info;
    info.softwareRasterizer = true;
    EXPECT_EQ(gl::suitableTimerMode(info), TimerMode::finish);
    info.softwareRasterizer = false;
    EXPECT_EQ(gl::suitableTimerMode(info), TimerMode::query);
}

}  // namespace
}  // namespace voxcone
