// What a capture and a reference have in common: files, pictures of channels, descriptions.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "capture/script.h"
#include "metric/image.h"

namespace voxcone {

/// Whether `scene` is another at another time.
bool moves(const Scene& scene);

/// Writes out/<shot>/<channel>.<frame>.exr and .png and out/<shot>/stats.json, each whole or not at all, and remembers
/// them.
class ShotWriter {
  public:
    explicit ShotWriter(std::filesystem::path out) : out_(std::move(out)) {}

    /// `image` is what the EXR holds, `picture` what the PNG shows.
    void channel(const Shot& shot, const std::string& name, int frame, const Image& image, const Image& picture);
    void stats(const Shot& shot, const nlohmann::json& stats);

    /// The files in the order written.
    std::vector<std::filesystem::path> take() { return std::move(files_); }

  private:
    std::filesystem::path out_;
    std::vector<std::filesystem::path> files_;
};

/// What a PNG of `channel` shows, linear for writePng: radiance is exposed and clipped, directions are n/2 + 1/2 and
/// distances are scaled to the largest, both stored as they are (not encoded); the absolute value of `seam` is a heat
/// map that ends at 0.1. `beauty` has the tone curve instead.
Image pictureOf(const std::string& channel, const Image& image, const Settings& settings);

/// Radiance, exposed already, through the tone curve: linear display-referred.
Image displayOf(const Image& radiance, ToneMap curve);

/// What every stats.json has: program and `command`, scene, shot, settings.
nlohmann::json statsHead(const char* command, const CaptureScript& script, const Shot& shot);

/// Counts and sizes of a scene, for stats.json and `voxcone info`.
nlohmann::json describeScene(const Scene& scene);

}  // namespace voxcone
