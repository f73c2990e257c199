// The cheapest settings for a script's scene, on this device, that meet a bound on the error: report/search.h on the
// settings that trade time for accuracy.
#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "report/evaluate.h"
#include "report/search.h"

namespace voxcone {

/// One setting that may change: its values from the cheapest to the most accurate one, as far as is known.
struct Knob {
    std::string key;  ///< dotted, as in Settings
    std::vector<nlohmann::json> values;
};

/// Settings to choose from: `base`, changed by knobs.
struct TuneSpace {
    Settings base;
    std::vector<Knob> knobs;

    /// The settings of a choice.
    Settings settingsOf(const Choice& choice) const;

    /// "key=value", by a space each, of what differs from `base`; "-" when nothing does.
    std::string changesOf(const Choice& choice) const;

    /// The choice whose values are nearest to those of `settings`.
    Choice nearest(const Settings& settings) const;

    /// What searchCheapest is given: begins with `base`, then the presets `fast` and `accurate`, then both ends of all
    /// knobs, as near as knobs allow; knobs that a choice leaves without effect are at their cheapest value.
    SearchSpace searchSpace(bool smallPictures) const;
};

/// The settings that `voxcone tune` searches unless it is told others: levels, resolution, storage, cones, steps, near
/// field, bounces, shadow maps. Each list holds the value of `base` too. Left out are those that cannot change
/// `channel` (beauty, indirect_diffuse, indirect_specular, transmission), or without effect in `base`.
TuneSpace defaultTuneSpace(const Settings& base, const std::string& channel);

/// A knob of one's own from "KEY=VALUE,VALUE,…", cheapest first. Throws UsageError for an unknown key, a bad value or
/// fewer than two of them.
Knob knobFromText(const std::string& text);

/// Of several shots the largest value of each counts.
struct Measured {
    double firstMilliseconds = 0, steadyMilliseconds = 0;  ///< a frame that builds all, and one where nothing moved
    double error = 0;
    double samplesPerPixel = 0;
    std::uint64_t memoryBytes = 0;
    std::string failure;  ///< why it cannot be rendered; the rest is 0 then
};

/// Measures settings on the first frame of every shot of a script.
class SettingsMeter {
  public:
    /// `script` without extracted lights, as Evaluator takes it; both must outlive this object. `metric`: a key of
    /// ChannelResult::errors that is better when it is small; its magnitude is taken. `repeats`: frames whose median
    /// counts, of steady ones; of first ones only with `firstFrames`, else one is rendered, which may take much longer.
    SettingsMeter(gl::Context& context, Evaluator& evaluator, const CaptureScript& script, std::string channel,
                  std::string metric, int repeats, bool firstFrames);

    /// Renders the references of pictures of 1/`divisor` of the script's width and height. `progress` gets 0…1. Throws
    /// InputError when a shot's reference is black in the channel.
    void prepare(int divisor, const std::function<void(double)>& progress);

    /// Renders all of `list` in turns. With a `divisor` errors are those of the smaller pictures, but times and samples
    /// are estimates for the whole ones: passes over pixels take divisor² times as long.
    std::vector<Measured> measure(const std::vector<Settings>& list, int divisor);

  private:
    Settings resized(Settings settings, int divisor) const;
    void measureShot(const Shot& shot, const std::vector<Settings>& list, int divisor, std::vector<Measured>& out);

    gl::Context& context_;
    Evaluator& evaluator_;
    const CaptureScript& script_;
    std::string channel_, metric_;
    int repeats_;
    bool firstFrames_;
};

struct TuneOptions {
    double maxError = 0;
    std::optional<double> maxMilliseconds;
    bool firstFrame = false;  ///< the time of a frame that builds all, instead of one where nothing moved
    int budget = 40;          ///< measurements of settings, at most
};

struct TuneResult {
    struct Row {
        Choice choice;
        Measured measured;       ///< error corrected by how far small pictures err
        bool confirmed = false;  ///< on whole pictures
    };
    std::vector<Row> front;       ///< of all that was measured: faster than all that err less, by time
    std::optional<Row> cheapest;  ///< of the confirmed ones that meet the error
    bool met = false;             ///< by `cheapest`, the time too
    int measurements = 0, failed = 0;
};

/// Searches with small pictures where the script's are at least 256 × 144. `onMeasured`, where not empty, hears of each
/// measurement: its number, choice and figures.
TuneResult tune(SettingsMeter& meter, const TuneSpace& space, const TuneOptions& options,
                const std::function<void(int, const Choice&, const Measured&)>& onMeasured = {});

/// 2 where tune() searches with small pictures, else 1.
int tuneDivisor(const Settings& settings);

/// A preset that gives these settings whatever they are applied to: all but `output`, `reference` and `device`.
nlohmann::json presetOf(const Settings& settings);

}  // namespace voxcone
