#include <gmock/gmock.h>

#include <numeric>

#include "core/error.h"
#include "gl/buffer.h"
#include "gl/framebuffer.h"
#include "gl/program.h"
#include "gl/shader_library.h"
#include "gl/texture.h"
#include "support/gl_context.h"

namespace voxcone {
namespace {

using gl::Buffer;
using gl::Framebuffer;
using gl::ShaderLibrary;
using gl::Texture;
using test::GlTest;
using testing::Each;

TEST_F(GlTest, BufferRoundTripUploadAndClear) {
    std::vector<std::uint32_t> values(1000);
    std::iota(values.begin(), values.end(), 7u);
    Buffer buffer = Buffer::of(values);
    EXPECT_EQ(buffer.bytes(), 4000u);
    EXPECT_EQ(buffer.read<std::uint32_t>(), values);
    EXPECT_EQ(buffer.read<std::uint32_t>(10, 2), (std::vector<std::uint32_t>{17, 18}));
    const std::uint32_t word = 99;
    buffer.upload(&word, sizeof(word), 8);
    EXPECT_EQ(buffer.read<std::uint32_t>(2, 1).front(), 99u);
    buffer.clear(5);
    EXPECT_THAT(buffer.read<std::uint32_t>(), Each(5u));
}

TEST_F(GlTest, MovedFromObjectsAreEmpty) {
    Texture a = Texture::create2D(GL_RGBA8, 4, 4);
    const GLuint id = a.id();
    Texture b = std::move(a);
    EXPECT_EQ(a.id(), 0u);  // NOLINT(bugprone-use-after-move): what is tested
    EXPECT_EQ(b.id(), id);
    b = Texture::create2D(GL_RGBA8, 2, 2);
    EXPECT_EQ(glIsTexture(id), id == b.id() ? GL_TRUE : GL_FALSE);
}

TEST_F(GlTest, Texture2DRoundTripAndSizes) {
    Texture texture = Texture::create2D(GL_RGBA32F, 5, 3, gl::fullMipLevels(5, 3));
    EXPECT_EQ(texture.levels(), 3);
    EXPECT_EQ(texture.width(1), 2);
    EXPECT_EQ(texture.height(2), 1);
    EXPECT_EQ(texture.bytes(), (15u + 2 + 1) * 16);
    std::vector<float> values(5 * 3 * 4);
    std::iota(values.begin(), values.end(), -10.0f);
    texture.upload(0, GL_RGBA, GL_FLOAT, values.data());
    EXPECT_EQ(texture.readFloats(), values);
}

TEST_F(GlTest, Texture3DRoundTripAndClear) {
    Texture texture = Texture::create3D(GL_R32UI, 4, 3, 2, 2);
    EXPECT_EQ(texture.depth(1), 1);
    std::vector<std::uint32_t> values(24);
    std::iota(values.begin(), values.end(), 100u);
    texture.upload(0, GL_RED_INTEGER, GL_UNSIGNED_INT, values.data());
    EXPECT_EQ(texture.readUints(), values);
    texture.clearAll();
    EXPECT_THAT(texture.readUints(0), Each(0u));
    EXPECT_THAT(texture.readUints(1), Each(0u));
}

TEST_F(GlTest, ArrayLayersAndCubeFacesAreApart) {
    Texture array = Texture::create2DArray(GL_R32F, 2, 2, 3);
    Texture cube = Texture::createCube(GL_R32F, 2);
    std::vector<float> expectedArray, expectedCube;
    for (int layer = 0; layer < 6; ++layer) {
        const std::vector<float> face(4, static_cast<float>(layer));
        if (layer < 3) {
            array.uploadLayer(0, layer, GL_RED, GL_FLOAT, face.data());
            expectedArray.insert(expectedArray.end(), face.begin(), face.end());
        }
        cube.uploadLayer(0, layer, GL_RED, GL_FLOAT, face.data());
        expectedCube.insert(expectedCube.end(), face.begin(), face.end());
    }
    EXPECT_EQ(array.readFloats(), expectedArray);
    EXPECT_EQ(cube.readFloats(), expectedCube);
}

TEST_F(GlTest, ClearSetsTheGivenTexel) {
    Texture texture = Texture::create2D(GL_RGBA8, 7, 7);
    const std::uint8_t texel[4] = {51, 102, 153, 255};
    texture.clear(0, GL_RGBA, GL_UNSIGNED_BYTE, texel);
    const std::vector<float> values = texture.readFloats();
    EXPECT_FLOAT_EQ(values[4 * 48], 0.2f);
    EXPECT_FLOAT_EQ(values[4 * 48 + 3], 1.0f);
}

TEST_F(GlTest, TooLargeATextureIsADeviceErrorThatNamesTheLimit) {
    try {
        Texture::create3D(GL_R8, 1 << 20, 1, 1);
        FAIL() << "no error";
    } catch (const DeviceError& error) {
        EXPECT_THAT(error.what(), testing::HasSubstr("GL_MAX_3D_TEXTURE_SIZE"));
    }
}

TEST_F(GlTest, FramebufferClearsLevelsAndLayers) {
    Texture color = Texture::create2DArray(GL_RGBA32F, 4, 4, 2, 2);
    Texture depth = Texture::create2DArray(GL_DEPTH_COMPONENT32F, 4, 4, 2);
    for (int layer = 0; layer < 2; ++layer) {
        Framebuffer framebuffer;
        framebuffer.attachColorLayer(0, color, layer);
        framebuffer.attachDepthLayer(depth, layer);
        framebuffer.clearColor(0, glm::vec4(static_cast<float>(layer + 1)));
        framebuffer.clearDepth(0.25f * static_cast<float>(layer + 1));
    }
    const std::vector<float> values = color.readFloats(), depths = depth.readFloats();
    EXPECT_EQ(values.front(), 1.0f);
    EXPECT_EQ(values.back(), 2.0f);
    EXPECT_EQ(depths.front(), 0.25f);
    EXPECT_EQ(depths.back(), 0.5f);
}

TEST_F(GlTest, UniformsOfEveryTypeArrive) {
    const std::string source = R"(
layout(local_size_x = 1) in;
uniform int u_int; uniform uint u_uint; uniform float u_float; uniform bool u_bool;
uniform vec2 u_vec2; uniform vec3 u_vec3; uniform vec4 u_vec4; uniform ivec3 u_ivec3; uniform uvec4 u_uvec4;
uniform mat3 u_mat3; uniform mat4 u_mat4; uniform float u_floats[3]; uniform vec3 u_vec3s[2];
layout(std430, binding = 2) writeonly buffer Out { float b_out[]; };
void main() {
    b_out[0] = float(u_int); b_out[1] = float(u_uint); b_out[2] = u_float; b_out[3] = u_bool ? 1.0 : 0.0;
    b_out[4] = u_vec2.y; b_out[5] = u_vec3.z; b_out[6] = u_vec4.w; b_out[7] = float(u_ivec3.z); b_out[8] = float(u_uvec4.w);
    b_out[9] = u_mat3[2][0]; b_out[10] = u_mat4[3][1]; b_out[11] = u_floats[2]; b_out[12] = u_vec3s[1].y;
})";
    gl::Program program = ShaderLibrary().computeFromText("uniforms.comp", source);
    program.set("u_int", -3);
    program.set("u_uint", 4u);
    program.set("u_float", 0.5f);
    program.set("u_bool", true);
    program.set("u_vec2", glm::vec2(1, 2));
    program.set("u_vec3", glm::vec3(1, 2, 3));
    program.set("u_vec4", glm::vec4(1, 2, 3, 4));
    program.set("u_ivec3", glm::ivec3(-1, -2, -3));
    program.set("u_uvec4", glm::uvec4(5, 6, 7, 8));
    glm::mat3 m3(1);
    m3[2][0] = 9;
    program.set("u_mat3", m3);
    glm::mat4 m4(1);
    m4[3][1] = 10;
    program.set("u_mat4", m4);
    program.set("u_floats", std::span<const float>(std::vector<float>{1, 2, 11}));
    program.set("u_vec3s", std::span<const glm::vec3>(std::vector<glm::vec3>{glm::vec3(0), glm::vec3(12)}));
    program.set("u_not_there", 1);
    EXPECT_FALSE(program.has("u_not_there"));

    Buffer out(13 * sizeof(float));
    out.bindBase(GL_SHADER_STORAGE_BUFFER, 2);
    gl::dispatch(program, 1, 1, 1);
    EXPECT_EQ(out.read<float>(), (std::vector<float>{-3, 4, .5f, 1, 2, 3, 4, -3, 8, 9, 10, 11, 12}));
}

TEST_F(GlTest, ImagesAreWrittenThroughAnotherView) {
    const std::string source = R"(
layout(local_size_x = 4, local_size_y = 4) in;
layout(r32ui, binding = 1) uniform writeonly uimage2D u_image;
void main() { imageStore(u_image, ivec2(gl_GlobalInvocationID.xy), uvec4(0xff00cc33u)); })";
    const gl::Program program = ShaderLibrary().computeFromText("view.comp", source);
    Texture texture = Texture::create2D(GL_RGBA8, 4, 4);
    texture.bindImage(1, 0, GL_WRITE_ONLY, GL_R32UI);
    gl::dispatch(program, 1, 1, 1);
    const std::vector<float> values = texture.readFloats();
    EXPECT_FLOAT_EQ(values[60], 0.2f);
    EXPECT_FLOAT_EQ(values[61], 0.8f);
    EXPECT_FLOAT_EQ(values[62], 0.0f);
    EXPECT_FLOAT_EQ(values[63], 1.0f);
}

TEST_F(GlTest, DispatchOfNothingDoesNothingAndTooMuchIsADeviceError) {
    const gl::Program program =
        ShaderLibrary().computeFromText("empty.comp", "layout(local_size_x = 1) in; void main() {}");
    EXPECT_NO_THROW(gl::dispatch(program, 0, 4, 4));
    GLint max = 0;
    glGetIntegeri_v(GL_MAX_COMPUTE_WORK_GROUP_COUNT, 1, &max);
    if (max < 0x7fffffff) {
        EXPECT_THROW(gl::dispatch(program, 1, max + 1, 1), DeviceError);
    }
}

TEST_F(GlTest, AFramebufferWithoutAttachmentsRunsFragments) {
    const Framebuffer framebuffer = Framebuffer::withoutAttachments(16, 8);
    framebuffer.bind();
    GLint viewport[4] = {};
    glGetIntegerv(GL_VIEWPORT, viewport);
    EXPECT_EQ(viewport[2], 16);
    EXPECT_EQ(viewport[3], 8);
}

TEST_F(GlTest, ASamplerOverridesTheTexture) {
    Texture texture = Texture::create2D(GL_R32F, 2, 1);
    const float values[2] = {0, 1};
    texture.upload(0, GL_RED, GL_FLOAT, values);
    const std::string source = R"(
layout(local_size_x = 1) in;
layout(binding = 5) uniform sampler2D u_texture;
layout(std430, binding = 2) writeonly buffer Out { float b_out[]; };
void main() { b_out[0] = textureLod(u_texture, vec2(0.4, 0.5), 0.0).r; })";
    const gl::Program program = ShaderLibrary().computeFromText("sampler.comp", source);
    Buffer out(sizeof(float));
    out.bindBase(GL_SHADER_STORAGE_BUFFER, 2);
    texture.bindTo(5);
    gl::dispatch(program, 1, 1, 1);
    EXPECT_EQ(out.read<float>()[0], 0.0f);
    const gl::Sampler linear(GL_LINEAR, GL_LINEAR, GL_CLAMP_TO_EDGE, GL_CLAMP_TO_EDGE);
    linear.bindTo(5);
    gl::dispatch(program, 1, 1, 1);
    EXPECT_NEAR(out.read<float>()[0], 0.3f, 1e-2f);
    gl::Sampler::unbind(5);
}

}  // namespace
}  // namespace voxcone
