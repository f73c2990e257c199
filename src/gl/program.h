// Linked shader programs and their uniforms.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>

#include "gl/buffer.h"
#include "gl/handle.h"

namespace voxcone::gl {

/// A linked program. Uniforms are set on the program itself, whether it is in use or not; a name that the program does
/// not have is ignored, because a compiler may drop what a variant does not need.
class Program {
  public:
    Program() = default;
    /// Takes over a linked program; ShaderLibrary makes them. `label` is for messages.
    Program(GLuint linked, std::string label);

    explicit operator bool() const { return static_cast<bool>(handle_); }
    GLuint id() const { return handle_.id(); }
    const std::string& label() const { return label_; }
    void use() const { glUseProgram(handle_.id()); }

    /// Location of a uniform, -1 when the program has none of that name. Cached.
    GLint location(std::string_view name);
    bool has(std::string_view name) { return location(name) >= 0; }

    void set(std::string_view name, bool value) { set(name, static_cast<int>(value)); }
    void set(std::string_view name, int value) { glProgramUniform1i(id(), location(name), value); }
    void set(std::string_view name, std::uint32_t value) { glProgramUniform1ui(id(), location(name), value); }
    void set(std::string_view name, float value) { glProgramUniform1f(id(), location(name), value); }
    void set(std::string_view name, double value) { set(name, static_cast<float>(value)); }
    void set(std::string_view name, const glm::vec2& value) { set(name, std::span(&value, 1)); }
    void set(std::string_view name, const glm::vec3& value) { set(name, std::span(&value, 1)); }
    void set(std::string_view name, const glm::vec4& value) { set(name, std::span(&value, 1)); }
    void set(std::string_view name, const glm::ivec2& value) { set(name, std::span(&value, 1)); }
    void set(std::string_view name, const glm::ivec3& value) { set(name, std::span(&value, 1)); }
    void set(std::string_view name, const glm::ivec4& value) { set(name, std::span(&value, 1)); }
    void set(std::string_view name, const glm::uvec2& value) { set(name, std::span(&value, 1)); }
    void set(std::string_view name, const glm::uvec3& value) { set(name, std::span(&value, 1)); }
    void set(std::string_view name, const glm::uvec4& value) { set(name, std::span(&value, 1)); }
    void set(std::string_view name, const glm::mat3& value) { set(name, std::span(&value, 1)); }
    void set(std::string_view name, const glm::mat4& value) { set(name, std::span(&value, 1)); }

    /// Arrays: the first elements of uniform array `name`.
    void set(std::string_view name, std::span<const int> values);
    void set(std::string_view name, std::span<const std::uint32_t> values);
    void set(std::string_view name, std::span<const float> values);
    void set(std::string_view name, std::span<const glm::vec2> values);
    void set(std::string_view name, std::span<const glm::vec3> values);
    void set(std::string_view name, std::span<const glm::vec4> values);
    void set(std::string_view name, std::span<const glm::ivec2> values);
    void set(std::string_view name, std::span<const glm::ivec3> values);
    void set(std::string_view name, std::span<const glm::ivec4> values);
    void set(std::string_view name, std::span<const glm::uvec2> values);
    void set(std::string_view name, std::span<const glm::uvec3> values);
    void set(std::string_view name, std::span<const glm::uvec4> values);
    void set(std::string_view name, std::span<const glm::mat3> values);
    void set(std::string_view name, std::span<const glm::mat4> values);

  private:
    struct Delete {
        void operator()(GLuint id) const { glDeleteProgram(id); }
    };
    struct Hash : std::hash<std::string_view> {
        using is_transparent = void;
    };
    Handle<Delete> handle_;
    std::string label_;
    std::unordered_map<std::string, GLint, Hash, std::equal_to<>> locations_;
};

/// Uses `program` and dispatches `x`×`y`×`z` work groups; none when one of them is 0. Counts above the device's limit
/// are a DeviceError.
void dispatch(const Program& program, int x, int y, int z);

/// The same with counts that the device has written: three words of `groups` from `offset` bytes on. Whoever wrote them
/// orders the reading by GL_COMMAND_BARRIER_BIT, and keeps them below the limit.
void dispatchIndirect(const Program& program, const Buffer& groups, std::size_t offset);

/// Groups of `groupSize` that cover `count` items.
constexpr int groupsFor(int count, int groupSize) {
    return (count + groupSize - 1) / groupSize;
}

/// glMemoryBarrier, here so that passes name what they wait for.
inline void memoryBarrier(GLbitfield bits) {
    glMemoryBarrier(bits);
}

}  // namespace voxcone::gl
