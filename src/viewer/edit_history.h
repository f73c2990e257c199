// What was moved by hand in the window, and the way back. Plain data, no window.
#pragma once

#include <cstddef>
#include <map>
#include <vector>

#include "scene/placement.h"

namespace voxcone {

/// The scene as it was changed by hand.
struct Edits {
    std::vector<Light> lights;        ///< SceneFacts::outline's, changed
    std::map<int, Placement> placed;  ///< by index in Scene::nodes: what was put elsewhere
    bool operator==(const Edits&) const = default;
};

/// Undo and redo of edits. Steps know how many of the settings' steps came before, so that both can be taken back in
/// turn.
class EditHistory {
  public:
    const Edits& now() const { return now_; }
    /// Begins anew: there is nothing to undo.
    void begin(Edits edits);
    /// A step, if anything has changed. `settingsSteps`: SettingsHistory::steps().
    void commit(const Edits& edits, std::size_t settingsSteps);
    /// Changes without a step: lights that were extracted anew.
    void replace(Edits edits) { now_ = std::move(edits); }

    /// Whether the last step, or the one that comes again, is one of these and not of the settings.
    bool canUndo(std::size_t settingsSteps) const {
        return !past_.empty() && past_.back().settingsSteps >= settingsSteps;
    }
    bool canRedo(std::size_t settingsSteps) const {
        return !future_.empty() && future_.back().settingsSteps <= settingsSteps;
    }
    void undo();
    void redo();

  private:
    struct Step {
        Edits edits;
        std::size_t settingsSteps;
    };
    static constexpr std::size_t kMost = 200;

    Edits now_;
    std::vector<Step> past_, future_;
};

}  // namespace voxcone
