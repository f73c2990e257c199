// Measures every combination of a few settings on a script, and then whether the search of `voxcone tune` finds the
// cheapest one under bounds of several sizes with a quarter of the measurements. Exit status 1 when it misses by more
// than a tenth of the cost.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>

#include "core/atomic_file.h"
#include "core/error.h"
#include "core/log.h"
#include "core/progress.h"
#include "gl/context.h"
#include "report/tune.h"

namespace {

using namespace voxcone;
using nlohmann::json;

struct Options {
    std::string script, channel = "indirect_diffuse", metric = "relmse", cost = "ms", table, cache;
    std::vector<std::string> assignments, vary;
    std::vector<double> shares{0.1, 0.25, 0.5, 0.75, 0.9};
    int repeats = 3;
    bool fresh = false;
};

using Table = std::map<Choice, Measured>;

std::vector<Choice> allChoices(const SearchSpace& space) {
    std::set<Choice> all;
    Choice choice(space.sizes.size(), 0);
    for (std::size_t k = 0; k < choice.size();) {
        all.insert(space.canonicalOf(choice));
        for (k = 0; k < choice.size() && ++choice[k] == space.sizes[k]; ++k) choice[k] = 0;
    }
    return {all.begin(), all.end()};
}

/// The figures of every choice from `file`, where it has them; the others are measured and added to it.
Table sweep(const TuneSpace& space, const std::vector<Choice>& all, SettingsMeter& meter, const Options& options) {
    json rows = std::filesystem::exists(options.table) ? json::parse(readTextFile(options.table)) : json::object();
    Progress progress("sweep");
    Table table;
    for (const Choice& choice : all) {
        const std::string name = presetOf(space.settingsOf(choice)).dump();
        if (!rows.contains(name)) {
            const Measured m = meter.measure(space.settingsOf(choice), 1);
            rows[name] = {{"steady_ms", m.steadyMilliseconds},
                          {"first_ms", m.firstMilliseconds},
                          {"error", m.failure.empty() ? m.errors.at(options.metric) : 0},
                          {"samples", m.samplesPerPixel},
                          {"seconds", m.seconds},
                          {"build_seconds", m.buildSeconds},
                          {"failure", m.failure}};
            if (!options.table.empty()) writeTextFile(options.table, rows.dump(1) + "\n");
        }
        const json& row = rows[name];
        Measured& m = table[choice];
        m.firstMilliseconds = row["first_ms"], m.steadyMilliseconds = row["steady_ms"];
        m.errors[options.metric] = row.at("error"), m.samplesPerPixel = row.at("samples");
        m.seconds = row.at("seconds"), m.buildSeconds = row.at("build_seconds");
        m.failure = row["failure"];
        progress.update(static_cast<double>(table.size()) / static_cast<double>(all.size()));
    }
    return table;
}

int run(const Options& options) {
    CaptureScript script = loadCaptureScript(options.script);
    for (const std::string& assignment : options.assignments) applyAssignment(script.settings, assignment);
    TuneSpace space{script.settings, {}};
    for (const std::string& text : options.vary) space.knobs.push_back(knobFromText(text));
    const SearchSpace searched = space.searchSpace(false);
    const std::vector<Choice> all = allChoices(searched);

    const auto context = gl::Context::createHeadless(false);
    Evaluator evaluator(*context, script, options.cache, script.settings.reference);
    SettingsMeter meter(*context, evaluator, script, options.channel, options.repeats, options.cost == "first-ms", {});
    meter.prepare(1, {});
    const Table table = sweep(space, all, meter, options);
    const auto costOf = [&](const Measured& m) {
        return Cost{options.cost == "samples"    ? m.samplesPerPixel
                    : options.cost == "first-ms" ? m.firstMilliseconds
                                                 : m.steadyMilliseconds,
                    m.errors.at(options.metric), m.buildSeconds, m.seconds - m.buildSeconds};
    };

    std::vector<double> errors;
    for (const auto& [choice, m] : table)
        if (m.failure.empty()) errors.push_back(m.errors.at(options.metric));
    if (errors.empty()) throw InputError(options.script, "", "nothing could be rendered");
    std::sort(errors.begin(), errors.end());
    const int budget = static_cast<int>(all.size()) / 4;
    fmt::print("{}: {} settings, {} of {}, cost in {}, device {}\n", options.script, all.size(), options.metric,
               options.channel, options.cost, context->info().renderer);
    fmt::print("{:>10}  {:>12} {:>12} {:>6} {:>8}  {}\n", "bound", "cheapest", "found", "ratio", "measured",
               "found settings");
    int missed = 0;
    for (const double share : options.shares) {
        const double bound = errors[static_cast<std::size_t>(share * static_cast<double>(errors.size() - 1))];
        double cheapest = 1e300;
        for (const auto& [choice, m] : table)
            if (m.failure.empty() && m.errors.at(options.metric) <= bound)
                cheapest = std::min(cheapest, costOf(m).milliseconds);
        const MeasureChoices measure = [&](const std::vector<Choice>& choices, Stage) {
            std::vector<std::optional<Cost>> costs;
            std::vector<Settings> list;
            for (const Choice& choice : choices) list.push_back(space.settingsOf(choice));
            const auto rendered = options.fresh ? meter.compare(list) : std::vector<Measured>{};
            for (std::size_t i = 0; i < choices.size(); ++i) {
                const Measured& m = options.fresh ? rendered[i] : table.at(choices[i]);
                costs.push_back(m.failure.empty() ? std::optional(costOf(m)) : std::nullopt);
            }
            return costs;
        };
        const SearchResult result = searchCheapest(searched, bound, budget, measure);
        // What was found is judged by the sweep's figures.
        const Choice* found = result.best ? &result.probes[static_cast<std::size_t>(*result.best)].choice : nullptr;
        const double cost = found != nullptr ? costOf(table.at(*found)).milliseconds : INFINITY;
        const double ratio = cost / cheapest;
        missed += !(ratio <= 1.1) || result.measurements > budget;
        fmt::print("{:>10.4g}  {:>12.5g} {:>12.5g} {:>6.3f} {:>4} of {:<3}  {}\n", bound, cheapest, cost, ratio,
                   result.measurements, all.size(), found != nullptr ? space.changesOf(*found) : "none");
    }
    return missed > 0 ? 1 : 0;
}

}  // namespace

int main(int argc, char** argv) {
    CLI::App app("Compares the search of voxcone tune with a sweep of all combinations", "tune_sweep");
    Options options;
    options.cache = (std::filesystem::temp_directory_path() / "voxcone-references").string();
    app.add_option("script", options.script, "capture script or scene; its pictures should be small")->required();
    app.add_option("--vary", options.vary, "KEY=VALUE,VALUE…, cheapest first; may be repeated")
        ->allow_extra_args(false)
        ->required();
    app.add_option("--set", options.assignments, "KEY=VALUE; may be repeated")->allow_extra_args(false);
    app.add_option("--channel", options.channel)->capture_default_str();
    app.add_option("--metric", options.metric)->capture_default_str();
    app.add_option("--cost", options.cost,
                   "ms of a steady or a first frame, or samples of cones a pixel, which no clock disturbs")
        ->check(CLI::IsMember({"ms", "first-ms", "samples"}))
        ->capture_default_str();
    app.add_option("--shares", options.shares, "bounds, as shares of the combinations that meet them")
        ->delimiter(',')
        ->check(CLI::Range(0.0, 1.0));
    app.add_option("--repeats", options.repeats, "frames timed for a measurement")->capture_default_str();
    app.add_option("--table", options.table, "JSON file that keeps the sweep");
    app.add_option("--references", options.cache, "folder that keeps references")->capture_default_str();
    app.add_flag("--fresh", options.fresh, "the search renders again instead of reading the sweep's figures");
    CLI11_PARSE(app, argc, argv);
    try {
        return run(options);
    } catch (const Error& error) {
        log::message("", error.what());
        return static_cast<int>(error.exitCode);
    }
}
