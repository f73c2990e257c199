#include "gl/pieces.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <chrono>

namespace voxcone::gl {

bool inPieces(int& next, int count, int& piece, const Stop& stop, const std::function<void(int first, int end)>& work) {
    constexpr double kSeconds = 0.02;
    using Clock = std::chrono::steady_clock;
    if (stop) glFinish();
    while (next < count) {
        const int size = stop ? std::min(piece, count - next) : count - next;
        const auto start = Clock::now();
        work(next, next + size);
        next += size;
        if (!stop) break;
        glFinish();
        const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
        // A small rest of the work says little of how much fits in.
        if (seconds > 1.5 * kSeconds) piece = std::max(size / 2, 1);
        if (seconds < 0.5 * kSeconds && size == piece && piece < (1 << 28)) piece *= 2;
        if (stop()) break;
    }
    return next == count;
}

}  // namespace voxcone::gl
