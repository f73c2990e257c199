#include "gl/framebuffer.h"

#include <algorithm>
#include <vector>

#include "core/check.h"

namespace voxcone::gl {

Framebuffer::Framebuffer() {
    GLuint id = 0;
    glGenFramebuffers(1, &id);
    handle_ = Handle<Delete>(id);
}

Framebuffer Framebuffer::withoutAttachments(int width, int height, int layers) {
    Framebuffer framebuffer;
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, framebuffer.handle_.id());
    glFramebufferParameteri(GL_DRAW_FRAMEBUFFER, GL_FRAMEBUFFER_DEFAULT_WIDTH, width);
    glFramebufferParameteri(GL_DRAW_FRAMEBUFFER, GL_FRAMEBUFFER_DEFAULT_HEIGHT, height);
    glFramebufferParameteri(GL_DRAW_FRAMEBUFFER, GL_FRAMEBUFFER_DEFAULT_LAYERS, layers);
    framebuffer.width_ = width;
    framebuffer.height_ = height;
    return framebuffer;
}

void Framebuffer::attach(GLenum attachment, const Texture& texture, int level, int layer) {
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, handle_.id());
    if (layer < 0) {
        glFramebufferTexture(GL_DRAW_FRAMEBUFFER, attachment, texture.id(), level);
    } else if (texture.target() == GL_TEXTURE_CUBE_MAP) {
        glFramebufferTexture2D(GL_DRAW_FRAMEBUFFER, attachment,
                               GL_TEXTURE_CUBE_MAP_POSITIVE_X + static_cast<GLenum>(layer), texture.id(), level);
    } else {
        glFramebufferTextureLayer(GL_DRAW_FRAMEBUFFER, attachment, texture.id(), level, layer);
    }
    width_ = texture.width(level);
    height_ = texture.height(level);
}

void Framebuffer::attachColor(int index, const Texture& texture, int level) {
    attach(GL_COLOR_ATTACHMENT0 + static_cast<GLenum>(index), texture, level, -1);
    colors_ = std::max(colors_, index + 1);
}

void Framebuffer::attachColorLayer(int index, const Texture& texture, int layer, int level) {
    attach(GL_COLOR_ATTACHMENT0 + static_cast<GLenum>(index), texture, level, layer);
    colors_ = std::max(colors_, index + 1);
}

void Framebuffer::attachDepth(const Texture& texture, int level) {
    attach(GL_DEPTH_ATTACHMENT, texture, level, -1);
}

void Framebuffer::attachDepthLayer(const Texture& texture, int layer, int level) {
    attach(GL_DEPTH_ATTACHMENT, texture, level, layer);
}

void Framebuffer::bind() const {
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, handle_.id());
    std::vector<GLenum> buffers;
    for (int i = 0; i < colors_; ++i) buffers.push_back(GL_COLOR_ATTACHMENT0 + static_cast<GLenum>(i));
    if (buffers.empty()) buffers.push_back(GL_NONE);
    glDrawBuffers(static_cast<GLsizei>(buffers.size()), buffers.data());
    const GLenum status = glCheckFramebufferStatus(GL_DRAW_FRAMEBUFFER);
    VOXCONE_CHECK(status == GL_FRAMEBUFFER_COMPLETE, "framebuffer status 0x{:04x}", status);
    glViewport(0, 0, width_, height_);
}

void Framebuffer::clearColor(int index, const glm::vec4& value) const {
    bind();
    glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    glClearBufferfv(GL_COLOR, index, &value.x);
}

void Framebuffer::clearColorUint(int index, const glm::uvec4& value) const {
    bind();
    glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    glClearBufferuiv(GL_COLOR, index, &value.x);
}

void Framebuffer::clearDepth(float value) const {
    bind();
    glDepthMask(GL_TRUE);
    glClearBufferfv(GL_DEPTH, 0, &value);
}

void beginWindow(int width, int height, const glm::vec3& color) {
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
    glViewport(0, 0, width, height);
    glClearColor(color.r, color.g, color.b, 1);
    glClear(GL_COLOR_BUFFER_BIT);
}

std::vector<std::uint8_t> readWindow(int width, int height) {
    std::vector<std::uint8_t> bytes(3 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    glReadBuffer(GL_BACK);
    glReadPixels(0, 0, width, height, GL_RGB, GL_UNSIGNED_BYTE, bytes.data());
    return bytes;
}

VertexArray::VertexArray() {
    GLuint id = 0;
    glGenVertexArrays(1, &id);
    handle_ = Handle<Delete>(id);
}

void VertexArray::attribute(int location, const Buffer& buffer, int components, GLenum type, std::size_t stride,
                            std::size_t offset, bool normalized, int divisor) {
    glBindVertexArray(handle_.id());
    glBindBuffer(GL_ARRAY_BUFFER, buffer.id());
    const auto index = static_cast<GLuint>(location);
    glEnableVertexAttribArray(index);
    glVertexAttribPointer(index, components, type, normalized ? GL_TRUE : GL_FALSE, static_cast<GLsizei>(stride),
                          reinterpret_cast<const void*>(offset));
    glVertexAttribDivisor(index, static_cast<GLuint>(divisor));
}

void VertexArray::integerAttribute(int location, const Buffer& buffer, int components, GLenum type, std::size_t stride,
                                   std::size_t offset, int divisor) {
    glBindVertexArray(handle_.id());
    glBindBuffer(GL_ARRAY_BUFFER, buffer.id());
    const auto index = static_cast<GLuint>(location);
    glEnableVertexAttribArray(index);
    glVertexAttribIPointer(index, components, type, static_cast<GLsizei>(stride),
                           reinterpret_cast<const void*>(offset));
    glVertexAttribDivisor(index, static_cast<GLuint>(divisor));
}

void VertexArray::indexBuffer(const Buffer& buffer) {
    glBindVertexArray(handle_.id());
    glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, buffer.id());
}

void VertexArray::bind() const {
    glBindVertexArray(handle_.id());
}

void DrawState::apply() const {
    const auto set = [](GLenum capability, bool on) { on ? glEnable(capability) : glDisable(capability); };
    const auto flag = [](bool on) { return static_cast<GLboolean>(on ? GL_TRUE : GL_FALSE); };
    set(GL_DEPTH_TEST, depthTest || depthWrite);
    // Depth is written only where the depth test is on, so that a write without a test is a test that always passes.
    glDepthFunc(depthTest ? depthFunction : GL_ALWAYS);
    glDepthMask(flag(depthWrite));
    glColorMask(flag(colorWrite), flag(colorWrite), flag(colorWrite), flag(colorWrite));
    set(GL_CULL_FACE, cullBack);
    glCullFace(GL_BACK);
    glFrontFace(GL_CCW);
    set(GL_POLYGON_OFFSET_FILL, polygonOffset);
    glPolygonOffset(polygonOffsetFactor, polygonOffsetUnits);
    set(GL_DEPTH_CLAMP, depthClamp);
    for (int i = 0; i < 8; ++i) set(GL_CLIP_DISTANCE0 + static_cast<GLenum>(i), i < clipDistances);
    glDisable(GL_BLEND);
    glDisable(GL_SCISSOR_TEST);
    glDisable(GL_STENCIL_TEST);
}

}  // namespace voxcone::gl
