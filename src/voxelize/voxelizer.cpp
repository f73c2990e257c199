#include "voxelize/voxelizer.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "gl/bindings.h"

namespace voxcone {

namespace {

constexpr int kIndexImage = 0, kPositiveImage = 1, kNegativeImage = 2;

std::string onOff(bool value) {
    return value ? "1" : "0";
}

/// Largest radiance that any material emits, W/(m² sr).
float largestEmission(const Scene& scene) {
    float largest = 0;
    for (const Material& m : scene.materials) {
        const glm::vec3 e = m.unlit ? glm::vec3(m.baseColor) : m.emission;
        largest = std::max({largest, e.x, e.y, e.z});
    }
    return largest;
}

int mipGroups(int size) {
    return gl::groupsFor(size, 4);
}

}  // namespace

Voxelizer::Voxelizer(const gl::Context& context, const gl::ShaderLibrary& shaders, const gl::GpuScene& scene,
                     const Settings& settings)
    : settings_(settings.voxel),
      maxStorageBytes_(context.info().maxSsboBytes),
      maxRecordBytes_(maxStorageBytes_),
      emission_(scene.anyEmission()) {
    const int r = settings_.resolution;
    if (r > context.info().max3DTextureSize)
        throw DeviceError(
            fmt::format("voxel.resolution {} is beyond GL_MAX_3D_TEXTURE_SIZE {}", r, context.info().max3DTextureSize));
    const bool cas = settings_.averaging == VoxelAveraging::compare_and_swap;
    const gl::Defines defines{
        {"COMPARE_AND_SWAP", onOff(cas)},
        {"EMISSION", onOff(emission_)},
        {"BINARY_COVERAGE", onOff(settings_.coverage == VoxelCoverage::binary)},
        {"CONSERVATIVE", onOff(settings_.conservative)},
        {"SIX_FACE", onOff(settings_.storage == VoxelStorage::six_face)},
    };
    const auto with = [&](const char* name, const char* value) {
        gl::Defines more = defines;
        more[name] = value;
        return more;
    };
    mark_ = shaders.graphics({"voxelize/voxelize.vert", "voxelize/voxelize.geom", "voxelize/mark.frag"}, defines);
    accumulate_ =
        shaders.graphics({"voxelize/voxelize.vert", "voxelize/voxelize.geom", "voxelize/accumulate.frag"}, defines);
    allocate_ = shaders.compute("voxelize/allocate.comp", with("WRITE_VOXELS", "0"));
    list_ = shaders.compute("voxelize/allocate.comp", with("WRITE_VOXELS", "1"));
    resolve_ = shaders.compute("voxelize/resolve.comp", defines);
    if (settings_.storage == VoxelStorage::six_face) mip_ = shaders.compute("voxelize/mip_coverage.comp", defines);

    // 24 bits for the brightest emitter: one of a millionth of it is still stored to 6 %. Compare-and-swap keeps 8
    // bits. The clamp is for unlit materials that are black.
    const float largest = std::clamp(largestEmission(scene.scene()), 1e-30f, 1e30f);
    if (emission_) emissionUnit_ = cas ? 1 / largest : std::exp2(24 - std::ceil(std::log2(largest)));

    index_ = gl::Texture::create3D(GL_R32UI, r, r, r);
    framebuffer_ = gl::Framebuffer::withoutAttachments(r, r);
}

Voxels Voxelizer::voxelize(const gl::GpuScene& scene, const VoxelGrid& grid, gl::PassTimers& timers) {
    VOXCONE_CHECK(grid.resolution == settings_.resolution, "grid {} settings {}", grid.resolution,
                  settings_.resolution);
    VOXCONE_CHECK(scene.origin() == grid.origin, "scene and grid differ in origin: {} and {}", scene.origin().x,
                  grid.origin.x);
    const int r = grid.resolution;
    Voxels voxels;
    voxels.grid = grid;
    voxels.emission = emission_;

    const VoxelCounters zero;
    gl::Buffer counters(sizeof zero, &zero);
    counters.bindBase(GL_SHADER_STORAGE_BUFFER, kCounterStorage);

    {
        const auto pass = timers.pass("voxelize: mark");
        // The index still holds what shaders stored into it last time.
        gl::memoryBarrier(GL_TEXTURE_UPDATE_BARRIER_BIT);
        index_.clear();
        index_.bindImage(kIndexImage, 0, GL_WRITE_ONLY);
        mark_.set("u_index", kIndexImage);
        mark_.set("u_resolution", r);
        mark_.set("u_inverseVoxelSize", static_cast<float>(1 / grid.voxelSize));
        framebuffer_.bind();
        gl::DrawState{}.apply();
        scene.draw(mark_);
        // The marks were written through images and are read so.
        gl::memoryBarrier(GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
    }
    {
        const auto pass = timers.pass("voxelize: allocate");
        index_.bindImage(kIndexImage, 0, GL_READ_WRITE);
        const auto run = [&](gl::Program& program) {
            program.set("u_index", kIndexImage);
            program.set("u_resolution", r);
            gl::dispatch(program, gl::groupsFor(r, 8), gl::groupsFor(r, 8), r);
        };
        run(allocate_);
        gl::memoryBarrier(GL_SHADER_IMAGE_ACCESS_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT);
        voxels.count = counters.read<VoxelCounters>()[0].occupied;
        const std::size_t count = std::max(voxels.count, 1u);  // buffers of no size cannot be bound
        const std::size_t faceBytes = count * 6 * sizeof(FaceRecord);
        if (faceBytes > static_cast<std::size_t>(maxStorageBytes_))
            throw DeviceError(
                fmt::format("{} voxels need a storage block of {} bytes; the device allows "
                            "GL_MAX_SHADER_STORAGE_BLOCK_SIZE = {}: lower voxel.resolution",
                            count, faceBytes, maxStorageBytes_));
        voxels.list = gl::Buffer(count * sizeof(std::uint32_t));
        voxels.faces = gl::Buffer(faceBytes);
        voxels.coverage = gl::Buffer(count * 6 * sizeof(float));
        voxels.list.bindBase(GL_SHADER_STORAGE_BUFFER, kVoxelStorage);
        run(list_);
        gl::memoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
    }
    {
        const auto pass = timers.pass("voxelize: accumulate");
        if (settings_.storage == VoxelStorage::six_face) {
            for (gl::Texture* volume : {&voxels.coveragePositive, &voxels.coverageNegative}) {
                *volume = gl::Texture::create3D(GL_RGBA16, r, r, r, gridLevels(r));
                volume->clear();
            }
        }
        accumulate(scene, voxels);
    }
    voxels.counters = counters.read<VoxelCounters>()[0];
    if (settings_.storage == VoxelStorage::six_face) {
        const auto pass = timers.pass("voxelize: mips");
        for (const gl::Texture* volume : {&voxels.coveragePositive, &voxels.coverageNegative}) {
            volume->bindTo(gl::kPassTextureUnit);
            mip_.set("u_finer", gl::kPassTextureUnit);
            mip_.set("u_coarser", kIndexImage);
            for (int level = 1; level < volume->levels(); ++level) {
                const int groups = mipGroups(volume->width(level));
                volume->bindImage(kIndexImage, level, GL_WRITE_ONLY);
                mip_.set("u_finerLevel", level - 1);
                gl::dispatch(mip_, groups, groups, groups);
                gl::memoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
            }
        }
    }
    return voxels;
}

void Voxelizer::accumulate(const gl::GpuScene& scene, Voxels& voxels) {
    const bool cas = settings_.averaging == VoxelAveraging::compare_and_swap;
    const std::size_t recordBytes = 6 * sizeof(std::uint32_t) * static_cast<std::size_t>(faceWords(cas, emission_));
    // No more than one dispatch of the resolve may hold, either.
    const std::size_t most =
        std::clamp<std::size_t>(static_cast<std::size_t>(maxRecordBytes_) / recordBytes, 1, 65535 * 64);
    const std::uint32_t chunk = static_cast<std::uint32_t>(std::min<std::size_t>(std::max(voxels.count, 1u), most));
    gl::Buffer records(chunk * recordBytes);
    voxels.faces.bindBase(GL_SHADER_STORAGE_BUFFER, kFaceStorage);
    voxels.coverage.bindBase(GL_SHADER_STORAGE_BUFFER, kCoverageStorage);

    // When the sums of all voxels do not fit in one buffer, the scene is drawn once for every part of the list.
    for (std::uint32_t first = 0; first < voxels.count; first += chunk) {
        const std::uint32_t count = std::min(chunk, voxels.count - first);
        records.clear();
        records.bindBase(GL_SHADER_STORAGE_BUFFER, kRecordStorage);
        index_.bindImage(kIndexImage, 0, GL_READ_ONLY);
        accumulate_.set("u_index", kIndexImage);
        accumulate_.set("u_resolution", settings_.resolution);
        accumulate_.set("u_inverseVoxelSize", static_cast<float>(1 / voxels.grid.voxelSize));
        accumulate_.set("u_firstRecord", first);
        accumulate_.set("u_recordCount", count);
        accumulate_.set("u_emissionUnit", emissionUnit_);
        framebuffer_.bind();
        gl::DrawState{}.apply();
        scene.draw(accumulate_, {}, gl::TextureFiltering::isotropic);
        gl::memoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);

        if (voxels.coveragePositive) {
            voxels.coveragePositive.bindImage(kPositiveImage, 0, GL_WRITE_ONLY);
            voxels.coverageNegative.bindImage(kNegativeImage, 0, GL_WRITE_ONLY);
            resolve_.set("u_coveragePositive", kPositiveImage);
            resolve_.set("u_coverageNegative", kNegativeImage);
        }
        resolve_.set("u_firstRecord", first);
        resolve_.set("u_recordCount", count);
        resolve_.set("u_emissionUnit", emissionUnit_);
        gl::dispatch(resolve_, gl::groupsFor(static_cast<int>(count), 64), 1, 1);
        gl::memoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_TEXTURE_FETCH_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT);
    }
}

}  // namespace voxcone
