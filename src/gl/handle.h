// A move-only OpenGL object name that deletes itself.
#pragma once

#include <epoxy/gl.h>

#include <utility>

namespace voxcone::gl {

/// `Delete` is a function object that takes a non-zero name.
template <class Delete>
class Handle {
  public:
    Handle() = default;
    explicit Handle(GLuint id) : id_(id) {}
    ~Handle() { reset(); }
    Handle(Handle&& other) noexcept : id_(std::exchange(other.id_, 0)) {}
    Handle& operator=(Handle&& other) noexcept {
        if (this != &other) {
            reset();
            id_ = std::exchange(other.id_, 0);
        }
        return *this;
    }

    GLuint id() const { return id_; }
    explicit operator bool() const { return id_ != 0; }

  private:
    void reset() {
        if (id_ != 0) Delete{}(id_);
        id_ = 0;
    }
    GLuint id_ = 0;
};

}  // namespace voxcone::gl
