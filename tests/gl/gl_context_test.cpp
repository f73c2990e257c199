#include <epoxy/gl.h>
#include <gmock/gmock.h>

#include "support/gl_context.h"

namespace voxcone {
namespace {

using test::GlTest;

TEST_F(GlTest, InfoHasWhatOpenGl43Guarantees) {
    const gl::DeviceInfo& info = test::glContext().info();
    EXPECT_FALSE(info.renderer.empty());
    EXPECT_THAT(info.platform, testing::HasSubstr("EGL"));
    EXPECT_GE(info.max2DTextureSize, 16384);
    EXPECT_GE(info.max3DTextureSize, 2048);
    EXPECT_GE(info.maxSsboBytes, std::int64_t{1} << 24);
    EXPECT_GE(info.maxImageUniforms, 8);
    EXPECT_GE(info.maxTextureUnits, 16);
    EXPECT_GE(info.maxComputeInvocations, 1024);
    EXPECT_EQ(info.softwareRasterizer, info.renderer.find("llvmpipe") != std::string::npos);
}

TEST_F(GlTest, HighSeverityIsCaughtOnce) {
    glBindTexture(GL_TEXTURE_2D, 0);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, 0x1234);
    EXPECT_THROW(test::glContext().checkErrors(), gl::GlError);
    EXPECT_NO_THROW(test::glContext().checkErrors());
}

TEST_F(GlTest, ASecondContextWorksBesideTheFirst) {
    {
        const auto second = gl::Context::createHeadless(false);
        EXPECT_EQ(second->info().renderer, test::glContext().info().renderer);
    }
    test::glContext().makeCurrent();
    GLint major = 0;
    glGetIntegerv(GL_MAJOR_VERSION, &major);
    EXPECT_EQ(major, 4);
}

}  // namespace
}  // namespace voxcone
