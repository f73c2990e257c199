// Shader sources: embedded at build time from shaders/, or read from a folder that overrides them, with #include,
// defines and messages that name file and line.
#pragma once

#include <filesystem>
#include <initializer_list>
#include <map>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "gl/program.h"

namespace voxcone::gl {

/// A shader that does not compile or link; every line of the message is "shaders/FILE:LINE: message".
class ShaderError : public std::runtime_error {
  public:
    using std::runtime_error::runtime_error;
};

/// Names and values of `#define NAME VALUE`, in alphabetical order.
using Defines = std::map<std::string, std::string>;

/// A line of a file below shaders/, counted from 1.
struct SourceLine {
    std::string file;
    int line = 0;
};

class ShaderLibrary {
  public:
    /// Embedded sources; a file below `overrideFolder` (a copy of shaders/) goes before the embedded one of the same
    /// name.
    explicit ShaderLibrary(std::filesystem::path overrideFolder = {});

    /// Compiles and links. Paths are relative to shaders/, e.g. "cone/diffuse.comp"; extensions .vert, .geom, .frag,
    /// .comp say the stage. Sources have no #version: the library begins them with 430 core and then the defines.
    /// Throws ShaderError.
    Program compute(const std::string& path, const Defines& defines = {}) const;
    Program graphics(const std::vector<std::string>& paths, const Defines& defines = {}) const;

    /// From text instead of a file (tests): `name` stands in messages and its extension says the stage.
    Program computeFromText(const std::string& name, const std::string& text, const Defines& defines = {}) const;

    /// One stage after includes and defines: what the driver gets, and where each of its lines comes from.
    struct Assembled {
        std::string text;
        std::vector<SourceLine> lines;
    };
    Assembled assemble(const std::string& path, const std::string& text, const Defines& defines) const;

    /// Whether the library has this file.
    bool has(const std::string& path) const;

  private:
    std::string source(const std::string& path, const std::string& includedFrom) const;
    void expand(const std::string& path, const std::string& text, std::vector<std::string>& included,
                Assembled& out) const;
    GLuint compileStage(const std::string& path, const std::string& text, const Defines& defines) const;

    std::filesystem::path overrideFolder_;
};

/// The driver's log with its line numbers replaced: "shaders/FILE:LINE: message". `lines` holds the origin of every
/// line of the text that the driver got, which is given as one string. Knows the formats of Mesa ("0:12(5): error: …"),
/// NVIDIA
/// ("0(12) : error …") and AMD and Intel ("ERROR: 0:12: …").
std::string mapShaderLog(std::string_view log, const std::vector<SourceLine>& lines);

}  // namespace voxcone::gl
