// The cheapest settings for a script's scene, on this device, that meet a bound on the error: report/search.h on the
// settings that trade time for accuracy.
#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "report/meter.h"
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

    /// What searchCheapest is given: begins with `base`, the preset `fast`, and both ends of all knobs where these are
    /// few, as near as knobs allow. Knobs that a choice leaves without effect are at their cheapest value.
    SearchSpace searchSpace(bool smallPictures) const;
};

/// The settings that `voxcone tune` searches unless it is told others: levels, resolution, storage, cones, steps, near
/// field, bounces, shadow maps. Each list holds the value of `base` too. Left out are those that cannot change
/// `channel` (beauty, indirect_diffuse, indirect_specular, transmission), or without effect in `base`.
TuneSpace defaultTuneSpace(const Settings& base, const std::string& channel);

/// A knob of one's own from "KEY=VALUE,VALUE,…", cheapest first. Throws UsageError for an unknown key, a bad value or
/// fewer than two of them.
Knob knobFromText(const std::string& text);

struct TuneOptions {
    std::string metric = "relmse";  ///< a key of Measured::errors that is better when it is small
    double maxError = 0;
    std::optional<double> maxMilliseconds;
    bool firstFrame = false;  ///< the time of a frame that builds all, instead of one where nothing moved
    int budget = 40;          ///< measurements of settings, at most
};

struct TuneResult {
    struct Row {
        Choice choice;
        Measured measured;       ///< errors corrected by how far small pictures err in the bounded one
        bool confirmed = false;  ///< on whole pictures
    };
    std::vector<Row> front;       ///< by time: what is faster than all that errs less, and the cheapest
    std::optional<Row> cheapest;  ///< of the confirmed ones that meet the error
    bool met = false;             ///< by `cheapest`, the time too
    int measurements = 0, failed = 0;
    int kept = 0;  ///< measurements that an earlier search left
};

/// Calls that tell how the search gets on; each may be empty.
struct TuneEvents {
    std::function<void(int, const std::vector<Choice>&)>
        before;                                  ///< number of the first, and what is measured in turns
    std::function<void(const Measured&)> after;  ///< for each of them
};

/// Searches with small pictures where the script's are at least 256 × 144. Of settings that are alike in the time of a
/// steady frame it takes those that build faster: a thousandth of the first frame is added to what is compared.
TuneResult tune(SettingsMeter& meter, const TuneSpace& space, const TuneOptions& options,
                const TuneEvents& events = {});

/// 2 where tune() searches with small pictures, else 1.
int tuneDivisor(const Settings& settings);

/// A preset that gives these settings whatever they are applied to: all but `output`, `reference` and `device`.
nlohmann::json presetOf(const Settings& settings);

}  // namespace voxcone
