// Views of the window as a capture script, which renders them again without one.
#pragma once

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "capture/script.h"
#include "scene/placement.h"

namespace voxcone {

/// A view that was saved, or a camera path that was recorded.
struct SavedView {
    std::string name;  ///< letters, digits, '_', '-' and '.'
    std::string channel = "beauty";
    Camera camera;    ///< world space; `up` as it was set, not yet turned to the view
    double time = 0;  ///< of the scene, seconds
    CameraPath path;  ///< where not empty: times from 0 on, added to `time`
    double fps = 24;  ///< of a path
    /// Frames of a path: one at each 1/fps from its first key to its last.
    int frames() const;
};

/// What a script written for a scene begins with.
struct ScriptSource {
    std::filesystem::path file;         ///< scene or script that was opened
    std::filesystem::path environment;  ///< image that replaced its environment, or empty
    const Scene* outline = nullptr;     ///< SceneFacts::outline
};

/// The script: everything that the opened file says about the scene, with absolute paths, `lights` as they were changed
/// and nodes where they were `placed` (by index in the outline's nodes), `settings`, and one shot a view.
nlohmann::json captureScript(const ScriptSource& source, const std::vector<Light>& lights,
                             const std::map<int, Placement>& placed, const Settings& settings,
                             const std::vector<SavedView>& views);

}  // namespace voxcone
