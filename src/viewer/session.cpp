#include "viewer/session.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "capture/output.h"
#include "core/atomic_file.h"
#include "core/error.h"

namespace voxcone {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr double kKeyInterval = 0.1;     ///< seconds between keys of a recorded path
constexpr double kResizeSettles = 0.25;  ///< seconds until a picture of a new size is begun
constexpr std::size_t kMostMessages = 200, kMostRecent = 10;

bool sameCamera(const Camera& a, const Camera& b) {
    return a.position == b.position && a.target == b.target && a.up == b.up && a.verticalFovDeg == b.verticalFovDeg &&
           a.near == b.near && a.far == b.far;
}

}  // namespace

bool sameView(const View& a, const View& b) {
    return a.scene == b.scene && sameCamera(a.camera, b.camera) && a.time == b.time && a.channel == b.channel &&
           a.clipmapEye == b.clipmapEye && a.voxels == b.voxels && a.triangles == b.triangles && a.lights == b.lights &&
           a.placed == b.placed && a.placing == b.placing && a.watched == b.watched &&
           sameSettings(a.settings, b.settings);
}

namespace {

bool isPanorama(const fs::path& file) {
    std::string extension = file.extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return std::tolower(c); });
    return extension == ".hdr" || extension == ".exr";
}

/// A name for a shot's folder out of a file's.
std::string plainName(const std::string& text) {
    std::string name;
    for (const char c : text)
        name += std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '-' ? c : '_';
    return name.empty() ? "scene" : name.substr(0, 80);
}

template <class T>
void keepLast(std::deque<T>& values, T value, std::size_t most) {
    values.push_back(std::move(value));
    while (values.size() > most) values.pop_front();
}

}  // namespace

void CostHistory::add(const Picture& picture) {
    for (auto& [name, values] : passes) keepLast(values, 0.0f, kFrames);
    for (const FrameStats::Pass& pass : picture.stats.passes) {
        auto& values = passes[pass.name];
        if (values.empty()) values.push_back(0);
        values.back() = static_cast<float>(pass.milliseconds);
    }
    keepLast(frame, static_cast<float>(picture.stats.frameMilliseconds), kFrames);
    if (!picture.clipmap.update.empty()) lastUpdate = picture.stats;
    voxels.resize(static_cast<std::size_t>(std::max(picture.clipmap.layout.levels, 0)));
    levels.resize(voxels.size());
    for (std::size_t level = 0; level < voxels.size(); ++level) {
        long long sum = 0;
        for (const auto* regions : {&picture.clipmap.update.fixed, &picture.clipmap.update.moving})
            for (const Region& region : *regions)
                if (region.level == static_cast<int>(level) && !picture.clipmap.update.all) sum += region.box.volume();
        keepLast(voxels[level], static_cast<float>(sum), kFrames);
        const auto& cost = picture.stats.levelMilliseconds;
        const auto found = cost.find(static_cast<int>(level));
        keepLast(levels[level], found == cost.end() ? 0.0f : static_cast<float>(found->second), kFrames);
    }
}

Session::Session(RenderThread& renderThread, ViewerFolders where, std::function<void(Settings&)> change)
    : thread(renderThread),
      folders(std::move(where)),
      flicker([this] { wake(); }),
      prepare_(std::move(change)),
      measuring_([this] { wake(); }) {
    if (folders.config.empty()) return;
    const json list = [&] {
        std::error_code none;
        const fs::path file = folders.config / "recent.json";
        if (!fs::exists(file, none)) return json();
        return json::parse(readTextFile(file), nullptr, false);
    }();
    if (list.is_array())
        for (const json& item : list)
            if (item.is_string()) recent.emplace_back(item.get<std::string>());
}

void Session::say(const std::string& text, bool error) {
    messages.push_back({text, error});
    while (messages.size() > kMostMessages) messages.pop_front();
    messageTime = Clock::now();
}

// ---- Files

void Session::open(const fs::path& file) {
    if (isPanorama(file)) {
        if (!facts) return say("open a scene before an environment", true);
        environmentFile = fs::absolute(file);
        thread.environment(environmentFile);
        if (other) other->thread().environment(environmentFile);
    } else {
        thread.open(fs::absolute(file), prepare_);
    }
}

void Session::remember(const fs::path& file) {
    std::erase(recent, file);
    recent.insert(recent.begin(), file);
    if (recent.size() > kMostRecent) recent.resize(kMostRecent);
    if (folders.config.empty()) return;
    json list = json::array();
    for (const fs::path& item : recent) list.push_back(item.string());
    try {
        writeTextFile(folders.config / "recent.json", list.dump(1) + "\n");
    } catch (const Error& error) {
        say(error.what(), true);
    }
}

fs::path Session::freshFile(const std::string& stem, const std::vector<std::string>& extensions) const {
    for (int number = 1;; ++number) {
        const fs::path file = folders.output / fmt::format("{}_{:03}", stem, number);
        std::error_code none;
        const bool taken = std::any_of(extensions.begin(), extensions.end(),
                                       [&](const std::string& e) { return fs::exists(file.string() + e, none); });
        if (!taken) return file;
    }
}

void Session::takeScene() {
    const auto next = thread.scene();
    if (!next || next == facts) return;
    const std::uint64_t serial = thread.sceneSerial();
    facts = next;
    const std::vector<Light> before = std::move(lights);
    lights = facts->outline.lights;
    scene_ = facts->outline;
    if (serial == sceneSerial) {
        // What was moved stays where it is when only extraction or the environment has changed.
        takeLights(before);
        poseScene();
        edits_.replace({lights, edits_.now().placed});
        return;
    }
    sceneSerial = serial;
    placed.clear();
    selectedNode = -1;
    poseScene();
    edits_.begin({lights, placed});
    endOther();
    settings.begin(facts->settings);
    environmentFile.clear();
    playing = false;
    frozenEye.reset();
    forgetInspection();
    releaseHeld();
    clearChanges();
    slice.reset();
    cutAxis = -1;
    flashes.clear();
    history = {};
    levelShown.clear();
    views.clear();
    recording = false;
    // A script says how large its pictures are, a bare scene does not.
    followWindow = facts->file.extension() != ".json";
    takeShot(0);
    remember(facts->file);
    say(fmt::format("{}: {} triangles", facts->file.filename().string(), facts->triangles));
}

// ---- Cameras

void Session::takeShot(int index) {
    shot = std::clamp(index, 0, static_cast<int>(facts->shots.size()) - 1);
    const Shot& s = facts->shots[static_cast<std::size_t>(shot)];
    time = s.timeOf(s.firstFrame);
    followShot = !s.path.empty() || s.camera.node >= 0;
    Camera c = cameraAt(s, scene_, time);
    camera.set(c);
}

void Session::takeCamera(const Camera& c) {
    camera.set(worldCamera(c, scene_.worldMatrices(time)));
    followShot = false;
}

void Session::frameScene() {
    moved();
    const Settings::Output& output = settings.now().output;
    camera.frame(facts->bounds, static_cast<double>(output.width) / output.height);
}

std::optional<glm::dvec3> Session::surfaceAt(const glm::dvec2& place) const {
    if (!picture || picture->position.data.empty()) return std::nullopt;
    const Image& image = picture->position;
    const int x = std::clamp(static_cast<int>(place.x * image.width), 0, image.width - 1);
    const int y = std::clamp(static_cast<int>(place.y * image.height), 0, image.height - 1);
    const float* p = image.pixel(x, y);
    if (p[0] == 0 && p[1] == 0 && p[2] == 0) return std::nullopt;  // background
    return glm::dvec3(p[0], p[1], p[2]);
}

bool Session::focus(const glm::dvec2& place) {
    const auto surface = surfaceAt(place);
    if (!surface) return false;
    moved();
    camera.focus(*surface);
    return true;
}

// ---- Questions

namespace {

/// Exact where the renderer's beauty is exposed.
glm::vec3 withoutExposure(const glm::vec3& exposed, double exposure) {
    return exposed * static_cast<float>(std::exp2(-exposure));
}

glm::vec3 pixelOf(const Image& image, int x, int y) {
    const float* p = image.pixel(x, y);
    return {p[0], p[1], p[2]};
}

json array(const glm::dvec3& v) {
    return {v.x, v.y, v.z};
}

}  // namespace

void Session::inspect(const glm::dvec2& place) {
    if (!facts) return;
    const Settings::Output& output = settings.now().output;
    const glm::ivec2 pixel = glm::clamp(glm::ivec2(place * glm::dvec2(output.width, output.height)), glm::ivec2(0),
                                        glm::ivec2(output.width, output.height) - 1);
    forgetInspection();
    threadAt(place).afterPicture([this, pixel](RenderThread::Desk& desk) {
        auto found = std::make_shared<Inspection>();
        found->pixel = pixel;
        found->view = desk.view;
        const Settings::Output& size = desk.view.settings.output;
        if (pixel.x >= size.width || pixel.y >= size.height) return;
        if (withoutCones(desk.view)) desk.renderer.render(desk.view.camera);
        const int n = size.supersample;
        found->lobes = desk.renderer.inspect(pixel.x * n + n / 2, pixel.y * n + n / 2);
        for (const char* name :
             {"beauty", "direct", "indirect_diffuse", "indirect_specular", "transmission", "emission"}) {
            const glm::vec3 value = pixelOf(desk.renderer.channel(name), pixel.x, pixel.y);
            found->terms.emplace_back(name,
                                      std::string(name) == "beauty" ? withoutExposure(value, size.exposure) : value);
        }
        auto scene = std::make_shared<Scene>(desk.scene);
        thread.deliver([this, found, scene] {
            Settings s = found->view.settings;
            const Camera c =
                pixelCamera(found->view.camera, s.output.width, s.output.height, found->pixel.x, found->pixel.y);
            s.output.width = s.output.height = 1;
            // Few paths see small bright things; those of one pixel cost little.
            s.reference.samples = std::max(s.reference.samples, 1 << 16);
            found->tracer = std::make_unique<BackgroundTracer>(scene, found->view.time, c, s, 256, wake);
            forgetInspection();
            inspection = std::make_unique<Inspection>(std::move(*found));
        });
    });
}

std::optional<glm::vec3> Inspection::traced(const std::string& term) const {
    const auto picture = tracer ? tracer->picture() : nullptr;
    if (!picture) return std::nullopt;
    const std::map<std::string, const Image*> images = {{"beauty", &picture->beauty},
                                                        {"direct", &picture->direct},
                                                        {"indirect_diffuse", &picture->indirectDiffuse},
                                                        {"indirect_specular", &picture->indirectSpecular},
                                                        {"transmission", &picture->transmission},
                                                        {"emission", &picture->emission}};
    return pixelOf(*images.at(term), 0, 0);
}

std::string Inspection::json() const {
    nlohmann::json tree = {{"pixel", {pixel.x, pixel.y}},
                           {"camera",
                            {{"position", array(view.camera.position)},
                             {"target", array(view.camera.target)},
                             {"up", array(view.camera.up)},
                             {"fov_deg", view.camera.verticalFovDeg}}},
                           {"time_s", view.time},
                           {"settings", toJson(view.settings)}};
    for (const auto& [name, value] : terms) {
        tree["terms"][name] = {{"voxels", array(value)}};
        if (const auto reference = traced(name)) tree["terms"][name]["path_traced"] = array(*reference);
    }
    if (const auto picture = tracer ? tracer->picture() : nullptr)
        tree["path_tracer"] = {{"samples", picture->samples}, {"relative_error", picture->error}};
    tree["surface"] = nullptr;
    tree["lobes"] = nlohmann::json::object();
    for (const PixelCones& one : lobes) {
        tree["surface"] = {{"position", array(one.position)}, {"normal", array(one.normal)}};
        nlohmann::json cones = nlohmann::json::array();
        for (const InspectedCone& cone : one.cones) {
            nlohmann::json samples = nlohmann::json::array();
            for (const ConeSample& s : cone.samples)
                samples.push_back({{"distance_m", s.distance},
                                   {"length_m", s.length},
                                   {"level", s.level},
                                   {"footprint_m", s.footprint},
                                   {"transmittance", s.transmittance},
                                   {"openness", s.openness},
                                   {"radiance", array(s.radiance)}});
            cones.push_back({{"origin", array(cone.origin)},
                             {"direction", array(cone.direction)},
                             {"tan_half_angle", cone.tanHalfAngle},
                             {"sky_tan_half_angle", cone.skyTanHalfAngle},
                             {"weight", cone.weight},
                             {"radiance", array(cone.radiance)},
                             {"sky", array(cone.sky)},
                             {"transmittance", cone.transmittance},
                             {"openness", cone.openness},
                             {"truncated", cone.truncated},
                             {"samples", samples}});
        }
        tree["lobes"][nameOf(one.lobe)] = {{"channel", channelOf(one.lobe)},
                                           {"gathered", array(one.radiance())},
                                           {"share", array(one.share)},
                                           {"outgoing", array(one.outgoing())},
                                           {"cones", cones}};
    }
    return tree.dump(2);
}

void Session::hold() {
    if (!picture || !picture->finished || picture->image.data.empty())
        return say("the picture is not finished yet", true);
    releaseHeld();
    held = Held{picture->texture, std::make_shared<const Image>(picture->image), "held " + picture->view.channel};
}

void Session::releaseHeld() {
    held.reset();
    retire(std::move(referenceTracer));
    traced_.reset();
    presentToHeld.forget();
    otherToHeld.forget();
}

void Session::holdFile(const fs::path& file) {
    try {
        Image image = readImage(file);
        if (image.channels < 3) throw InputError(file.string(), "", "has no colours");
        if (image.channels > 3) {
            Image three(image.width, image.height, 3);
            for (int y = 0; y < image.height; ++y)
                for (int x = 0; x < image.width; ++x) std::copy_n(image.pixel(x, y), 3, three.pixel(x, y));
            image = std::move(three);
        }
        releaseHeld();
        held = Held{nullptr, std::make_shared<const Image>(std::move(image)), file.filename().string()};
    } catch (const Error& error) {
        say(error.what(), true);
    }
}

void Session::holdReference() {
    if (!facts) return;
    releaseHeld();
    channel = "beauty";
    thread.now([this](RenderThread::Desk& desk) {
        auto scene = std::make_shared<Scene>(desk.scene);
        const View view = desk.view;
        thread.deliver([this, scene, view] {
            referenceView_ = view;
            const int n = view.settings.output.supersample;
            referenceTracer = std::make_unique<BackgroundTracer>(scene, view.time, view.camera, view.settings,
                                                                 std::max(2, 2 * n * n), wake);
        });
    });
}

void Session::retire(std::unique_ptr<BackgroundTracer> tracer) {
    if (!tracer) return;
    tracer->stop();
    retired_.push_back(std::move(tracer));
}

void Session::forgetInspection() {
    if (inspection) retire(std::move(inspection->tracer));
    inspection.reset();
}

void Session::takeTraced() {
    std::erase_if(retired_, [](const auto& tracer) { return !tracer->running(); });
    if (!referenceTracer) return;
    const auto next = referenceTracer->picture();
    if (!next || next == traced_) return;
    traced_ = next;
    Image exposed = next->beauty;
    const auto exposure = static_cast<float>(std::exp2(referenceView_.settings.output.exposure));
    for (float& value : exposed.data) value *= exposure;
    Held reference;
    reference.image = std::make_shared<const Image>(std::move(exposed));
    reference.name = fmt::format("path traced, {} samples, error {:.2g} %", next->samples, 100 * next->error);
    held = std::move(reference);
}

void Session::compare() {
    measuring_.take();
    const auto follow = [&](Measurement& measurement, const std::shared_ptr<const Image>& reference,
                            const Settings& referenceSettings, const std::shared_ptr<const Image>& test,
                            const Picture& of) {
        if (reference && test)
            measurement.follow(measuring_,
                               {reference, test, of.view.channel, referenceSettings, of.view.settings, errorMap});
    };
    if (!held && !other) return;
    const std::shared_ptr<const Picture> second = other ? other->picture() : nullptr;
    const std::shared_ptr<const Image> a = presentImage(picture), b = otherImage(second);
    if (held && a) follow(presentToHeld, held->image, picture->view.settings, a, *picture);
    if (held && b) follow(otherToHeld, held->image, second->view.settings, b, *second);
    if (!a || !b) return;
    // While the camera moves, one may be ahead of the other.
    View sight = second->view;
    sight.scene = picture->view.scene;
    sight.settings = picture->view.settings;
    sight.lights = picture->view.lights;
    sight.watched = picture->view.watched;
    if (sameView(picture->view, sight)) follow(otherToPresent, a, picture->view.settings, b, *second);
}

void Session::compareWith(const std::string& preset) {
    if (!facts || other) return;
    if (otherEnds_.valid() && otherEnds_.wait_for(std::chrono::seconds(0)) != std::future_status::ready)
        return say("the renderer of the last settings B has not ended yet", true);
    try {
        Settings b = settingsA();
        if (!preset.empty()) applyPreset(b, preset);
        other = std::make_unique<OtherSettings>(otherThread(), facts->file, environmentFile, b);
        exchangeControls();
    } catch (const Error& error) {
        say(error.what(), true);
    }
}

void Session::endOther(bool keep) {
    if (!other) return;
    if (controlsOther) exchangeControls();
    if (keep) settings.change(settingsB(), "settings B");
    otherEnds_ = std::move(*other).end();
    other.reset();
    otherImage = {};
    otherToHeld.forget();
    otherToPresent.forget();
}

void Session::exchangeControls() {
    if (!other) return;
    controlsOther = !controlsOther;
    std::swap(settings, other->settings);
}

void Session::reloadShaders() {
    thread.reloadShaders();
    if (other) other->thread().reloadShaders();
}

void Session::updateOther(const View& shown) {
    std::vector<Message> told;
    other->update(told);
    for (const Message& message : told) say("B: " + message.text, message.error);
    // The size is that of the settings that the controls change.
    Settings parked = other->settings.now();
    parked.output.width = settings.now().output.width;
    parked.output.height = settings.now().output.height;
    if (!sameSettings(parked, other->settings.now())) other->settings.replace(parked);
    other->show(shown, settingsB());
}

void Session::watchPicture() {
    flicker.update();
    if (flicker.watched == Watched::none || !picture || picture == watched_ || !picture->watched) return;
    if (!picture->light.whole) return;  // light that is being gathered is no flicker
    // Other settings are no change from frame to frame; what moves by itself is.
    if (watched_ && !sameSettings(watched_->view.settings, picture->view.settings)) flicker.clear();
    watched_ = picture;
    if (picture->watched->what == flicker.watched) flicker.take(picture->watched);
}

void Session::watch(Watched what) {
    if (what == flicker.watched) return;
    clearChanges();
    flicker.watched = what;
}

void Session::clearChanges() {
    flicker.clear();
    watched_.reset();
}

void Session::askSlice() {
    if (!facts || !picture) return;
    const int axis = sliceAxis, depth = sliceDepth, at = std::max(level, 0);
    const int bounce = voxelChannel().bounce;
    const std::uint64_t serial = ++sliceSerial_;
    slicePicture_ = picture->serial;
    sliceBounce_ = bounce;
    sliceSettled_ = picture->finished;
    thread.now([this, axis, depth, at, bounce, serial](RenderThread::Desk& desk) {
        auto read = std::make_shared<VoxelSlice>(desk.renderer.voxelSlice(at, axis, depth, bounce));
        thread.deliver([this, read, serial] {
            sliceAnswered_ = serial;
            slice = read;
        });
    });
}

void Session::askOccupancy(int ofLevel) {
    if (!facts || !picture || ofLevel >= picture->clipmap.layout.count()) return;
    const int slices = picture->clipmap.layout.resolutionOf(ofLevel);
    occupancy.reset();
    occupancyLevel = ofLevel;
    thread.now([this, ofLevel, slices](RenderThread::Desk& desk) {
        Occupancy all;
        for (int depth = 0; depth < slices; ++depth) all.add(desk.renderer.voxelSlice(ofLevel, 2, depth));
        thread.deliver([this, ofLevel, all] {
            if (ofLevel == occupancyLevel) occupancy = all;
        });
    });
}

/// Counts what the cones of the finished picture look at, which gathers it once more.
void Session::askSamples() {
    if (!countSamples || !picture || !picture->finished || picture->serial == samplesAsked_) return;
    const std::uint64_t serial = samplesAsked_ = picture->serial;
    thread.afterPicture([this, serial](RenderThread::Desk& desk) {
        const Settings::Output& output = desk.view.settings.output;
        const double pixels = static_cast<double>(output.width) * output.height;
        const double samples = withoutCones(desk.view) ? 0 : static_cast<double>(desk.renderer.coneSamples());
        thread.deliver([this, serial, each = samples / pixels] {
            samplesPerPixel = each;
            samplesSerial = serial;
        });
    });
}

// ---- Clipmap

void Session::freeze(bool on) {
    if (on == frozen()) return;
    if (on) {
        frozenEye = camera.camera().position;
    } else {
        frozenEye.reset();
    }
}

void Session::stepClipmap() {
    if (!picture || picture->clipmap.layout.levels == 0) return;
    freeze(true);
    const ClipmapLayout& layout = picture->clipmap.layout;
    const double step = layout.voxelSize * layout.snapOf(0);
    const glm::dvec3 way = camera.camera().position - *frozenEye;
    frozenEye = *frozenEye + glm::clamp(way, -step, step);
}

// ---- Views and recording

SavedView Session::viewNow(const std::string& name) const {
    SavedView view;
    view.name = name;
    view.channel = shownChannel();
    view.camera = camera.camera();
    view.camera.up = camera.up();
    view.time = time;
    return view;
}

void Session::saveView() {
    if (!facts) return;
    views.push_back(viewNow(fmt::format("view{}", views.size() + 1)));
    say(fmt::format("saved {}", views.back().name));
}

void Session::recallView(const SavedView& view) {
    followShot = false;
    time = view.time;
    Camera c = view.camera;
    if (!view.path.empty()) {
        c.position = view.path.position.values.front();
        c.target = view.path.target.values.front();
    }
    c.up = uprightOf(c.up, glm::normalize(c.target - c.position));
    camera.set(c);
    channel = baseChannel(view.channel);
    level = voxelFace = voxelBounce = -1;
    if (VoxelChannel voxel; VoxelChannel::parse(view.channel, voxel).empty()) {
        level = voxel.level;
        voxelFace = voxel.face;
        voxelBounce = voxel.bounce;
    }
}

void Session::startRecording() {
    if (!facts || recording) return;
    recording = true;
    recordClock_ = 0;
    recorded_ = viewNow(fmt::format("path{}", views.size() + 1));
    recorded_.path.position.interpolation = recorded_.path.target.interpolation = Interpolation::catmull_rom;
    say("recording the camera");
}

void Session::stopRecording() {
    if (!recording) return;
    recording = false;
    if (recorded_.path.position.times.size() < 2) return say("nothing was recorded", true);
    say(fmt::format("recorded {}: {:.1f} s, {} frames", recorded_.name, recorded_.path.position.times.back(),
                    recorded_.frames()));
    views.push_back(recorded_);
}

void Session::writeScript() {
    if (!facts) return;
    std::vector<SavedView> shots = views;
    if (shots.empty()) shots.push_back(viewNow("view1"));
    try {
        const ScriptSource source{facts->file, environmentFile, &facts->outline};
        const json tree = captureScript(source, lights, placed, settings.now(), shots);
        const fs::path file = freshFile(plainName(facts->file.stem().string()), {".json"}).string() + ".json";
        writeTextFile(file, tree.dump(2) + "\n");
        say(fmt::format("wrote {}", file.string()));
    } catch (const Error& error) {
        say(error.what(), true);
    }
}

void Session::screenshot() {
    if (!facts) return;
    const fs::path stem =
        freshFile(plainName(facts->file.stem().string()) + "_" + plainName(channel), {".exr", ".png"});
    RenderThread& shown = controlsOther ? other->thread() : thread;
    shown.afterPicture([this, stem](RenderThread::Desk& desk) {
        const View& view = desk.view;
        // With a budget a frame depends on those before it, but for the first.
        if (view.settings.cascade.update == CascadeUpdate::budget) {
            desk.renderer.invalidate();
            desk.renderer.render(view.camera);
        }
        const Image image = desk.renderer.channel(view.channel);
        const fs::path exr = stem.string() + ".exr", png = stem.string() + ".png";
        writeExr(exr, image);
        writePng(png,
                 view.channel == "beauty" ? desk.renderer.display() : pictureOf(view.channel, image, view.settings));
        const bool frozenView = view.clipmapEye.has_value();
        thread.deliver([this, exr, png, frozenView] {
            say(fmt::format("wrote {} and {}", png.string(), exr.filename().string()));
            if (frozenView) say("the clipmap is frozen: a capture of this view differs", true);
        });
    });
}

// ---- Settings

void Session::savePreset(const std::string& name) {
    try {
        json tree = toJson(settings.now());
        tree.erase("output");
        tree.erase("reference");
        const fs::path file = folders.output / (plainName(name) + ".json");
        writeTextFile(file, tree.dump(2) + "\n");
        say(fmt::format("wrote {}", file.string()));
    } catch (const Error& error) {
        say(error.what(), true);
    }
}

void Session::applyPresetByName(const std::string& nameOrFile) {
    try {
        Settings next = settings.now();
        applyPreset(next, nameOrFile);
        settings.change(next, "preset " + nameOrFile);
    } catch (const Error& error) {
        say(error.what(), true);
    }
}

void Session::undo() {
    rememberEdits();
    if (edits_.canUndo(settings)) {
        edits_.undo();
        takeEdits();
    } else if (settings.canUndo()) {
        settings.undo();
    }
}

void Session::redo() {
    rememberEdits();
    if (edits_.canRedo(settings)) {
        edits_.redo();
        takeEdits();
    } else if (settings.canRedo()) {
        settings.redo();
    }
}

// ---- The loop

VoxelChannel Session::voxelChannel() const {
    VoxelChannel voxel;
    voxel.base = channel;
    voxel.level = level;
    if (voxel.hasFaces()) voxel.face = voxelFace;
    if (voxel.showsLight()) voxel.bounce = voxelBounce;
    return voxel;
}

std::string Session::shownChannel() const {
    return channel.starts_with("voxel_") ? voxelChannel().name() : channel;
}

View Session::view() const {
    View v;
    v.scene = sceneSerial;
    v.camera = camera.camera();
    v.time = time;
    v.channel = shownChannel();
    v.settings = settingsA();
    v.watched = flicker.watched;
    v.clipmapEye = frozenEye;
    v.lights = lights;
    v.placed = placed;
    v.placing = dragging && placed != edits_.now().placed;
    if (channel.starts_with("voxel_")) {
        v.triangles = triangles;
        v.voxels.edges = voxels.edges;
        if (cutAxis >= 0 && facts) {
            v.voxels.cutNormal[cutAxis] = cutFlipped ? -1 : 1;
            const double place =
                facts->bounds.min[cutAxis] + cutPlace * (facts->bounds.max[cutAxis] - facts->bounds.min[cutAxis]);
            v.voxels.cutOffset = cutFlipped ? -place : place;
        }
    }
    return v;
}

void Session::takePicture(const std::shared_ptr<const Picture>& next) {
    if (!next || next == picture) return;
    picture = next;
    if (picture->view.scene != sceneSerial || picture->surfaces) return;
    history.add(*picture);
    const ClipmapState& clipmap = picture->clipmap;
    if (levelShown.size() != static_cast<std::size_t>(clipmap.layout.levels))
        levelShown.assign(static_cast<std::size_t>(clipmap.layout.levels), 1);
    if (clipmap.update.all) return;  // everything
    for (const Region& region : clipmap.update.fixed) {
        const double edge = clipmap.layout.voxelSizeOf(region.level);
        Flash flash;
        flash.box.min = clipmap.origin + edge * glm::dvec3(region.box.low);
        flash.box.max = clipmap.origin + edge * glm::dvec3(region.box.high);
        flash.level = region.level;
        flash.start = Clock::now();
        flashes.push_back(flash);
    }
}

bool Session::update(double seconds, const glm::ivec2& place) {
    thread.takeResults();
    bool changed = false;
    for (Message& message : thread.takeMessages()) {
        say(message.text, message.error);
        changed = true;
    }
    const auto before = picture;
    takeScene();
    if (!facts) return changed;
    takePicture(thread.picture());
    takeTraced();
    compare();
    watchPicture();
    askSamples();
    changed |= picture != before;

    const auto now = Clock::now();
    while (!flashes.empty() && now - flashes.front().start > std::chrono::milliseconds(800)) flashes.pop_front();

    if (playing && facts->duration > 0) {
        time += seconds;
        if (time > facts->duration) time = std::fmod(time, facts->duration);
    }
    if (followShot) camera.set(cameraAt(facts->shots[static_cast<std::size_t>(shot)], scene_, time));
    if (recording) {
        Track& positions = recorded_.path.position;
        Track& targets = recorded_.path.target;
        if (positions.times.empty() || recordClock_ - positions.times.back() >= kKeyInterval) {
            const Camera c = camera.camera();
            positions.times.push_back(recordClock_);
            targets.times.push_back(recordClock_);
            positions.values.push_back(c.position);
            targets.values.push_back(c.target);
        }
        recordClock_ += seconds;
    }

    // A picture of each size that a dragged border passes would never be finished.
    if (place != lastPlace_) {
        lastPlace_ = place;
        placeChanged_ = now;
    }
    if (followWindow && place.x > 0 && place.y > 0 &&
        (place_ == glm::ivec2(0) || now - placeChanged_ > std::chrono::duration<double>(kResizeSettles))) {
        place_ = place;
        Settings s = settings.now();
        s.output.width = std::min(place.x, 16384);
        s.output.height = std::min(place.y, 16384);
        if (!sameSettings(s, settings.now())) settings.replace(s);
    }

    rememberEdits();
    const View wanted = view();
    if (!shown_ || !sameView(*shown_, wanted)) {
        shown_ = wanted;
        shownSerial_ = thread.show(wanted);
    }
    if (other) updateOther(wanted);
    return changed;
}

bool Session::settled() const {
    return shown_ && thread.idle() && picture && picture->finished && picture->serial == shownSerial_;
}

}  // namespace voxcone
