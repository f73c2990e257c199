// A progress line with the time left, on a terminal only; silent in a pipe.
#pragma once

#include <chrono>
#include <string>

namespace voxcone {

class Progress {
  public:
    /// `what` names the work, e.g. "reference cornell".
    explicit Progress(std::string what);
    ~Progress();
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;

    /// `fraction` of the work that is done, 0 to 1. Cheap to call often: draws at most ten times a second.
    void update(double fraction);

  private:
    using Clock = std::chrono::steady_clock;
    std::string what_;
    Clock::time_point start_ = Clock::now();
    Clock::time_point lastDrawn_{};
    bool terminal_ = false;
    bool drawn_ = false;
};

}  // namespace voxcone
