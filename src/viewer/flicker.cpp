#include "viewer/flicker.h"

#include <cmath>
#include <limits>

namespace voxcone {
namespace {

Image unknown(const Image& like) {
    Image out(like.width, like.height, 1);
    for (float& v : out.data) v = std::numeric_limits<float>::quiet_NaN();
    return out;
}

}  // namespace

FlickerPicture FlickerTrail::add(const std::shared_ptr<const WatchedFrame>& now) {
    if (last_ && last_->what != now->what) clear();
    const Image& position = now->frame.position;
    std::shared_ptr<const WatchedFrame>& before = before_[{position.width, position.height}];
    FlickerPicture out;
    const auto carry = [&](const Image& values) {
        return last_ ? carried(values, last_->frame, now->frame) : unknown(position);
    };
    out.held = carry(latest_.held);
    const bool compared = before || now->what == Watched::seam;
    out.known = compared || latest_.known;
    if (now->what == Watched::seam) {
        out.change = now->seam;
    } else if (before) {
        ChangeMap map = changeMap(before->frame, now->frame);
        out.change = std::move(map.change);
        out.figures = map.figures;
    } else {
        out.change = carry(latest_.change);
    }
    for (std::size_t i = 0; compared && i < out.held.data.size(); ++i) {
        float& held = out.held.data[i];
        const float change = out.change.data[i];
        if (std::isnan(held) || std::abs(change) > std::abs(held)) held = change;
    }
    before = last_ = now;
    latest_ = out;
    return out;
}

void FlickerTrail::clear() {
    before_.clear();
    last_.reset();
    latest_ = {};
}

void Flicker::take(const std::shared_ptr<const WatchedFrame>& frame) {
    if (worker_.waiting() >= kMostWaiting) {
        ++leftOut_;
        return;
    }
    worker_.post([this, trail = trail_, frame]() -> Worker::Result {
        auto picture = std::make_shared<const FlickerPicture>(trail->add(frame));
        return [this, trail, picture] {
            if (trail != trail_) return;  // cleared meanwhile
            latest_ = picture;
            fresh_ = true;
        };
    });
}

void Flicker::clear() {
    trail_ = std::make_shared<FlickerTrail>();
    latest_.reset();
    leftOut_ = 0;
}

bool Flicker::update() {
    worker_.take();
    return std::exchange(fresh_, false);
}

std::shared_ptr<const Image> Flicker::shown() const {
    if (watched == Watched::none || !latest_ || !latest_->known) return nullptr;
    return {latest_, hold ? &latest_->held : &latest_->change};
}

}  // namespace voxcone
