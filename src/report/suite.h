// A suite: what a report measures, as JSON (docs/reports.md).
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "capture/script.h"

namespace voxcone {

/// One picture that every configuration is measured on.
struct SuiteView {
    std::string id;     ///< "scene/shot", with "@frame" behind it for other frames than the shot's first
    std::string scene;  ///< name in the suite
    const CaptureScript* script = nullptr;
    std::string file;  ///< script or glTF, as the suite names it
    Shot shot;
    int frame = 0;
    Settings::Reference reference;
    nlohmann::json settings = nlohmann::json::object();  ///< for all configurations on this view
    std::string path;                                    ///< JSON path of `settings`, for messages
};

/// One way to light a picture.
struct SuiteConfiguration {
    std::string id;
    std::string preset;                             ///< empty: that of the script
    nlohmann::json set = nlohmann::json::object();  ///< what it changes, by dotted keys
    bool multiplyAo = false;                        ///< Trial::picture
    std::vector<std::string> scenes;                ///< that it is measured on; empty = all
    std::string path;                               ///< JSON path, for messages
};

struct Suite {
    std::filesystem::path file;
    std::string name;
    std::string hash;  ///< of the suite's text, of its scripts' and of the list of views: parts of one report agree
    int warmUp = 1;    ///< frames before the first repeat
    int repeats = 3;
    std::uint64_t memoryBytes = 0;  ///< of renderers that are kept at a time
    std::vector<std::string> channels;
    nlohmann::json settings = nlohmann::json::object();  ///< for all configurations
    std::vector<std::unique_ptr<CaptureScript>> scripts;
    std::vector<SuiteView> views;
    std::vector<SuiteConfiguration> configurations;

    bool measures(const SuiteView& view, const SuiteConfiguration& configuration) const;

    /// The script's settings; the preset; what the suite, the view and the configuration change, in this order.
    Settings settingsOf(const SuiteView& view, const SuiteConfiguration& configuration) const;
};

/// Reads a suite with all of its scripts and scenes. `scenes`: glTF files to take instead of those that the scripts of
/// the scenes of these names say. Scenes that are optional and missing are left out with a message. Unknown keys, wrong
/// types, settings out of range and names that stand twice are InputErrors with file and JSON path; a name in `scenes`
/// that is no scene of the suite is a UsageError.
Suite loadSuite(const std::filesystem::path& file, const std::map<std::string, std::filesystem::path>& scenes = {});

/// The part of a suite that one of several machines measures.
struct Shard {
    int part = 1, parts = 1;  ///< 1 to parts
};

/// One view by one configuration, by their places in the suite.
struct SuiteRow {
    std::size_t view = 0, configuration = 0;
    bool operator==(const SuiteRow&) const = default;
};

/// All rows, by view.
std::vector<SuiteRow> rowsOf(const Suite& suite);

/// Those of a shard: whole views where there are as many as parts, so that configurations of a view are measured by
/// turns on one machine; else runs of rows in order. Every row is in exactly one part.
std::vector<SuiteRow> rowsOf(const Suite& suite, const Shard& shard);

}  // namespace voxcone
