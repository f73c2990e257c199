// The path tracer beside the window: passes of few samples until it is told to stop, the mean so far at any time.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "reference/path_tracer.h"

namespace voxcone {

/// Means over all passes so far.
struct TracedPicture {
    Image beauty, direct, indirectDiffuse, indirectSpecular, transmission, emission;  ///< linear radiance, not exposed
    /// Standard error of the mean of beauty over its mean, over the picture; 0 with fewer than two passes.
    double error = 0;
    int passes = 0;
    int samples = 0;  ///< a pixel
};

class BackgroundTracer {
  public:
    /// Begins at once. `scene` is its own copy, as it is at `time`. Passes differ in their seeds, which follow
    /// settings.reference.seed; each has `passSamples` paths a pixel. Ends after settings.reference.samples of them.
    /// `wake` is called after each pass, from the tracer's thread.
    BackgroundTracer(std::shared_ptr<const Scene> scene, double time, const Camera& worldCamera,
                     const Settings& settings, int passSamples, std::function<void()> wake);
    /// Waits for the pass that is under way.
    ~BackgroundTracer();
    BackgroundTracer(const BackgroundTracer&) = delete;
    BackgroundTracer& operator=(const BackgroundTracer&) = delete;

    /// Null before the first pass.
    std::shared_ptr<const TracedPicture> picture() const;
    bool running() const { return running_; }
    /// Ends it after the pass that is under way; does not wait.
    void stop() { quit_ = true; }

  private:
    void run(const Scene& scene, double time, const Camera& camera, Settings settings, int passSamples);

    std::function<void()> wake_;
    std::atomic<bool> quit_{false}, running_{true};
    mutable std::mutex mutex_;
    std::shared_ptr<const TracedPicture> picture_;
    std::thread thread_;
};

/// The camera that sees one pixel of `camera`'s picture alone; (0, 0) is the upper left one.
Camera pixelCamera(const Camera& camera, int width, int height, int x, int y);

}  // namespace voxcone
