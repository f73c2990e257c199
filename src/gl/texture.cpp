#include "gl/texture.h"

#include <algorithm>

#include "core/check.h"
#include "core/error.h"

namespace voxcone::gl {
namespace {

/// Texture unit that no pass uses: OpenGL 4.3 guarantees 96 units over all stages.
constexpr GLenum kScratchUnit = GL_TEXTURE0 + 95;

struct FormatFacts {
    int components;
    int bytes;          ///< of one texel
    GLenum dataFormat;  ///< of a transfer of all components
    bool integer;
};

FormatFacts facts(GLenum format) {
    switch (format) {
        case GL_R8:
            return {1, 1, GL_RED, false};
        case GL_RG8:
            return {2, 2, GL_RG, false};
        case GL_RGBA8:
        case GL_SRGB8_ALPHA8:
        case GL_RGBA8_SNORM:
        case GL_RGB10_A2:
            return {4, 4, GL_RGBA, false};
        case GL_R16:
            return {1, 2, GL_RED, false};
        case GL_RG16:
        case GL_RG16_SNORM:
        case GL_RG16F:
            return {2, 4, GL_RG, false};
        case GL_RGBA16:
        case GL_RGBA16_SNORM:
        case GL_RGBA16F:
            return {4, 8, GL_RGBA, false};
        case GL_R16F:
            return {1, 2, GL_RED, false};
        case GL_R32F:
            return {1, 4, GL_RED, false};
        case GL_RG32F:
            return {2, 8, GL_RG, false};
        case GL_RGB32F:
            return {3, 12, GL_RGB, false};
        case GL_RGBA32F:
            return {4, 16, GL_RGBA, false};
        case GL_R11F_G11F_B10F:
        case GL_RGB9_E5:
            return {3, 4, GL_RGB, false};
        case GL_R8UI:
            return {1, 1, GL_RED_INTEGER, true};
        case GL_R16UI:
            return {1, 2, GL_RED_INTEGER, true};
        case GL_R32UI:
        case GL_R32I:
            return {1, 4, GL_RED_INTEGER, true};
        case GL_RG32UI:
            return {2, 8, GL_RG_INTEGER, true};
        case GL_RGBA8UI:
            return {4, 4, GL_RGBA_INTEGER, true};
        case GL_RGBA16UI:
            return {4, 8, GL_RGBA_INTEGER, true};
        case GL_RGBA32UI:
            return {4, 16, GL_RGBA_INTEGER, true};
        case GL_DEPTH_COMPONENT16:
            return {1, 2, GL_DEPTH_COMPONENT, false};
        case GL_DEPTH_COMPONENT24:
        case GL_DEPTH_COMPONENT32F:
            return {1, 4, GL_DEPTH_COMPONENT, false};
        default:
            VOXCONE_CHECK(false, "texture format 0x{:04x} is not in the table", format);
    }
    return {};
}

int limit(GLenum name) {
    GLint value = 0;
    glGetIntegerv(name, &value);
    return value;
}

void requireAtMost(int size, GLenum limitName, const char* text) {
    const int max = limit(limitName);
    if (size > max)
        throw DeviceError(fmt::format("a texture of size {} is beyond the device's {} = {}", size, text, max));
}

int mip(int size, int level) {
    return std::max(1, size >> level);
}

}  // namespace

int fullMipLevels(int width, int height, int depth) {
    int levels = 1;
    for (int size = std::max({width, height, depth}); size > 1; size >>= 1) ++levels;
    return levels;
}

Texture Texture::create(GLenum target, GLenum format, int width, int height, int depth, int levels) {
    VOXCONE_CHECK(width > 0 && height > 0 && depth > 0 && levels > 0, "{}×{}×{}, {} levels", width, height, depth,
                  levels);
    Texture texture;
    GLuint id = 0;
    glGenTextures(1, &id);
    texture.handle_ = Handle<Delete>(id);
    texture.target_ = target;
    texture.format_ = format;
    texture.width_ = width;
    texture.height_ = height;
    texture.depth_ = depth;
    texture.levels_ = levels;
    while (glGetError() != GL_NO_ERROR) {
        // Whatever came before is not of this allocation; the debug callback has it.
    }
    texture.bindScratch();
    if (target == GL_TEXTURE_3D || target == GL_TEXTURE_2D_ARRAY) {
        glTexStorage3D(target, levels, format, width, height, depth);
    } else {
        glTexStorage2D(target, levels, format, width, height);
    }
    if (const GLenum error = glGetError(); error != GL_NO_ERROR) {
        throw DeviceError(fmt::format(
            "the device cannot hold a texture of {}×{}×{} texels, {} MiB ({})", width, height, depth,
            texture.bytes() >> 20, error == GL_OUT_OF_MEMORY ? "out of memory" : fmt::format("error 0x{:04x}", error)));
    }
    if (levels == 1) {
        texture.filter(GL_NEAREST, GL_NEAREST);
    } else {
        texture.filter(GL_LINEAR_MIPMAP_LINEAR, GL_LINEAR);
    }
    texture.wrap(GL_CLAMP_TO_EDGE);
    return texture;
}

Texture Texture::create2D(GLenum format, int width, int height, int levels) {
    requireAtMost(std::max(width, height), GL_MAX_TEXTURE_SIZE, "GL_MAX_TEXTURE_SIZE");
    return create(GL_TEXTURE_2D, format, width, height, 1, levels);
}

Texture Texture::create3D(GLenum format, int width, int height, int depth, int levels) {
    requireAtMost(std::max({width, height, depth}), GL_MAX_3D_TEXTURE_SIZE, "GL_MAX_3D_TEXTURE_SIZE");
    return create(GL_TEXTURE_3D, format, width, height, depth, levels);
}

Texture Texture::create2DArray(GLenum format, int width, int height, int layers, int levels) {
    requireAtMost(std::max(width, height), GL_MAX_TEXTURE_SIZE, "GL_MAX_TEXTURE_SIZE");
    requireAtMost(layers, GL_MAX_ARRAY_TEXTURE_LAYERS, "GL_MAX_ARRAY_TEXTURE_LAYERS");
    return create(GL_TEXTURE_2D_ARRAY, format, width, height, layers, levels);
}

Texture Texture::createCube(GLenum format, int size, int levels) {
    requireAtMost(size, GL_MAX_CUBE_MAP_TEXTURE_SIZE, "GL_MAX_CUBE_MAP_TEXTURE_SIZE");
    return create(GL_TEXTURE_CUBE_MAP, format, size, size, 6, levels);
}

int Texture::width(int level) const {
    return mip(width_, level);
}
int Texture::height(int level) const {
    return mip(height_, level);
}
int Texture::depth(int level) const {
    return target_ == GL_TEXTURE_3D ? mip(depth_, level) : depth_;
}
int Texture::components() const {
    return facts(format_).components;
}

std::size_t Texture::bytes() const {
    std::size_t texels = 0;
    for (int level = 0; level < levels_; ++level) {
        texels += static_cast<std::size_t>(width(level)) * static_cast<std::size_t>(height(level)) *
                  static_cast<std::size_t>(depth(level));
    }
    return handle_ ? texels * static_cast<std::size_t>(facts(format_).bytes) : 0;
}

void Texture::bindScratch() const {
    glActiveTexture(kScratchUnit);
    glBindTexture(target_, handle_.id());
}

void Texture::filter(GLenum min, GLenum mag) {
    bindScratch();
    glTexParameteri(target_, GL_TEXTURE_MIN_FILTER, static_cast<GLint>(min));
    glTexParameteri(target_, GL_TEXTURE_MAG_FILTER, static_cast<GLint>(mag));
}

void Texture::wrap(GLenum s, GLenum t, GLenum r) {
    bindScratch();
    glTexParameteri(target_, GL_TEXTURE_WRAP_S, static_cast<GLint>(s));
    glTexParameteri(target_, GL_TEXTURE_WRAP_T, static_cast<GLint>(t));
    glTexParameteri(target_, GL_TEXTURE_WRAP_R, static_cast<GLint>(r));
}

void Texture::border(float r, float g, float b, float a) {
    bindScratch();
    const float color[4] = {r, g, b, a};
    glTexParameterfv(target_, GL_TEXTURE_BORDER_COLOR, color);
}

void Texture::compare(GLenum function) {
    bindScratch();
    glTexParameteri(target_, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
    glTexParameteri(target_, GL_TEXTURE_COMPARE_FUNC, static_cast<GLint>(function));
}

void Texture::maxAnisotropy(float value) {
    if (!epoxy_has_gl_extension("GL_EXT_texture_filter_anisotropic")) return;
    bindScratch();
    glTexParameterf(target_, GL_TEXTURE_MAX_ANISOTROPY_EXT, value);
}

void Texture::generateMipmaps() {
    bindScratch();
    glGenerateMipmap(target_);
}

void Texture::bindTo(int unit) const {
    glActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
    glBindTexture(target_, handle_.id());
}

void Texture::bindImage(int unit, int level, GLenum access, GLenum viewFormat, bool layered, int layer) const {
    glBindImageTexture(static_cast<GLuint>(unit), handle_.id(), level, layered ? GL_TRUE : GL_FALSE, layer, access,
                       viewFormat == 0 ? format_ : viewFormat);
}

void Texture::upload(int level, GLenum dataFormat, GLenum dataType, const void* data) {
    VOXCONE_CHECK(target_ != GL_TEXTURE_CUBE_MAP, "cubes are uploaded by face (uploadLayer)");
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    bindScratch();
    if (target_ == GL_TEXTURE_2D) {
        glTexSubImage2D(target_, level, 0, 0, width(level), height(level), dataFormat, dataType, data);
    } else {
        glTexSubImage3D(target_, level, 0, 0, 0, width(level), height(level), depth(level), dataFormat, dataType, data);
    }
}

void Texture::uploadLayer(int level, int layer, GLenum dataFormat, GLenum dataType, const void* data) {
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    bindScratch();
    if (target_ == GL_TEXTURE_2D || target_ == GL_TEXTURE_CUBE_MAP) {
        const GLenum image =
            target_ == GL_TEXTURE_2D ? target_ : GL_TEXTURE_CUBE_MAP_POSITIVE_X + static_cast<GLenum>(layer);
        glTexSubImage2D(image, level, 0, 0, width(level), height(level), dataFormat, dataType, data);
    } else {
        glTexSubImage3D(target_, level, 0, 0, layer, width(level), height(level), 1, dataFormat, dataType, data);
    }
}

void Texture::clear(int level) {
    const std::uint32_t zero[4] = {};
    const FormatFacts f = facts(format_);
    clear(level, f.dataFormat, f.integer ? GL_UNSIGNED_INT : GL_FLOAT, zero);
}

void Texture::clear(int level, GLenum dataFormat, GLenum dataType, const void* texel) {
    if (epoxy_gl_version() >= 44 || epoxy_has_gl_extension("GL_ARB_clear_texture")) {
        glClearTexImage(handle_.id(), level, dataFormat, dataType, texel);
        return;
    }
    // Plain 4.3: upload slices of the value.
    const bool wide = dataType == GL_FLOAT || dataType == GL_UNSIGNED_INT || dataType == GL_INT;
    VOXCONE_CHECK(wide || dataType == GL_UNSIGNED_BYTE, "clear with data type 0x{:04x}", dataType);
    const std::size_t size = static_cast<std::size_t>(components()) * (wide ? 4 : 1);
    const std::size_t texels = static_cast<std::size_t>(width(level)) * static_cast<std::size_t>(height(level));
    std::vector<std::uint8_t> slice(texels * size);
    for (std::size_t i = 0; i < texels; ++i) {
        std::copy_n(static_cast<const std::uint8_t*>(texel), size, slice.data() + i * size);
    }
    for (int layer = 0; layer < depth(level); ++layer) uploadLayer(level, layer, dataFormat, dataType, slice.data());
}

void Texture::clearAll() {
    for (int level = 0; level < levels_; ++level) clear(level);
}

void Texture::read(int level, GLenum dataFormat, GLenum dataType, void* data, std::size_t sliceBytes) const {
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    glMemoryBarrier(GL_TEXTURE_UPDATE_BARRIER_BIT);
    bindScratch();
    if (target_ == GL_TEXTURE_CUBE_MAP) {
        for (GLenum face = 0; face < 6; ++face) {
            glGetTexImage(GL_TEXTURE_CUBE_MAP_POSITIVE_X + face, level, dataFormat, dataType,
                          static_cast<std::uint8_t*>(data) + face * sliceBytes);
        }
    } else {
        glGetTexImage(target_, level, dataFormat, dataType, data);
    }
}

std::vector<float> Texture::readFloats(int level) const {
    const FormatFacts f = facts(format_);
    VOXCONE_CHECK(!f.integer, "readFloats of integer format 0x{:04x}", format_);
    const std::size_t slice = static_cast<std::size_t>(width(level)) * static_cast<std::size_t>(height(level)) *
                              static_cast<std::size_t>(f.components);
    std::vector<float> data(slice * static_cast<std::size_t>(depth(level)));
    read(level, f.dataFormat, GL_FLOAT, data.data(), slice * sizeof(float));
    return data;
}

std::vector<std::uint32_t> Texture::readUints(int level) const {
    const FormatFacts f = facts(format_);
    VOXCONE_CHECK(f.integer, "readUints of format 0x{:04x}", format_);
    const std::size_t slice = static_cast<std::size_t>(width(level)) * static_cast<std::size_t>(height(level)) *
                              static_cast<std::size_t>(f.components);
    std::vector<std::uint32_t> data(slice * static_cast<std::size_t>(depth(level)));
    read(level, f.dataFormat, GL_UNSIGNED_INT, data.data(), slice * sizeof(std::uint32_t));
    return data;
}

Sampler::Sampler(GLenum min, GLenum mag, GLenum wrapS, GLenum wrapT, GLenum wrapR) {
    GLuint id = 0;
    glGenSamplers(1, &id);
    handle_ = Handle<Delete>(id);
    glSamplerParameteri(id, GL_TEXTURE_MIN_FILTER, static_cast<GLint>(min));
    glSamplerParameteri(id, GL_TEXTURE_MAG_FILTER, static_cast<GLint>(mag));
    glSamplerParameteri(id, GL_TEXTURE_WRAP_S, static_cast<GLint>(wrapS));
    glSamplerParameteri(id, GL_TEXTURE_WRAP_T, static_cast<GLint>(wrapT));
    glSamplerParameteri(id, GL_TEXTURE_WRAP_R, static_cast<GLint>(wrapR));
}

void Sampler::bindTo(int unit) const {
    glBindSampler(static_cast<GLuint>(unit), handle_.id());
}
void Sampler::unbind(int unit) {
    glBindSampler(static_cast<GLuint>(unit), 0);
}

void Sampler::maxAnisotropy(float value) {
    if (!epoxy_has_gl_extension("GL_EXT_texture_filter_anisotropic")) return;
    glSamplerParameterf(handle_.id(), GL_TEXTURE_MAX_ANISOTROPY_EXT, value);
}

}  // namespace voxcone::gl
