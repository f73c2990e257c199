#include "gl/program.h"

#include <array>

#include "core/check.h"
#include "core/error.h"

namespace voxcone::gl {

Program::Program(GLuint linked, std::string label) : handle_(linked), label_(std::move(label)) {}

GLint Program::location(std::string_view name) {
    if (const auto found = locations_.find(name); found != locations_.end()) return found->second;
    std::string key(name);
    const GLint location = glGetUniformLocation(id(), key.c_str());
    locations_.emplace(std::move(key), location);
    return location;
}

namespace {
template <class T>
GLsizei count(std::span<const T> values) {
    return static_cast<GLsizei>(values.size());
}
}  // namespace

void Program::set(std::string_view name, std::span<const int> values) {
    glProgramUniform1iv(id(), location(name), count(values), values.data());
}
void Program::set(std::string_view name, std::span<const std::uint32_t> values) {
    glProgramUniform1uiv(id(), location(name), count(values), values.data());
}
void Program::set(std::string_view name, std::span<const float> values) {
    glProgramUniform1fv(id(), location(name), count(values), values.data());
}
void Program::set(std::string_view name, std::span<const glm::vec2> values) {
    glProgramUniform2fv(id(), location(name), count(values), &values.data()->x);
}
void Program::set(std::string_view name, std::span<const glm::vec3> values) {
    glProgramUniform3fv(id(), location(name), count(values), &values.data()->x);
}
void Program::set(std::string_view name, std::span<const glm::vec4> values) {
    glProgramUniform4fv(id(), location(name), count(values), &values.data()->x);
}
void Program::set(std::string_view name, std::span<const glm::ivec2> values) {
    glProgramUniform2iv(id(), location(name), count(values), &values.data()->x);
}
void Program::set(std::string_view name, std::span<const glm::ivec3> values) {
    glProgramUniform3iv(id(), location(name), count(values), &values.data()->x);
}
void Program::set(std::string_view name, std::span<const glm::ivec4> values) {
    glProgramUniform4iv(id(), location(name), count(values), &values.data()->x);
}
void Program::set(std::string_view name, std::span<const glm::uvec2> values) {
    glProgramUniform2uiv(id(), location(name), count(values), &values.data()->x);
}
void Program::set(std::string_view name, std::span<const glm::uvec3> values) {
    glProgramUniform3uiv(id(), location(name), count(values), &values.data()->x);
}
void Program::set(std::string_view name, std::span<const glm::uvec4> values) {
    glProgramUniform4uiv(id(), location(name), count(values), &values.data()->x);
}
void Program::set(std::string_view name, std::span<const glm::mat3> values) {
    glProgramUniformMatrix3fv(id(), location(name), count(values), GL_FALSE, &(*values.data())[0][0]);
}
void Program::set(std::string_view name, std::span<const glm::mat4> values) {
    glProgramUniformMatrix4fv(id(), location(name), count(values), GL_FALSE, &(*values.data())[0][0]);
}

void dispatch(const Program& program, int x, int y, int z) {
    VOXCONE_CHECK(x >= 0 && y >= 0 && z >= 0, "{}: {}×{}×{} groups", program.label(), x, y, z);
    if (x == 0 || y == 0 || z == 0) return;
    const std::array<int, 3> groups = {x, y, z};
    for (GLuint axis = 0; axis < 3; ++axis) {
        GLint max = 0;
        glGetIntegeri_v(GL_MAX_COMPUTE_WORK_GROUP_COUNT, axis, &max);
        if (groups[axis] > max) {
            throw DeviceError(
                fmt::format("{} needs {} work groups along axis {}; the device allows "
                            "GL_MAX_COMPUTE_WORK_GROUP_COUNT = {}",
                            program.label(), groups[axis], axis, max));
        }
    }
    program.use();
    glDispatchCompute(static_cast<GLuint>(x), static_cast<GLuint>(y), static_cast<GLuint>(z));
}

void dispatchIndirect(const Program& program, const Buffer& groups, std::size_t offset) {
    VOXCONE_CHECK(offset % 4 == 0 && offset + 12 <= groups.bytes(), "{}: groups at {} of {} bytes", program.label(),
                  offset, groups.bytes());
    program.use();
    groups.bind(GL_DISPATCH_INDIRECT_BUFFER);
    glDispatchComputeIndirect(static_cast<GLintptr>(offset));
}

}  // namespace voxcone::gl
