#include "light/radiance.h"

#include <bit>
#include <cmath>
#include <cstddef>
#include <utility>

#include "gl/bindings.h"

namespace voxcone {

namespace {

/// Where bounces keep shaders/light/series.glsl; nothing that they run reads direct light there.
constexpr int kSeriesStorage = kLitStorage;

struct Series {
    glm::uvec3 faceGroups{0}, slotGroups{0};
    std::uint32_t bounces = 0;
    glm::vec3 before{0}, total{0}, gain{0}, tail{0};
};
static_assert(sizeof(Series) == 19 * 4);

/// Groups of 64 for `count` items, spread over two dimensions: one alone may hold only 65535 groups.
glm::uvec3 groupsOf(std::uint32_t count) {
    const int groups = static_cast<int>((count + 63) / 64);
    const int rows = gl::groupsFor(groups, 32768);
    return {gl::groupsFor(groups, std::max(rows, 1)), rows, 1};
}

void dispatchItems(const gl::Program& program, std::uint32_t count) {
    const glm::ivec3 groups(groupsOf(count));
    gl::dispatch(program, groups.x, groups.y, groups.z);
}

void bind(const gl::Buffer& buffer, int block) {
    if (buffer) buffer.bindBase(GL_SHADER_STORAGE_BUFFER, block);
}

}  // namespace

RadianceField::RadianceField(const gl::ShaderLibrary& shaders, const Settings& settings, const Voxels& voxels,
                             const Sky& sky, bool lights)
    : settings_(settings), lights_(lights), sixFace_(voxels.sixFace()) {
    gl::Defines defines{{"LIGHTS", lights ? "1" : "0"},
                        {"EMISSION", voxels.emits ? "1" : "0"},
                        {"LAYERS", voxels.anyMoving() ? "2" : "1"}};
    inject_ = shaders.compute("light/inject.comp", defines);
    reset_ = shaders.compute("light/reset.comp", defines);
    mip_ = shaders.compute("light/mip.comp", defines);
    if (voxels.layout.levels > 1) spread_ = shaders.compute("light/spread.comp", defines);
    defines["SH1"] = settings.voxel.storage == VoxelStorage::sh1 ? "1" : "0";
    if (!sixFace_) fold_ = shaders.compute("light/fold.comp", defines);
    defines["MEASURE"] = "1";
    measure_ = shaders.compute("light/begin.comp", defines);
    defines["MEASURE"] = "0";
    store_ = shaders.compute("light/begin.comp", defines);
    if (settings.light.bounces > 0) {
        gl::Defines cones = coneSetDefines(settings, voxels, sky, settings.light.bounceCones);
        cones["AO_DISTANCE"] = "0";
        bounce_ = shaders.compute("light/bounce.comp", cones);
        series_ = shaders.compute("light/series.comp", {});
        extend_ = shaders.compute("light/extend.comp", {});
        state_ = gl::Buffer(sizeof(Series));
    }
}

void RadianceField::reserve(const Voxels& voxels) {
    const std::size_t faces = std::size_t{6} * voxels.capacity;
    if (direct_.bytes() == faces * sizeof(std::uint32_t)) return;
    // What is kept from update to update, or while one is under way, moves along.
    const auto grow = [](gl::Buffer& buffer, std::size_t bytes) {
        gl::Buffer larger(bytes);
        if (buffer) larger.copyFrom(buffer, std::min(buffer.bytes(), bytes));
        buffer = std::move(larger);
    };
    grow(direct_, faces * sizeof(std::uint32_t));
    grow(gathered_, faces * sizeof(glm::uvec2));
    grow(list_, faces * sizeof(glm::uvec2));
    grow(faces_, faces * sizeof(glm::uvec2));
    const std::size_t words = settings_.voxel.storage == VoxelStorage::sh1 ? 4 : 1;
    if (!sixFace_) grow(folded_, voxels.capacity * words * sizeof(glm::uvec2));
}

void RadianceField::update(const Voxels& voxels, const Sky& sky, const Change& change, const BindLights& bindLights,
                           gl::PassTimers& timers) {
    begin(voxels, change, bindLights, timers, false);
    resume(voxels, sky, bindLights, timers);
}

void RadianceField::begin(const Voxels& voxels, const Change& change, const BindLights& bindLights,
                          gl::PassTimers& timers, bool shown) {
    // Cones that read these buffers in the last frame are done; buffer commands that touch what shaders stored are
    // ordered by a barrier of their own.
    gl::memoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT);
    reserve(voxels);
    const bool idle = whole(), gathers = change.light || change.coarsest || !change.forget;
    if (idle || change.light) {
        // What records count is kept while the records stay.
        counters_.clamped = 0;
        counterBuffer_ = gl::Buffer(sizeof counters_, &counters_);
    }
    if (idle) change_ = {false, false, true};
    if (gathers) {
        made_ = 0;
        wanted_ = change.forget ? settings_.light.bounces : 1;  // as far as is known
    }
    if (gathers) change_ = {change_.light || change.light, change_.coarsest || change.coarsest, change.forget};
    {
        const auto pass = timers.pass("light: inject");
        if (voxels.freshCount > 0) reset(voxels);
        if (change.light) {
            step_ = Step::direct;
            next_ = 0;
        } else {
            // Direct light that has not begun yet will come to the new records too.
            const bool toCome = step_ == Step::direct && next_ == 0;
            int done = 0;
            if (!toCome) inject(voxels, true, bindLights, done, static_cast<int>(voxels.freshCount * 6), {});
            if (gathers && step_ != Step::direct) {
                step_ = Step::measure;
                next_ = items_ = 0;
            }
        }
        if (step_ == Step::direct) items_ = static_cast<int>(voxels.slots * 6);
        if (!gathers) measure(voxels, false);
    }
    if (gathers && !(shown && voxels.freshCount > 0)) return;
    const auto pass = timers.pass("light: store");
    show(voxels, change.coarsest, !gathers && idle);
    if (idle && !gathers) {
        gl::memoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
        counters_ = counterBuffer_.read<VoxelCounters>()[0];
    }
}

bool RadianceField::resume(const Voxels& voxels, const Sky& sky, const BindLights& bindLights, gl::PassTimers& timers,
                           const gl::Stop& stop) {
    if (whole()) return true;
    gl::memoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT);
    if (step_ == Step::direct) {
        const auto pass = timers.pass("light: inject");
        if (!inject(voxels, false, bindLights, next_, items_, stop)) return false;
        step_ = Step::measure;
        if (stop && stop()) return false;
    }
    if (step_ == Step::measure) {
        {
            const auto pass = timers.pass("light: inject");
            measure(voxels, change_.light || change_.coarsest);
        }
        const bool forget = decide(sky);
        if (again_) {
            const auto pass = timers.pass("light: bounce");
            if (forget) gathered_.clear();
            if (wanted_ > 0) beginSeries(voxels);
        }
        if (stop && wanted_ > 0) {
            const auto pass = timers.pass("light: store");
            show(voxels, true, false);
            roundStored_ = true;
        }
        step_ = Step::bounces;
        if (stop && wanted_ > 0 && stop()) return false;
    }
    if (wanted_ > 0) {
        const auto pass = timers.pass("light: bounce");
        if (!bounce(voxels, sky, stop)) return false;
    }
    {
        const auto pass = timers.pass("light: store");
        show(voxels, true, true);
    }
    gl::memoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    counters_ = counterBuffer_.read<VoxelCounters>()[0];
    if (again_ && change_.forget) {
        const Series series = wanted_ > 0 ? state_.read<Series>()[0] : Series{};
        bounces_ = static_cast<int>(series.bounces);
        gain_ = series.gain;
    }
    step_ = Step::whole;
    return true;
}

void RadianceField::reset(const Voxels& voxels) {
    bind(voxels.fresh, kListStorage);
    bind(gathered_, kGatheredStorage);
    bind(direct_, kDirectStorage);
    reset_.set("u_faceCount", voxels.freshCount * 6);
    dispatchItems(reset_, voxels.freshCount * 6);
    gl::memoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
}

/// Faces from `next` to `items` of the first records, or of the new ones: gl::inPieces.
bool RadianceField::inject(const Voxels& voxels, bool listed, const BindLights& bindLights, int& next, int items,
                           const gl::Stop& stop) {
    if (items == 0) return true;
    bind(voxels.fresh, kListStorage);
    voxels.setClipmapUniforms(inject_);
    inject_.set("u_listed", listed);
    inject_.set("u_voxelSize", static_cast<float>(voxels.layout.voxelSize));
    counterBuffer_.bindBase(GL_SHADER_STORAGE_BUFFER, kCounterStorage);
    bind(voxels.places, kPlaceStorage);
    bind(voxels.faces, kFaceStorage);
    bind(voxels.emission, kEmissionStorage);
    bind(direct_, kDirectStorage);
    if (lights_) bindLights(inject_);
    const bool done = gl::inPieces(next, items, directPiece_, stop, [&](int first, int end) {
        inject_.set("u_firstFace", static_cast<std::uint32_t>(first));
        inject_.set("u_endFace", static_cast<std::uint32_t>(end));
        dispatchItems(inject_, static_cast<std::uint32_t>(end - first));
    });
    gl::memoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
    return done;
}

/// Counts the records; with `list` also lists the faces that gather and finds the brightest.
void RadianceField::measure(const Voxels& voxels, bool list) {
    gl::memoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    const VoxelCounters none;
    const std::size_t from = list ? offsetof(VoxelCounters, brightest) : offsetof(VoxelCounters, records);
    counterBuffer_.upload(reinterpret_cast<const char*>(&none) + from, sizeof none - from, from);
    counterBuffer_.bindBase(GL_SHADER_STORAGE_BUFFER, kCounterStorage);
    bind(voxels.places, kPlaceStorage);
    bind(voxels.coverage, kCoverageStorage);
    bind(direct_, kLitStorage);
    bind(list_, kListStorage);
    voxels.setClipmapUniforms(measure_);
    measure_.set("u_slotCount", voxels.slots);
    measure_.set("u_list", list);
    dispatchItems(measure_, voxels.slots);
    gl::memoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT);
    counters_ = counterBuffer_.read<VoxelCounters>()[0];
}

/// What is to bounce, and the scale of it. Whether it begins from nothing.
bool RadianceField::decide(const Sky& sky) {
    // Half floats keep 11 bits between 6e-5 and 65504: the brightest face of the last level is put at 2^6. That leaves
    // a factor of 1024 for bounces and for small bright things, which finer levels average less, and 10^6 for the dim.
    // What was gathered is stored over this scale, so it only changes when bounces begin from nothing. They do when it
    // no longer fits by far: when all was much brighter before, what was gathered then is of no use either.
    const float most = std::max({std::bit_cast<float>(counters_.brightest), sky.color.x, sky.color.y, sky.color.z});
    const float scale = most > 0 ? std::exp2(std::ceil(std::log2(most)) - 6) : 1;
    const bool forget =
        (change_.forget && (change_.light || change_.coarsest)) || scale > 16 * scale_ || scale < scale_ / 256;
    if (forget) scale_ = scale;
    const bool bounces = settings_.light.bounces > 0 && counters_.activeFaces > 0;
    again_ = forget || (!change_.forget && bounces);
    made_ = 0;
    wanted_ = !again_ || !bounces ? 0 : change_.forget ? settings_.light.bounces : 1;
    return forget;
}

void RadianceField::beginSeries(const Voxels& voxels) {
    const Series series{.faceGroups = groupsOf(counters_.activeFaces), .slotGroups = groupsOf(voxels.slots)};
    state_.upload(&series, sizeof series);
    next_ = 0;
    items_ = static_cast<int>(counters_.activeFaces);
    roundStored_ = false;
}

/// Up to `wanted_` bounces: the device itself ends the series, so that nobody waits for it, but for those who ask
/// `stop`. In the end the rest of the series is added.
bool RadianceField::bounce(const Voxels& voxels, const Sky& sky, const gl::Stop& stop) {
    const bool extend = change_.forget && settings_.light.extrapolate;
    // The sums have 17 bits below the storage's unit: enough to see a ratio of increments when they are all dim.
    bounce_.set("u_fixedPointUnit", 131072.0f);
    // A single bounce that is added to those of the frames before says nothing of a series.
    series_.set("u_tolerance", wanted_ > 1 ? settings_.light.tolerance : 0);
    series_.set("u_extrapolate", extend);
    counterBuffer_.bindBase(GL_SHADER_STORAGE_BUFFER, kCounterStorage);
    while (made_ < wanted_) {
        if (!roundStored_) store(voxels, voxels.layout.levels - 1, true, false, true);
        roundStored_ = true;
        // Bounces depend on the windows alone, wherever the camera is in them.
        setConeUniforms(bounce_, settings_, sky, volume(voxels), settings_.cone.step, gl::kPassTextureUnit, true);
        setConeSetUniforms(bounce_, settings_.light.bounceCones);
        bind(list_, kListStorage);
        bind(voxels.places, kPlaceStorage);
        bind(voxels.faces, kFaceStorage);
        bind(voxels.coverage, kBouncedStorage);
        bind(gathered_, kGatheredStorage);
        if (!stop && next_ == 0) {
            bounce_.set("u_firstFace", std::uint32_t{0});
            bounce_.set("u_endFace", static_cast<std::uint32_t>(items_));
            gl::dispatchIndirect(bounce_, state_, offsetof(Series, faceGroups));
        } else if (!gl::inPieces(next_, items_, bouncePiece_, stop, [&](int first, int end) {
                       bounce_.set("u_firstFace", static_cast<std::uint32_t>(first));
                       bounce_.set("u_endFace", static_cast<std::uint32_t>(end));
                       dispatchItems(bounce_, static_cast<std::uint32_t>(end - first));
                   })) {
            return false;
        }
        gl::memoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
        bind(state_, kSeriesStorage);
        gl::dispatch(series_, 1, 1, 1);
        gl::memoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_COMMAND_BARRIER_BIT);
        ++made_;
        next_ = 0;
        roundStored_ = false;
        if (!stop) continue;
        gl::memoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
        if (state_.read<Series>()[0].faceGroups.x == 0) break;
        if (made_ == wanted_) break;
        // The light of whole bounces, for cones of pixels meanwhile, and for the next bounce.
        show(voxels, true, false);
        roundStored_ = true;
        if (stop()) return false;
    }
    if (!extend) return true;
    bind(state_, kSeriesStorage);
    bind(list_, kListStorage);
    bind(gathered_, kGatheredStorage);
    extend_.set("u_faceCount", static_cast<std::uint32_t>(items_));
    dispatchItems(extend_, static_cast<std::uint32_t>(items_));
    gl::memoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
    return true;
}

/// What cones read of all records, or of the new ones; finer levels take over what was gathered.
void RadianceField::show(const Voxels& voxels, bool all, bool count) {
    if (voxels.layout.levels > 1) spread(voxels, all);
    counterBuffer_.bindBase(GL_SHADER_STORAGE_BUFFER, kCounterStorage);
    store(voxels, 0, all, count);
}

void RadianceField::isolateLastBounce(const Voxels& voxels) {
    gl::memoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    direct_.clear();
    gathered_.clear();
    if (counters_.activeFaces > 0) {
        // The series continued by once its last increment, from nothing: the increment.
        const Series series{.tail = glm::vec3(1)};
        state_.upload(&series, sizeof series);
        bind(state_, kSeriesStorage);
        bind(list_, kListStorage);
        bind(gathered_, kGatheredStorage);
        extend_.set("u_faceCount", counters_.activeFaces);
        dispatchItems(extend_, counters_.activeFaces);
        gl::memoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
    }
    if (voxels.layout.levels > 1) spread(voxels, true);
    store(voxels, 0, true, false);
}

void RadianceField::spread(const Voxels& voxels, bool all) {
    bind(voxels.places, kPlaceStorage);
    bind(voxels.faces, kFaceStorage);
    bind(voxels.coverage, kCoverageStorage);
    bind(gathered_, kGatheredStorage);
    voxels.setClipmapUniforms(spread_);
    const std::uint32_t slots = all ? voxels.slots : voxels.freshCount;
    bind(voxels.fresh, kListStorage);
    spread_.set("u_slotCount", slots);
    spread_.set("u_listed", !all);
    voxels.bindIndex(spread_, gl::kPassTextureUnit);
    for (int level = voxels.layout.levels - 2; level >= 0; --level) {
        spread_.set("u_level", level);
        dispatchItems(spread_, slots);
        gl::memoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
    }
}

/// Radiance of the faces of all levels from `firstLevel` on, and of the mips, as cones read it; or of new records only.
/// `count`: values that are clamped. `inSeries`: only while the series of bounces goes on.
void RadianceField::store(const Voxels& voxels, int firstLevel, bool all, bool count, bool inSeries) {
    const auto dispatchSlots = [&](const gl::Program& program, std::uint32_t slots) {
        if (inSeries) {
            gl::dispatchIndirect(program, state_, offsetof(Series, slotGroups));
        } else {
            dispatchItems(program, slots);
        }
        gl::memoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
    };
    bind(voxels.places, kPlaceStorage);
    bind(voxels.faces, kFaceStorage);
    bind(voxels.coverage, kCoverageStorage);
    bind(direct_, kLitStorage);
    bind(gathered_, kGatheredStorage);
    bind(faces_, kRadianceStorage);
    voxels.setClipmapUniforms(store_);
    const std::uint32_t slots = all ? voxels.slots : voxels.freshCount;
    bind(voxels.fresh, kListStorage);
    store_.set("u_slotCount", slots);
    store_.set("u_listed", !all);
    store_.set("u_firstLevel", firstLevel);
    store_.set("u_count", count);
    store_.set("u_inverseRadianceScale", 1 / scale_);
    dispatchSlots(store_, slots);
    // Mips hold the last level, and only with that do they change.
    if (!all && sixFace_) return;

    voxels.setClipmapUniforms(mip_);
    mip_.set("u_slotCount", voxels.slots);
    voxels.bindIndex(mip_, gl::kPassTextureUnit);
    for (int level = voxels.layout.levels; level < voxels.layout.count(); ++level) {
        mip_.set("u_level", level);
        dispatchSlots(mip_, voxels.slots);
    }
    if (sixFace_) return;
    bind(faces_, kGatheredStorage);
    bind(folded_, kRadianceStorage);
    bind(voxels.faces, kFaceStorage);
    fold_.set("u_slotCount", voxels.slots);
    dispatchSlots(fold_, voxels.slots);
}

}  // namespace voxcone
