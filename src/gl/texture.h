// Textures with immutable storage, and samplers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "gl/handle.h"

namespace voxcone::gl {

/// Texture with immutable storage. Default state: nearest filtering without mips for one level, else
/// LINEAR_MIPMAP_LINEAR / LINEAR; clamped to the edge. Contents are undefined until written or cleared.
/// An empty (default-constructed or moved-from) texture has id 0.
class Texture {
  public:
    Texture() = default;
    /// `format` is a sized internal format (GL_RGBA16F, GL_R32UI, …). Sizes in texels. Throws DeviceError that names
    /// the limit when a size is beyond the device's or when memory runs out.
    static Texture create2D(GLenum format, int width, int height, int levels = 1);
    static Texture create3D(GLenum format, int width, int height, int depth, int levels = 1);
    static Texture create2DArray(GLenum format, int width, int height, int layers, int levels = 1);
    static Texture createCube(GLenum format, int size, int levels = 1);

    explicit operator bool() const { return static_cast<bool>(handle_); }
    GLuint id() const { return handle_.id(); }
    GLenum target() const { return target_; }
    GLenum format() const { return format_; }
    int width(int level = 0) const;
    int height(int level = 0) const;
    int depth(int level = 0) const;  ///< 3D: depth of the level; arrays: layers; cubes: 6; 2D: 1
    int levels() const { return levels_; }
    std::size_t bytes() const;  ///< memory of all levels

    void filter(GLenum min, GLenum mag);
    void wrap(GLenum s, GLenum t, GLenum r = GL_CLAMP_TO_EDGE);
    void wrap(GLenum all) { wrap(all, all, all); }
    void border(float r, float g, float b, float a);  ///< colour outside for GL_CLAMP_TO_BORDER
    void compare(GLenum function);                    ///< depth formats: sampler*Shadow look-ups with e.g. GL_LEQUAL
    void maxAnisotropy(float value);                  ///< ignored where the device has no anisotropic filtering
    void generateMipmaps();

    /// Binds for sampling at texture unit `unit` (layout(binding = unit) in the shader).
    void bindTo(int unit) const;
    /// Binds `level` as image `unit`. `access` is GL_READ_ONLY, GL_WRITE_ONLY or GL_READ_WRITE; `viewFormat` 0 means
    /// the texture's own (GL_R32UI reads the bits of RGBA8 or RGB9_E5). `layered` binds all slices, else slice `layer`.
    void bindImage(int unit, int level, GLenum access, GLenum viewFormat = 0, bool layered = true, int layer = 0) const;

    /// Replaces a whole level (all slices); `data` is tightly packed in `dataFormat`/`dataType`.
    void upload(int level, GLenum dataFormat, GLenum dataType, const void* data);
    /// Replaces a 2D texture's or one layer's (or face's) level.
    void uploadLayer(int level, int layer, GLenum dataFormat, GLenum dataType, const void* data);
    /// Sets every texel of a level to zero.
    void clear(int level = 0);
    /// Sets every texel of a level to the value of one texel in `dataFormat`/`dataType`.
    void clear(int level, GLenum dataFormat, GLenum dataType, const void* texel);
    void clearAll();  ///< zero in all levels

    /// Reads a whole level back: row 0 first (texel y = 0), slices in order, `components()` values a texel (depth: 1).
    std::vector<float> readFloats(int level = 0) const;
    /// The same for integer formats.
    std::vector<std::uint32_t> readUints(int level = 0) const;
    /// Channels of the format.
    int components() const;

  private:
    static Texture create(GLenum target, GLenum format, int width, int height, int depth, int levels);
    void read(int level, GLenum dataFormat, GLenum dataType, void* data, std::size_t sliceBytes) const;
    void bindScratch() const;

    struct Delete {
        void operator()(GLuint id) const { glDeleteTextures(1, &id); }
    };
    Handle<Delete> handle_;
    GLenum target_ = 0, format_ = 0;
    int width_ = 0, height_ = 0, depth_ = 0, levels_ = 0;
};

/// Number of levels of a full mip chain.
int fullMipLevels(int width, int height = 1, int depth = 1);

/// Sampler object: overrides a texture's own filter and wrap at one unit.
class Sampler {
  public:
    Sampler() = default;
    Sampler(GLenum min, GLenum mag, GLenum wrapS, GLenum wrapT, GLenum wrapR = GL_CLAMP_TO_EDGE);

    void bindTo(int unit) const;
    static void unbind(int unit);  ///< back to the texture's own state
    GLuint id() const { return handle_.id(); }
    void maxAnisotropy(float value);

  private:
    struct Delete {
        void operator()(GLuint id) const { glDeleteSamplers(1, &id); }
    };
    Handle<Delete> handle_;
};

}  // namespace voxcone::gl
