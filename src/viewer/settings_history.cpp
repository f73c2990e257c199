#include "viewer/settings_history.h"

#include <atomic>

#include "core/check.h"

namespace voxcone {
namespace {

/// The value of a field as a number.
double valueOf(const Field& field) {
    if (const auto* b = std::get_if<bool*>(&field.value)) return **b ? 1 : 0;
    if (const auto* i = std::get_if<int*>(&field.value)) return **i;
    if (const auto* d = std::get_if<double*>(&field.value)) return **d;
    return std::get<Field::Choice>(field.value).get();
}

}  // namespace

bool sameSettings(const Settings& a, const Settings& b) {
    Settings x = a, y = b;
    const auto p = fields(x), q = fields(y);
    for (std::size_t i = 0; i < p.size(); ++i)
        if (valueOf(p[i]) != valueOf(q[i])) return false;
    return true;
}

std::uint64_t newStep() {
    static std::atomic<std::uint64_t> steps{0};
    return ++steps;
}

void SettingsHistory::begin(const Settings& settings) {
    *this = SettingsHistory(settings);
}

void SettingsHistory::change(const Settings& settings, const std::string& what, bool held) {
    if (sameSettings(settings, now_)) return;
    const bool sameStep = held_ && held && !past_.empty() && past_.back().what == what;
    if (!sameStep) past_.push_back({now_, what, newStep()});
    if (past_.size() > kMost) past_.erase(past_.begin());
    future_.clear();
    now_ = settings;
    held_ = held;
}

void SettingsHistory::undo() {
    VOXCONE_CHECK(canUndo(), "nothing to undo");
    Step step = std::move(past_.back());
    past_.pop_back();
    future_.push_back({now_, step.what, step.number});
    now_ = step.settings;
    held_ = false;
}

void SettingsHistory::redo() {
    VOXCONE_CHECK(canRedo(), "nothing to redo");
    Step step = std::move(future_.back());
    future_.pop_back();
    past_.push_back({now_, step.what, step.number});
    now_ = step.settings;
    held_ = false;
}

std::optional<std::size_t> fieldIndex(const std::string& key) {
    Settings settings;
    const auto all = fields(settings);
    for (std::size_t i = 0; i < all.size(); ++i)
        if (all[i].key == key) return i;
    return std::nullopt;
}

bool fieldDiffers(const Settings& a, const Settings& b, std::size_t field) {
    Settings x = a, y = b;
    return valueOf(fields(x)[field]) != valueOf(fields(y)[field]);
}

void copyField(const Settings& from, Settings& to, std::size_t field) {
    Settings source = from;
    const Field a = fields(source)[field], b = fields(to)[field];
    if (const auto* flag = std::get_if<bool*>(&a.value)) {
        *std::get<bool*>(b.value) = **flag;
    } else if (const auto* integer = std::get_if<int*>(&a.value)) {
        *std::get<int*>(b.value) = **integer;
    } else if (const auto* number = std::get_if<double*>(&a.value)) {
        *std::get<double*>(b.value) = **number;
    } else {
        std::get<Field::Choice>(b.value).set(std::get<Field::Choice>(a.value).get());
    }
}

}  // namespace voxcone
