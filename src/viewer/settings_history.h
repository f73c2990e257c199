// Settings that are being edited: what was changed, and the way back. Plain data, no window.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/settings.h"

namespace voxcone {

/// Whether all fields are equal.
bool sameSettings(const Settings& a, const Settings& b);

/// Numbers of steps, of all histories together, so that they can be taken back in turn; rising from 1.
std::uint64_t newStep();
constexpr std::uint64_t kNoStep = 0;

/// Undo and redo. A drag of one control is one step, however many values it passes.
class SettingsHistory {
  public:
    explicit SettingsHistory(const Settings& settings = {}) : now_(settings), reset_(settings) {}

    const Settings& now() const { return now_; }
    /// What controls are reset to and marked as changed against.
    const Settings& base() const { return reset_; }

    /// Begins anew: there is nothing to undo, and `settings` are what is reset to.
    void begin(const Settings& settings);
    /// A change. `what` names it ("cone.gain", "preset fast"); while the same thing is `held`, changes are one step.
    void change(const Settings& settings, const std::string& what, bool held = false);
    /// Ends a held change.
    void release() { held_ = false; }
    /// Changes without a step: sizes that follow the window.
    void replace(const Settings& settings) { now_ = settings; }

    bool canUndo() const { return !past_.empty(); }
    bool canRedo() const { return !future_.empty(); }
    /// Numbers of the steps that undo and redo would take.
    std::uint64_t lastStep() const { return past_.empty() ? kNoStep : past_.back().number; }
    std::uint64_t comingStep() const { return future_.empty() ? kNoStep : future_.back().number; }
    /// What the next undo or redo takes back or brings again.
    const std::string& undoName() const { return past_.back().what; }
    const std::string& redoName() const { return future_.back().what; }
    void undo();
    void redo();

  private:
    /// `settings` before the step `what`, or after it among what can be redone.
    struct Step {
        Settings settings;
        std::string what;
        std::uint64_t number;
    };
    static constexpr std::size_t kMost = 200;

    Settings now_, reset_;
    std::vector<Step> past_, future_;
    bool held_ = false;
};

/// Index of the field in fields().
std::optional<std::size_t> fieldIndex(const std::string& key);
/// Whether a field differs between two trees.
bool fieldDiffers(const Settings& a, const Settings& b, std::size_t field);
/// Copies one field.
void copyField(const Settings& from, Settings& to, std::size_t field);

}  // namespace voxcone
