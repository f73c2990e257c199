// One headless debug context for all tests of a program, and the fixture that fails a test on any error the driver
// reports.
#pragma once

#include <gtest/gtest.h>

#include <memory>

#include "gl/context.h"

namespace voxcone::test {

inline gl::Context& glContext() {
    static const std::unique_ptr<gl::Context> context = gl::Context::createHeadless(true);
    return *context;
}

class GlTest : public ::testing::Test {
  protected:
    void SetUp() override { glContext().makeCurrent(); }
    void TearDown() override { EXPECT_NO_THROW(glContext().checkErrors()); }
};

}  // namespace voxcone::test
