// What was moved by hand in the window, and the way back. Plain data, no window.
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "scene/placement.h"
#include "viewer/settings_history.h"

namespace voxcone {

/// The scene as it was changed by hand.
struct Edits {
    std::vector<Light> lights;        ///< SceneFacts::outline's, changed
    std::map<int, Placement> placed;  ///< by index in Scene::nodes: what was put elsewhere
    bool operator==(const Edits&) const = default;
};

/// Undo and redo of edits. Steps are numbered together with those of the settings.
class EditHistory {
  public:
    const Edits& now() const { return now_; }
    /// Begins anew: there is nothing to undo.
    void begin(Edits edits);
    /// A step, if anything has changed.
    void commit(const Edits& edits);
    /// Changes without a step: lights that were extracted anew.
    void replace(Edits edits) { now_ = std::move(edits); }

    /// Whether the last step of all, or the first that comes again, is one of these and not of the settings.
    bool canUndo(const SettingsHistory& settings) const {
        return !past_.empty() && past_.back().number > settings.lastStep();
    }
    bool canRedo(const SettingsHistory& settings) const {
        const std::uint64_t other = settings.comingStep();
        return !future_.empty() && (other == kNoStep || future_.back().number < other);
    }
    void undo();
    void redo();

  private:
    struct Step {
        Edits edits;
        std::uint64_t number;
    };
    static constexpr std::size_t kMost = 200;

    Edits now_;
    std::vector<Step> past_, future_;
};

}  // namespace voxcone
