// voxcone tune: the cheapest settings for a scene on this device that meet a bound on the error.
#include "report/tune.h"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <memory>

#include "app/commands.h"
#include "core/atomic_file.h"
#include "core/error.h"
#include "core/log.h"
#include "core/nearest.h"
#include "core/progress.h"
#include "gl/context.h"

namespace voxcone {

namespace {

// Those that are better when they are small.
const std::vector<std::string> kMetrics = {"relmse", "rmse", "bias", "relative_bias", "p99", "hdr_flip", "flip"};

struct Bound {
    std::string metric;
    double value = 0;
};

Bound parseBound(const std::string& text) {
    const auto equals = text.find('=');
    Bound bound{text.substr(0, equals), 0};
    if (std::find(kMetrics.begin(), kMetrics.end(), bound.metric) == kMetrics.end())
        throw UsageError(fmt::format("--max-error {}: no metric \"{}\"; did you mean \"{}\"?", text, bound.metric,
                                     nearestWord(kMetrics, bound.metric)));
    try {
        std::size_t end = 0;
        const std::string number = equals == std::string::npos ? "" : text.substr(equals + 1);
        bound.value = std::stod(number, &end);
        if (end == number.size() && std::isfinite(bound.value) && bound.value > 0) return bound;
    } catch (const std::exception&) {
    }
    throw UsageError(fmt::format("--max-error {}: expected METRIC=VALUE with a value above 0, e.g. relmse=0.02", text));
}

/// The front, the chosen row marked. What small pictures or a single frame tell is marked as about.
void printFront(const TuneResult& result, const TuneSpace& space, const std::string& metric, bool firstFrames) {
    fmt::print("  {:>10} {:>10} {:>12} {:>10} {:>8}  settings changed\n", "steady_ms", "first_ms", metric, "samples/px",
               "MB");
    for (const TuneResult::Row& row : result.front) {
        const Measured& m = row.measured;
        const char* about = row.confirmed ? "" : "~";
        // Without repeats of first frames there is but the very first one.
        const char* aboutFirst = row.confirmed && firstFrames ? "" : "~";
        fmt::print("{} {:>10} {:>10} {:>12} {:>10.0f} {:>8.1f}  {}\n",
                   result.cheapest && row.choice == result.cheapest->choice ? "*" : " ",
                   fmt::format("{}{:.4g}", about, m.steadyMilliseconds),
                   fmt::format("{}{:.4g}", aboutFirst, m.firstMilliseconds),
                   fmt::format("{}{:.4g}", about, m.errors.at(metric)), m.samplesPerPixel,
                   static_cast<double>(m.memoryBytes) / 1e6, space.changesOf(row.choice));
    }
}

struct Options : ScriptOptions {
    std::string maxError, channel = "beauty", frame = "steady", out, cache;
    std::optional<double> maxMilliseconds;
    int budget = 40, repeats = 3;
    std::vector<std::string> vary;
};

int run(const Options& options) {
    const Bound bound = parseBound(options.maxError);
    std::vector<Knob> knobs;
    for (const std::string& text : options.vary) knobs.push_back(knobFromText(text));
    const CaptureScript script = options.loadAsWritten();
    TuneSpace space = defaultTuneSpace(script.settings, options.channel);
    if (!knobs.empty()) space.knobs = std::move(knobs);

    const auto context = gl::Context::createHeadless(false);
    const std::filesystem::path cache = options.cache;
    Evaluator evaluator(*context, script, cache / "references", script.settings.reference);
    SettingsMeter meter(*context, evaluator, script, options.channel, options.repeats, options.frame == "first",
                        cache / "measurements");
    const std::string name = std::filesystem::path(options.file).stem().string();
    double noise = 0;
    for (int divisor = tuneDivisor(script.settings); divisor > 0; --divisor) {
        Progress progress("reference " + name);
        noise = meter.prepare(divisor, [&](double fraction) { progress.update(fraction); });
    }
    if (bound.metric == "relmse" && noise > 0.25 * bound.value)
        log::info("the reference's own noise is relmse {:.3g} of {}: with more reference.samples errors would be less",
                  noise, options.channel);
    const TuneOptions tuning{bound.metric, bound.value, options.maxMilliseconds, options.frame == "first",
                             options.budget};
    const auto time = [&](const Measured& m) { return tuning.firstFrame ? m.firstMilliseconds : m.steadyMilliseconds; };
    TuneEvents events;
    events.before = [&](int number, const std::vector<Choice>& choices) {
        for (const Choice& choice : choices)
            log::info("{:>3}/{}{}: {}", number++, options.budget, choices.size() > 1 ? ", in turns" : "",
                      space.changesOf(choice));
    };
    events.after = [&](const Measured& m) {
        if (m.failure.empty())
            log::info("        {:.4g} ms, {} {:.4g}, {}", time(m), bound.metric, m.errors.at(bound.metric),
                      m.kept ? "kept from an earlier search" : fmt::format("measured in {:.1f} s", m.seconds));
        else
            log::info("        {}", m.failure);
    };
    const TuneResult result = tune(meter, space, tuning, events);
    if (result.kept > 0) log::info("{} measurements of an earlier search, from {}", result.kept, options.cache);

    fmt::print("trade-offs of {}, {} x {} pixels, {} of {}, {} times of {} measurements of settings{}:\n", name,
               script.settings.output.width, script.settings.output.height, bound.metric, options.channel,
               options.repeats, result.measurements,
               result.failed > 0 ? fmt::format(", {} of which failed", result.failed) : "");
    printFront(result, space, bound.metric, tuning.firstFrame);
    if (!result.met) {
        if (result.cheapest)
            fmt::print(
                "nothing found meets {} <= {} within {} ms; the cheapest that meets the error takes {:.4g} ms: {}\n",
                bound.metric, bound.value, *options.maxMilliseconds, time(result.cheapest->measured),
                space.changesOf(result.cheapest->choice));
        else
            fmt::print("nothing found meets {} <= {}; ", bound.metric, bound.value);
        const TuneResult::Row* least = nullptr;
        for (const TuneResult::Row& row : result.front)
            if (!options.maxMilliseconds || time(row.measured) <= *options.maxMilliseconds) least = &row;
        if (least != nullptr)
            fmt::print("the least error found{} is {:.4g}, at {:.4g} ms: {}\n",
                       options.maxMilliseconds ? fmt::format(" within {} ms", *options.maxMilliseconds) : "",
                       least->measured.errors.at(bound.metric), time(least->measured), space.changesOf(least->choice));
        else
            fmt::print("nothing found is as fast as that\n");
        return static_cast<int>(ExitCode::over_bound);
    }
    const Measured& best = result.cheapest->measured;
    fmt::print("cheapest with {} <= {}: {:.4g} at {:.4g} ms: {}\n", bound.metric, bound.value,
               best.errors.at(bound.metric), time(best), space.changesOf(result.cheapest->choice));
    if (!options.out.empty()) {
        writeTextFile(options.out, presetOf(space.settingsOf(result.cheapest->choice)).dump(2) + "\n");
        fmt::print("{}\n", options.out);
    }
    return 0;
}

}  // namespace

Command tuneCommand(CLI::App& app) {
    const auto options = std::make_shared<Options>();
    options->cache = (std::filesystem::temp_directory_path() / "voxcone-tune").string();
    CLI::App* parser =
        app.add_subcommand("tune", "Find the cheapest settings for a scene that meet a bound on the error");
    options->addTo(*parser, true);
    parser
        ->add_option("--max-error", options->maxError, "the bound, e.g. relmse=0.02, on the first frame of every shot")
        ->type_name("METRIC=VALUE")
        ->required();
    parser->add_option("--channel", options->channel, "whose error it is")
        ->check(CLI::IsMember({"beauty", "indirect_diffuse", "indirect_specular", "transmission"}))
        ->capture_default_str();
    parser->add_option("--max-ms", options->maxMilliseconds, "fail when the cheapest takes longer")->type_name("MS");
    parser
        ->add_option("--frame", options->frame,
                     "what is timed: a frame where nothing moved, or the first, which builds voxels and light")
        ->check(CLI::IsMember({"steady", "first"}))
        ->capture_default_str();
    parser->add_option("--out", options->out, "preset to write, for --set preset=FILE.json")->type_name("FILE.json");
    parser
        ->add_option(
            "--vary", options->vary,
            "search these values of this setting, cheapest first, instead of the usual settings; may be repeated")
        ->type_name("KEY=VALUE,VALUE…")
        ->allow_extra_args(false);
    parser->add_option("--budget", options->budget, "measurements of settings, at most")
        ->check(CLI::Range(6, 10000))
        ->capture_default_str();
    parser->add_option("--repeats", options->repeats, "frames timed for a measurement, of which the median counts")
        ->check(CLI::Range(1, 1000))
        ->capture_default_str();
    parser
        ->add_option("--cache", options->cache,
                     "folder that keeps references and measurements: a search that was stopped goes on, and one for "
                     "another bound begins with what is known")
        ->type_name("DIR")
        ->capture_default_str();
    return {parser, "voxcone tune SCRIPT.json|SCENE.gltf --max-error METRIC=VALUE [--out FILE.json] [--set KEY=VALUE]…",
            [options] { return run(*options); }};
}

}  // namespace voxcone
