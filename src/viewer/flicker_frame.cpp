#include "viewer/flicker_frame.h"

#include <algorithm>

#include "capture/capture.h"
#include "frame/renderer.h"

namespace voxcone {

std::shared_ptr<const WatchedFrame> watchedFrame(Renderer& renderer, Watched what, const Camera& camera,
                                                 std::uint64_t view) {
    auto out = std::make_shared<WatchedFrame>();
    out->what = what;
    out->view = view;
    out->frame = temporalFrame(renderer, camera);
    if (what == Watched::seam) out->seam = renderer.channel("seam");
    if (what == Watched::beauty) {
        out->frame.indirectDiffuse = renderer.channel("beauty");
        std::fill(out->frame.albedo.data.begin(), out->frame.albedo.data.end(), 1.0f);
    }
    return out;
}

}  // namespace voxcone
