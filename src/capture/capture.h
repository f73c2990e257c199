// Shots to files by the renderer: what `voxcone capture` does once the script is read.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "capture/script.h"
#include "metric/temporal.h"

namespace voxcone {

class Renderer;

namespace gl {
class Context;
struct DeviceInfo;
}  // namespace gl

/// Renders every shot of `script` on the current context. Writes out/<shot>/<channel>.<frame>.exr and .png and
/// out/<shot>/stats.json (times of the passes, memory, counts, settings, device, temporal figures where the shot asks
/// for them), each whole or not at all. Frame n is the same picture whatever frames were rendered before it. The first
/// frame of a shot builds voxels and shadow maps anew, so that its times are those of a scene that has just been
/// loaded; a tiny frame is drawn beforehand and thrown away, so that no shader is compiled within them. Returns the
/// files in the order written. Throws InputError for files that cannot be written, DeviceError for limits.
std::vector<std::filesystem::path> runCapture(const CaptureScript& script, gl::Context& context,
                                              const std::filesystem::path& out);

/// What the temporal figure needs of the frame that `renderer` has just rendered by `worldCamera`.
TemporalFrame temporalFrame(Renderer& renderer, const Camera& worldCamera);

/// Strings and limits of a device, for stats.json and `voxcone info`.
nlohmann::json describeDevice(const gl::DeviceInfo& info);

}  // namespace voxcone
