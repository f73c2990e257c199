// What settings cost and how far they err on a script's shots, for searches among settings: as report/evaluate.h
// measures it, with as little rendering as that takes, and kept from one search to the next.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "report/evaluate.h"

namespace voxcone {

/// Of several shots the largest value of each counts, but for seconds, which add up.
struct Measured {
    double firstMilliseconds = 0, steadyMilliseconds = 0;  ///< a frame that builds all, and one where nothing moved
    std::map<std::string, double> errors;                  ///< magnitudes by metric, of the meter's channel
    double samplesPerPixel = 0;
    std::uint64_t memoryBytes = 0;
    double seconds = 0;       ///< that the measurement took, of all shots
    double buildSeconds = 0;  ///< of these, what the first frames took longer than the next ones
    bool kept = false;        ///< from a search before this one
    std::string failure;      ///< why it cannot be rendered; the rest is 0 then
};

/// Measures settings on the first frame of every shot of a script.
class SettingsMeter {
  public:
    /// `script` without extracted lights, as Evaluator takes it; both must outlive this object. `repeats`: frames whose
    /// median counts, of steady ones; of first ones only with `firstFrames`, else it is the very first frame, with the
    /// compilation of shaders. `folder` keeps what `measure` finds; empty = nothing is kept.
    SettingsMeter(gl::Context& context, Evaluator& evaluator, const CaptureScript& script, std::string channel,
                  int repeats, bool firstFrames, std::filesystem::path folder);

    /// Renders the references of pictures of 1/`divisor` of the script's width and height; returns the largest noise of
    /// one in the channel, as relMSE. `progress` gets 0…1. Throws InputError when a shot's reference is black there.
    double prepare(int divisor, const std::function<void(double)>& progress);

    /// With a `divisor` errors are those of the smaller pictures, but times and samples are estimates for the whole
    /// ones: passes over pixels take divisor² times as long. Where the folder holds a measurement by this program on
    /// this device, it is taken from there; settings that ended the program before have failed.
    Measured measure(const Settings& settings, int divisor);

    /// Renders all of `list` in turns, as the script says, whatever the folder holds.
    std::vector<Measured> compare(const std::vector<Settings>& list);

  private:
    Settings resized(Settings settings, int divisor) const;
    std::vector<Measured> render(const std::vector<Settings>& list, int divisor);
    void renderShot(const Shot& shot, const std::vector<Settings>& list, int divisor, std::vector<Measured>& out);

    gl::Context& context_;
    Evaluator& evaluator_;
    const CaptureScript& script_;
    std::string channel_;
    int repeats_;
    bool firstFrames_;
    std::filesystem::path folder_;
    std::string program_;  ///< sha256OfProgram, if there is a folder
};

}  // namespace voxcone
