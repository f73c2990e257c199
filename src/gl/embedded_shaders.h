// The table that cmake/EmbedShaders.cmake generates from shaders/.
#pragma once

#include <span>
#include <string_view>

namespace voxcone::gl {

struct EmbeddedShader {
    std::string_view path;  ///< relative to shaders/
    std::string_view text;
};

std::span<const EmbeddedShader> embeddedShaders();

}  // namespace voxcone::gl
