// Framebuffers, vertex arrays and the fixed-function state of a draw.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "gl/buffer.h"
#include "gl/handle.h"
#include "gl/texture.h"

namespace voxcone::gl {

/// Where a draw writes. Attached textures must outlive it.
class Framebuffer {
  public:
    Framebuffer();
    /// No attachments: fragments run over `width`×`height` and write through images only.
    static Framebuffer withoutAttachments(int width, int height, int layers = 0);

    /// Whole level: for layered textures gl_Layer chooses the slice.
    void attachColor(int index, const Texture& texture, int level = 0);
    void attachDepth(const Texture& texture, int level = 0);
    /// One slice, layer or cube face.
    void attachColorLayer(int index, const Texture& texture, int layer, int level = 0);
    void attachDepthLayer(const Texture& texture, int layer, int level = 0);

    /// Makes it the draw framebuffer, checks completeness (a bug of ours otherwise), sets the draw buffers and the
    /// viewport to its whole size.
    void bind() const;
    /// Restricts drawing to a part of it, after bind(); texels from the lower left.
    static void viewport(int x, int y, int width, int height) { glViewport(x, y, width, height); }
    void clearColor(int index, const glm::vec4& value) const;  ///< binds
    void clearColorUint(int index, const glm::uvec4& value) const;
    void clearDepth(float value) const;

    int width() const { return width_; }
    int height() const { return height_; }

  private:
    void attach(GLenum attachment, const Texture& texture, int level, int layer);

    struct Delete {
        void operator()(GLuint id) const { glDeleteFramebuffers(1, &id); }
    };
    Handle<Delete> handle_;
    int width_ = 0, height_ = 0, colors_ = 0;
};

/// Draws into the window's own framebuffer from now on, of `width`×`height` pixels, and fills it with one colour.
void beginWindow(int width, int height, const glm::vec3& color);

/// What was drawn into the window's framebuffer and is not shown yet: RGB, 8 bits each, row 0 at the bottom.
std::vector<std::uint8_t> readWindow(int width, int height);

/// Where vertices come from. Buffers must outlive it.
class VertexArray {
  public:
    VertexArray();
    /// Float attribute of `components` values of `type` (normalised integers when `normalized`); `stride` in bytes.
    void attribute(int location, const Buffer& buffer, int components, GLenum type, std::size_t stride,
                   std::size_t offset, bool normalized = false, int divisor = 0);
    /// uint or int attribute.
    void integerAttribute(int location, const Buffer& buffer, int components, GLenum type, std::size_t stride,
                          std::size_t offset, int divisor = 0);
    void indexBuffer(const Buffer& buffer);
    void bind() const;

  private:
    struct Delete {
        void operator()(GLuint id) const { glDeleteVertexArrays(1, &id); }
    };
    Handle<Delete> handle_;
};

/// All fixed-function state that our passes vary. `apply` sets every bit of it, so that nothing leaks between passes.
struct DrawState {
    bool depthTest = false;
    GLenum depthFunction = GL_LESS;
    bool depthWrite = false;
    bool colorWrite = true;
    bool cullBack = false;
    bool polygonOffset = false;
    float polygonOffsetFactor = 0, polygonOffsetUnits = 0;
    bool depthClamp = false;
    int clipDistances = 0;  ///< how many gl_ClipDistance are in force, at most 8

    void apply() const;
};

}  // namespace voxcone::gl
