// Buffer objects.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>
#include <vector>

#include "core/check.h"
#include "gl/handle.h"

namespace voxcone::gl {

/// Buffer of a fixed size. An empty (default-constructed) buffer has id 0 and size 0.
class Buffer {
  public:
    Buffer() = default;
    /// `bytes` > 0; contents are `data`, or undefined when null. Throws DeviceError when memory runs out.
    explicit Buffer(std::size_t bytes, const void* data = nullptr, GLenum usage = GL_STATIC_DRAW);

    /// A buffer that holds a copy of `values`, which must not be empty.
    template <class T>
    static Buffer of(std::span<const T> values, GLenum usage = GL_STATIC_DRAW) {
        static_assert(std::is_trivially_copyable_v<T>);
        return Buffer(values.size_bytes(), values.data(), usage);
    }
    template <class T>
    static Buffer of(const std::vector<T>& values, GLenum usage = GL_STATIC_DRAW) {
        return of(std::span<const T>(values), usage);
    }

    explicit operator bool() const { return static_cast<bool>(handle_); }
    GLuint id() const { return handle_.id(); }
    std::size_t bytes() const { return bytes_; }

    void bind(GLenum target) const;                 ///< e.g. GL_DISPATCH_INDIRECT_BUFFER
    void bindBase(GLenum target, int index) const;  ///< GL_SHADER_STORAGE_BUFFER, GL_UNIFORM_BUFFER, …
    void bindRange(GLenum target, int index, std::size_t offset, std::size_t bytes) const;

    void upload(const void* data, std::size_t bytes, std::size_t offset = 0);
    /// Copies the first `bytes` of `source` to the beginning, on the device.
    void copyFrom(const Buffer& source, std::size_t bytes);
    /// Sets all 32-bit words. The size must be a multiple of 4.
    void clear(std::uint32_t word = 0);

    /// All of the buffer, or `count` elements from element `first`. Waits for the device.
    template <class T>
    std::vector<T> read() const {
        return read<T>(0, bytes_ / sizeof(T));
    }
    template <class T>
    std::vector<T> read(std::size_t first, std::size_t count) const {
        static_assert(std::is_trivially_copyable_v<T>);
        VOXCONE_CHECK((first + count) * sizeof(T) <= bytes_, "read of {} + {} elements from {} bytes", first, count,
                      bytes_);
        std::vector<T> values(count);
        readBytes(values.data(), count * sizeof(T), first * sizeof(T));
        return values;
    }

  private:
    void readBytes(void* data, std::size_t bytes, std::size_t offset) const;

    struct Delete {
        void operator()(GLuint id) const { glDeleteBuffers(1, &id); }
    };
    Handle<Delete> handle_;
    std::size_t bytes_ = 0;
};

}  // namespace voxcone::gl
