// Messages go to standard error, results to standard output.
#pragma once

#include <fmt/format.h>

#include <string>

namespace voxcone::log {

void message(const char* prefix, const std::string& text);

/// One line of information, e.g. "wrote out/cornell/beauty.0000.png".
template <class... Args>
void info(fmt::format_string<Args...> format, Args&&... args) {
    message("", fmt::format(format, std::forward<Args>(args)...));
}

/// Something the user should know but that does not stop the work.
template <class... Args>
void warn(fmt::format_string<Args...> format, Args&&... args) {
    message("warning: ", fmt::format(format, std::forward<Args>(args)...));
}

}  // namespace voxcone::log
