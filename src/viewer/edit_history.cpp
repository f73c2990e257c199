#include "viewer/edit_history.h"

#include <utility>

#include "core/check.h"

namespace voxcone {

void EditHistory::begin(Edits edits) {
    now_ = std::move(edits);
    past_.clear();
    future_.clear();
}

void EditHistory::commit(const Edits& edits) {
    if (edits == now_) return;
    past_.push_back({std::exchange(now_, edits), newStep()});
    if (past_.size() > kMost) past_.erase(past_.begin());
    future_.clear();
}

void EditHistory::undo() {
    VOXCONE_CHECK(!past_.empty(), "nothing to undo");
    Step step = std::move(past_.back());
    past_.pop_back();
    future_.push_back({std::exchange(now_, std::move(step.edits)), step.number});
}

void EditHistory::redo() {
    VOXCONE_CHECK(!future_.empty(), "nothing to redo");
    Step step = std::move(future_.back());
    future_.pop_back();
    past_.push_back({std::exchange(now_, std::move(step.edits)), step.number});
}

}  // namespace voxcone
