#include "light/radiance.h"

#include <bit>
#include <cmath>

#include "gl/bindings.h"

namespace voxcone {

namespace {

constexpr int kVolumeImage = 0;

/// Gain of a bounce beyond which no series is believed: a scene that reflects all of its light has no answer.
constexpr double kMostGain = 0.98;

/// Groups of 64 for `count` items, spread over two dimensions: one alone may hold only 65535 groups.
void dispatchItems(gl::Program& program, std::uint32_t count) {
    const int groups = static_cast<int>((count + 63) / 64);
    const int rows = gl::groupsFor(groups, 32768);
    gl::dispatch(program, gl::groupsFor(groups, std::max(rows, 1)), rows, 1);
}

}  // namespace

RadianceField::RadianceField(const gl::ShaderLibrary& shaders, const Settings& settings, const Sky& sky, bool lights)
    : settings_(settings), lights_(lights) {
    const std::string sixFace = settings.voxel.storage == VoxelStorage::six_face ? "1" : "0";
    inject_ = shaders.compute("light/inject.comp",
                              {{"LIGHTS", lights ? "1" : "0"}, {"COMPARE_AND_SWAP", "0"}, {"EMISSION", "0"}});
    store_ = shaders.compute("light/store.comp", {{"SIX_FACE", sixFace}, {"COMPARE_AND_SWAP", "0"}, {"EMISSION", "0"}});
    mip_ = shaders.compute("light/mip_radiance.comp", {{"SIX_FACE", sixFace}});
    if (settings.light.bounces > 0) {
        gl::Defines defines = coneSetDefines(settings, sky, settings.light.bounceCones);
        defines["COMPARE_AND_SWAP"] = defines["EMISSION"] = "0";
        defines["AO_DISTANCE"] = "0";
        bounce_ = shaders.compute("light/bounce.comp", defines);
    }
}

void RadianceField::update(const Voxels& voxels, const Sky& sky, const std::function<void(gl::Program&)>& bindLights,
                           gl::PassTimers& timers) {
    const int r = voxels.grid.resolution;
    const bool sixFace = static_cast<bool>(voxels.coveragePositive);
    const std::size_t faceBytes = std::max<std::size_t>(voxels.count, 1) * 6 * sizeof(glm::vec4);
    const std::uint32_t faces = voxels.count * 6;

    counters_ = VoxelCounters{};
    gl::Buffer counters(sizeof counters_, &counters_);
    {
        const auto pass = timers.pass("light: inject");
        if (!volume_) {
            volume_ = gl::Texture::create3D(GL_RGBA16F, r, r, sixFace ? 6 * r : r, gridLevels(r));
            volume_.wrap(GL_CLAMP_TO_EDGE);
        }
        if (radiance_.bytes() != faceBytes) radiance_ = gl::Buffer(faceBytes);
        counters.bindBase(GL_SHADER_STORAGE_BUFFER, kCounterStorage);
        voxels.list.bindBase(GL_SHADER_STORAGE_BUFFER, kVoxelStorage);
        voxels.faces.bindBase(GL_SHADER_STORAGE_BUFFER, kFaceStorage);
        voxels.coverage.bindBase(GL_SHADER_STORAGE_BUFFER, kCoverageStorage);
        radiance_.bindBase(GL_SHADER_STORAGE_BUFFER, kRadianceStorage);
        // What the last update stored is done with before it is cleared and written over, and so is who read it.
        gl::memoryBarrier(GL_TEXTURE_UPDATE_BARRIER_BIT | GL_SHADER_STORAGE_BARRIER_BIT |
                          GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
        volume_.clear();
        inject_.set("u_faceCount", faces);
        inject_.set("u_voxelSize", static_cast<float>(voxels.grid.voxelSize));
        if (lights_) bindLights(inject_);
        dispatchItems(inject_, faces);
        gl::memoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT);
        // Half floats keep 11 bits between 6e-5 and 65504: put the brightest face at 2^11, which leaves a factor of 32
        // for bounces and as much as there is for the dim.
        const float brightest = std::bit_cast<float>(counters.read<VoxelCounters>()[0].brightest);
        const float most = std::max({brightest, sky.color.x, sky.color.y, sky.color.z});
        scale_ = most > 0 ? std::exp2(std::ceil(std::log2(most)) - 11) : 1;
        store(voxels);
    }
    if (settings_.light.bounces > 0 && voxels.count > 0) {
        const auto pass = timers.pass("light: bounce");
        if (direct_.bytes() != faceBytes) direct_ = gl::Buffer(faceBytes);
        direct_.copyFrom(radiance_);
        direct_.bindBase(GL_SHADER_STORAGE_BUFFER, kDirectStorage);
        // The sums have 12 bits below the storage's unit: enough to see a ratio of increments when they are all dim.
        bounce_.set("u_fixedPointUnit", 4096 / scale_);
        glm::dvec3 addedBefore(0), ratio(0);
        for (int i = 0; i < settings_.light.bounces; ++i) {
            const bool last = i + 1 == settings_.light.bounces;
            // Bounces k and k+1 add in the ratio ρ of a geometric series: the rest is ρ/(1−ρ) of the last.
            const glm::dvec3 tail =
                last && settings_.light.extrapolate && i > 0 ? ratio / (1.0 - ratio) : glm::dvec3(0);
            bounce_.set("u_tail", glm::vec3(tail));
            bounce_.set("u_faceCount", faces);
            setConeUniforms(bounce_, settings_, sky, volume(voxels), settings_.cone.step, gl::kPassTextureUnit);
            setConeSetUniforms(bounce_, settings_.light.bounceCones);
            dispatchItems(bounce_, faces);
            // The images that are stored next are those that the cones have just fetched.
            gl::memoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT |
                              GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
            store(voxels);
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
    counters_ = counters.read<VoxelCounters>()[0];
}

void RadianceField::store(const Voxels& voxels) {
    volume_.bindImage(kVolumeImage, 0, GL_WRITE_ONLY);
    store_.set("u_volume", kVolumeImage);
    store_.set("u_voxelCount", voxels.count);
    store_.set("u_resolution", voxels.grid.resolution);
    store_.set("u_inverseRadianceScale", 1 / scale_);
    dispatchItems(store_, voxels.count);
    // Storage: the next bounce writes the faces that were read here.
    gl::memoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_SHADER_STORAGE_BARRIER_BIT);

    volume_.bindTo(gl::kPassTextureUnit);
    mip_.set("u_finer", gl::kPassTextureUnit);
    mip_.set("u_coarser", kVolumeImage);
    if (voxels.coveragePositive) {
        voxels.coveragePositive.bindTo(gl::kPassTextureUnit + 1);
        voxels.coverageNegative.bindTo(gl::kPassTextureUnit + 2);
        mip_.set("u_coveragePositive", gl::kPassTextureUnit + 1);
        mip_.set("u_coverageNegative", gl::kPassTextureUnit + 2);
    }
    for (int level = 1; level < gridLevels(voxels.grid.resolution); ++level) {
        volume_.bindImage(kVolumeImage, level, GL_WRITE_ONLY);
        mip_.set("u_finerLevel", level - 1);
        gl::dispatch(mip_, gl::groupsFor(volume_.width(level), 4), gl::groupsFor(volume_.height(level), 4),
                     gl::groupsFor(volume_.depth(level), 4));
        gl::memoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
    }
}

}  // namespace voxcone
