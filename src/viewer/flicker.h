// The change of light from one picture to the next, on the surfaces that both show, and the largest that was seen.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <utility>

#include "viewer/flicker_frame.h"
#include "viewer/worker.h"

namespace voxcone {

/// One channel each, signed: shares of the whole picture's mean light (ChangeMap), or what the channel `seam` holds. 0
/// on the background, NaN on surfaces that were not seen before.
struct FlickerPicture {
    Image change;  ///< the last that is known of a surface
    Image held;    ///< by surface, the one of the largest magnitude since clear()
    /// Of this picture; without valid pixels for `seam`, and where there was no picture of this size before.
    TemporalChange figures;
    bool known = false;  ///< some picture since clear() could be compared
};

/// Follows the pictures one by one. Each is compared with the last one of the same size, so that neither stages of
/// refinement nor other resolutions count as change. What is held keeps the resolution of the largest pictures: changes
/// in smaller ones go into it only if their view was given up before it had that size.
class FlickerTrail {
  public:
    FlickerPicture add(const std::shared_ptr<const WatchedFrame>& now);
    /// Forgets all pictures.
    void clear() { *this = {}; }

  private:
    /// Values by surface, and the picture that they lie on.
    struct Layer {
        Image values;
        std::shared_ptr<const WatchedFrame> on;
        Image at(const WatchedFrame& now) const;
    };
    std::map<std::pair<int, int>, std::shared_ptr<const WatchedFrame>> before_;  ///< by size
    Layer latest_;                                                               ///< the last change
    Layer held_;                                                                 ///< of pictures of the largest size
    Layer small_;                                                                ///< of smaller ones since then
    Layer stage_;  ///< of the stages of a view that may still become as large as held_
    bool known_ = false;
};

/// The window's side of it: pictures go to a thread, results come back.
class Flicker {
  public:
    explicit Flicker(std::function<void()> wake) : worker_(std::move(wake)) {}

    Watched watched = Watched::none;
    double exaggeration = 10;
    bool hold = true;  ///< show the largest change instead of the last one

    /// A picture of what is watched. When more than a few wait, it is left out.
    void take(const std::shared_ptr<const WatchedFrame>& frame);
    /// Forgets all pictures, and those that are still to be compared.
    void clear();
    /// Takes results. True when there is a new one.
    bool update();
    bool idle() const { return worker_.idle(); }

    /// Null before the first.
    const std::shared_ptr<const FlickerPicture>& latest() const { return latest_; }
    /// The one to be shown; empty when there is none.
    std::shared_ptr<const Image> shown() const;
    int leftOut() const { return leftOut_; }  ///< pictures, since clear()

  private:
    static constexpr std::size_t kMostWaiting = 4;

    std::shared_ptr<FlickerTrail> trail_ = std::make_shared<FlickerTrail>();  ///< of the worker alone
    std::shared_ptr<const FlickerPicture> latest_;
    bool fresh_ = false;
    int leftOut_ = 0;
    Worker worker_;  ///< last: it ends before what it works on
};

}  // namespace voxcone
