// voxcone compare: how far pictures are from their references.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "app/commands.h"
#include "core/error.h"
#include "core/log.h"
#include "core/nearest.h"
#include "metric/flip.h"
#include "metric/heatmap.h"
#include "metric/metrics.h"

namespace voxcone {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

struct MetricName {
    const char* name;
    const char* meaning;
    bool higherIsBetter = false;
};
// In the order of the table.
constexpr MetricName kMetrics[] = {
    {"relmse", "mean((I-R)^2/(R^2+e)), e = 1 % of the mean squared reference"},
    {"rmse", "root of the mean squared error, linear"},
    {"bias", "mean signed error, linear"},
    {"relative_bias", "bias over the reference's mean"},
    {"p99", "99th percentile of the absolute error, linear"},
    {"hdr_flip", "mean HDR-FLIP (floating-point pictures)"},
    {"flip", "mean FLIP of the displayed picture"},
    {"ssim", "mean structural similarity of the displayed picture", true},
    {"psnr", "dB, of the displayed picture", true},
    {"grade", "10*SSIM^1000, pixels black in both left out", true},
};

/// Two pictures and what was found.
struct Comparison {
    std::string name;  ///< "<shot>/<channel>.<frame>" in folders, else the test's file name
    fs::path reference, test;
    int width = 0, height = 0, channels = 0;
    std::map<std::string, double> metrics;  ///< by MetricName::name; absent where a metric makes no sense
    double epsilon = 0;
    std::string display;  ///< what the display metrics saw
    std::optional<HdrFlip> hdr;
};

bool isDisplayReferred(const fs::path& file) {
    std::string extension = file.extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return std::tolower(c); });
    return extension == ".png" || extension == ".jpg" || extension == ".jpeg" || extension == ".bmp" ||
           extension == ".tga";
}

/// Channels that hold no colour: perceptual metrics say nothing about them.
bool isData(const std::string& fileName) {
    const std::string channel = fileName.substr(0, fileName.find('.'));
    return channel == "normal" || channel == "depth" || channel == "position" || channel == "voxel_normal";
}

/// Without alpha, which no perceptual metric looks at.
Image withoutAlpha(const Image& image) {
    if (image.channels == 1 || image.channels == 3) return image;
    Image out(image.width, image.height, image.channels - 1);
    for (int y = 0; y < image.height; ++y) {
        for (int x = 0; x < image.width; ++x) std::copy_n(image.pixel(x, y), out.channels, out.pixel(x, y));
    }
    return out;
}

/// The largest absolute error over the channels of every pixel.
Image absoluteError(const Image& reference, const Image& test) {
    Image out(reference.width, reference.height, 1);
    const auto channels = static_cast<std::size_t>(reference.channels);
    for (std::size_t i = 0; i < reference.data.size(); ++i)
        out.data[i / channels] = std::max(out.data[i / channels], std::abs(test.data[i] - reference.data[i]));
    return out;
}

Comparison compareFiles(const std::string& name, const fs::path& referenceFile, const fs::path& testFile,
                        const std::optional<fs::path>& heatmapFile) {
    Comparison out;
    out.name = name, out.reference = referenceFile, out.test = testFile;
    const Image reference = readImage(referenceFile), test = readImage(testFile);
    requireComparable(reference, referenceFile.string(), test, testFile.string());
    out.width = test.width, out.height = test.height, out.channels = test.channels;

    const LinearError linear = linearError(reference, test);
    out.epsilon = linear.epsilon;
    out.metrics = metricsByName(linear);

    const bool data = isData(testFile.filename().string());
    const bool display = isDisplayReferred(referenceFile) && isDisplayReferred(testFile);
    Image errors = absoluteError(reference, test);
    double fullScale = std::max(static_cast<double>(*std::max_element(errors.data.begin(), errors.data.end())), 1e-30);
    if (!data) {
        const Image r = withoutAlpha(reference), t = withoutAlpha(test);
        Image shownR = r, shownT = t;
        out.display = display ? "the files" : "values clipped to 0..1";
        if (!display) {
            out.hdr = hdrFlip(r, t);
            out.metrics["hdr_flip"] = meanOf(out.hdr->error);
            errors = out.hdr->error, fullScale = 1;
            const fs::path pngR = fs::path(referenceFile).replace_extension(".png");
            const fs::path pngT = fs::path(testFile).replace_extension(".png");
            if (fs::exists(pngR) && fs::exists(pngT)) {
                shownR = withoutAlpha(readImage(pngR)), shownT = withoutAlpha(readImage(pngT));
                requireComparable(shownR, pngR.string(), shownT, pngT.string());
                out.display = "the .png files beside them";
            }
        } else if (heatmapFile) {
            errors = flip(r, t), fullScale = 1;
        }
        out.metrics.merge(metricsByName(displayError(shownR, shownT)));
    }
    if (heatmapFile) writePng(*heatmapFile, heatmap(errors, fullScale));
    return out;
}

/// Every <shot>/<channel>.<frame>.exr that both folders have, in order of name.
std::vector<Comparison> compareFolders(const fs::path& reference, const fs::path& test,
                                       const std::optional<fs::path>& heatmaps) {
    std::vector<fs::path> pairs;
    std::size_t alone = 0;
    for (const auto& entry : fs::recursive_directory_iterator(test)) {
        if (!entry.is_regular_file() || entry.path().extension() != ".exr") continue;
        if (entry.path().filename().string().starts_with(".")) continue;  // somebody's unfinished file
        const fs::path relative = entry.path().lexically_relative(test);
        if (fs::exists(reference / relative))
            pairs.push_back(relative);
        else
            ++alone;
    }
    if (pairs.empty())
        throw InputError(test.string(), "",
                         fmt::format("no <shot>/<channel>.<frame>.exr that is in {} too", reference.string()));
    if (alone > 0) log::info("{} pictures of {} have no reference", alone, test.string());
    std::sort(pairs.begin(), pairs.end());
    std::vector<Comparison> out;
    for (const fs::path& pair : pairs) {
        std::optional<fs::path> map;
        if (heatmaps) map = (*heatmaps / pair).replace_extension(".png");
        out.push_back(compareFiles(fs::path(pair).replace_extension("").string(), reference / pair, test / pair, map));
    }
    return out;
}

/// Mean of every metric over the comparisons that have it.
std::map<std::string, double> meanMetrics(const std::vector<Comparison>& all) {
    std::map<std::string, double> mean;
    std::map<std::string, int> counts;
    for (const Comparison& c : all) {
        for (const auto& [name, value] : c.metrics) mean[name] += value, ++counts[name];
    }
    for (auto& [name, value] : mean) value /= counts[name];
    return mean;
}

std::string cell(const std::map<std::string, double>& metrics, const char* name) {
    const auto found = metrics.find(name);
    return found == metrics.end() ? "-" : fmt::format("{:.5g}", found->second);
}

void printTable(const std::vector<Comparison>& all) {
    std::size_t width = 4;
    for (const Comparison& c : all) width = std::max(width, c.name.size());
    const auto row = [&](const std::string& name, auto&& value) {
        std::string line = fmt::format("{:<{}}", name, width);
        for (const MetricName& metric : kMetrics)
            line +=
                fmt::format("  {:>{}}", value(metric), std::max<std::size_t>(10, std::string_view(metric.name).size()));
        fmt::print("{}\n", line);
    };
    row("", [](const MetricName& metric) { return std::string(metric.name); });
    for (const Comparison& c : all) row(c.name, [&](const MetricName& metric) { return cell(c.metrics, metric.name); });
    const auto mean = meanMetrics(all);
    row("mean", [&](const MetricName& metric) { return cell(mean, metric.name); });
}

void printOne(const Comparison& c) {
    fmt::print("reference      {}\ntest           {}\nsize           {}x{}, {} channels\n", c.reference.string(),
               c.test.string(), c.width, c.height, c.channels);
    for (const MetricName& metric : kMetrics) {
        if (c.metrics.contains(metric.name))
            fmt::print("{:<14} {:<12} {}\n", metric.name, cell(c.metrics, metric.name), metric.meaning);
    }
    fmt::print("epsilon        {:.5g}\n", c.epsilon);
    if (c.hdr)
        fmt::print("exposures      {} from {:+.2f} to {:+.2f} EV (HDR-FLIP)\n", c.hdr->exposures, c.hdr->startExposure,
                   c.hdr->stopExposure);
    if (!c.display.empty()) fmt::print("displayed      {}\n", c.display);
}

/// Infinity (PSNR of equal pictures) has no JSON; it becomes null.
json metricsJson(const std::map<std::string, double>& metrics) {
    json out = json::object();
    for (const auto& [name, value] : metrics) out[name] = std::isfinite(value) ? json(value) : json(nullptr);
    return out;
}

json toJson(const std::vector<Comparison>& all) {
    json pairs = json::array();
    for (const Comparison& c : all) {
        json pair = {{"name", c.name},          {"reference", c.reference.string()},
                     {"test", c.test.string()}, {"width", c.width},
                     {"height", c.height},      {"channels", c.channels},
                     {"epsilon", c.epsilon},    {"metrics", metricsJson(c.metrics)}};
        if (!c.display.empty()) pair["displayed"] = c.display;
        if (c.hdr)
            pair["hdr_flip_exposures"] = {
                {"start", c.hdr->startExposure}, {"stop", c.hdr->stopExposure}, {"count", c.hdr->exposures}};
        pairs.push_back(pair);
    }
    return {{"pairs", pairs}, {"mean", metricsJson(meanMetrics(all))}};
}

struct Bound {
    std::string metric;
    double value = 0;
    bool above = true;  ///< fails above, else below
};

Bound parseBound(const std::string& option, const std::string& text, bool above) {
    const auto equals = text.find('=');
    std::vector<std::string> names;
    for (const MetricName& metric : kMetrics) names.emplace_back(metric.name);
    Bound bound{text.substr(0, equals), 0, above};
    const json value = equals == std::string::npos ? json() : json::parse(text.substr(equals + 1), nullptr, false);
    if (!value.is_number())
        throw UsageError(fmt::format("{} {}: expected metric=value, e.g. {} relmse=0.05", option, text, option));
    if (std::find(names.begin(), names.end(), bound.metric) == names.end())
        throw UsageError(fmt::format("{} {}: unknown metric \"{}\"; did you mean \"{}\"? (there are {})", option, text,
                                     bound.metric, nearestWord(names, bound.metric), fmt::join(names, ", ")));
    bound.value = value.get<double>();
    return bound;
}

/// Tells every bound that is broken; true when one is.
bool breaksBounds(const std::vector<Comparison>& all, const std::vector<Bound>& bounds) {
    bool broken = false;
    for (const Bound& bound : bounds) {
        bool seen = false;
        for (const Comparison& c : all) {
            const auto found = c.metrics.find(bound.metric);
            if (found == c.metrics.end()) continue;
            seen = true;
            const bool isSigned = bound.metric == "bias" || bound.metric == "relative_bias";
            const double value = isSigned ? std::abs(found->second) : found->second;
            if (bound.above ? value <= bound.value : value >= bound.value) continue;
            broken = true;
            log::info("{}: {} {:.5g} is {} {:g}", c.name, bound.metric, value, bound.above ? "above" : "below",
                      bound.value);
        }
        if (!seen) throw UsageError(fmt::format("{} is not a metric of these pictures", bound.metric));
    }
    return broken;
}

}  // namespace

Command compareCommand(CLI::App& app) {
    struct Options {
        std::string reference, test, heatmap;
        std::vector<std::string> above, below;
        bool json = false;
    };
    const auto options = std::make_shared<Options>();
    CLI::App* parser = app.add_subcommand("compare", "Error metrics of a picture, or of all pictures of a folder");
    parser->add_option("reference", options->reference, "picture, or folder written by `voxcone reference`")
        ->type_name("REFERENCE")
        ->required();
    parser->add_option("test", options->test, "picture, or folder written by `voxcone capture`")
        ->type_name("TEST")
        ->required();
    parser->add_flag("--json", options->json, "print JSON instead of a table");
    parser
        ->add_option("--heatmap", options->heatmap,
                     "write the FLIP error of every pixel as a PNG in the colours of magma (of folders: a folder); "
                     "channels that "
                     "are no colours show the absolute error, scaled to its largest")
        ->type_name("F");
    parser
        ->add_option("--fail-above", options->above,
                     "exit 1 when a metric of any picture is above the value (bias: in either "
                     "direction); may be repeated")
        ->type_name("METRIC=VALUE")
        ->allow_extra_args(false);
    parser->add_option("--fail-below", options->below, "the same for metrics of which more is better")
        ->type_name("METRIC=VALUE")
        ->allow_extra_args(false);
    std::string footer = "Metrics:\n";
    for (const MetricName& metric : kMetrics)
        footer += fmt::format("  {:<14} {}{}\n", metric.name, metric.meaning,
                              metric.higherIsBetter ? "; more is better" : "");
    footer +=
        "Linear metrics and HDR-FLIP are of the values of the files (8-bit files are decoded from sRGB). FLIP, SSIM, "
        "PSNR and\n"
        "grade are of what is displayed: of the .png files beside two .exr files where both are there, else of values\n"
        "clipped to 0..1. NaN or infinity in a pixel is bad input.\n";
    parser->footer(footer);
    return {parser,
            "voxcone compare REFERENCE TEST [--json] [--heatmap F] [--fail-above METRIC=VALUE]… [--fail-below "
            "METRIC=VALUE]…",
            [options] {
                std::vector<Bound> bounds;
                for (const std::string& text : options->above) bounds.push_back(parseBound("--fail-above", text, true));
                for (const std::string& text : options->below)
                    bounds.push_back(parseBound("--fail-below", text, false));
                std::optional<fs::path> heatmapPath;
                if (!options->heatmap.empty()) heatmapPath = options->heatmap;

                const fs::path reference = options->reference, test = options->test;
                for (const fs::path& path : {reference, test}) {
                    if (!fs::exists(path)) throw InputError(path.string(), "", "no such file or folder");
                }
                const bool folders = fs::is_directory(reference);
                if (folders != fs::is_directory(test))
                    throw UsageError("REFERENCE and TEST must be two files or two folders");
                const std::vector<Comparison> all =
                    folders
                        ? compareFolders(reference, test, heatmapPath)
                        : std::vector<Comparison>{compareFiles(test.filename().string(), reference, test, heatmapPath)};
                if (options->json)
                    fmt::print("{}\n", toJson(all).dump(2));
                else if (folders)
                    printTable(all);
                else
                    printOne(all.front());
                return static_cast<int>(breaksBounds(all, bounds) ? ExitCode::over_bound : ExitCode::done);
            }};
}

}  // namespace voxcone
