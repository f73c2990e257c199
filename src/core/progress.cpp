#include "core/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>

namespace voxcone {

Progress::Progress(std::string what) : what_(std::move(what)), terminal_(isatty(STDERR_FILENO) == 1) {}

Progress::~Progress() {
    if (drawn_) std::fputs("\r\033[K", stderr);
}

void Progress::update(double fraction) {
    if (!terminal_) return;
    const auto now = Clock::now();
    if (drawn_ && now - lastDrawn_ < std::chrono::milliseconds(100)) return;
    lastDrawn_ = now;
    drawn_ = true;
    fraction = std::clamp(fraction, 0.0, 1.0);
    const double elapsed = std::chrono::duration<double>(now - start_).count();
    const double left = fraction > 0 ? elapsed * (1 - fraction) / fraction : 0;
    std::fputs(fmt::format("\r\033[K{} {:3.0f} %, {:.0f} s left", what_, 100 * fraction, left).c_str(), stderr);
}

}  // namespace voxcone
