// The page of a report: speed against error, in one HTML file that needs nothing else.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

namespace voxcone {

/// The page of `report` (the content of report.json). Its pictures are read below `folder`, the report's own, and
/// embedded at most 320 pixels wide, less where there are many; those that are missing or unreadable are left out.
/// The same report and pictures give the same bytes. The page makes no request, and nothing in the report can run in
/// it: names may hold any text.
std::string makePage(const nlohmann::json& report, const std::filesystem::path& folder);

}  // namespace voxcone
