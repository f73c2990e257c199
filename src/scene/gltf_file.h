// The outer shell of glTF: GLB container, JSON text, buffers and images behind URIs. Nothing is read or allocated
// before its size is known to fit.
#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

namespace voxcone {

using Bytes = std::vector<std::uint8_t>;

struct GltfFile {
    std::filesystem::path path;
    nlohmann::json document;      ///< an object
    std::optional<Bytes> binary;  ///< BIN chunk of a .glb
};

/// Reads and splits a .gltf or .glb (told apart by its magic, not its name). Throws InputError: for JSON syntax errors
/// with line and column, for a damaged container with the byte offset, for nesting deeper than 128.
GltfFile readGltfFile(const std::filesystem::path& path);

/// Number of bytes that `uri` (a data URI or a relative path) gives, without decoding it. Throws InputError at
/// `jsonPath` for absolute paths, other schemes, broken escapes and missing files.
std::uint64_t uriSize(const GltfFile& file, const std::string& uri, const std::string& jsonPath);

/// The first `maxBytes` bytes behind `uri`.
Bytes readUri(const GltfFile& file, const std::string& uri, const std::string& jsonPath, std::uint64_t maxBytes);

/// `text` as it may appear in a one-line message: control characters blanked, long text cut.
std::string printable(std::string text);

}  // namespace voxcone
