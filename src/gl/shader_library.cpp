#include "gl/shader_library.h"

#include <algorithm>
#include <regex>
#include <sstream>

#include "core/atomic_file.h"
#include "core/check.h"
#include "gl/embedded_shaders.h"

namespace voxcone::gl {
namespace {

GLenum stageOf(const std::string& path) {
    const std::string extension = std::filesystem::path(path).extension().string();
    if (extension == ".vert") return GL_VERTEX_SHADER;
    if (extension == ".geom") return GL_GEOMETRY_SHADER;
    if (extension == ".frag") return GL_FRAGMENT_SHADER;
    if (extension == ".comp") return GL_COMPUTE_SHADER;
    VOXCONE_CHECK(false, "shader {} has no stage extension", path);
    return 0;
}

const EmbeddedShader* findEmbedded(std::string_view path) {
    for (const EmbeddedShader& shader : embeddedShaders()) {
        if (shader.path == path) return &shader;
    }
    return nullptr;
}

std::string programLog(GLuint program) {
    GLint length = 0;
    glGetProgramiv(program, GL_INFO_LOG_LENGTH, &length);
    std::string log(static_cast<std::size_t>(std::max(length, 1)), '\0');
    glGetProgramInfoLog(program, length, nullptr, log.data());
    return log.c_str();
}

std::string shaderLog(GLuint shader) {
    GLint length = 0;
    glGetShaderiv(shader, GL_INFO_LOG_LENGTH, &length);
    std::string log(static_cast<std::size_t>(std::max(length, 1)), '\0');
    glGetShaderInfoLog(shader, length, nullptr, log.data());
    return log.c_str();
}

/// Links and deletes `stages`; throws ShaderError.
Program link(const std::vector<GLuint>& stages, const std::string& label) {
    const GLuint id = glCreateProgram();
    for (const GLuint stage : stages) glAttachShader(id, stage);
    glLinkProgram(id);
    for (const GLuint stage : stages) {
        glDetachShader(id, stage);
        glDeleteShader(stage);
    }
    Program program(id, label);
    GLint linked = GL_FALSE;
    glGetProgramiv(id, GL_LINK_STATUS, &linked);
    if (linked == GL_FALSE) throw ShaderError("shaders/" + label + ": " + programLog(id));
    glObjectLabel(GL_PROGRAM, id, static_cast<GLsizei>(label.size()), label.data());
    return program;
}

}  // namespace

std::string mapShaderLog(std::string_view log, const std::vector<SourceLine>& lines) {
    static const std::regex mesaOrIntel(R"(^(?:ERROR: |WARNING: )?0:(\d+)(?:\(\d+\))?: ?(.*)$)");
    static const std::regex nvidia(R"(^0\((\d+)\) ?: ?(.*)$)");
    std::istringstream in{std::string(log)};
    std::string line, out;
    while (std::getline(in, line)) {
        std::smatch match;
        if (std::regex_match(line, match, mesaOrIntel) || std::regex_match(line, match, nvidia)) {
            const std::size_t number = std::stoul(match[1]);
            if (number >= 1 && number <= lines.size()) {
                const SourceLine& origin = lines[number - 1];
                line = fmt::format("shaders/{}:{}: {}", origin.file, origin.line, match[2].str());
            }
        }
        if (!line.empty()) out += (out.empty() ? "" : "\n") + line;
    }
    return out;
}

ShaderLibrary::ShaderLibrary(std::filesystem::path overrideFolder) : overrideFolder_(std::move(overrideFolder)) {}

bool ShaderLibrary::has(const std::string& path) const {
    return findEmbedded(path) != nullptr ||
           (!overrideFolder_.empty() && std::filesystem::exists(overrideFolder_ / path));
}

std::string ShaderLibrary::source(const std::string& path, const std::string& includedFrom) const {
    if (!overrideFolder_.empty() && std::filesystem::exists(overrideFolder_ / path)) {
        return readTextFile(overrideFolder_ / path);
    }
    if (const EmbeddedShader* shader = findEmbedded(path)) return std::string(shader->text);
    throw ShaderError(includedFrom.empty() ? "shaders/" + path + ": no such shader"
                                           : includedFrom + ": no such include: shaders/" + path);
}

void ShaderLibrary::expand(const std::string& path, const std::string& text, std::vector<std::string>& included,
                           Assembled& out) const {
    static const std::regex include(R"re(^\s*#\s*include\s*"([^"]+)"\s*(//.*)?$)re");
    included.push_back(path);
    std::istringstream in(text);
    std::string line;
    for (int lineNumber = 1; std::getline(in, line); ++lineNumber) {
        std::smatch match;
        if (line.find('#') == std::string::npos || !std::regex_match(line, match, include)) {
            out.text += line + "\n";
            out.lines.push_back({path, lineNumber});
            continue;
        }
        const std::string name = match[1];
        if (std::find(included.begin(), included.end(), name) == included.end()) {
            expand(name, source(name, fmt::format("shaders/{}:{}", path, lineNumber)), included, out);
        }
    }
}

// No #line directives: Mesa forgets their source number inside expressions, so lines are mapped back by our own table.
ShaderLibrary::Assembled ShaderLibrary::assemble(const std::string& path, const std::string& text,
                                                 const Defines& defines) const {
    Assembled out;
    out.text = "#version 430 core\n";
    out.lines.push_back({path, 0});
    for (const auto& [name, value] : defines) {
        out.text += "#define " + name + " " + value + "\n";
        out.lines.push_back({path, 0});
    }
    std::vector<std::string> included;
    expand(path, text, included, out);
    return out;
}

GLuint ShaderLibrary::compileStage(const std::string& path, const std::string& text, const Defines& defines) const {
    const Assembled full = assemble(path, text, defines);
    const GLuint shader = glCreateShader(stageOf(path));
    const GLchar* pointer = full.text.data();
    const auto length = static_cast<GLint>(full.text.size());
    glShaderSource(shader, 1, &pointer, &length);
    glCompileShader(shader);
    GLint compiled = GL_FALSE;
    glGetShaderiv(shader, GL_COMPILE_STATUS, &compiled);
    if (compiled == GL_FALSE) {
        const std::string log = shaderLog(shader);
        glDeleteShader(shader);
        throw ShaderError(mapShaderLog(log, full.lines));
    }
    return shader;
}

Program ShaderLibrary::compute(const std::string& path, const Defines& defines) const {
    return computeFromText(path, source(path, ""), defines);
}

Program ShaderLibrary::computeFromText(const std::string& name, const std::string& text, const Defines& defines) const {
    return link({compileStage(name, text, defines)}, name);
}

Program ShaderLibrary::graphics(const std::vector<std::string>& paths, const Defines& defines) const {
    std::vector<GLuint> stages;
    try {
        for (const std::string& path : paths) stages.push_back(compileStage(path, source(path, ""), defines));
    } catch (...) {
        for (const GLuint stage : stages) glDeleteShader(stage);
        throw;
    }
    VOXCONE_CHECK(!paths.empty(), "a program without shaders");
    return link(stages, paths.back());
}

}  // namespace voxcone::gl
