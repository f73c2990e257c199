#include "report/tune.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "core/check.h"
#include "core/error.h"

namespace voxcone {

using nlohmann::json;

namespace {

json valueIn(const Settings& settings, const std::string& key) {
    std::string pointer = "/" + key;
    std::replace(pointer.begin(), pointer.end(), '.', '/');
    return toJson(settings).at(json::json_pointer(pointer));
}

std::string textOf(const json& value) {
    return value.is_string() ? value.get<std::string>() : value.dump();
}

void assign(Settings& settings, const std::string& key, const json& value) {
    applyAssignment(settings, key + "=" + textOf(value));
}

/// Numbers are as far apart as their ratio.
double distance(const json& a, const json& b) {
    if (a.is_number() && b.is_number()) return std::abs(std::log((a.get<double>() + 0.25) / (b.get<double>() + 0.25)));
    return a == b ? 0 : 1;
}

int nearestIndex(const std::vector<json>& values, const json& value) {
    const auto nearer = [&](const json& a, const json& b) { return distance(a, value) < distance(b, value); };
    return static_cast<int>(std::min_element(values.begin(), values.end(), nearer) - values.begin());
}

/// Puts `value` where it belongs in the order of numbers, or at the end, unless it is there.
void include(std::vector<json>& values, const json& value) {
    if (std::find(values.begin(), values.end(), value) != values.end()) return;
    const bool falls = values.front().is_number() && values.back() < values.front();
    const auto after = std::find_if(values.begin(), values.end(), [&](const json& v) {
        return value.is_number() && (falls ? v < value : value < v);
    });
    values.insert(after, value);
}

/// SearchSpace::efforts of a setting. Surfaces of twice the resolution have four times the voxels, each of which
/// gathers its bounces by cones.
double effortOf(const std::string& key) {
    if (key == "voxel.resolution") return std::log(4.0);
    return key.starts_with("light.bounce") || key == "cascade.levels" ? 0.5 : 0.2;
}

}  // namespace

Settings TuneSpace::settingsOf(const Choice& choice) const {
    Settings settings = base;
    for (std::size_t k = 0; k < knobs.size(); ++k)
        assign(settings, knobs[k].key, knobs[k].values.at(static_cast<std::size_t>(choice.at(k))));
    return settings;
}

std::string TuneSpace::changesOf(const Choice& choice) const {
    std::string out;
    for (std::size_t k = 0; k < knobs.size(); ++k) {
        const json& value = knobs[k].values.at(static_cast<std::size_t>(choice.at(k)));
        if (value == valueIn(base, knobs[k].key)) continue;
        out += fmt::format("{}{}={}", out.empty() ? "" : " ", knobs[k].key, textOf(value));
    }
    return out.empty() ? "-" : out;
}

Choice TuneSpace::nearest(const Settings& settings) const {
    Choice choice;
    for (const Knob& knob : knobs) choice.push_back(nearestIndex(knob.values, valueIn(settings, knob.key)));
    return choice;
}

SearchSpace TuneSpace::searchSpace(bool smallPictures) const {
    SearchSpace space;
    space.smallPictures = smallPictures;
    Choice lowest, highest;
    std::map<std::string, std::size_t> places;
    for (const Knob& knob : knobs) {
        places[knob.key] = space.sizes.size();
        space.sizes.push_back(static_cast<int>(knob.values.size()));
        lowest.push_back(0), highest.push_back(static_cast<int>(knob.values.size()) - 1);
        space.efforts.push_back(effortOf(knob.key));
    }
    space.seeds.push_back(nearest(base));
    // Not `accurate`, whose light may take minutes: the search goes up to it where nothing less will do.
    Settings fast = base;
    applyPreset(fast, "fast");
    space.seeds.push_back(nearest(fast));
    // What presets do not speak of stays.
    for (std::size_t k = 0; k < knobs.size(); ++k)
        if (valueIn(fast, knobs[k].key) == valueIn(Settings(), knobs[k].key)) space.seeds[1][k] = space.seeds[0][k];
    // A few knobs of one's own may look the same under all presets.
    if (knobs.size() < 6) space.seeds.insert(space.seeds.end(), {lowest, highest});

    // Only six faces have a near field, and without a bounce its cones do nothing.
    const auto without = [&](const std::string& switchKey, const json& on, bool meansOff, const std::string& idleKey) {
        const auto idle = places.find(idleKey), change = places.find(switchKey);
        if (idle == places.end()) return std::function<void(Choice&)>([](Choice&) {});
        std::vector<char> off;
        const auto isOff = [&](const json& value) { return (value == on) == meansOff; };
        if (change != places.end())
            for (const json& value : knobs[change->second].values) off.push_back(isOff(value));
        const bool always = change == places.end() && isOff(valueIn(base, switchKey));
        return std::function<void(Choice&)>(
            [=, at = idle->second, by = change == places.end() ? 0 : change->second](Choice& choice) {
                if (always || (!off.empty() && off[static_cast<std::size_t>(choice[by])])) choice[at] = 0;
            });
    };
    space.canonical = [near = without("voxel.storage", "six_face", false, "cone.near_field"),
                       bounce = without("light.bounces", 0, true, "light.bounce_cones")](Choice choice) {
        near(choice), bounce(choice);
        return choice;
    };
    return space;
}

TuneSpace defaultTuneSpace(const Settings& base, const std::string& channel) {
    const bool beauty = channel == "beauty", diffuse = channel == "indirect_diffuse";
    const bool nearField = base.cone.start == StartOffset::normal && base.cone.compositing == Compositing::linear;
    const bool specular = !diffuse && base.specular.enabled;
    TuneSpace space;
    space.base = base;
    const auto add = [&](bool wanted, const char* key, std::vector<json> values) {
        if (!wanted) return;
        include(values, valueIn(base, key));
        space.knobs.push_back({key, std::move(values)});
    };
    add(true, "voxel.resolution", {32, 64, 128, 256});
    add(true, "cascade.levels", {1, 2, 3});
    add(true, "voxel.storage", {"isotropic", "sh1", "six_face"});
    add(beauty || diffuse, "cone.diffuse", {5, 6, 9, 16, 32});
    add(true, "cone.step", {2.0, 1.5, 1.0, 0.7});
    add(base.cone.footprintCap > 0, "cone.footprint_cap", {4.0, 6.0, 8.0, 12.0, 16.0});
    add(nearField, "cone.near_field", {0.0, 4.0, 8.0, 16.0, 32.0});
    add(true, "light.bounces", {0, 1, 2, 3, 6});
    add(true, "light.bounce_cones", {5, 6, 9, 16});
    add(true, "light.shadow_resolution", {512, 1024, 2048, 4096});
    add(specular, "specular.cones", {1, 2, 4, 8});
    add(specular, "specular.step", {2.0, 1.0, 0.5});
    return space;
}

Knob knobFromText(const std::string& text) {
    const auto equals = text.find('=');
    if (equals == std::string::npos || equals == 0)
        throw UsageError(fmt::format("--vary {}: expected KEY=VALUE,VALUE, e.g. --vary cone.diffuse=6,16", text));
    Knob knob{text.substr(0, equals), {}};
    for (std::size_t from = equals + 1; from <= text.size();) {
        const std::size_t comma = std::min(text.find(',', from), text.size());
        const std::string word = text.substr(from, comma - from);
        if (knob.key == "preset") throw UsageError("--vary preset: name settings one by one");
        Settings probe;
        try {
            applyAssignment(probe, knob.key + "=" + word);
        } catch (const UsageError& error) {
            const std::string reason = error.what();
            throw UsageError("--vary " + reason.substr(reason.starts_with("--set ") ? 6 : 0));
        }
        knob.values.push_back(valueIn(probe, knob.key));
        from = comma + 1;
    }
    if (knob.values.size() < 2) throw UsageError(fmt::format("--vary {}: fewer than two values", text));
    return knob;
}

int tuneDivisor(const Settings& settings) {
    return settings.output.width >= 256 && settings.output.height >= 144 ? 2 : 1;
}

TuneResult tune(SettingsMeter& meter, const TuneSpace& space, const TuneOptions& options, const TuneEvents& events) {
    const int divisor = tuneDivisor(space.base);
    const auto milliseconds = [&](const Measured& m) {
        return options.firstFrame ? m.firstMilliseconds : m.steadyMilliseconds;
    };
    constexpr double kFirstShare = 0.001;
    TuneResult result;
    std::map<Choice, Measured> searched, confirmed;
    int number = 0;
    const MeasureChoices measure = [&](const std::vector<Choice>& choices, Stage stage) {
        const bool search = stage == Stage::search;
        std::vector<Settings> list;
        for (const Choice& choice : choices) list.push_back(space.settingsOf(choice));
        std::vector<Measured> measured;
        if (events.before) events.before(number + 1, choices);
        number += static_cast<int>(choices.size());
        if (search)
            measured = {meter.measure(list.front(), divisor)};
        else
            measured = meter.compare(list);
        std::vector<std::optional<Cost>> costs;
        for (std::size_t i = 0; i < choices.size(); ++i) {
            const Measured& m = measured[i];
            if (events.after) events.after(m);
            result.kept += m.kept;
            if (m.failure.empty()) {
                (search ? searched : confirmed)[choices[i]] = m;
                const double time = milliseconds(m) + (options.firstFrame ? 0 : kFirstShare * m.firstMilliseconds);
                // A picture without error and a clock that has not ticked have no logarithm.
                costs.emplace_back(Cost{std::max(time, 1e-6), std::max(m.errors.at(options.metric), 1e-12),
                                        std::max(m.buildSeconds, 1e-3), std::max(m.seconds - m.buildSeconds, 1e-3)});
            } else {
                ++result.failed;
                costs.emplace_back(std::nullopt);
            }
        }
        return costs;
    };
    const SearchResult found =
        searchCheapest(space.searchSpace(divisor > 1), options.maxError, options.budget, measure);
    result.measurements = found.measurements;

    std::vector<TuneResult::Row> rows;
    for (const SearchResult::Probe& probe : found.probes) {
        if (probe.confirmed) {
            rows.push_back({probe.choice, confirmed.at(probe.choice), true});
        } else if (probe.cost) {
            rows.push_back({probe.choice, searched.at(probe.choice), false});
            for (auto& [name, error] : rows.back().measured.errors) error *= found.pictureFactor;
        }
    }
    if (found.best) {
        const Choice& choice = found.probes[static_cast<std::size_t>(*found.best)].choice;
        result.cheapest = TuneResult::Row{choice, confirmed.at(choice), true};
        result.met = !options.maxMilliseconds || milliseconds(result.cheapest->measured) <= *options.maxMilliseconds;
    }
    std::stable_sort(rows.begin(), rows.end(), [&](const TuneResult::Row& a, const TuneResult::Row& b) {
        return milliseconds(a.measured) < milliseconds(b.measured);
    });
    const auto errorOf = [&](const TuneResult::Row& row) { return row.measured.errors.at(options.metric); };
    double least = std::numeric_limits<double>::infinity();
    for (TuneResult::Row& row : rows) {
        const double error = errorOf(row);
        // Single times of what was not confirmed may look better than the choice.
        const bool chosen = result.cheapest && row.choice == result.cheapest->choice;
        if (error < least || chosen) result.front.push_back(std::move(row));
        least = std::min(least, error);
    }
    return result;
}

json presetOf(const Settings& settings) {
    json tree = toJson(settings);
    for (const char* group : {"output", "reference", "device"}) tree.erase(group);
    return tree;
}

}  // namespace voxcone
