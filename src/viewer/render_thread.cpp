#include "viewer/render_thread.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <nlohmann/json.hpp>
#include <utility>

#include "capture/capture.h"
#include "capture/output.h"
#include "core/error.h"
#include "gl/shader_library.h"
#include "scene/environment.h"
#include "scene/extract.h"
#include "viewer/presenter.h"

namespace voxcone {

namespace fs = std::filesystem;

/// What is being rendered.
struct RenderThread::Loaded {
    fs::path file;
    CaptureScript script;
    std::vector<Light> lights;  ///< of scene and script, without extracted ones
    std::vector<Node> nodes;    ///< where scene and script have them
    std::map<int, Placement> placed;

    /// Puts nodes elsewhere, all others back.
    void place(const std::map<int, Placement>& where) {
        placed = where;
        script.scene.nodes = nodes;
        for (const auto& [node, placement] : placed)
            voxcone::place(script.scene.nodes.at(static_cast<std::size_t>(node)), placement);
    }

    /// Takes back what was extracted and extracts anew.
    void extract(const Settings::Light& settings) {
        Scene& scene = script.scene;
        scene.lights = lights;
        scene.environment.residual.clear();
        for (Material& material : scene.materials) material.extracted = false;
        extractLights(scene, settings);
    }
};

namespace {

/// Longest time for a picture, in milliseconds, while light gathers.
constexpr double kUnsettledMilliseconds = 500;

bool sameExtraction(const Settings::Light& a, const Settings::Light& b) {
    return a.extractEnvironment == b.extractEnvironment && a.extractEmitters == b.extractEmitters;
}

/// Whether a renderer built for `a` serves `b`, but for the output.
bool sameRenderer(const Settings& a, Settings b) {
    b.output = a.output;
    b.reference = a.reference;
    return sameSettings(a, b);
}

/// The last time at which something is animated.
double lastKey(const CaptureScript& script) {
    double last = 0;
    const auto take = [&](const std::vector<double>& times) {
        if (!times.empty()) last = std::max(last, times.back());
    };
    for (const Animation& animation : script.scene.animations)
        for (const AnimationChannel& channel : animation.channels) take(channel.times);
    for (const Light& light : script.scene.lights) {
        take(light.track.position.times);
        take(light.track.direction.times);
        take(light.track.intensity.times);
    }
    for (const Shot& shot : script.shots) take(shot.path.position.times);
    return last;
}

}  // namespace

bool withoutCones(const View& view) {
    if (view.watched != Watched::none) return false;
    const std::string base = baseChannel(view.channel);
    return base == "albedo" || base == "normal" || base == "depth" || base == "position" || base == "emission" ||
           base == "cascade" || (base.starts_with("voxel_") && view.triangles <= 0);
}

std::string lightText(const LightProgress& light) {
    if (light.whole) return "";
    if (light.levelsLeft > 0)
        return fmt::format("{} level{} to voxelize", light.levelsLeft, light.levelsLeft == 1 ? "" : "s");
    if (!light.direct) return fmt::format("direct light {:.0f} %", 100 * light.share);
    return fmt::format("light {}/{} bounces, {:.0f} %", light.bounces, light.of, 100 * light.share);
}

RenderThread::RenderThread(std::function<std::unique_ptr<gl::Context>()> makeContext, std::function<void()> wake,
                           fs::path shaders)
    : wake_(std::move(wake)), shaders_(std::move(shaders)) {
    thread_ = std::thread([this, make = std::move(makeContext)] { run(make); });
}

RenderThread::~RenderThread() {
    {
        const std::scoped_lock lock(mutex_);
        quit_ = true;
        quitting_ = true;
    }
    changed_.notify_all();
    thread_.join();
}

// ---- From the window's thread

void RenderThread::order(std::function<void(gl::Context&)> order) {
    const std::scoped_lock lock(mutex_);
    orders_.push_back(std::move(order));
    ordered_ = true;
    idle_ = false;
    changed_.notify_all();
}

void RenderThread::open(const fs::path& file, std::function<void(Settings&)> prepare) {
    order([this, file, change = std::move(prepare)](gl::Context& context) { load(context, file, change); });
}

void RenderThread::environment(const fs::path& file) {
    order([this, file](gl::Context& context) {
        if (!loaded_) return;
        loadEnvironmentImage(file);
        publishFacts(context, false);
    });
}

void RenderThread::reloadShaders() {
    order([this](gl::Context& context) {
        if (!loaded_) return;
        setActivity("compiling shaders");
        // The old renderer stays until the new one is known to compile.
        auto fresh = std::make_unique<Renderer>(context, loaded_->script.scene, built_, 0, shaders_);
        renderer_ = std::move(fresh);
        builtBounds_.reset();
        fresh_ = true;
        divisor_ = 0;
        finished_ = false;
        tell("shaders compiled", false);
    });
}

std::uint64_t RenderThread::show(const View& view) {
    const std::scoped_lock lock(mutex_);
    view_ = view;
    wanted_ = true;
    idle_ = false;
    latest_ = ++serial_;
    changed_.notify_all();
    return serial_;
}

void RenderThread::afterPicture(std::function<void(Desk&)> job) {
    const std::scoped_lock lock(mutex_);
    afterPicture_.push_back(std::move(job));
    idle_ = false;
    changed_.notify_all();
}

void RenderThread::now(std::function<void(Desk&)> job) {
    order([this, work = std::move(job)](gl::Context& context) {
        if (!renderer_) throw UsageError("there is no scene yet");
        View view;
        {
            const std::scoped_lock lock(mutex_);
            view = view_;
        }
        Desk desk{*renderer_, loaded_->script.scene, view, context};
        work(desk);
    });
}

void RenderThread::deliver(std::function<void()> result) {
    {
        const std::scoped_lock lock(mutex_);
        results_.push_back(std::move(result));
    }
    wake_();
}

void RenderThread::takeResults() {
    std::vector<std::function<void()>> results;
    {
        const std::scoped_lock lock(mutex_);
        if (failure_) std::rethrow_exception(failure_);
        results.swap(results_);
    }
    for (const auto& result : results) result();
}

std::shared_ptr<const Picture> RenderThread::picture() const {
    const std::scoped_lock lock(mutex_);
    return picture_;
}

std::shared_ptr<const SceneFacts> RenderThread::scene() const {
    const std::scoped_lock lock(mutex_);
    return facts_;
}

std::uint64_t RenderThread::sceneSerial() const {
    const std::scoped_lock lock(mutex_);
    return sceneSerial_;
}

std::string RenderThread::activity() const {
    const std::scoped_lock lock(mutex_);
    return activity_;
}

double RenderThread::activitySeconds() const {
    const std::scoped_lock lock(mutex_);
    return std::chrono::duration<double>(Clock::now() - activityStart_).count();
}

LightProgress RenderThread::light() const {
    const std::scoped_lock lock(mutex_);
    return light_;
}

bool RenderThread::idle() const {
    const std::scoped_lock lock(mutex_);
    return idle_;
}

std::vector<Message> RenderThread::takeMessages() {
    const std::scoped_lock lock(mutex_);
    return std::exchange(messages_, {});
}

void RenderThread::motionBudget(double milliseconds) {
    motionBudget_ = milliseconds;
}

// ---- On the thread

void RenderThread::setActivity(const std::string& text) {
    {
        const std::scoped_lock lock(mutex_);
        if (activity_ == text) return;
        activity_ = text;
        activityStart_ = Clock::now();
    }
    wake_();
}

void RenderThread::tell(const std::string& text, bool error) {
    {
        const std::scoped_lock lock(mutex_);
        messages_.push_back({text, error});
    }
    wake_();
}

void RenderThread::run(const std::function<std::unique_ptr<gl::Context>()>& makeContext) {
    try {
        const std::unique_ptr<gl::Context> context = makeContext();
        presenter_ = std::make_unique<Presenter>();
        try {
            loop(*context);
        } catch (...) {
            presenter_.reset();
            renderer_.reset();
            throw;
        }
        presenter_.reset();
        renderer_.reset();
        const std::scoped_lock lock(mutex_);
        picture_.reset();
        context->checkErrors();
    } catch (...) {
        {
            const std::scoped_lock lock(mutex_);
            failure_ = std::current_exception();
            idle_ = true;
        }
        wake_();
    }
}

void RenderThread::loop(gl::Context& context) {
    for (;;) {
        std::function<void(gl::Context&)> order;
        std::function<void(Desk&)> job;
        View view;
        std::uint64_t serial = 0;
        {
            std::unique_lock lock(mutex_);
            const auto toDo = [&] {
                if (quit_ || !orders_.empty()) return true;
                const bool showable = wanted_ && view_.scene == sceneSerial_ && loaded_;
                return showable && (serial_ != shown_ || !finished_ || !afterPicture_.empty());
            };
            if (!toDo()) {
                idle_ = true;
                if (!activity_.empty()) {
                    activity_.clear();
                    lock.unlock();
                    wake_();
                    lock.lock();
                }
                changed_.wait(lock, toDo);
            }
            if (quit_) return;
            idle_ = false;
            if (!orders_.empty()) {
                order = std::move(orders_.front());
                orders_.pop_front();
                ordered_ = !orders_.empty();
            }
            view = view_;
            serial = serial_;
            if (!order && serial == shown_ && finished_) {
                job = std::move(afterPicture_.front());
                afterPicture_.pop_front();
            }
        }
        try {
            if (order) {
                order(context);
            } else if (job) {
                if (renderer_) {
                    Desk desk{*renderer_, loaded_->script.scene, view, context};
                    job(desk);
                } else {
                    tell("there is no picture", true);
                }
            } else {
                stage(context, view, serial);
            }
        } catch (const Error& error) {
            tell(error.what(), true);
        } catch (const gl::ShaderError& error) {
            tell(error.what(), true);
        }
        context.checkErrors();
    }
}

void RenderThread::load(gl::Context& context, const fs::path& file, const std::function<void(Settings&)>& prepare) {
    setActivity("loading " + file.filename().string());
    auto fresh = std::make_unique<Loaded>();
    fresh->file = file;
    fresh->script = loadCaptureScript(file);
    Settings& settings = fresh->script.settings;
    if (prepare) prepare(settings);
    fresh->lights = fresh->script.scene.lights;
    fresh->nodes = fresh->script.scene.nodes;
    fresh->extract(settings.light);
    setActivity("uploading " + file.filename().string());
    auto renderer =
        std::make_unique<Renderer>(context, fresh->script.scene, settings, fresh->script.shots.front().start, shaders_);
    // Both are good: from here on nothing fails.
    renderer_ = std::move(renderer);
    builtBounds_.reset();
    stale_ = false;
    fresh_ = true;
    loaded_ = std::move(fresh);
    built_ = settings;
    pixelCost_ = 0;
    divisor_ = 0;
    finished_ = false;
    publishFacts(context, true);
}

void RenderThread::loadEnvironmentImage(const fs::path& file) {
    setActivity("loading " + file.filename().string());
    Environment environment = loadEnvironment(file);
    environment.color = glm::vec3(1);
    environment.rotationDeg = loaded_->script.scene.environment.rotationDeg;
    renderer_.reset();  // it refers to the old one
    loaded_->script.scene.environment = std::move(environment);
    loaded_->extract(built_.light);
    divisor_ = 0;
    finished_ = false;
}

void RenderThread::publishFacts(gl::Context& context, bool opened) {
    const CaptureScript& script = loaded_->script;
    auto facts = std::make_shared<SceneFacts>();
    facts->file = loaded_->file;
    Scene& outline = facts->outline;
    outline.file = script.scene.file;
    outline.materials = script.scene.materials;
    outline.nodes = loaded_->nodes;
    outline.instances = script.scene.instances;
    outline.skins = script.scene.skins;
    outline.lights = script.scene.lights;
    outline.cameras = script.scene.cameras;
    outline.animations = script.scene.animations;
    outline.environment.color = script.scene.environment.color;
    outline.environment.rotationDeg = script.scene.environment.rotationDeg;
    facts->settings = script.settings;
    facts->shots = script.shots;
    facts->bounds = script.scene.bounds();
    for (const Instance& instance : script.scene.instances) {
        facts->boxes.emplace_back();
        for (const glm::vec3& p : script.scene.meshes[static_cast<std::size_t>(instance.mesh)].positions)
            facts->boxes.back().add(glm::dvec3(p));
    }
    facts->triangles = script.scene.triangleCount();
    facts->duration = lastKey(script);
    nlohmann::json description = describeScene(script.scene);
    description["device"] = describeDevice(context.info());
    facts->description = description.dump(2);
    {
        const std::scoped_lock lock(mutex_);
        facts_ = std::move(facts);
        if (opened) ++sceneSerial_;
    }
    wake_();
}

void RenderThread::prepareRenderer(gl::Context& context, const View& view) {
    if (!sameExtraction(built_.light, view.settings.light)) {
        renderer_.reset();
        loaded_->extract(view.settings.light);
        built_.light.extractEnvironment = view.settings.light.extractEnvironment;
        built_.light.extractEmitters = view.settings.light.extractEmitters;
        publishFacts(context, false);
    }
    placeNodes(context, view);
    const Settings::Output& output = view.settings.output;
    const int largest = std::max(output.width, output.height) * output.supersample;
    if (largest > context.info().max2DTextureSize)
        throw DeviceError(fmt::format("a picture with {} samples on a side; the device allows GL_MAX_TEXTURE_SIZE = {}",
                                      largest, context.info().max2DTextureSize));
    std::vector<Light>& lights = loaded_->script.scene.lights;
    if (view.lights.size() == lights.size()) lights = view.lights;
    if (renderer_ && sameRenderer(built_, view.settings)) return;
    setActivity("compiling and uploading");
    renderer_.reset();
    builtBounds_.reset();
    built_ = view.settings;
    pixelCost_ = 0;
    fresh_ = true;
    renderer_ = std::make_unique<Renderer>(context, loaded_->script.scene, view.settings, view.time, shaders_);
}

/// Puts nodes where the view has them. Voxels and shadow maps follow at once; the extent of levels and shadow maps, and
/// which emitters are lights, depend on all of the scene and follow once nothing is dragged.
void RenderThread::placeNodes(gl::Context& context, const View& view) {
    Scene& scene = loaded_->script.scene;
    if (loaded_->placed != view.placed) {
        if (renderer_ && !builtBounds_) builtBounds_ = scene.motionBounds();
        loaded_->place(view.placed);
        if (renderer_) renderer_->placeNodes();
        stale_ = true;
    }
    if (!stale_ || view.placing) return;
    stale_ = false;
    if (std::any_of(scene.materials.begin(), scene.materials.end(), [](const Material& m) { return m.emits(); })) {
        const auto extracted = [&scene] {
            std::vector<Light> lights;
            std::copy_if(scene.lights.begin(), scene.lights.end(), std::back_inserter(lights),
                         [](const Light& light) { return light.extracted; });
            return lights;
        };
        const std::vector<Light> before = extracted();
        loaded_->extract(built_.light);
        if (extracted() != before) {
            renderer_.reset();
            publishFacts(context, false);
        }
    }
    if (!renderer_ || !builtBounds_) return;
    const Bounds bounds = scene.motionBounds();
    if (bounds.min != builtBounds_->min || bounds.max != builtBounds_->max) renderer_.reset();
}

/// That of the largest picture that should take no longer.
int RenderThread::divisorFor(const Settings::Output& output, const gl::Context& context, double milliseconds) const {
    constexpr std::array kDivisors = {1, 2, 4, 8, 16, 32};
    if (pixelCost_ <= 0) return context.info().softwareRasterizer ? 16 : 1;
    const double all = pixelCost_ * output.width * output.height;
    for (const int divisor : kDivisors)
        if (all / (divisor * divisor) <= milliseconds) return divisor;
    return kDivisors.back();
}

void RenderThread::tellLight() {
    const LightProgress light = renderer_->light();
    {
        const std::scoped_lock lock(mutex_);
        light_ = light;
    }
    wake_();
}

/// Frames may be given up, but not what they have done to voxels and light.
void RenderThread::addUpdate(bool begins) {
    const ClipmapUpdate update = renderer_->clipmap().update;
    updated_.all |= update.all;
    updated_.fixed.insert(updated_.fixed.end(), update.fixed.begin(), update.fixed.end());
    updated_.moving.insert(updated_.moving.end(), update.moving.begin(), update.moving.end());
    for (const auto& [level, milliseconds] : renderer_->stats().levelMilliseconds)
        levelMilliseconds_[level] += milliseconds;
    for (const FrameStats::Pass& pass : renderer_->stats().passes) {
        if (!pass.name.starts_with("voxelize") && !pass.name.starts_with("light")) continue;
        if (std::exchange(begins, false)) updatePasses_.clear();
        const auto same = std::find_if(updatePasses_.begin(), updatePasses_.end(),
                                       [&](const FrameStats::Pass& other) { return other.name == pass.name; });
        if (same == updatePasses_.end()) {
            updatePasses_.push_back(pass);
        } else {
            same->milliseconds += pass.milliseconds;
        }
    }
}

void RenderThread::stage(gl::Context& context, const View& view, std::uint64_t serial) {
    const auto start = Clock::now();
    const bool first = serial != shown_ || divisor_ == 0;
    shown_ = serial;
    if (first) {
        divisor_ = 0;
        finished_ = true;  // unless all goes well there is nothing more to be tried for this view
    }
    prepareRenderer(context, view);
    const Settings::Output& full = view.settings.output;
    const bool quick = withoutCones(view), settled = !first && renderer_->light().whole;
    int divisor = 1;
    if (!quick) {
        divisor = first ? divisorFor(full, context, motionBudget_) : std::max(1, divisor_ / 4);
        // Each bounce makes another picture: they shall cost little beside it.
        if (!first && !settled)
            divisor = std::min(divisor_, std::max(divisor, divisorFor(full, context, kUnsettledMilliseconds)));
    }
    Settings::Output output = full;
    if (divisor > 1) {
        output.width = (output.width + divisor - 1) / divisor;
        output.height = (output.height + divisor - 1) / divisor;
        output.supersample = 1;
    }
    renderer_->setClipmapEye(view.clipmapEye);
    renderer_->setVoxelView(view.voxels);
    renderer_->setTime(view.time);
    if (fresh_ && context.info().softwareRasterizer && !quick) publishSurfaces(view, serial);
    renderer_->setOutput(output);
    setActivity(fresh_ || (!first && !settled) ? "voxels and light"
                : divisor == 1                 ? "rendering"
                                               : fmt::format("rendering 1/{}", divisor));
    const auto changed = [this, serial] { return latest_ != serial || ordered_; };
    // The first stage is finished whatever comes, so that there is always a next picture while the view moves. It shows
    // the light there is; of what is left it does a little, so that light goes on while the view moves. At rest the
    // next picture waits for a bounce.
    const auto stop = [this, quick, first, changed] { return quick || quitting_ || (!first && changed()); };
    const auto deadline = start + std::chrono::duration<double, std::milli>(0.5 * motionBudget_);
    const LightProgress before = renderer_->light();
    const auto pause = [&] {
        tellLight();
        if (quitting_) return true;
        if (first) return Clock::now() > deadline;
        const LightProgress now = renderer_->light();
        return changed() || now.levelsLeft != before.levelsLeft || now.direct != before.direct ||
               now.bounces != before.bounces;
    };
    const bool drawn = renderer_->render(view.camera, stop, pause);
    addUpdate(std::exchange(fresh_, false) || before.whole);
    tellLight();
    finished_ = divisor == 1 && renderer_->light().whole;
    if (!quick && !drawn) {
        finished_ = false;
        return;
    }
    divisor_ = divisor;
    const bool published = finished_ && !stale_;
    if (quick) return publish(view, serial, published, start);
    double perPixel = 0;
    for (const FrameStats::Pass& pass : renderer_->stats().passes) {
        const std::string& name = pass.name;
        if (name == "direct" || name == "composite" || name.starts_with("cones")) perPixel += pass.milliseconds;
    }
    const double pixels = static_cast<double>(output.width) * output.height * output.supersample * output.supersample;
    pixelCost_ = std::max(perPixel, 1e-3) / pixels;
    publish(view, serial, published, start);
}

/// A software rasteriser gathers light for many seconds: the surfaces say meanwhile what was opened.
void RenderThread::publishSurfaces(const View& view, std::uint64_t serial) {
    setActivity("surfaces");
    Settings::Output output = view.settings.output;
    output.supersample = 1;
    renderer_->setOutput(output);
    renderer_->drawSurfaces(view.camera);
    auto picture = std::make_shared<Picture>();
    picture->texture = presenter_->encode(pictureOf("albedo", renderer_->channel("albedo"), view.settings), true);
    picture->view = view;
    picture->serial = serial;
    picture->surfaces = true;
    picture->clipmap.layout.levels = 0;
    picture->position = renderer_->channel("position");
    picture->levels = renderer_->levels();
    picture->leftOut = renderer_->leftOut();
    {
        const std::scoped_lock lock(mutex_);
        picture_ = std::move(picture);
    }
    wake_();
}

void RenderThread::publish(const View& view, std::uint64_t serial, bool finished, Clock::time_point start) {
    auto picture = std::make_shared<Picture>();
    if (view.channel == "beauty") {
        picture->texture = presenter_->encode(renderer_->displayTexture(), divisor_ > 1);
    } else {
        const Image image = renderer_->channel(view.channel);
        Image shown = pictureOf(view.channel, image, view.settings);
        if (view.triangles > 0 && view.channel.starts_with("voxel_")) {
            const Image beauty = renderer_->display();
            const auto share = static_cast<float>(view.triangles);
            for (std::size_t i = 0; i < shown.data.size(); ++i)
                shown.data[i] += share * (beauty.data[i] - shown.data[i]);
        }
        picture->texture = presenter_->encode(shown, divisor_ > 1);
    }
    picture->view = view;
    picture->serial = serial;
    picture->divisor = divisor_;
    picture->light = renderer_->light();
    picture->finished = finished;
    picture->stats = renderer_->stats();
    picture->stats.levelMilliseconds = std::exchange(levelMilliseconds_, {});
    picture->updatePasses = updatePasses_;
    picture->clipmap = renderer_->clipmap();
    const ClipmapUpdate updated = std::exchange(updated_, {});
    picture->clipmap.update.all = updated.all;
    picture->clipmap.update.fixed = updated.fixed;
    picture->clipmap.update.moving = updated.moving;
    picture->levels = renderer_->levels();
    picture->leftOut = renderer_->leftOut();
    if (latest_ == serial && finished) picture->image = renderer_->channel(view.channel);
    if (latest_ == serial) picture->position = renderer_->channel("position");
    picture->milliseconds = std::chrono::duration<double, std::milli>(Clock::now() - start).count();
    if (view.watched != Watched::none) picture->watched = watchedFrame(*renderer_, view.watched, view.camera, serial);
    {
        const std::scoped_lock lock(mutex_);
        picture_ = std::move(picture);
    }
    wake_();
}

}  // namespace voxcone
