#include "viewer/flicker.h"

#include <cmath>
#include <limits>

namespace voxcone {
namespace {

/// Takes over what is larger in magnitude, and what is not known yet.
void merge(Image& into, const Image& from) {
    for (std::size_t i = 0; i < into.data.size(); ++i) {
        float& value = into.data[i];
        if (std::isnan(value) || std::abs(from.data[i]) > std::abs(value)) value = from.data[i];
    }
}

}  // namespace

Image FlickerTrail::Layer::at(const WatchedFrame& now) const {
    if (on) return carried(values, on->frame, now.frame);
    Image none(now.frame.position.width, now.frame.position.height, 1);
    for (float& v : none.data) v = std::numeric_limits<float>::quiet_NaN();
    return none;
}

FlickerPicture FlickerTrail::add(const std::shared_ptr<const WatchedFrame>& now) {
    if (latest_.on && latest_.on->what != now->what) clear();
    const Image& position = now->frame.position;
    std::shared_ptr<const WatchedFrame>& before = before_[{position.width, position.height}];
    const bool compared = before || now->what == Watched::seam;
    FlickerPicture out;
    if (now->what == Watched::seam) {
        out.change = now->seam;
    } else if (before) {
        ChangeMap map = changeMap(before->frame, now->frame);
        out.change = std::move(map.change);
        out.figures = map.figures;
    } else {
        out.change = latest_.at(*now);
    }
    before = now;
    latest_ = {out.change, now};

    // The view of these stages was given up: nothing finer will say it better.
    if (stage_.on && stage_.on->view != now->view) {
        Image sum = small_.at(*stage_.on);
        merge(sum, stage_.values);
        small_ = {std::move(sum), stage_.on};
        stage_ = {};
    }
    out.held = held_.at(*now);
    merge(out.held, small_.at(*now));
    if (compared) {
        merge(out.held, out.change);
    } else {
        merge(out.held, stage_.at(*now));
    }
    if (!held_.on || position.width >= held_.values.width) {
        held_ = {out.held, now};
        small_ = stage_ = {};
    } else if (compared) {
        stage_ = {out.change, now};
    }
    known_ = known_ || compared;
    out.known = known_;
    return out;
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
