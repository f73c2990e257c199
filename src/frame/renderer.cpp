#include "frame/renderer.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <utility>

#include "cascade/voxels.h"
#include "cone/gather.h"
#include "cone/inspect.h"
#include "cone/refraction.h"
#include "core/check.h"
#include "core/voxel_channel.h"
#include "frame/cascade_view.h"
#include "frame/gbuffer.h"
#include "frame/tonemap.h"
#include "frame/voxel_slice.h"
#include "frame/voxel_view.h"
#include "gl/bindings.h"
#include "gl/context.h"
#include "gl/gpu_environment.h"
#include "gl/gpu_scene.h"
#include "gl/pass_timers.h"
#include "light/direct.h"
#include "light/radiance.h"
#include "light/shadow_maps.h"
#include "light/specular_table.h"
#include "scene/topology.h"
#include "voxelize/voxelizer.h"

namespace voxcone {

namespace {

/// Bounces, one a frame, that an update budget adds after the last change. What is left of the light before is the mean
/// albedo to this power: with 0.7, 10^-5 of it.
constexpr int kSettlingBounces = 32;

gl::TimerMode timerMode(const gl::Context& context, PassTimer setting) {
    switch (setting) {
        case PassTimer::query:
            return gl::TimerMode::query;
        case PassTimer::finish:
            return gl::TimerMode::finish;
        case PassTimer::automatic:
            break;
    }
    return gl::suitableTimerMode(context.info());
}

}  // namespace

/// Passes hold the programs and textures of one scene under one tree of settings. Those that the scene or the settings
/// do not need are absent.
struct Renderer::Impl {
    Impl(gl::Context& glContext, const Scene& renderedScene, const Settings& givenSettings, double time,
         const std::filesystem::path& shaderFolder)
        : context(glContext),
          scene(renderedScene),
          settings(givenSettings),
          width(settings.output.width * settings.output.supersample),
          height(settings.output.height * settings.output.supersample),
          shaders(shaderFolder),
          timers(timerMode(context, settings.device.timer)),
          environment(scene.environment, scene.environment.residual),
          background(scene.environment.residual.empty() ? gl::GpuEnvironment() : gl::GpuEnvironment(scene.environment)),
          sky(skyOf(environment)),
          seenSky(background.panorama ? skyOf(background) : sky),
          gpuScene(scene, time),
          shadowMaps(context, shaders, settings.light),
          gbuffer(shaders, gpuScene, width, height),
          composite(shaders, gbuffer, seenSky),
          readout(shaders) {
        const bool lights = !scene.lights.empty();
        if (lights) direct = std::make_unique<DirectPass>(shaders, gbuffer.defines(), width, height);
        if (gpuScene.empty()) return;
        for (const Instance& instance : scene.instances) {
            const Mesh& mesh = scene.meshes[static_cast<std::size_t>(instance.mesh)];
            degenerate += degenerateTriangles(mesh.positions, mesh.indices);
        }
        layout = layoutClipmap(scene.motionBounds(), settings);
        voxelizer = std::make_unique<Voxelizer>(context, shaders, gpuScene, settings);
        voxels = voxelizer->allocate(layout);
        const bool exact = settings.cascade.update == CascadeUpdate::exact;
        schedule = std::make_unique<ClipmapSchedule>(layout, exact ? 0 : settings.cascade.budget, gpuScene.anyMoving());
        field = std::make_unique<RadianceField>(shaders, settings, voxels, sky, lights);
        diffuse = std::make_unique<DiffusePass>(shaders, settings, voxels, sky, gbuffer.defines(), width, height);
        const bool reflects = settings.specular.enabled && anySpecular(), transmits = gpuScene.anyTransmission();
        if (reflects || transmits) specularAlbedo = specularAlbedoTexture();
        if (transmits)
            refraction = std::make_unique<RefractionPass>(shaders, settings, scene, voxels, sky, gbuffer.defines(),
                                                          specularAlbedo, width, height);
        if (reflects) {
            specular = std::make_unique<SpecularPass>(shaders, settings, voxels, sky, gbuffer.defines(), specularAlbedo,
                                                      width, height);
        }
        if (settings.shadow.cones && lights)
            softShadow = std::make_unique<SoftShadowPass>(shaders, settings, voxels, gbuffer.defines(), width, height);
    }

    bool anySpecular() const {
        for (const Material& m : scene.materials)
            if (!m.unlit && (m.metallic > 0 || m.specularFactor > 0)) return true;
        return false;
    }

    void setOutput(const Settings::Output& output) {
        settings.output = output;
        const int newWidth = output.width * output.supersample, newHeight = output.height * output.supersample;
        if (newWidth == width && newHeight == height) return;
        width = newWidth;
        height = newHeight;
        gbuffer.resize(width, height);
        composite.resize(width, height);
        if (direct) direct->resize(width, height);
        if (diffuse) diffuse->resize(width, height);
        if (specular) specular->resize(width, height);
        if (refraction) refraction->resize(width, height);
        if (softShadow) softShadow->resize(width, height);
        if (voxelView) voxelView->resize(width, height);
        if (cascadeView) cascadeView->resize(width, height);
    }

    /// Brings shadow maps, voxels and their light to the scene's time and the camera's place; `pause`:
    /// Renderer::render.
    void updateVoxels(const glm::dvec3& eye, const gl::Stop& pause) {
        const glm::dvec3 origin = clipmapOrigin(layout, eye);
        if (forgotten || origin != voxels.origin) {
            forgotten = true;
            voxels.origin = origin;
            gpuScene.setOrigin(origin);
            shadowMaps.invalidate();
            if (schedule) schedule->reset();
            parts.clear();
        }
        relight |= shadowMaps.update(gpuScene, timers) || forgotten;
        if (voxelizer) {
            updateLevels(eye - origin, pause);
            voxels.center = eye - origin;
            if (settings.cascade.center == CascadeCenter::window && layout.moves(0) && !voxels.windows[0].empty())
                voxels.center = 0.5 * layout.voxelSize * glm::dvec3(voxels.windows[0].low + voxels.windows[0].high);
        }
        forgotten = false;
    }

    /// Renewal of voxels and their light, as far as `pause` lets it go; `center`: of the clipmap, from the origin.
    void updateLevels(const glm::dvec3& center, const gl::Stop& pause) {
        const auto bindLights = [this](gl::Program& program) { shadowMaps.bind(program); };
        const bool exact = settings.cascade.update == CascadeUpdate::exact;
        voxels.freshCount = 0;
        recordsMade = trianglesDrawn = 0;
        update = ClipmapUpdate{};
        behind = true;
        // A frame adds one bounce at most, and only when that of the frame before is whole.
        bool bounceBegun = !field->whole();
        const auto begin = [&](bool coarsest) {
            if (!exact && (relight || coarsest) && !anew) {
                bouncesLeft = settings.light.bounces > 0 ? kSettlingBounces : 0;
            }
            const bool bounce = bouncesLeft > 0 && (relight || coarsest || !bounceBegun);
            bounceField.reset();
            field->begin(voxels, {relight, coarsest, !bounce}, bindLights, timers, static_cast<bool>(pause));
            relight = false;
            bounceBegun = true;
        };
        // What an earlier call has left comes first: places and motion since then are beside it.
        for (bool planned = false; !parts.empty() || !planned;) {
            if (parts.empty()) {
                planned = true;
                behind = false;
                gl::GpuScene::Moved moved = gpuScene.takeMoved();
                for (auto* boxes : {&moved.moving, &moved.fixed})
                    for (Bounds& box : *boxes) box = {box.min - voxels.origin, box.max - voxels.origin};
                const ClipmapUpdate next = schedule->next(center, moved.moving, moved.fixed);
                anew = next.all;
                if (anew) bouncesLeft = 0;
                if (!next.empty()) voxelized = {};
                if (pause) {
                    for (ClipmapUpdate& part : byLevel(layout, next, voxels.windows)) parts.push_back(std::move(part));
                } else if (!next.empty()) {
                    parts.push_back(next);
                }
                if (parts.empty()) {
                    if (relight || (bouncesLeft > 0 && !bounceBegun)) begin(false);
                    break;
                }
            }
            voxelize(parts.front());
            begin(parts.front().touches(layout.levels - 1));
            parts.pop_front();
            if (pause && (!parts.empty() || !planned) && pause()) break;
        }
        update.windows = voxels.windows;
        if (behind || !parts.empty() || field->whole()) return;
        if (field->resume(voxels, sky, bindLights, timers, pause)) bouncesLeft = std::max(bouncesLeft - 1, 0);
    }

    /// Voxelizes a part of an update that is not empty; its time counts for its level if it is of one alone.
    void voxelize(const ClipmapUpdate& part) {
        const std::vector<Region>& some = part.fixed.empty() ? part.moving : part.fixed;
        const int level = some.front().level;
        const auto same = [level](const Region& region) { return region.level == level; };
        if (std::all_of(part.fixed.begin(), part.fixed.end(), same) &&
            std::all_of(part.moving.begin(), part.moving.end(), same))
            timers.label(level);
        voxelizer->update(gpuScene, part, voxels, timers);
        timers.label(-1);
        update.all = anew;
        update.fixed.insert(update.fixed.end(), part.fixed.begin(), part.fixed.end());
        update.moving.insert(update.moving.end(), part.moving.begin(), part.moving.end());
        recordsMade += voxels.freshCount;
        trianglesDrawn += voxels.trianglesDrawn;
        voxelized.fragments += voxels.counters.fragments;
        voxelized.saturated += voxels.counters.saturated;
        voxelized.clamped += voxels.counters.clamped;
    }

    LightProgress lightProgress() const {
        LightProgress p;
        if (!voxelizer) return p;
        p.levelsLeft = static_cast<int>(parts.size()) + schedule->waiting();
        p.direct = field->directWhole();
        p.bounces = bouncesLeft > 0 ? kSettlingBounces - bouncesLeft : field->bouncesMade();
        p.of = bouncesLeft > 0 ? kSettlingBounces : field->bouncesWanted();
        p.share = field->share();
        p.whole = !forgotten && !behind && p.levelsLeft == 0 && field->whole() && bouncesLeft == 0;
        return p;
    }

    /// The frame, pass by pass. `change`: set to what the light of the frame before has become, if not null. False when
    /// `stop` has abandoned it.
    bool render(const Camera& worldCamera, TemporalChange* change, const gl::Stop& stop, const gl::Stop& pause) {
        Image before;
        const bool compare = change && voxelizer && !voxels.windows.empty();
        if (compare) before = gatheredBefore(worldCamera);
        timers.beginFrame();
        if (!std::exchange(bounceShown, false)) bounceField.reset();
        // Passes store into the images that the last frame fetched.
        gl::memoryBarrier(GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
        updateVoxels(clipmapEye.value_or(worldCamera.position), pause);
        const auto abandoned = [&] {
            if (!stop || !stop()) return false;
            timers.endFrame();
            collectStats();
            return true;
        };
        gbuffer.draw(gpuScene, cameraView(worldCamera, gpuScene.origin(), gpuScene.bounds(), width, height), timers);
        if (abandoned()) return false;
        const auto bindGBuffer = [this](gl::Program& program, int unit) { gbuffer.bind(program, unit); };
        std::vector<const gl::Texture*> layers;
        if (direct && shadowMaps.lightCount() > 0) {
            direct->run(
                shadowMaps, [&](gl::Program& program) { bindGBuffer(program, gl::kPassTextureUnit); }, timers);
            layers.push_back(&direct->texture());
        }
        if (voxelizer) {
            const RadianceVolume volume = field->volume(voxels);
            if (abandoned()) return false;
            diffuse->run(volume, sky, bindGBuffer, timers, SeamSide::blended, stop);
            if (abandoned()) return false;
            layers.push_back(&diffuse->texture());
            if (specular) {
                specular->run(volume, sky, bindGBuffer, timers, stop);
                if (abandoned()) return false;
                layers.push_back(&specular->texture());
            }
            if (refraction) {
                refraction->run(volume, seenSky, bindGBuffer, timers);
                layers.push_back(&refraction->texture());
            }
            if (softShadow)
                softShadow->run(
                    volume, [this](gl::Program& program) { shadowMaps.bind(program); }, bindGBuffer, timers);
        }
        composite.run(gbuffer, seenSky, layers, settings.output.exposure, timers);
        timers.endFrame();
        collectStats();
        if (compare) *change = changeInPlace(before, channel("indirect_diffuse"), channel("albedo"));
        return true;
    }

    /// What this frame's surfaces would gather from the voxels of the last one.
    Image gatheredBefore(const Camera& worldCamera) {
        gl::PassTimers unused(gl::TimerMode::finish);
        gbuffer.draw(gpuScene, cameraView(worldCamera, gpuScene.origin(), gpuScene.bounds(), width, height), unused);
        gatherDiffuse(SeamSide::blended);
        return channel("indirect_diffuse");
    }

    /// Gathers the diffuse light of the last G-buffer again, outside of the frame's times.
    void gatherDiffuse(SeamSide side) {
        gl::PassTimers unused(gl::TimerMode::finish);
        gl::memoryBarrier(GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
        diffuse->run(
            field->volume(voxels), sky, [this](gl::Program& program, int unit) { gbuffer.bind(program, unit); }, unused,
            side);
    }

    std::uint64_t coneSamples() {
        if (!voxelizer) return 0;
        gl::memoryBarrier(GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
        const RadianceVolume volume = field->volume(voxels);
        const auto bindGBuffer = [this](gl::Program& program, int unit) { gbuffer.bind(program, unit); };
        std::uint64_t samples = diffuse->countSamples(volume, sky, bindGBuffer);
        if (specular) samples += specular->countSamples(volume, sky, bindGBuffer);
        if (refraction) samples += refraction->countSamples(volume, seenSky, bindGBuffer);
        return samples;
    }

    void collectStats() {
        timers.wait();
        stats = FrameStats{};
        for (const gl::PassTime& pass : timers.results()) stats.passes.push_back({pass.name, pass.milliseconds});
        stats.frameMilliseconds = timers.frameMilliseconds();
        stats.timer = timers.modeName();
        stats.levelMilliseconds = timers.byLabel();
        const auto memory = [&](const char* name, std::uint64_t bytes) {
            if (bytes > 0) stats.memory.push_back({name, bytes});
        };
        memory("scene geometry", gpuScene.bufferBytes());
        memory("scene textures", gpuScene.textureBytes());
        memory("environment", environment.panorama.bytes() + background.panorama.bytes());
        memory("shadow maps", shadowMaps.bytes());
        memory("g-buffer", gbuffer.bytes());
        if (direct) memory("direct light", direct->bytes());
        if (voxelizer) {
            memory("voxel index", voxels.index.bytes() + voxels.movingIndex.bytes());
            memory("coverage volumes", voxels.coveragePositive.bytes() + voxels.coverageNegative.bytes());
            memory("leaf volume", voxels.leafDepth.bytes());
            memory("voxel records", voxels.recordBytes());
            memory("voxel radiance", field->bytes());
            if (bounceField) memory("voxel radiance of a bounce", bounceField->bytes());
            memory("diffuse cones", diffuse->bytes());
            if (specular) memory("specular cones", specular->bytes());
            if (refraction) memory("refraction cones", refraction->texture().bytes());
            if (softShadow) memory("soft shadow", softShadow->texture().bytes());
        }
        memory("beauty", composite.beauty().bytes());
        stats.counts["triangles"] = gpuScene.triangleCount();
        stats.counts["degenerate_triangles"] = degenerate;
        stats.counts["voxels_occupied"] = voxels.occupied();
        for (int level = 0; field && level < layout.count(); ++level)
            stats.counts[fmt::format("{}_{}_voxels", level < layout.levels ? "level" : "mip",
                                     level < layout.levels ? level : level - layout.levels + 1)] =
                field->records(level);
        stats.counts["voxel_triangles_drawn"] = trianglesDrawn;
        stats.counts["voxel_records_made"] = recordsMade;
        stats.counts["levels_waiting"] = schedule ? static_cast<std::uint64_t>(schedule->waiting()) : 0;
        stats.counts["voxel_faces_lit"] = field ? field->activeFaces() : 0;
        stats.counts["light_bounces"] = field ? static_cast<std::uint64_t>(field->bounces()) : 0;
        stats.counts["voxel_fragments"] = voxelized.fragments;
        stats.counts["voxel_sums_saturated"] = voxels.counters.saturated;
        stats.counts["emission_clamped"] = voxels.counters.clamped;
        stats.counts["radiance_clamped"] = field ? field->clamped() : 0;
    }

    /// All light, or that of one bounce alone (VoxelChannel::bounce). The latter is gathered when it is first asked
    /// for, and given up when voxels or light change, or a frame has passed without its being shown.
    const RadianceField& fieldOf(int bounce) {
        if (bounce < 0) return *field;
        bounceShown = true;
        if (bounceField && bounceOfField == bounce) return *bounceField;
        Settings only = settings;
        only.light.bounces = bounceOfField = bounce;
        only.light.tolerance = 0;
        only.light.extrapolate = false;
        bounceField.reset();
        bounceField = std::make_unique<RadianceField>(shaders, only, voxels, sky, !scene.lights.empty());
        gl::PassTimers unused(gl::TimerMode::finish);
        bounceField->update(
            voxels, sky, {}, [this](gl::Program& program) { shadowMaps.bind(program); }, unused);
        if (bounce > 0) bounceField->isolateLastBounce(voxels);
        return *bounceField;
    }

    const gl::Texture& drawCascade() {
        if (!cascadeView) cascadeView = std::make_unique<CascadeView>(shaders, gbuffer, voxels);
        return cascadeView->draw(gbuffer, voxels);
    }

    /// Gathers the last frame again with either level alone where two blend, and once more as it was.
    Seam seam() {
        const int n = settings.output.supersample;
        const Image none(settings.output.width, settings.output.height, 3);
        if (!voxelizer || layout.levels < 2) return {Image(none.width, none.height, 1), {}};
        const auto gathered = [&](SeamSide side) {
            gatherDiffuse(side);
            return readout.read(diffuse->texture(), 3, n);
        };
        const Image finer = gathered(SeamSide::finer), coarser = gathered(SeamSide::coarser);
        gathered(SeamSide::blended);
        return CascadeView::seam(finer, coarser, readout.read(drawCascade(), 4, n));
    }

    Image channel(const std::string& name) {
        const int n = settings.output.supersample;
        const auto layer = [&](const gl::Texture* texture, int channels) {
            return texture ? readout.read(*texture, channels, n)
                           : Image(settings.output.width, settings.output.height, channels);
        };
        if (name == "beauty") return readout.read(composite.beauty(), 3, n);
        if (name == "direct") return layer(direct ? &direct->texture() : nullptr, 3);
        if (name == "indirect_diffuse") return layer(diffuse ? &diffuse->texture() : nullptr, 3);
        if (name == "indirect_specular") return layer(specular ? &specular->texture() : nullptr, 3);
        if (name == "transmission") return layer(refraction ? &refraction->texture() : nullptr, 3);
        if (name == "ao") {
            const Image four = layer(diffuse ? &diffuse->texture() : nullptr, 4);
            Image ao(four.width, four.height, 1);
            for (std::size_t i = 0; i < ao.data.size(); ++i) ao.data[i] = diffuse ? four.data[4 * i + 3] : 1;
            return ao;
        }
        if (name == "soft_shadow") {
            if (softShadow) return readout.read(softShadow->texture(), 1, n);
            Image lit(settings.output.width, settings.output.height, 1);
            std::fill(lit.data.begin(), lit.data.end(), 1.0f);
            return lit;
        }
        if (name == "cascade") return layer(voxelizer ? &drawCascade() : nullptr, 3);
        if (name == "seam") return seam().picture;
        if (name.rfind("voxel_", 0) == 0) {
            Image empty(settings.output.width, settings.output.height, 3);
            if (!voxelizer) return empty;
            VoxelChannel shown;
            const std::string why = VoxelChannel::parse(name, shown);
            VOXCONE_CHECK(why.empty(), "{}", why);
            if (shown.level >= layout.count()) return empty;
            if (!voxelView)
                voxelView = std::make_unique<VoxelView>(shaders, voxels, settings.voxel.storage, width, height);
            const RadianceField& light = fieldOf(shown.bounce);
            voxelView->draw(shown, gbuffer.view(), light.volume(voxels), light.faces(), voxelOptions);
            return readout.read(voxelView->texture(), 3, n);
        }
        return gbuffer.channel(name, n);
    }

    gl::Context& context;
    const Scene& scene;
    Settings settings;
    int width, height;  ///< of the G-buffer
    gl::ShaderLibrary shaders;
    gl::PassTimers timers;
    gl::GpuEnvironment environment;
    gl::GpuEnvironment background;  ///< empty unless it differs from what cones see
    Sky sky, seenSky;
    gl::GpuScene gpuScene;
    ShadowMaps shadowMaps;
    GBuffer gbuffer;
    std::unique_ptr<DirectPass> direct;
    std::unique_ptr<Voxelizer> voxelizer;
    std::unique_ptr<RadianceField> field;
    std::unique_ptr<RadianceField> bounceField;  ///< of one bounce alone, while it is looked at
    int bounceOfField = 0;
    bool bounceShown = false;      ///< since the last frame
    std::uint64_t degenerate = 0;  ///< triangles without area, over all instances
    ClipmapLayout layout;
    std::unique_ptr<ClipmapSchedule> schedule;
    Voxels voxels;
    ClipmapUpdate update;                               ///< what the last frame has voxelized of it
    std::deque<ClipmapUpdate> parts;                    ///< not yet voxelized
    bool anew = false;                                  ///< the update is of everything
    bool behind = true;                                 ///< the camera's place and motion are not yet in `parts`
    bool relight = true;                                ///< light or shadows have changed, and `field` does not know
    VoxelCounters voxelized;                            ///< sums of the update
    std::uint64_t recordsMade = 0, trianglesDrawn = 0;  ///< by the last frame
    std::optional<glm::dvec3> clipmapEye;               ///< instead of the camera
    int bouncesLeft = 0;                                ///< frames until light has settled, with an update budget
    std::unique_ptr<DiffusePass> diffuse;
    gl::Texture specularAlbedo;
    std::unique_ptr<SpecularPass> specular;
    std::unique_ptr<RefractionPass> refraction;
    std::unique_ptr<SoftShadowPass> softShadow;
    Composite composite;
    Readout readout;
    std::unique_ptr<VoxelView> voxelView;
    VoxelViewOptions voxelOptions;
    std::unique_ptr<VoxelSlicer> slicer;
    std::map<ConeLobe, std::unique_ptr<ConeInspector>> inspectors;
    std::unique_ptr<CascadeView> cascadeView;
    bool forgotten = true;  ///< nothing that was voxelized and lit before is of use
    FrameStats stats;
};

Renderer::Renderer(gl::Context& context, const Scene& scene, const Settings& settings, double time,
                   const std::filesystem::path& shaderFolder)
    : impl_(std::make_unique<Impl>(context, scene, settings, time, shaderFolder)) {}
Renderer::~Renderer() = default;

void Renderer::setTime(double time) {
    if (time == impl_->gpuScene.time()) return;
    impl_->gpuScene.setTime(time);
}

void Renderer::placeNodes() {
    impl_->gpuScene.setTime(impl_->gpuScene.time());
    impl_->shadowMaps.invalidate();
}

void Renderer::setOutput(const Settings::Output& output) {
    impl_->setOutput(output);
}

void Renderer::setClipmapEye(const std::optional<glm::dvec3>& eye) {
    impl_->clipmapEye = eye;
}

void Renderer::setVoxelView(const VoxelViewOptions& options) {
    impl_->voxelOptions = options;
}

std::vector<PixelCones> Renderer::inspect(int x, int y) {
    Impl& r = *impl_;
    VOXCONE_CHECK(x >= 0 && y >= 0 && x < r.width && y < r.height, "pixel {}, {} of {}×{}", x, y, r.width, r.height);
    std::vector<PixelCones> lobes;
    if (!r.voxelizer) return lobes;
    const auto ask = [&](ConeLobe lobe, const Sky& seen) {
        auto& inspector = r.inspectors[lobe];
        if (!inspector)
            inspector = std::make_unique<ConeInspector>(lobe, r.shaders, r.settings, r.scene, r.voxels, seen,
                                                        r.gbuffer.defines(), r.specularAlbedo);
        PixelCones cones = inspector->inspect({x, r.height - 1 - y}, r.field->volume(r.voxels), seen,
                                              [&r](gl::Program& program, int unit) { r.gbuffer.bind(program, unit); });
        if (!cones.cones.empty()) lobes.push_back(std::move(cones));
    };
    ask(ConeLobe::diffuse, r.sky);
    if (r.specular) ask(ConeLobe::specular, r.sky);
    const auto any = [&](auto&& test) {
        return r.refraction && std::any_of(r.scene.materials.begin(), r.scene.materials.end(), test);
    };
    if (any([](const Material& m) { return m.transmission > 0; })) ask(ConeLobe::beam, r.seenSky);
    if (any([](const Material& m) { return m.diffuseTransmission > 0; })) ask(ConeLobe::scattered, r.seenSky);
    return lobes;
}

VoxelSlice Renderer::voxelSlice(int level, int axis, int depth, int bounce) {
    Impl& r = *impl_;
    if (!r.voxelizer || r.voxels.windows.empty()) return {};
    if (!r.slicer) r.slicer = std::make_unique<VoxelSlicer>(r.shaders, r.voxels);
    const RadianceField& light = r.fieldOf(bounce);
    return r.slicer->read(std::clamp(level, 0, r.layout.count() - 1), axis, depth, light.volume(r.voxels),
                          light.faces());
}

bool Renderer::render(const Camera& worldCamera, const std::function<bool()>& stop,
                      const std::function<bool()>& pause) {
    return impl_->render(worldCamera, nullptr, stop, pause);
}

LightProgress Renderer::light() const {
    return impl_->lightProgress();
}

void Renderer::drawSurfaces(const Camera& worldCamera) {
    Impl& r = *impl_;
    gl::PassTimers unused(gl::TimerMode::finish);
    // Before the first frame nothing has an origin; from then on voxels and surfaces share it.
    if (r.forgotten) r.gpuScene.setOrigin(clipmapOrigin(r.layout, worldCamera.position));
    r.gbuffer.draw(r.gpuScene, cameraView(worldCamera, r.gpuScene.origin(), r.gpuScene.bounds(), r.width, r.height),
                   unused);
}

TemporalChange Renderer::renderAndCompare(const Camera& worldCamera) {
    TemporalChange change;
    impl_->render(worldCamera, &change, {}, {});
    return change;
}

std::vector<SeamStep> Renderer::seam() {
    return impl_->seam().steps;
}

std::uint64_t Renderer::coneSamples() {
    return impl_->coneSamples();
}

std::vector<Renderer::Level> Renderer::levels() const {
    const ClipmapLayout& layout = impl_->layout;
    std::vector<Level> out;
    if (!impl_->voxelizer) return out;
    // The volumes hold whole boxes: a level's share of them is that of its texels.
    const double texels = [&] {
        double sum = 0;
        for (int l = 0; l < layout.count(); ++l) sum += std::pow(layout.resolutionOf(l), 3);
        return sum;
    }();
    for (int l = 0; l < layout.count(); ++l)
        out.push_back({l, l >= layout.levels, layout.moves(l), layout.resolutionOf(l), layout.voxelSizeOf(l),
                       layout.sizeOf(l),
                       static_cast<std::uint64_t>(std::pow(layout.resolutionOf(l), 3) / texels *
                                                  static_cast<double>(impl_->voxels.volumeBytes())),
                       ""});
    for (int l = layout.levels; l < layout.requestedLevels; ++l)
        out.push_back({l, false, false, layout.resolution, layout.voxelSizeOf(l),
                       layout.voxelSizeOf(l) * layout.resolution, 0,
                       fmt::format("level {} holds the whole scene", layout.levels - 1)});
    return out;
}

ClipmapState Renderer::clipmap() const {
    const Voxels& voxels = impl_->voxels;
    ClipmapState state;
    if (!impl_->voxelizer || voxels.windows.empty()) {
        state.layout.levels = 0;
        return state;
    }
    state.layout = impl_->layout;
    state.origin = voxels.origin;
    state.center = voxels.origin + voxels.center;
    state.radius = voxels.radius() * impl_->layout.voxelSize;
    state.update = impl_->update;
    return state;
}

Image Renderer::channel(const std::string& name) {
    return impl_->channel(name);
}

Image Renderer::display() {
    return impl_->readout.display(impl_->composite.beauty(), impl_->settings.output.toneMap,
                                  impl_->settings.output.supersample);
}

gl::Texture Renderer::displayTexture() {
    return impl_->readout.displayTexture(impl_->composite.beauty(), impl_->settings.output.toneMap,
                                         impl_->settings.output.supersample);
}

void Renderer::invalidate() {
    impl_->shadowMaps.invalidate();
    impl_->forgotten = true;
}

void Renderer::reverseDrawOrder() {
    impl_->gpuScene.reverseDrawOrder();
    invalidate();
}

const FrameStats& Renderer::stats() const {
    return impl_->stats;
}

std::vector<LeftOut> Renderer::leftOut() const {
    const Impl& r = *impl_;
    std::vector<LeftOut> out;
    if (r.scene.lights.empty()) out.push_back({"shadow maps, direct light", "the scene has no analytic light"});
    if (r.gpuScene.empty()) out.push_back({"voxels, cones", "the scene has no triangles"});
    if (!r.gpuScene.anyEmission()) out.push_back({"emission sums and G-buffer channel", "no material emits"});
    if (!r.gpuScene.anyAlphaTest()) out.push_back({"alpha-tested shaders", "no material is masked or blended"});
    if (r.sky.kind() == 0) out.push_back({"sky", "the environment is black"});
    if (r.sky.kind() == 1) out.push_back({"environment texture", "the environment is one colour"});
    if (!r.specular && !r.gpuScene.empty())
        out.push_back({"specular cones",
                       r.settings.specular.enabled ? "no material reflects specularly" : "specular.enabled is false"});
    if (!r.refraction && !r.gpuScene.empty()) out.push_back({"refraction cones", "no material transmits light"});
    if (!r.softShadow)
        out.push_back({"soft shadow cones", !r.settings.shadow.cones ? "shadow.cones is false"
                                            : r.scene.lights.empty() ? "the scene has no analytic light"
                                                                     : "the scene has no triangles"});
    if (r.settings.voxel.storage != VoxelStorage::six_face)
        out.push_back({"second coverage volume", "voxel.storage has one opacity a voxel"});
    if (r.settings.ao.distance <= 0) out.push_back({"occluder distances", "ao.distance is 0: all occluders count"});
    return out;
}

}  // namespace voxcone
