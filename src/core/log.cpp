#include "core/log.h"

#include <cstdio>

namespace voxcone::log {

void message(const char* prefix, const std::string& text) {
    // One call, so that lines of several threads do not mix.
    std::fputs(fmt::format("voxcone: {}{}\n", prefix, text).c_str(), stderr);
}

}  // namespace voxcone::log
