#include "report/report.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <fstream>
#include <new>
#include <set>
#include <thread>

#include "capture/capture.h"
#include "capture/output.h"
#include "core/atomic_file.h"
#include "core/error.h"
#include "core/log.h"
#include "core/progress.h"
#include "gl/context.h"
#include "report/evaluate.h"
#include "report/results.h"
#include "report/sha256.h"

namespace voxcone {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

/// A reference counts as so many frames in the progress.
constexpr int kReferenceWork = 8;

std::string now() {
    const std::time_t time = std::time(nullptr);
    std::tm utc{};
    gmtime_r(&time, &utc);
    char text[32];
    std::strftime(text, sizeof(text), "%Y-%m-%dT%H:%M:%SZ", &utc);
    return text;
}

/// `text` as part of a name of a file.
std::string slug(std::string text) {
    for (char& c : text) {
        if (std::isalnum(static_cast<unsigned char>(c)) == 0 && c != '-' && c != '.') c = '_';
    }
    return text.substr(0, 80);
}

// ---- Facts

json machineJson() {
    std::string cpu = "unknown";
    std::ifstream info("/proc/cpuinfo");
    for (std::string line; std::getline(info, line);) {
        if (line.starts_with("model name") && line.find(": ") != std::string::npos) {
            cpu = line.substr(line.find(": ") + 2);
            break;
        }
    }
    return {{"cpu", cpu},
            {"cores", std::thread::hardware_concurrency()},
            {"memory_bytes",
             static_cast<std::uint64_t>(sysconf(_SC_PHYS_PAGES)) * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE))}};
}

json buildJson() {
#if defined(__clang__)
    const std::string compiler = "Clang " __clang_version__;
#else
    const std::string compiler = "GCC " __VERSION__;
#endif
    return {{"version", VOXCONE_VERSION}, {"compiler", compiler}, {"type", VOXCONE_BUILD_TYPE}};
}

json timesJson(const Times& times) {
    return {{"median", times.median}, {"p10", times.p10}, {"p90", times.p90}, {"repeats", times.repeats}};
}

json passTimesJson(const std::optional<Times>& times) {
    if (!times) return nullptr;
    return {{"median", times->median}, {"p10", times->p10}, {"p90", times->p90}};
}

/// Infinity (psnr of equal pictures) has no JSON; it becomes null.
json errorsJson(const std::map<std::string, double>& errors) {
    json out = json::object();
    for (const auto& [name, value] : errors) out[name] = std::isfinite(value) ? json(value) : json(nullptr);
    return out;
}

json frameJson(const FrameTimes& frame) {
    json passes = json::array();
    for (const FrameStats::Pass& pass : frame.passes) passes.push_back({pass.name, pass.milliseconds});
    return {{"ms", frame.milliseconds}, {"passes", passes}};
}

FrameTimes frameOf(const json& tree) {
    FrameTimes frame;
    frame.milliseconds = tree.at("ms");
    for (const json& pass : tree.at("passes")) frame.passes.push_back({pass.at(0), pass.at(1)});
    return frame;
}

// ---- One report

class Runner {
  public:
    explicit Runner(const ReportOptions& options)
        : options_(options),
          suite_(loadSuite(options.suite, options.scenes)),
          context_(gl::Context::createHeadless(false)),
          references_(options.references.empty() ? options.out / "references" : options.references),
          rows_(options.shard ? rowsOf(suite_, *options.shard) : rowsOf(suite_)),
          program_(sha256OfProgram()),
          progress_("report " + suite_.name) {}

    ReportResult run() {
        const fs::path started = options_.out / "measurements" / "started";
        if (!fs::exists(started)) writeTextFile(started, now() + "\n");
        started_ = readTextFile(started);
        started_.pop_back();
        for (const SuiteRow& row : rows_) plan(row);
        for (std::size_t v = 0; v < suite_.views.size(); ++v) measureView(v);
        return write();
    }

  private:
    /// A row of this part of the suite, and where its measurement lies.
    struct Item {
        SuiteRow row;
        Settings settings;
        std::string reference;                 ///< key
        fs::path folder;                       ///< of repeat.N.json, picture.json or failed.json
        std::string images;                    ///< beginning of its pictures' names, relative to the report
        std::vector<int> repeats;              ///< that are not there yet
        bool picture = false, failed = false;  ///< are there

        bool finished() const { return failed || (repeats.empty() && picture); }
    };

    const SuiteView& viewOf(const Item& item) const { return suite_.views[item.row.view]; }
    const SuiteConfiguration& configurationOf(const Item& item) const {
        return suite_.configurations[item.row.configuration];
    }

    /// One a script and reference settings, so that a scene's files are hashed once.
    Evaluator& evaluatorOf(const SuiteView& view) {
        const Settings::Reference& r = view.reference;
        const auto key = std::tuple(view.script, r.samples, r.error, r.maxDepth, r.seed);
        auto& evaluator = evaluators_[key];
        if (!evaluator) evaluator = std::make_unique<Evaluator>(*context_, *view.script, references_, view.reference);
        return *evaluator;
    }

    void plan(const SuiteRow& row) {
        Item item;
        item.row = row;
        const SuiteView& view = suite_.views[row.view];
        const SuiteConfiguration& configuration = suite_.configurations[row.configuration];
        item.settings = suite_.settingsOf(view, configuration);
        item.reference = evaluatorOf(view).referenceKey(view.shot, view.frame, item.settings);
        Sha256 hash;
        hash.text(program_).text(context_->info().renderer).text(context_->info().version);
        hash.text(item.reference).text(toJson(item.settings).dump()).number(configuration.multiplyAo);
        for (const std::string& channel : suite_.channels) hash.text(channel);
        const std::string key = hash.hex().substr(0, 12);
        const std::string name = slug(configuration.id) + "." + key;
        item.folder = options_.out / "measurements" / slug(view.id) / name;
        item.images = "images/" + slug(view.id) + "/" + name;
        for (int i = 0; i < suite_.repeats; ++i)
            if (!fs::exists(repeatFile(item, i))) item.repeats.push_back(i);
        item.picture = fs::exists(item.folder / "picture.json");
        item.failed = fs::exists(item.folder / "failed.json");
        if (!item.finished() && fs::exists(markerFile(item))) {
            fs::remove(markerFile(item));
            fail(item, "the program was ended while it measured this: a crash, or out of memory");
        }
        if (!item.finished()) {
            work_ += suite_.warmUp + static_cast<int>(item.repeats.size()) + 1;
            if (counted_.insert(item.reference).second && !fs::exists(references_ / item.reference / "reference.json"))
                work_ += kReferenceWork;
        }
        items_.push_back(std::move(item));
    }

    /// Is there while the device works for the item, so that the next run does not crash in the same place.
    static fs::path markerFile(const Item& item) { return item.folder / "measuring"; }

    static fs::path repeatFile(const Item& item, int repeat) {
        return item.folder / fmt::format("repeat.{}.json", repeat);
    }

    void advance(double work) {
        done_ += work;
        progress_.update(work_ > 0 ? done_ / work_ : 1);
    }

    /// The row ends here, with the reason; the run goes on.
    void fail(Item& item, const std::string& reason) {
        item.failed = true;
        measured_ = true;
        writeTextFile(item.folder / "failed.json", json{{"reason", reason}}.dump(2) + "\n");
        log::info("{}, {}: {}", viewOf(item).id, configurationOf(item).id, reason);
    }

    /// Runs `what` of an item; false when it failed. Files are written outside of it: a full disk is no failure of a
    /// configuration.
    template <class F>
    bool attempt(Item& item, F&& what) {
        const Marker marker(markerFile(item));
        try {
            what();
            return true;
        } catch (const std::bad_alloc&) {
            fail(item, "out of memory");
        } catch (const std::exception& error) {
            fail(item, error.what());
        }
        return false;
    }

    /// The reference of an item, held in memory for the view.
    const Reference& referenceOf(const Item& item) {
        const auto found = held_.find(item.reference);
        if (found != held_.end()) return found->second;
        const SuiteView& view = viewOf(item);
        Evaluator& evaluator = evaluatorOf(view);
        const int before = evaluator.referencesRendered();
        const double start = done_;
        const auto tell = [&](double part) {
            done_ = start + part * kReferenceWork;
            progress_.update(done_ / std::max(work_, 1));
        };
        Reference reference = evaluator.reference(view.shot, view.frame, item.settings, tell);
        if (evaluator.referencesRendered() > before) {
            done_ = start + kReferenceWork;
            measured_ = true;
        }
        return held_.emplace(item.reference, std::move(reference)).first->second;
    }

    /// Everything of a view that is still to be measured, in groups of renderers that fit into memory together.
    void measureView(std::size_t v) {
        std::vector<Item*> waiting;
        for (Item& item : items_)
            if (item.row.view == v && !item.finished()) waiting.push_back(&item);
        held_.clear();
        const auto start = std::chrono::steady_clock::now();
        const std::size_t count = waiting.size();
        while (!waiting.empty()) measureGroup(waiting);
        if (count > 0)
            log::info("{}: {} configurations in {:.0f} s", suite_.views[v].id, count,
                      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
    }

    /// Takes from the front of `waiting` what fits, and measures it by turns.
    void measureGroup(std::vector<Item*>& waiting) {
        struct Member {
            Item* item;
            std::unique_ptr<Trial> trial;
        };
        std::vector<Member> group;
        std::uint64_t bytes = 0;
        while (!waiting.empty() && (group.empty() || bytes < suite_.memoryBytes)) {
            Item& item = *waiting.front();
            std::unique_ptr<Trial> trial;
            try {
                referenceOf(item);
                const SuiteView& view = viewOf(item);
                const Marker marker(markerFile(item));
                trial = std::make_unique<Trial>(*context_, evaluatorOf(view).sceneFor(item.settings), view.shot,
                                                view.frame, item.settings, suite_.warmUp);
            } catch (const std::exception& error) {
                // Perhaps there is room when the others have gone.
                if (!group.empty() && dynamic_cast<const InputError*>(&error) == nullptr) break;
                if (dynamic_cast<const InputError*>(&error) != nullptr) throw;
                fail(item, dynamic_cast<const std::bad_alloc*>(&error) != nullptr ? "out of memory" : error.what());
            }
            waiting.erase(waiting.begin());
            advance(suite_.warmUp);
            if (!trial) continue;
            bytes += trial->memoryBytes();
            group.push_back({&item, std::move(trial)});
        }
        for (int i = 0; i < suite_.repeats; ++i) {
            for (Member& member : group) {
                Item& item = *member.item;
                if (item.failed || std::find(item.repeats.begin(), item.repeats.end(), i) == item.repeats.end())
                    continue;
                Repeat repeat;
                const bool done = attempt(item, [&] { repeat = member.trial->repeat(); });
                advance(1);
                if (!done) continue;
                const json tree = {{"first", frameJson(repeat.first)}, {"steady", frameJson(repeat.steady)}};
                writeTextFile(repeatFile(item, i), tree.dump() + "\n");
                measured_ = true;
            }
        }
        for (Member& member : group) {
            Item& item = *member.item;
            if (!item.failed && !item.picture) takePicture(item, *member.trial);
            advance(1);
            member.trial.reset();
        }
    }

    void takePicture(Item& item, Trial& trial) {
        PictureResult result;
        if (!attempt(item, [&] {
                result = trial.picture(referenceOf(item), suite_.channels, configurationOf(item).multiplyAo);
            }))
            return;
        json images = json::object(), errors = json::object();
        for (const auto& [channel, found] : result.channels) {
            errors[channel] = errorsJson(found.errors);
            images[channel] = item.images + "." + channel + ".png";
            images[channel + "_heatmap"] = item.images + "." + channel + ".heatmap.png";
            writePng(options_.out / images[channel].get<std::string>(), found.shown);
            writePng(options_.out / images[channel + "_heatmap"].get<std::string>(), found.heatmap);
        }
        const json tree = {{"memory_bytes", result.memoryBytes},
                           {"samples_per_pixel", result.samplesPerPixel},
                           {"voxels", result.voxels},
                           {"errors", errors},
                           {"images", images}};
        writeTextFile(item.folder / "picture.json", tree.dump(2) + "\n");
        item.picture = true;
        measured_ = true;
    }

    // ---- report.json

    /// Facts and pictures of an item's reference; the pictures are written where they are missing.
    json referenceJson(const Item& item) {
        const Reference& reference = referenceOf(item);
        json images = json::object();
        for (const std::string& channel : suite_.channels) {
            const auto found = reference.channels.find(channel);
            if (found == reference.channels.end()) continue;
            const std::string name = fmt::format("images/{}/reference.{}.{}.png", slug(viewOf(item).id),
                                                 item.reference.substr(0, 12), channel);
            images[channel] = name;
            if (fs::exists(options_.out / name)) continue;
            writePng(options_.out / name, shownReference(channel, found->second, item.settings));
        }
        return {{"key", reference.key},         {"samples", reference.samples},
                {"depth", reference.maxDepth},  {"standard_error", reference.standardErrors},
                {"seconds", reference.seconds}, {"noise_relmse", reference.noise},
                {"images", images}};
    }

    /// All of it is there.
    json rowJson(const Item& item) {
        json row = {{"view", viewOf(item).id}, {"configuration", configurationOf(item).id}};
        if (item.failed) {
            row["status"] = "failed";
            row["reason"] = readJsonFile(item.folder / "failed.json").at("reason");
            return row;
        }
        std::vector<Repeat> repeats;
        for (int i = 0; i < suite_.repeats; ++i) {
            const json tree = readJsonFile(repeatFile(item, i));
            repeats.push_back({frameOf(tree.at("first")), frameOf(tree.at("steady"))});
        }
        const Measurement summary = summarize(repeats);
        row["status"] = "ok";
        row["ms"] = {{"first", timesJson(summary.first)}, {"steady", timesJson(summary.steady)}};
        row["passes"] = json::array();
        for (const Measurement::Pass& pass : summary.passes)
            row["passes"].push_back(
                {{"name", pass.name}, {"first", passTimesJson(pass.first)}, {"steady", passTimesJson(pass.steady)}});
        row.update(readJsonFile(item.folder / "picture.json"));
        return row;
    }

    json viewJson(std::size_t v) {
        const SuiteView& view = suite_.views[v];
        json out = {{"id", view.id},       {"scene", view.scene}, {"shot", view.shot.name},
                    {"frame", view.frame}, {"script", view.file}, {"triangles", view.script->scene.triangleCount()}};
        for (const SuiteConfiguration& configuration : suite_.configurations) {
            if (!suite_.measures(view, configuration)) continue;
            const Settings settings = suite_.settingsOf(view, configuration);
            out["width"] = settings.output.width, out["height"] = settings.output.height;
            break;
        }
        return out;
    }

    json configurationJson(const SuiteConfiguration& configuration) const {
        json out = {{"id", configuration.id}, {"preset", configuration.preset}, {"set", configuration.set}};
        if (configuration.multiplyAo) out["multiply_ao"] = true;
        for (const SuiteView& view : suite_.views) {
            if (!suite_.measures(view, configuration)) continue;
            out["settings"] = toJson(suite_.settingsOf(view, configuration));
            break;
        }
        return out;
    }

    ReportResult write() {
        json report = {{"voxcone_report", 1},
                       {"suite", {{"name", suite_.name}, {"file", suite_.file.string()}, {"hash", suite_.hash}}},
                       {"command", options_.command},
                       {"build", buildJson()},
                       {"device", describeDevice(context_->info())},
                       {"machine", machineJson()},
                       {"views", json::array()},
                       {"configurations", json::array()},
                       {"rows", json::array()}};
        for (const SuiteConfiguration& configuration : suite_.configurations)
            report["configurations"].push_back(configurationJson(configuration));
        std::size_t next = 0;  // items are in the order of rows
        for (std::size_t v = 0; v < suite_.views.size(); ++v) {
            held_.clear();
            json view = viewJson(v);
            std::string key;
            for (std::size_t c = 0; c < suite_.configurations.size(); ++c) {
                if (!suite_.measures(suite_.views[v], suite_.configurations[c])) continue;
                if (next == items_.size() || !(items_[next].row == SuiteRow{v, c})) {
                    report["rows"].push_back({{"view", suite_.views[v].id},
                                              {"configuration", suite_.configurations[c].id},
                                              {"status", "missing"}});
                    continue;
                }
                const Item& item = items_[next++];
                json row = rowJson(item);
                if (!item.failed && key.empty()) {
                    key = item.reference;
                    view["reference"] = referenceJson(item);
                } else if (!item.failed && key != item.reference) {
                    row["reference"] = referenceJson(item);
                }
                report["rows"].push_back(std::move(row));
            }
            report["views"].push_back(std::move(view));
        }
        report["times_made"] = timesMade(report);
        return writeReport(report, options_.out);
    }

    /// From the first run into this folder to now; when nothing was measured, what stands in the report that is there.
    json timesMade(json& report) const {
        const fs::path file = options_.out / "report.json";
        json made = {{"started", started_}, {"finished", now()}};
        if (!fs::exists(file)) return made;
        const json before = readJsonFile(file);
        if (before.value("suite", json()) != report["suite"] || !before.contains("times_made")) return made;
        if (!measured_ && before.value("rows", json()) == report["rows"]) {
            report["command"] = before.at("command");
            return before.at("times_made");
        }
        return made;
    }

    const ReportOptions& options_;
    std::string started_;  ///< the first run into this folder
    const Suite suite_;
    const std::unique_ptr<gl::Context> context_;
    const fs::path references_;
    const std::vector<SuiteRow> rows_;
    const std::string program_;
    std::map<std::tuple<const CaptureScript*, int, double, int, int>, std::unique_ptr<Evaluator>> evaluators_;
    std::vector<Item> items_;
    std::set<std::string> counted_;          ///< references whose work is part of work_
    std::map<std::string, Reference> held_;  ///< of the view that is measured
    Progress progress_;
    int work_ = 0;
    double done_ = 0;
    bool measured_ = false;  ///< something was rendered in this run
};

}  // namespace

ReportResult runReport(const ReportOptions& options) {
    return Runner(options).run();
}

}  // namespace voxcone
