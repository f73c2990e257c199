// voxcone report: speed against error of many settings, as JSON, CSV and one page.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <charconv>
#include <cstdio>
#include <memory>

#include "app/commands.h"
#include "core/error.h"
#include "core/log.h"
#include "report/report.h"

namespace voxcone {

namespace fs = std::filesystem;

namespace {

int wholeNumber(const std::string& text) {
    int value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    return error == std::errc() && end == text.data() + text.size() ? value : -1;
}

Shard parseShard(const std::string& text) {
    const auto slash = text.find('/');
    Shard shard;
    shard.part = wholeNumber(text.substr(0, slash));
    shard.parts = slash == std::string::npos ? -1 : wholeNumber(text.substr(slash + 1));
    if (shard.part < 1 || shard.parts < shard.part || shard.parts > 1000000)
        throw UsageError(fmt::format("--shard {}: expected K/N, 1 <= K <= N, e.g. 2/8", text));
    return shard;
}

/// An argument as a shell takes it.
std::string shellQuoted(const std::string& text) {
    const bool plain = !text.empty() && std::all_of(text.begin(), text.end(), [](unsigned char c) {
        return std::isalnum(c) || std::string_view("_-./=,:+@%").find(static_cast<char>(c)) != std::string_view::npos;
    });
    if (plain) return text;
    std::string out = "'";
    for (const char c : text) out += c == '\'' ? "'\\''" : std::string(1, c);
    return out + "'";
}

/// Files go to standard output, what is wrong with the rows to standard error. A row that failed is a finding.
int tell(const ReportResult& result) {
    for (const fs::path& file : result.files) std::puts(file.c_str());
    for (const std::string& failure : result.failures) log::info("failed: {}", failure);
    if (result.missing > 0) log::info("{} rows are missing: other parts measure them", result.missing);
    return static_cast<int>(ExitCode::done);
}

}  // namespace

Command reportCommand(CLI::App& app) {
    struct Options {
        std::vector<std::string> inputs, scenes;
        std::string out, shard, references;
    };
    const auto options = std::make_shared<Options>();
    CLI::App* parser =
        app.add_subcommand("report", "Speed against error of many settings, scenes and views, as one page");
    parser
        ->add_option("inputs", options->inputs,
                     "suite (docs/reports.md); or the word merge and the folders of a report's parts")
        ->type_name("SUITE.json | merge DIR...")
        ->required();
    parser
        ->add_option("--out", options->out,
                     "folder for report.json, report.csv, index.html, images/, and for what is needed to go on after a "
                     "stop: measurements/ and references/")
        ->type_name("DIR")
        ->required();
    parser->add_option("--shard", options->shard, "measure the K-th of N parts; `report merge` joins them")
        ->type_name("K/N");
    parser
        ->add_option("--references", options->references,
                     "folder that keeps path-traced references, by their content; several reports may share it "
                     "(default: DIR/references)")
        ->type_name("DIR");
    parser
        ->add_option("--scene", options->scenes,
                     "glTF of a scene of the suite, instead of the one that it names; may be repeated")
        ->type_name("NAME=FILE")
        ->allow_extra_args(false);
    parser->footer(
        "A report that was stopped goes on when the same command is given again; one that is finished renders "
        "nothing.\n"
        "Configurations that fail are listed on standard error and are rows with the reason; the exit status stays 0.\n"
        "To try them again, delete measurements/*/*/failed.json in the report's folder.");
    const std::string usage =
        "voxcone report SUITE.json --out DIR [--shard K/N] [--references DIR] [--scene NAME=FILE]… | voxcone report "
        "merge "
        "DIR… --out DIR";
    return {
        parser, usage, [options] {
            std::string command = "voxcone report";
            for (const std::string& input : options->inputs) command += " " + shellQuoted(input);
            command += " --out " + shellQuoted(options->out);
            const bool merge = options->inputs.front() == "merge";
            if (merge) {
                if (options->inputs.size() < 2) throw UsageError("report merge: which folders?");
                if (!options->shard.empty() || !options->references.empty() || !options->scenes.empty())
                    throw UsageError("report merge takes folders and --out alone");
                return tell(mergeReports({options->inputs.begin() + 1, options->inputs.end()}, options->out, command));
            }
            if (options->inputs.size() > 1)
                throw UsageError(fmt::format("report: one suite, not {}", fmt::join(options->inputs, " ")));
            ReportOptions report;
            report.suite = options->inputs.front(), report.out = options->out;
            report.references = options->references;
            if (!options->shard.empty()) {
                report.shard = parseShard(options->shard);
                command += " --shard " + options->shard;
            }
            if (!options->references.empty()) command += " --references " + shellQuoted(options->references);
            for (const std::string& text : options->scenes) {
                const auto equals = text.find('=');
                if (equals == std::string::npos || equals == 0 || equals + 1 == text.size())
                    throw UsageError(fmt::format("--scene {}: expected NAME=FILE", text));
                report.scenes[text.substr(0, equals)] = text.substr(equals + 1);
                command += " --scene " + shellQuoted(text);
            }
            report.command = command;
            return tell(runReport(report));
        }};
}

}  // namespace voxcone
