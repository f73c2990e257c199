// glTF 2.0 reading on tinygltf.
#pragma once

#include <filesystem>

#include "scene/scene.h"

namespace voxcone {

/// Loads a .gltf or .glb. Throws InputError with file, JSON path and reason for anything that is malformed, unsupported
/// in `extensionsRequired`, unreadable, or too large for its file. Warnings (core/log.h) name what is ignored.
Scene loadGltf(const std::filesystem::path& file);

}  // namespace voxcone
