// The files of a report, from the tree that is report.json.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "report/report.h"

namespace voxcone {

/// A line for every row of `report` below a line of names: times, memory, samples, errors by channel and metric, and
/// the median of every pass. Fields with commas, quotes or line breaks are quoted (RFC 4180); what a row lacks is
/// empty.
std::string csvOf(const nlohmann::json& report);

/// Writes report.json, report.csv and index.html, each whole and only where it is not the same already, and says what
/// failed or is missing.
ReportResult writeReport(const nlohmann::json& report, const std::filesystem::path& out);

/// Parses a file that this program wrote. Throws InputError that names it.
nlohmann::json readJsonFile(const std::filesystem::path& file);

}  // namespace voxcone
