#include "report/evaluate.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "capture/output.h"
#include "core/atomic_file.h"
#include "core/check.h"
#include "core/error.h"
#include "gl/context.h"
#include "metric/flip.h"
#include "metric/heatmap.h"
#include "metric/metrics.h"
#include "reference/path_tracer.h"
#include "report/sha256.h"
#include "scene/extract.h"
#include "scene/gltf_file.h"

namespace voxcone {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

/// To be raised when the path tracer gives other pictures for the same scene: cached references are then made anew.
constexpr int kPathTracerVersion = 1;

/// A level waits at most this many frames for its update (cascade.budget).
constexpr int kMostWaiting = 64;

constexpr const char* kReferenceChannels[] = {"beauty",       "direct", "indirect_diffuse", "indirect_specular",
                                              "transmission", "ao"};

// ---- Keys

template <int N, class T>
void add(Sha256& hash, const glm::vec<N, T>& v) {
    for (glm::length_t i = 0; i < N; ++i) hash.number(v[i]);
}

void add(Sha256& hash, const glm::dmat4& m) {
    for (glm::length_t i = 0; i < 4; ++i) add(hash, m[i]);
}

void add(Sha256& hash, const Light& light) {
    hash.number(static_cast<int>(light.type)).number(light.extracted);
    add(hash, light.intensity), add(hash, light.position), add(hash, light.direction), add(hash, light.up);
    for (const double value : {light.range, light.innerConeAngle, light.outerConeAngle, light.radius,
                               light.angularRadius, light.width, light.height})
        hash.number(value);
}

void add(Sha256& hash, const Environment& environment) {
    add(hash, environment.color);
    hash.number(environment.width).number(environment.height).number(environment.rotationDeg);
    for (const auto* texels : {&environment.radiance, &environment.residual}) {
        hash.number(std::uint64_t{texels->size()});
        for (const glm::vec3& texel : *texels) add(hash, texel);
    }
}

void add(Sha256& hash, const Pose& pose) {
    for (const glm::dmat4& matrix : pose.instances) add(hash, matrix);
    for (const Deformation& deformation : pose.deformations) {
        hash.number(std::uint64_t{deformation.weights.size()}).number(std::uint64_t{deformation.joints.size()});
        for (const float weight : deformation.weights) hash.number(weight);
        for (const glm::dmat4& joint : deformation.joints) add(hash, joint);
    }
}

/// Of a glTF and of every file that its buffers and images name. A .glb holds its own.
std::string hashFiles(const fs::path& path) {
    Sha256 hash;
    hash.text(readTextFile(path));
    const GltfFile file = readGltfFile(path);
    for (const char* kind : {"buffers", "images"}) {
        const json list = file.document.value(kind, json::array());
        for (std::size_t i = 0; i < list.size(); ++i) {
            const std::string uri = list[i].value("uri", "");
            if (uri.empty() || uri.starts_with("data:")) continue;
            const Bytes bytes = readUri(file, uri, fmt::format("{}[{}].uri", kind, i), UINT64_MAX);
            hash.text(uri).number(std::uint64_t{bytes.size()}).add(bytes.data(), bytes.size());
        }
    }
    return hash.hex();
}

// ---- Pictures

bool black(const Image& image) {
    return std::all_of(image.data.begin(), image.data.end(), [](float v) { return v == 0; });
}

/// What an 8-bit PNG keeps of it, so that errors are those of `voxcone compare`, which reads such files.
Image quantized(const Image& shown) {
    Image out = shown;
    for (float& v : out.data) v = linearFromSrgb(std::round(255 * srgbFromLinear(std::clamp(v, 0.0f, 1.0f))) / 255);
    return out;
}

void multiplyBy(Image& image, double factor) {
    for (float& v : image.data) v = static_cast<float>(v * factor);
}

double exposureOf(const Settings& settings) {
    return std::exp2(settings.output.exposure);
}

Image shownOf(const std::string& channel, const Image& image, const Settings& settings) {
    return channel == "beauty" ? displayOf(image, settings.output.toneMap) : pictureOf(channel, image, settings);
}

fs::path channelFile(const fs::path& folder, const std::string& channel) {
    return folder / (channel + ".exr");
}

/// Null when the folder does not hold a whole reference.
std::optional<Reference> readReference(const fs::path& folder, const std::string& key) {
    const fs::path facts = folder / "reference.json";
    if (!fs::exists(facts)) return std::nullopt;
    Reference reference;
    reference.key = key;
    try {
        const json tree = json::parse(readTextFile(facts));
        reference.samples = tree.at("samples"), reference.maxDepth = tree.at("depth");
        reference.seconds = tree.at("seconds");
        reference.standardErrors = tree.at("standard_error").get<std::map<std::string, double>>();
        reference.noise = tree.value("noise_relmse", reference.noise);
        for (const std::string channel : tree.at("channels"))
            reference.channels[channel] = readImage(channelFile(folder, channel));
    } catch (const json::exception& error) {
        throw InputError(facts.string(), "", "is no reference of this program; delete its folder");
    }
    return reference;
}

/// The facts go last: a folder without them was not finished.
void writeReference(const fs::path& folder, const Reference& reference) {
    json channels = json::array();
    for (const auto& [channel, image] : reference.channels) {
        writeExr(channelFile(folder, channel), image);
        channels.push_back(channel);
    }
    const json facts = {{"key", reference.key},
                        {"samples", reference.samples},
                        {"depth", reference.maxDepth},
                        {"seconds", reference.seconds},
                        {"standard_error", reference.standardErrors},
                        {"noise_relmse", reference.noise},
                        {"channels", channels}};
    writeTextFile(folder / "reference.json", facts.dump(2) + "\n");
}

// ---- Times

/// Value at `share` of the way through `sorted`.
double quantile(const std::vector<double>& sorted, double share) {
    const double place = share * static_cast<double>(sorted.size() - 1);
    const auto low = static_cast<std::size_t>(place);
    const std::size_t high = std::min(low + 1, sorted.size() - 1);
    return sorted[low] + (place - static_cast<double>(low)) * (sorted[high] - sorted[low]);
}

}  // namespace

Times timesOf(std::vector<double> repeats) {
    VOXCONE_CHECK(!repeats.empty(), "no repeats");
    std::vector<double> sorted = repeats;
    std::sort(sorted.begin(), sorted.end());
    return {quantile(sorted, 0.5), quantile(sorted, 0.1), quantile(sorted, 0.9), std::move(repeats)};
}

Measurement summarize(const std::vector<Repeat>& repeats) {
    Measurement out;
    std::vector<double> first, steady;
    struct PassRepeats {
        std::vector<double> first, steady;
    };
    std::vector<std::pair<std::string, PassRepeats>> passes;
    const auto take = [&](const FrameTimes& frame, std::vector<double> PassRepeats::*list) {
        for (const FrameStats::Pass& pass : frame.passes) {
            auto found = std::find_if(passes.begin(), passes.end(), [&](auto& p) { return p.first == pass.name; });
            if (found == passes.end()) found = passes.insert(passes.end(), {pass.name, {}});
            (found->second.*list).push_back(pass.milliseconds);
        }
    };
    for (const Repeat& repeat : repeats) {
        first.push_back(repeat.first.milliseconds), steady.push_back(repeat.steady.milliseconds);
        take(repeat.first, &PassRepeats::first);
        take(repeat.steady, &PassRepeats::steady);
    }
    out.first = timesOf(first), out.steady = timesOf(steady);
    const auto times = [](const std::vector<double>& list) {
        return list.empty() ? std::nullopt : std::optional(timesOf(list));
    };
    for (const auto& [name, list] : passes) out.passes.push_back({name, times(list.first), times(list.steady)});
    return out;
}

Image shownReference(const std::string& channel, const Image& linear, const Settings& settings) {
    Image image = linear;
    if (channel == "beauty") multiplyBy(image, exposureOf(settings));
    return shownOf(channel, image, settings);
}

const std::vector<std::string>& comparedChannels() {
    static const std::vector<std::string> channels = {"beauty", "indirect_diffuse", "indirect_specular",
                                                      "transmission"};
    return channels;
}

Trial::Trial(gl::Context& context, std::shared_ptr<const Scene> scene, const Shot& shot, int frame,
             const Settings& settings, int warmUp)
    : context_(context), scene_(std::move(scene)), settings_(settings) {
    const double time = shot.timeOf(frame);
    camera_ = cameraAt(shot, *scene_, time);
    renderer_ = std::make_unique<Renderer>(context_, *scene_, settings_, time);
    for (int i = 0; i < std::max(warmUp, 1); ++i) warmedUp_ = repeat();
}

FrameTimes Trial::again() {
    renderer_->render(camera_);
    context_.checkErrors();
    return {renderer_->stats().frameMilliseconds, renderer_->stats().passes};
}

Repeat Trial::repeat() {
    Repeat out;
    renderer_->invalidate();
    out.first = again();
    for (int i = 0; i < kMostWaiting && renderer_->stats().counts.at("levels_waiting") > 0; ++i) again();
    out.steady = again();
    return out;
}

std::uint64_t Trial::memoryBytes() const {
    std::uint64_t bytes = 0;
    for (const FrameStats::Memory& item : renderer_->stats().memory) bytes += item.bytes;
    return bytes;
}

PictureResult Trial::picture(const Reference& reference, const std::vector<std::string>& channels, bool multiplyAo) {
    PictureResult out;
    out.memoryBytes = memoryBytes();
    out.voxels = renderer_->stats().counts.at("voxels_occupied");

    out.samplesPerPixel = static_cast<double>(renderer_->coneSamples()) /
                          (static_cast<double>(settings_.output.width) * settings_.output.height);

    // What the multiplication takes away.
    Image lost;
    if (multiplyAo) {
        lost = renderer_->channel("indirect_diffuse");
        const Image ao = renderer_->channel("ao");
        for (std::size_t i = 0; i < lost.data.size(); ++i) lost.data[i] *= 1 - ao.data[i / 3];
    }
    for (const std::string& channel : channels) {
        const auto found = reference.channels.find(channel);
        if (found == reference.channels.end()) continue;
        Image truth = found->second, test = renderer_->channel(channel);
        if (channel == "beauty") multiplyBy(truth, exposureOf(settings_));
        const bool changed = multiplyAo && (channel == "beauty" || channel == "indirect_diffuse");
        if (changed) {
            const auto scale = static_cast<float>(channel == "beauty" ? exposureOf(settings_) : 1);
            for (std::size_t i = 0; i < test.data.size(); ++i) test.data[i] -= scale * lost.data[i];
        }
        requireComparable(truth, "reference " + channel, test, channel);
        ChannelResult& result = out.channels[channel];
        result.shown =
            quantized(channel == "beauty" && !changed ? renderer_->display() : shownOf(channel, test, settings_));
        result.errors = metricsByName(linearError(truth, test));
        const HdrFlip hdr = hdrFlip(truth, test);
        result.errors["hdr_flip"] = meanOf(hdr.error);
        const Image shownTruth = quantized(shownOf(channel, truth, settings_));
        result.errors.merge(metricsByName(displayError(shownTruth, result.shown)));
        result.heatmap = heatmap(hdr.error);
    }
    return out;
}

Evaluator::Evaluator(gl::Context& context, const CaptureScript& script, fs::path cache,
                     const Settings::Reference& reference)
    : context_(context),
      script_(script),
      cache_(std::move(cache)),
      referenceSettings_(reference),
      filesHash_(hashFiles(script.scene.file)) {}

std::shared_ptr<const Scene> Evaluator::sceneFor(const Settings& settings) {
    const std::pair key(settings.light.extractEnvironment, settings.light.extractEmitters);
    std::shared_ptr<const Scene>& scene = scenes_[key];
    if (!scene) {
        auto extracted = std::make_shared<Scene>(script_.scene);
        extractLights(*extracted, settings.light);
        scene = std::move(extracted);
    }
    return scene;
}

std::string Evaluator::referenceKey(const Shot& shot, int frame, const Settings& settings) {
    const auto scene = sceneFor(settings);
    const double time = shot.timeOf(frame);
    const Camera camera = cameraAt(shot, *scene, time);
    Sha256 hash;
    hash.text("voxcone reference").number(kPathTracerVersion).text(filesHash_);
    add(hash, scene->pose(time));
    for (const Light& light : scene->lightsAt(time)) add(hash, light);
    for (const Material& material : scene->materials) hash.number(material.extracted);
    add(hash, scene->environment);
    add(hash, camera.position), add(hash, camera.target), add(hash, camera.up);
    for (const double value : {camera.verticalFovDeg, camera.near, camera.far}) hash.number(value);
    const Settings::Output& output = settings.output;
    hash.number(output.width).number(output.height).number(output.supersample);
    hash.number(settings.ao.distance).number(static_cast<int>(settings.ao.falloff));
    const Settings::Reference& r = referenceSettings_;
    hash.number(r.samples).number(r.error).number(r.maxDepth).number(r.seed);
    return hash.hex();
}

Reference Evaluator::reference(const Shot& shot, int frame, const Settings& settings,
                               const std::function<void(double)>& progress) {
    const std::string key = referenceKey(shot, frame, settings);
    const fs::path folder = cache_ / key;
    if (std::optional<Reference> cached = readReference(folder, key)) return *std::move(cached);

    const auto scene = sceneFor(settings);
    const double time = shot.timeOf(frame);
    Settings traced = settings;
    traced.reference = referenceSettings_;
    const PathTracer tracer(*scene, time);
    ReferenceImages images = tracer.render(cameraAt(shot, *scene, time), traced, progress);
    ++referencesRendered_;

    Reference reference;
    reference.key = key;
    reference.samples = images.samples, reference.maxDepth = referenceSettings_.maxDepth;
    reference.seconds = images.seconds;
    reference.standardErrors = {{"beauty", images.beautyError}, {"indirect_diffuse", images.indirectDiffuseError}};
    Image* const all[] = {&images.beauty,           &images.direct,       &images.indirectDiffuse,
                          &images.indirectSpecular, &images.transmission, &images.ao};
    for (std::size_t i = 0; i < std::size(all); ++i)
        if (!black(*all[i])) reference.channels[kReferenceChannels[i]] = std::move(*all[i]);
    for (const auto& [channel, noise] : images.noise)
        if (reference.channels.contains(channel)) reference.noise[channel] = noise;
    writeReference(folder, reference);
    return reference;
}

Measurement Evaluator::measure(const Shot& shot, int frame, const Settings& settings, int repeats, int warmUp) {
    const Reference truth = reference(shot, frame, settings);
    Trial trial(context_, sceneFor(settings), shot, frame, settings, warmUp);
    std::vector<Repeat> list;
    for (int i = 0; i < std::max(repeats, 1); ++i) list.push_back(trial.repeat());
    Measurement out = summarize(list);
    out.picture = trial.picture(truth, comparedChannels());
    return out;
}

}  // namespace voxcone
