// The parts of the page, compiled in by cmake/EmbedPage.cmake.
#pragma once

#include <string_view>

namespace voxcone {

std::string_view embeddedPageHtml();
std::string_view embeddedPageCss();
std::string_view embeddedPageJs();

}  // namespace voxcone
