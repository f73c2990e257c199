#include <gmock/gmock.h>

#include <filesystem>

#include "core/atomic_file.h"
#include "gl/buffer.h"
#include "gl/shader_library.h"
#include "support/gl_context.h"

namespace voxcone {
namespace {

using gl::Defines;
using gl::ShaderError;
using gl::ShaderLibrary;
using test::GlTest;
using testing::HasSubstr;
using testing::StartsWith;

/// A folder of shaders that goes away with the test.
class ShaderFolder {
  public:
    ShaderFolder()
        : path_(std::filesystem::path(testing::TempDir()) /
                ("voxcone_shaders_" + std::string(testing::UnitTest::GetInstance()->current_test_info()->name()))) {
        std::filesystem::remove_all(path_);
    }
    ~ShaderFolder() { std::filesystem::remove_all(path_); }
    ShaderFolder(const ShaderFolder&) = delete;
    ShaderFolder& operator=(const ShaderFolder&) = delete;
    void write(const std::string& name, const std::string& text) const { writeTextFile(path_ / name, text); }
    const std::filesystem::path& path() const { return path_; }

  private:
    std::filesystem::path path_;
};

std::string errorOf(const ShaderLibrary& library, const std::string& path) {
    try {
        library.compute(path);
    } catch (const ShaderError& error) {
        return error.what();
    }
    return "no error";
}

TEST_F(GlTest, ACompileErrorNamesFileAndLine) {
    const ShaderFolder folder;
    folder.write("a/bad.comp",
                 "layout(local_size_x = 1) in;\n#include \"a/good.glsl\"\nvoid main() {\n    x = 1;\n}\n");
    folder.write("a/good.glsl", "// one\n// two\nfloat twice(float v) { return 2.0 * v; }\n");
    EXPECT_THAT(errorOf(ShaderLibrary(folder.path()), "a/bad.comp"), StartsWith("shaders/a/bad.comp:4: "));
}

TEST_F(GlTest, ACompileErrorInAnIncludeNamesTheInclude) {
    const ShaderFolder folder;
    folder.write("a/main.comp", "layout(local_size_x = 1) in;\n\n#include \"a/bad.glsl\"\nvoid main() {}\n");
    folder.write("a/bad.glsl", "// one\nfloat f() { return nothing; }\n");
    EXPECT_THAT(errorOf(ShaderLibrary(folder.path()), "a/main.comp"), StartsWith("shaders/a/bad.glsl:2: "));
}

TEST_F(GlTest, AMissingIncludeNamesWhereItIsAskedFor) {
    const ShaderFolder folder;
    folder.write("a/main.comp", "\n#include \"a/none.glsl\"\n");
    const ShaderLibrary library(folder.path());
    EXPECT_EQ(errorOf(library, "a/main.comp"), "shaders/a/main.comp:2: no such include: shaders/a/none.glsl");
    EXPECT_EQ(errorOf(library, "none.comp"), "shaders/none.comp: no such shader");
}

TEST_F(GlTest, EachIncludeIsTakenOnceAndDefinesComeFirst) {
    const ShaderFolder folder;
    folder.write(
        "main.comp",
        "layout(local_size_x = 1) in;\n#include \"b.glsl\"\n  #include \"a.glsl\" // again\n"
        "layout(std430, binding = 2) buffer Out { int b_out[]; };\nvoid main() { b_out[0] = a() + b() + N; }\n");
    folder.write("a.glsl", "int a() { return N; }\n");
    folder.write("b.glsl", "#include \"a.glsl\"\nint b() { return 10 * a(); }\n");
    const gl::Program program = ShaderLibrary(folder.path()).compute("main.comp", Defines{{"N", "3"}});
    const gl::Buffer out(4);
    out.bindBase(GL_SHADER_STORAGE_BUFFER, 2);
    gl::dispatch(program, 1, 1, 1);
    EXPECT_EQ(out.read<int>()[0], 36);
}

TEST_F(GlTest, ALinkErrorNamesTheProgram) {
    const ShaderFolder folder;
    folder.write("x.vert", "out vec3 v_a; void main() { v_a = vec3(1); gl_Position = vec4(0); }\n");
    folder.write("x.frag", "in vec2 v_a; out vec4 o; void main() { o = v_a.xyxy; }\n");
    EXPECT_THROW(ShaderLibrary(folder.path()).graphics({"x.vert", "x.frag"}), ShaderError);
}

TEST(ShaderLog, LinesOfEveryDriverAreMapped) {
    const std::vector<gl::SourceLine> lines = {
        {"a.comp", 0}, {"a.comp", 1}, {"shared/brdf.glsl", 1}, {"shared/brdf.glsl", 2}, {"a.comp", 3}};
    EXPECT_EQ(gl::mapShaderLog("0:5(5): error: `x' undeclared\n", lines), "shaders/a.comp:3: error: `x' undeclared");
    EXPECT_EQ(gl::mapShaderLog("0(4) : error C1008: undefined variable\n", lines),
              "shaders/shared/brdf.glsl:2: error C1008: undefined variable");
    EXPECT_EQ(gl::mapShaderLog("ERROR: 0:3: 'x' : undeclared identifier\nsomething else", lines),
              "shaders/shared/brdf.glsl:1: 'x' : undeclared identifier\nsomething else");
    EXPECT_EQ(gl::mapShaderLog("0:77(5): error: beyond", lines), "0:77(5): error: beyond");
}

}  // namespace
}  // namespace voxcone
