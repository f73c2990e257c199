// Shots to files by the path tracer: what `voxcone reference` does once the script is read.
#pragma once

#include <filesystem>
#include <vector>

#include "capture/script.h"

namespace voxcone {

/// Path traces every shot into files of the same names as runCapture's; stats.json holds the reference's own errors.
/// Channels that only the renderer has (soft_shadow, cascade, seam and voxel views) are left out with a message.
/// Returns the files in the order written. Throws InputError for files that cannot be written.
std::vector<std::filesystem::path> runReference(const CaptureScript& script, const std::filesystem::path& out);

}  // namespace voxcone
