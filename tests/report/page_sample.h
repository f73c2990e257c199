// Made-up reports with pictures, for looking at the page and for testing it.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>

namespace voxcone {

/// Three views × twelve configurations in all: one row has failed, one is missing; pictures lie in `folder`.
nlohmann::json sampleReport(const std::filesystem::path& folder);

/// A report of one view without pictures; the first is "balanced".
nlohmann::json plainReport(int configurations);

}  // namespace voxcone
