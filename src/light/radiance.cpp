#include "light/radiance.h"

#include <bit>
#include <cmath>
#include <utility>

#include "gl/bindings.h"

namespace voxcone {

namespace {

/// Gain of a bounce beyond which no series is believed: a scene that reflects all of its light has no answer.
constexpr double kMostGain = 0.98;

/// Groups of 64 for `count` items, spread over two dimensions: one alone may hold only 65535 groups.
void dispatchItems(gl::Program& program, std::uint32_t count) {
    const int groups = static_cast<int>((count + 63) / 64);
    const int rows = gl::groupsFor(groups, 32768);
    gl::dispatch(program, gl::groupsFor(groups, std::max(rows, 1)), rows, 1);
}

void bind(const gl::Buffer& buffer, int block) {
    if (buffer) buffer.bindBase(GL_SHADER_STORAGE_BUFFER, block);
}

void bindIndex(gl::Program& program, const Voxels& voxels) {
    voxels.index.bindTo(gl::kPassTextureUnit);
    program.set("u_index", gl::kPassTextureUnit);
    if (!voxels.anyMoving()) return;
    voxels.movingIndex.bindTo(gl::kPassTextureUnit + 1);
    program.set("u_movingIndex", gl::kPassTextureUnit + 1);
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
    }
}

void RadianceField::reserve(const Voxels& voxels) {
    const std::size_t faces = std::size_t{6} * voxels.capacity;
    if (direct_.bytes() == faces * sizeof(std::uint32_t)) return;
    // What is kept from update to update moves along.
    const auto grow = [](gl::Buffer& buffer, std::size_t bytes) {
        gl::Buffer larger(bytes);
        if (buffer) larger.copyFrom(buffer, std::min(buffer.bytes(), bytes));
        buffer = std::move(larger);
    };
    grow(direct_, faces * sizeof(std::uint32_t));
    grow(gathered_, faces * sizeof(glm::uvec2));
    list_ = gl::Buffer(faces * sizeof(std::uint32_t));
    faces_ = gl::Buffer(faces * sizeof(glm::uvec2));
    stored_ = false;
    const std::size_t words = settings_.voxel.storage == VoxelStorage::sh1 ? 4 : 1;
    if (!sixFace_) folded_ = gl::Buffer(voxels.capacity * words * sizeof(glm::uvec2));
}

void RadianceField::update(const Voxels& voxels, const Sky& sky, const Change& change, const BindLights& bindLights,
                           gl::PassTimers& timers) {
    reserve(voxels);
    counters_ = VoxelCounters{};
    gl::Buffer counters(sizeof counters_, &counters_);
    {
        const auto pass = timers.pass("light: inject");
        counters.bindBase(GL_SHADER_STORAGE_BUFFER, kCounterStorage);
        // Cones that read these buffers in the last frame are done.
        gl::memoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
        inject(voxels, change.light, bindLights);
        measure(voxels, counters);
    }
    // Half floats keep 11 bits between 6e-5 and 65504: the brightest face of the last level is put at 2^6. That leaves
    // a factor of 1024 for bounces and for small bright things, which finer levels average less, and 10^6 for the dim.
    // What was gathered is stored over this scale, so it only changes when bounces begin from nothing. They do when it
    // no longer fits by far: when all was much brighter before, what was gathered then is of no use either.
    const float most = std::max({std::bit_cast<float>(counters_.brightest), sky.color.x, sky.color.y, sky.color.z});
    const float scale = most > 0 ? std::exp2(std::ceil(std::log2(most)) - 6) : 1;
    const bool forget =
        (change.forget && (change.light || change.coarsest)) || scale > 16 * scale_ || scale < scale_ / 256;
    if (forget) scale_ = scale;
    const bool bounces = settings_.light.bounces > 0 && counters_.activeFaces > 0;
    const bool again = forget || (!change.forget && bounces);
    if (again) {
        const auto pass = timers.pass("light: bounce");
        // Buffer commands that touch what shaders stored are ordered by a barrier of their own.
        gl::memoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
        if (forget) gathered_.clear();
        if (bounces) bounce(voxels, sky, change.forget ? settings_.light.bounces : 1, counters);
    }
    {
        const auto pass = timers.pass("light: store");
        // What has gathered and is stored the same way already needs nothing.
        const bool all = again || change.light || change.coarsest || !stored_;
        if (voxels.layout.levels > 1) spread(voxels, all);
        store(voxels, 0, all, true);
        stored_ = true;
    }
    gl::memoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    counters_ = counters.read<VoxelCounters>()[0];
}

void RadianceField::inject(const Voxels& voxels, bool all, const BindLights& bindLights) {
    bind(voxels.fresh, kListStorage);
    if (voxels.freshCount > 0) {
        bind(gathered_, kGatheredStorage);
        reset_.set("u_faceCount", voxels.freshCount * 6);
        dispatchItems(reset_, voxels.freshCount * 6);
    }
    const std::uint32_t records = all ? voxels.slots : voxels.freshCount;
    voxels.setClipmapUniforms(inject_);
    inject_.set("u_faceCount", records * 6);
    inject_.set("u_listed", !all);
    inject_.set("u_voxelSize", static_cast<float>(voxels.layout.voxelSize));
    bind(voxels.places, kPlaceStorage);
    bind(voxels.faces, kFaceStorage);
    bind(voxels.emission, kEmissionStorage);
    bind(direct_, kDirectStorage);
    if (lights_) bindLights(inject_);
    dispatchItems(inject_, records * 6);
    gl::memoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
}

void RadianceField::measure(const Voxels& voxels, const gl::Buffer& counters) {
    bind(voxels.places, kPlaceStorage);
    bind(voxels.coverage, kCoverageStorage);
    bind(direct_, kLitStorage);
    bind(list_, kListStorage);
    voxels.setClipmapUniforms(measure_);
    measure_.set("u_slotCount", voxels.slots);
    dispatchItems(measure_, voxels.slots);
    gl::memoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT);
    counters_ = counters.read<VoxelCounters>()[0];
}

void RadianceField::bounce(const Voxels& voxels, const Sky& sky, int bounces, gl::Buffer& counters) {
    const bool series = bounces == settings_.light.bounces && settings_.light.extrapolate;
    // The sums have 17 bits below the storage's unit: enough to see a ratio of increments when they are all dim.
    bounce_.set("u_fixedPointUnit", 131072.0f);
    glm::dvec3 addedBefore(0), ratio(0);
    for (int i = 0; i < bounces; ++i) {
        store(voxels, voxels.layout.levels - 1, true, false);
        const bool last = i + 1 == bounces;
        // Bounces k and k+1 add in the ratio ρ of a geometric series: the rest is ρ/(1−ρ) of the last.
        const glm::dvec3 tail = last && series && i > 0 ? ratio / (1.0 - ratio) : glm::dvec3(0);
        bounce_.set("u_tail", glm::vec3(tail));
        bounce_.set("u_faceCount", counters_.activeFaces);
        // Bounces depend on the windows alone, wherever the camera is in them.
        setConeUniforms(bounce_, settings_, sky, volume(voxels), settings_.cone.step, gl::kPassTextureUnit, true);
        setConeSetUniforms(bounce_, settings_.light.bounceCones);
        bind(list_, kListStorage);
        bind(voxels.places, kPlaceStorage);
        bind(voxels.faces, kFaceStorage);
        bind(voxels.coverage, kCoverageStorage);
        bind(gathered_, kGatheredStorage);
        dispatchItems(bounce_, counters_.activeFaces);
        gl::memoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT);
        if (last) break;
        VoxelCounters now = counters.read<VoxelCounters>()[0];
        for (int c = 0; c < 3; ++c) {
            const double added = std::ldexp(static_cast<double>(now.added[2 * c + 1]), 32) + now.added[2 * c];
            ratio[c] = addedBefore[c] > 0 ? std::min(added / addedBefore[c], kMostGain) : 0;
            addedBefore[c] = added;
            now.added[2 * c] = now.added[2 * c + 1] = 0;
        }
        counters.upload(&now, sizeof now);
    }
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
    bindIndex(spread_, voxels);
    for (int level = voxels.layout.levels - 2; level >= 0; --level) {
        spread_.set("u_level", level);
        dispatchItems(spread_, slots);
        gl::memoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
    }
}

/// Radiance of the faces of all levels from `firstLevel` on, and of the mips, as cones read it; or of new records only.
/// `count`: values that are clamped.
void RadianceField::store(const Voxels& voxels, int firstLevel, bool all, bool count) {
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
    dispatchItems(store_, slots);
    gl::memoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
    // Mips hold the last level, and only with that do they change.
    if (!all && sixFace_) return;

    voxels.setClipmapUniforms(mip_);
    mip_.set("u_slotCount", voxels.slots);
    bindIndex(mip_, voxels);
    for (int level = voxels.layout.levels; level < voxels.layout.count(); ++level) {
        mip_.set("u_level", level);
        dispatchItems(mip_, voxels.slots);
        gl::memoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
    }
    if (sixFace_) return;
    bind(faces_, kGatheredStorage);
    bind(folded_, kRadianceStorage);
    bind(voxels.faces, kFaceStorage);
    fold_.set("u_slotCount", voxels.slots);
    dispatchItems(fold_, voxels.slots);
    gl::memoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
}

}  // namespace voxcone
