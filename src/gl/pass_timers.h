// Time of every pass of a frame, under the name of its debug group.
#pragma once

#include <chrono>
#include <deque>
#include <map>
#include <string>
#include <vector>

#include "gl/context.h"
#include "gl/handle.h"

namespace voxcone::gl {

enum class TimerMode : int {
    query,  ///< two timestamp queries a pass, read frames later without waiting: for hardware
    finish  ///< glFinish and a clock: for software rasterisers, where timer queries lie
};

/// `finish` on a software rasteriser, else `query`.
TimerMode suitableTimerMode(const DeviceInfo& info);

struct PassTime {
    std::string name;
    double milliseconds = 0;
};

/// Passes do not nest. A pass of the same name twice in a frame gives one entry with the sum, where it first ran.
/// Outside beginFrame/endFrame a pass is a debug group only.
class PassTimers {
  public:
    explicit PassTimers(TimerMode mode) : mode_(mode) {}

    class Scope {
      public:
        ~Scope();
        Scope(const Scope&) = delete;
        Scope& operator=(const Scope&) = delete;

      private:
        friend class PassTimers;
        Scope(PassTimers& timers, const std::string& name);
        PassTimers& timers_;
    };

    void beginFrame();
    void endFrame();
    [[nodiscard]] Scope pass(const std::string& name) { return Scope(*this, name); }

    /// Passes from now on belong to `label` (a level of the clipmap) as well; −1, as at the frame's begin: to none.
    void label(int label) { label_ = label; }

    /// Waits for all frames that were ended and takes their times.
    void wait();

    /// Times of the last frame whose figures have arrived (mode finish: the last ended frame), in order of first run.
    const std::vector<PassTime>& results() const { return results_; }
    /// Milliseconds of that frame's passes by label.
    const std::map<int, double>& byLabel() const { return byLabel_; }
    /// From beginFrame to endFrame of that frame.
    double frameMilliseconds() const { return frameMilliseconds_; }
    TimerMode mode() const { return mode_; }
    const char* modeName() const { return mode_ == TimerMode::query ? "query" : "finish"; }

  private:
    using Clock = std::chrono::steady_clock;
    struct DeleteQuery {
        void operator()(GLuint id) const { glDeleteQueries(1, &id); }
    };
    using Query = Handle<DeleteQuery>;
    struct Mark {
        std::string name;
        Query begin, end;         ///< mode query
        double milliseconds = 0;  ///< mode finish
        int label = -1;
    };
    struct Frame {
        Mark total;
        std::vector<Mark> passes;
    };

    static Query stamp();
    void collect(bool block);

    TimerMode mode_;
    bool inFrame_ = false, inPass_ = false;
    Frame current_;
    Clock::time_point passStart_, frameStart_;
    std::deque<Frame> pending_;
    std::vector<PassTime> results_;
    std::map<int, double> byLabel_;
    int label_ = -1;
    double frameMilliseconds_ = 0;
};

}  // namespace voxcone::gl
