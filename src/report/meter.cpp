#include "report/meter.h"

#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <memory>
#include <new>
#include <nlohmann/json.hpp>

#include "core/atomic_file.h"
#include "core/error.h"
#include "gl/context.h"
#include "report/results.h"
#include "report/sha256.h"

namespace voxcone {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

bool isPerPixel(const std::string& pass) {
    return pass == "gbuffer" || pass == "direct" || pass == "composite" || pass.starts_with("cones: ");
}

json toJson(const Measured& m) {
    if (!m.failure.empty()) return {{"failure", m.failure}};
    // Infinity has no JSON.
    json errors = json::object();
    for (const auto& [name, value] : m.errors) errors[name] = std::isfinite(value) ? json(value) : json(nullptr);
    return {{"first_ms", m.firstMilliseconds},        {"steady_ms", m.steadyMilliseconds}, {"errors", errors},
            {"samples_per_pixel", m.samplesPerPixel}, {"memory_bytes", m.memoryBytes},     {"seconds", m.seconds},
            {"build_seconds", m.buildSeconds}};
}

Measured measuredOf(const json& tree) {
    Measured m;
    m.kept = true;
    m.failure = tree.value("failure", "");
    if (!m.failure.empty()) return m;
    m.firstMilliseconds = tree.at("first_ms"), m.steadyMilliseconds = tree.at("steady_ms");
    for (const auto& [name, value] : tree.at("errors").items())
        m.errors[name] = value.is_null() ? INFINITY : value.get<double>();
    m.samplesPerPixel = tree.at("samples_per_pixel"), m.memoryBytes = tree.at("memory_bytes");
    m.seconds = tree.at("seconds"), m.buildSeconds = tree.at("build_seconds");
    return m;
}

}  // namespace

SettingsMeter::SettingsMeter(gl::Context& context, Evaluator& evaluator, const CaptureScript& script,
                             std::string channel, int repeats, bool firstFrames, fs::path folder)
    : context_(context),
      evaluator_(evaluator),
      script_(script),
      channel_(std::move(channel)),
      repeats_(repeats),
      firstFrames_(firstFrames),
      folder_(std::move(folder)),
      program_(folder_.empty() ? "" : sha256OfProgram()) {}

Settings SettingsMeter::resized(Settings settings, int divisor) const {
    settings.output = script_.settings.output;
    settings.output.width = std::max(settings.output.width / divisor, 1);
    settings.output.height = std::max(settings.output.height / divisor, 1);
    return settings;
}

double SettingsMeter::prepare(int divisor, const std::function<void(double)>& progress) {
    const Settings settings = resized(script_.settings, divisor);
    const double shots = static_cast<double>(script_.shots.size());
    double noise = 0;
    for (std::size_t i = 0; i < script_.shots.size(); ++i) {
        const Shot& shot = script_.shots[i];
        const Reference truth = evaluator_.reference(shot, shot.firstFrame, settings, [&](double fraction) {
            if (progress) progress((static_cast<double>(i) + fraction) / shots);
        });
        if (!truth.channels.contains(channel_))
            throw InputError(script_.scene.file.string(), "",
                             fmt::format("{} of shot {} is black: there is nothing to tune", channel_, shot.name));
        if (const auto found = truth.noise.find(channel_); found != truth.noise.end())
            noise = std::max(noise, found->second);
    }
    return noise;
}

Measured SettingsMeter::measure(const Settings& settings, int divisor) {
    if (folder_.empty()) return render({settings}, divisor).front();
    const Settings sized = resized(settings, divisor);
    Sha256 hash;
    hash.text(program_).text(context_.info().renderer).text(context_.info().version);
    for (const Shot& shot : script_.shots) hash.text(evaluator_.referenceKey(shot, shot.firstFrame, sized));
    hash.text(voxcone::toJson(sized).dump()).text(channel_).number(divisor).number(repeats_).number(firstFrames_);
    const fs::path file = folder_ / (hash.hex() + ".json");
    if (fs::exists(file)) return measuredOf(readJsonFile(file));

    fs::path markerFile = file;
    markerFile.replace_extension("measuring");
    Measured m;
    if (fs::exists(markerFile)) {
        fs::remove(markerFile);
        m.failure = "the program was ended while it measured this: a crash, or out of memory";
    } else {
        const Marker marker(markerFile);
        m = render({settings}, divisor).front();
    }
    writeTextFile(file, toJson(m).dump(2) + "\n");
    return m;
}

std::vector<Measured> SettingsMeter::compare(const std::vector<Settings>& list) {
    return render(list, 1);
}

std::vector<Measured> SettingsMeter::render(const std::vector<Settings>& list, int divisor) {
    std::vector<Measured> out(list.size());
    for (const Shot& shot : script_.shots) renderShot(shot, list, divisor, out);
    return out;
}

void SettingsMeter::renderShot(const Shot& shot, const std::vector<Settings>& list, int divisor,
                               std::vector<Measured>& out) {
    const int frame = shot.firstFrame;
    std::vector<std::unique_ptr<Trial>> trials(list.size());
    std::vector<Settings> sized;
    const auto attempt = [&](std::size_t i, const auto& work) {
        if (!out[i].failure.empty()) return;
        const auto fail = [&](const char* reason) {
            out[i] = {};
            out[i].failure = reason;
            trials[i].reset();
        };
        const auto start = std::chrono::steady_clock::now();
        try {
            work();
            out[i].seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        } catch (const std::bad_alloc&) {
            fail("out of memory");
        } catch (const Error& error) {
            fail(error.what());
        }
    };
    for (std::size_t i = 0; i < list.size(); ++i) {
        sized.push_back(resized(list[i], divisor));
        attempt(i, [&] {
            trials[i] = std::make_unique<Trial>(context_, evaluator_.sceneFor(sized[i]), shot, frame, sized[i]);
        });
    }
    std::vector<std::vector<Repeat>> repeats(list.size());
    for (int n = 0; n < repeats_; ++n)
        for (std::size_t i = 0; i < list.size(); ++i)
            attempt(i, [&] {
                Trial& trial = *trials[i];
                repeats[i].push_back(firstFrames_ ? trial.repeat() : Repeat{trial.warmedUp().first, trial.again()});
            });

    const double pixels = static_cast<double>(script_.settings.output.width) * script_.settings.output.height;
    for (std::size_t i = 0; i < list.size(); ++i) {
        attempt(i, [&] {
            const Measurement measurement = summarize(repeats[i]);
            const Settings::Output& output = sized[i].output;
            const double perPixel = pixels / (static_cast<double>(output.width) * output.height);
            double first = 0, steady = 0;
            for (const Measurement::Pass& pass : measurement.passes) {
                const double scale = isPerPixel(pass.name) ? perPixel : 1;
                if (pass.first) first += scale * pass.first->median;
                if (pass.steady) steady += scale * pass.steady->median;
            }
            const Reference truth = evaluator_.reference(shot, frame, sized[i]);
            const PictureResult picture = trials[i]->picture(truth, {channel_});
            Measured& m = out[i];
            const Repeat& built = trials[i]->warmedUp();
            m.buildSeconds += std::max(built.first.milliseconds - built.steady.milliseconds, 0.0) / 1000;
            // Sums of passes are what estimates scale; whole pictures have the frame's own time.
            m.firstMilliseconds = std::max(m.firstMilliseconds, divisor > 1 ? first : measurement.first.median);
            m.steadyMilliseconds = std::max(m.steadyMilliseconds, divisor > 1 ? steady : measurement.steady.median);
            for (const auto& [name, error] : picture.channels.at(channel_).errors)
                m.errors[name] = std::max(m.errors[name], std::abs(error));
            m.samplesPerPixel = std::max(m.samplesPerPixel, picture.samplesPerPixel);
            m.memoryBytes = std::max(m.memoryBytes, picture.memoryBytes);
        });
    }
}

}  // namespace voxcone
