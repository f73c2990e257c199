// A suite's measurements, from nothing or from where a run before was stopped, to the files of a report.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "report/suite.h"

namespace voxcone {

struct ReportOptions {
    std::filesystem::path suite, out;
    std::filesystem::path references;  ///< where references are kept; empty = out/references
    std::optional<Shard> shard;
    std::map<std::string, std::filesystem::path> scenes;  ///< loadSuite
    std::string command;                                  ///< as it was typed, for the report
};

/// What a report is made of and what became of it.
struct ReportResult {
    std::vector<std::filesystem::path> files;  ///< report.json, report.csv, index.html
    std::vector<std::string> failures;         ///< "view, configuration: reason"
    int missing = 0;                           ///< rows that nothing has measured
};

/// Measures what is not measured yet, each configuration of a view in turn so that all meet the same drift of the
/// machine, and writes out/report.json, report.csv, index.html and images/. References lie in options.references,
/// single measurements in out/measurements/: a run that was stopped goes on from there, and one that was finished
/// renders nothing and leaves the same bytes. A configuration that cannot be rendered becomes a row with the reason.
/// Throws InputError for the suite and for files that cannot be written, DeviceError without an OpenGL context.
ReportResult runReport(const ReportOptions& options);

/// Joins the reports of `parts` (folders), which must be of one suite, into one in `out`, with their pictures. A row
/// that several have is taken from the first.
ReportResult mergeReports(const std::vector<std::filesystem::path>& parts, const std::filesystem::path& out,
                          const std::string& command);

}  // namespace voxcone
