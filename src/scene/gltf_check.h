// Checks the JSON of a glTF before anything trusts it.
#pragma once

#include <set>
#include <string>

#include "scene/gltf_file.h"

namespace voxcone {

/// Kinds of things that a file has and that are left out; told once a file.
using Ignored = std::set<std::string>;

/// Checks every property that the loader uses: types, ranges, references, cycles, sizes of accessors within their
/// views, of views within their buffers, of buffers within their data. What is not used (extras, unknown
/// extensions) is removed from `file.document`, and integers written as 2.0 become integers, so that readers
/// behind this one meet checked values only. Throws InputError with the JSON path.
void checkGltf(GltfFile& file, Ignored& ignored);

/// Bytes of one element: padded columns for matrices, as glTF 2.0 §3.6.2.4 says. `type` is "SCALAR", "VEC2", … "MAT4".
std::uint64_t elementSize(const std::string& type, int componentType);

}  // namespace voxcone
