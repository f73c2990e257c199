#include "gl/buffer.h"

#include "core/error.h"

namespace voxcone::gl {

Buffer::Buffer(std::size_t bytes, const void* data, GLenum usage) : bytes_(bytes) {
    VOXCONE_CHECK(bytes > 0, "a buffer of no bytes");
    GLuint id = 0;
    glGenBuffers(1, &id);
    handle_ = Handle<Delete>(id);
    while (glGetError() != GL_NO_ERROR) {
        // Whatever came before is not of this allocation; the debug callback has it.
    }
    glBindBuffer(GL_COPY_WRITE_BUFFER, id);
    glBufferData(GL_COPY_WRITE_BUFFER, static_cast<GLsizeiptr>(bytes), data, usage);
    if (glGetError() != GL_NO_ERROR) {
        throw DeviceError(fmt::format("the device cannot hold a buffer of {} MiB", bytes >> 20));
    }
}

void Buffer::bind(GLenum target) const {
    glBindBuffer(target, handle_.id());
}

void Buffer::bindBase(GLenum target, int index) const {
    glBindBufferBase(target, static_cast<GLuint>(index), handle_.id());
}

void Buffer::bindRange(GLenum target, int index, std::size_t offset, std::size_t bytes) const {
    glBindBufferRange(target, static_cast<GLuint>(index), handle_.id(), static_cast<GLintptr>(offset),
                      static_cast<GLsizeiptr>(bytes));
}

void Buffer::upload(const void* data, std::size_t bytes, std::size_t offset) {
    VOXCONE_CHECK(offset + bytes <= bytes_, "upload of {} bytes at {} into {}", bytes, offset, bytes_);
    glBindBuffer(GL_COPY_WRITE_BUFFER, handle_.id());
    glBufferSubData(GL_COPY_WRITE_BUFFER, static_cast<GLintptr>(offset), static_cast<GLsizeiptr>(bytes), data);
}

void Buffer::copyFrom(const Buffer& source, std::size_t bytes) {
    VOXCONE_CHECK(bytes <= source.bytes_ && bytes <= bytes_, "copy of {} bytes from {} to {}", bytes, source.bytes_,
                  bytes_);
    glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    glBindBuffer(GL_COPY_READ_BUFFER, source.id());
    glBindBuffer(GL_COPY_WRITE_BUFFER, id());
    glCopyBufferSubData(GL_COPY_READ_BUFFER, GL_COPY_WRITE_BUFFER, 0, 0, static_cast<GLsizeiptr>(bytes));
}

void Buffer::clear(std::uint32_t word) {
    glBindBuffer(GL_COPY_WRITE_BUFFER, handle_.id());
    glClearBufferData(GL_COPY_WRITE_BUFFER, GL_R32UI, GL_RED_INTEGER, GL_UNSIGNED_INT, &word);
}

void Buffer::readBytes(void* data, std::size_t bytes, std::size_t offset) const {
    if (bytes == 0) return;
    glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    glBindBuffer(GL_COPY_READ_BUFFER, handle_.id());
    glGetBufferSubData(GL_COPY_READ_BUFFER, static_cast<GLintptr>(offset), static_cast<GLsizeiptr>(bytes), data);
}

}  // namespace voxcone::gl
