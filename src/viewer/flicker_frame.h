// What the flicker view needs of a picture.
#pragma once

#include <cstdint>
#include <memory>

#include "metric/temporal.h"
#include "scene/scene.h"

namespace voxcone {

class Renderer;

/// What is watched for changes from picture to picture.
enum class Watched : int {
    none,
    indirect,  ///< indirect diffuse light over albedo
    beauty,
    seam,  ///< the channel `seam` itself: where levels differ, not what has changed
};

struct WatchedFrame {
    Watched what = Watched::none;
    std::uint64_t view = 0;  ///< serial of the view; stages of one view share it
    /// Of Watched::beauty, the beauty stands where indirect diffuse light does, and the albedo is 1.
    TemporalFrame frame;
    Image seam;  ///< of Watched::seam, else empty
};

/// Reads it from the last frame of `renderer`, which was not abandoned.
std::shared_ptr<const WatchedFrame> watchedFrame(Renderer& renderer, Watched what, const Camera& camera,
                                                 std::uint64_t view);

}  // namespace voxcone
