#include "report/results.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/atomic_file.h"
#include "core/error.h"
#include "core/log.h"
#include "report/page.h"

namespace voxcone {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

std::string quoted(const std::string& text) {
    if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
    std::string out = "\"";
    for (const char c : text) out += c == '"' ? "\"\"" : std::string(1, c);
    return out + "\"";
}

std::string cell(const json* value) {
    if (value == nullptr || value->is_null()) return "";
    return quoted(value->is_string() ? value->get<std::string>() : value->dump());
}

/// What lies at `keys` below `tree`; null where there is nothing.
const json* at(const json& tree, const std::vector<std::string>& keys) {
    const json* here = &tree;
    for (const std::string& key : keys) {
        if (!here->is_object() || !here->contains(key)) return nullptr;
        here = &here->at(key);
    }
    return here;
}

/// Adds `name` to `names` unless it is there.
void addName(std::vector<std::string>& names, const std::string& name) {
    if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
}

const json* passOf(const json& row, const std::string& name) {
    const json* passes = at(row, {"passes"});
    if (passes == nullptr) return nullptr;
    for (const json& pass : *passes)
        if (pass.at("name") == name) return &pass;
    return nullptr;
}

/// Files that `images` of a view's reference or of a row name.
void copyImages(const json& images, const fs::path& from, const fs::path& to) {
    for (const json& name : images) {
        const fs::path source = from / name.get<std::string>(), target = to / name.get<std::string>();
        std::error_code same;
        if (!fs::exists(source) || fs::equivalent(source, target, same)) continue;
        writeTextFile(target, readTextFile(source));
    }
}

void copyImagesOf(const json& holder, const fs::path& from, const fs::path& to) {
    if (const json* images = at(holder, {"images"})) copyImages(*images, from, to);
    if (const json* images = at(holder, {"reference", "images"})) copyImages(*images, from, to);
}

}  // namespace

json readJsonFile(const fs::path& file) {
    json tree = json::parse(readTextFile(file), nullptr, false);
    if (tree.is_discarded()) throw InputError(file.string(), "", "is no file of this program; delete it");
    return tree;
}

std::string csvOf(const json& report) {
    std::vector<std::string> channels, metrics, passes;
    for (const json& row : report.at("rows")) {
        if (const json* errors = at(row, {"errors"})) {
            for (const auto& [channel, values] : errors->items()) {
                addName(channels, channel);
                for (const auto& [metric, value] : values.items()) addName(metrics, metric);
            }
        }
        if (const json* list = at(row, {"passes"}))
            for (const json& pass : *list) addName(passes, pass.at("name"));
    }
    std::string out = "view,configuration,status,reason";
    for (const char* frame : {"first", "steady"})
        for (const char* part : {"median", "p10", "p90"}) out += fmt::format(",{}_ms_{}", frame, part);
    out += ",memory_bytes,samples_per_pixel,voxels";
    for (const std::string& channel : channels)
        for (const std::string& metric : metrics) out += "," + quoted(channel + "." + metric);
    for (const char* frame : {"first", "steady"})
        for (const std::string& pass : passes) out += "," + quoted(fmt::format("{}_ms: {}", frame, pass));
    out += "\n";
    for (const json& row : report.at("rows")) {
        std::string line;
        const auto add = [&](const json* value) { line += (line.empty() ? "" : ",") + cell(value); };
        for (const char* key : {"view", "configuration", "status", "reason"}) add(at(row, {key}));
        for (const char* frame : {"first", "steady"})
            for (const char* part : {"median", "p10", "p90"}) add(at(row, {"ms", frame, part}));
        for (const char* key : {"memory_bytes", "samples_per_pixel", "voxels"}) add(at(row, {key}));
        for (const std::string& channel : channels)
            for (const std::string& metric : metrics) add(at(row, {"errors", channel, metric}));
        for (const char* frame : {"first", "steady"}) {
            for (const std::string& name : passes) {
                const json* pass = passOf(row, name);
                add(pass == nullptr ? nullptr : at(*pass, {frame, "median"}));
            }
        }
        out += line + "\n";
    }
    return out;
}

ReportResult writeReport(const json& report, const fs::path& out) {
    ReportResult result;
    const auto write = [&](const char* name, const std::string& text) {
        result.files.push_back(out / name);
        if (!fs::exists(result.files.back()) || readTextFile(result.files.back()) != text)
            writeTextFile(result.files.back(), text);
    };
    write("report.json", report.dump(1) + "\n");
    write("report.csv", csvOf(report));
    write("index.html", makePage(report, out));
    for (const json& row : report.at("rows")) {
        if (row.at("status") == "failed")
            result.failures.push_back(fmt::format("{}, {}: {}", row.at("view").get<std::string>(),
                                                  row.at("configuration").get<std::string>(),
                                                  row.at("reason").get<std::string>()));
        result.missing += row.at("status") == "missing" ? 1 : 0;
    }
    return result;
}

ReportResult mergeReports(const std::vector<fs::path>& parts, const fs::path& out, const std::string& command) {
    json merged;
    json devices = json::array();
    for (const fs::path& part : parts) {
        const fs::path file = part / "report.json";
        const json report = readJsonFile(file);
        if (at(report, {"suite", "hash"}) == nullptr || !report.contains("rows") ||
            report.value("voxcone_report", 0) != 1)
            throw InputError(file.string(), "", "is no report of this program");
        for (const json& view : report.at("views")) copyImagesOf(view, part, out);
        for (const json& row : report.at("rows")) copyImagesOf(row, part, out);
        json made = json::object();
        for (const char* key : {"build", "device", "machine"}) made[key] = report.at(key);
        if (std::find(devices.begin(), devices.end(), made) == devices.end()) devices.push_back(made);
        if (merged.is_null()) {
            merged = report;
            merged["command"] = command;
            continue;
        }
        if (report.at("suite").at("hash") != merged.at("suite").at("hash"))
            throw InputError(file.string(), "suite",
                             fmt::format("is another suite than that of {}", parts.front().string()));
        json &times = merged["times_made"], &rows = merged["rows"], &views = merged["views"];
        const json& otherTimes = report.at("times_made");
        times["started"] = std::min(times.at("started"), otherTimes.at("started"));
        times["finished"] = std::max(times.at("finished"), otherTimes.at("finished"));
        if (report.at("rows").size() != rows.size() || report.at("views").size() != views.size())
            throw InputError(file.string(), "rows", "are not those of the other parts");
        for (std::size_t i = 0; i < rows.size(); ++i)
            if (rows[i].at("status") == "missing") rows[i] = report.at("rows")[i];
        for (std::size_t i = 0; i < views.size(); ++i) {
            const json& view = report.at("views")[i];
            if (!views[i].contains("reference") && view.contains("reference"))
                views[i]["reference"] = view.at("reference");
        }
    }
    // Times of different machines stand side by side: the page says so.
    if (devices.size() > 1) {
        merged["devices"] = devices;
        log::warn("the parts were measured by {} different builds, devices or machines", devices.size());
    }
    return writeReport(merged, out);
}

}  // namespace voxcone
