#include "voxelize/voxelizer.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/error.h"
#include "gl/bindings.h"

namespace voxcone {

namespace {

constexpr int kIndexImage = 0, kOtherIndexImage = 1, kPositiveImage = 2, kNegativeImage = 3, kLeafImage = 4;

std::string onOff(bool value) {
    return value ? "1" : "0";
}

/// Largest radiance that any material emits, W/(m² sr).
float largestEmission(const Scene& scene) {
    float largest = 0;
    for (const Material& m : scene.materials) {
        if (m.extracted) continue;
        const glm::vec3 e = m.unlit ? glm::vec3(m.baseColor) : m.emission;
        largest = std::max({largest, e.x, e.y, e.z});
    }
    return largest;
}

/// One invocation a voxel of the box; groups of shaders/voxelize are 8×4×2.
void dispatchBox(gl::Program& program, const Region& region) {
    program.set("u_level", region.level);
    program.set("u_boxLow", region.box.low);
    program.set("u_boxHigh", region.box.high);
    const glm::ivec3 size = region.box.size();
    gl::dispatch(program, gl::groupsFor(size.x, 8), gl::groupsFor(size.y, 4), gl::groupsFor(size.z, 2));
}

void dispatchRecords(gl::Program& program, std::uint32_t first, std::uint32_t count) {
    program.set("u_firstRecord", first);
    program.set("u_recordCount", count);
    gl::dispatch(program, gl::groupsFor(static_cast<int>(count), 64), 1, 1);
}

void bindImage(gl::Program& program, const char* name, const gl::Texture& texture, int unit, GLenum access) {
    if (!texture) return;
    texture.bindImage(unit, 0, access);
    program.set(name, unit);
}

void bindVolumes(gl::Program& program, const Voxels& voxels) {
    bindImage(program, "u_index", voxels.index, kIndexImage, GL_READ_WRITE);
    bindImage(program, "u_movingIndex", voxels.movingIndex, kOtherIndexImage, GL_READ_WRITE);
    bindImage(program, "u_coveragePositive", voxels.coveragePositive, kPositiveImage, GL_WRITE_ONLY);
    bindImage(program, "u_coverageNegative", voxels.coverageNegative, kNegativeImage, GL_WRITE_ONLY);
    bindImage(program, "u_leaves", voxels.leafDepth, kLeafImage, GL_WRITE_ONLY);
}

/// The buffers of records that new ones are made in, but for the sums.
void bindRecords(const Voxels& voxels) {
    const auto bind = [](const gl::Buffer& buffer, int block) {
        if (buffer) buffer.bindBase(GL_SHADER_STORAGE_BUFFER, block);
    };
    bind(voxels.freeSlots, kFreeStorage);
    bind(voxels.fresh, kFreshStorage);
    bind(voxels.places, kPlaceStorage);
    bind(voxels.faces, kFaceStorage);
    bind(voxels.emission, kEmissionStorage);
    bind(voxels.coverage, kCoverageStorage);
}

/// The boxes of each mip that hold the children of `regions`.
std::vector<Region> mipRegions(const ClipmapLayout& layout, const ClipmapUpdate& update) {
    std::vector<VoxelBox> boxes;
    for (const auto* regions : {&update.fixed, &update.moving})
        for (const Region& region : *regions)
            if (region.level == layout.levels - 1) boxes.push_back(region.box);
    std::vector<Region> out;
    for (int level = layout.levels; level < layout.count(); ++level) {
        for (VoxelBox& box : boxes) box = {box.low >> glm::ivec3(1), (box.high + 1) >> glm::ivec3(1)};
        for (const VoxelBox& box : disjoint(boxes)) out.push_back({level, box});
    }
    return out;
}

/// A buffer of `bytes` that begins with what `old` holds.
gl::Buffer grown(const gl::Buffer& old, std::size_t bytes) {
    gl::Buffer buffer(bytes);
    if (old) buffer.copyFrom(old, std::min(old.bytes(), bytes));
    return buffer;
}

}  // namespace

Voxelizer::Voxelizer(const gl::Context& context, const gl::ShaderLibrary& shaders, const gl::GpuScene& scene,
                     const Settings& settings)
    : settings_(settings.voxel),
      sheetGain_(settings.cone.compositing == Compositing::linear ? static_cast<float>(settings.cone.gain) : 1.0f),
      maxStorageBytes_(context.info().maxSsboBytes),
      maxRecordBytes_(maxStorageBytes_),
      emission_(scene.anyEmissionToCones()),
      layers_(scene.anyMoving()) {
    const bool cas = settings_.averaging == VoxelAveraging::compare_and_swap;
    // Other compositing takes all matter for one kind, and binary coverage knows no share.
    leaves_ = scene.anyLeaves() && !cas && settings_.coverage == VoxelCoverage::area &&
              settings.cone.compositing == Compositing::linear;
    const gl::Defines defines{
        {"COMPARE_AND_SWAP", onOff(cas)},
        {"EMISSION", onOff(emission_)},
        {"BINARY_COVERAGE", onOff(settings_.coverage == VoxelCoverage::binary)},
        {"CONSERVATIVE", onOff(settings_.conservative)},
        {"SIX_FACE", onOff(settings_.storage == VoxelStorage::six_face)},
        {"LAYERS", layers_ ? "2" : "1"},
        {"LEAVES", onOff(leaves_)},
    };
    clear_ = shaders.compute("voxelize/clear.comp", defines);
    mark_ = shaders.graphics({"voxelize/voxelize.vert", "voxelize/voxelize.geom", "voxelize/mark.frag"}, defines);
    allocate_ = shaders.compute("voxelize/allocate.comp", defines);
    markMip_ = shaders.compute("voxelize/mip_mark.comp", defines);
    accumulate_ =
        shaders.graphics({"voxelize/voxelize.vert", "voxelize/voxelize.geom", "voxelize/accumulate.frag"}, defines);
    resolve_ = shaders.compute("voxelize/resolve.comp", defines);
    resolveMip_ = shaders.compute("voxelize/mip_resolve.comp", defines);
    if (leaves_) {
        matter_ = shaders.compute("voxelize/matter.comp", defines);
        matterMip_ = shaders.compute("voxelize/matter_mip.comp", defines);
    }

    // 24 bits for the brightest emitter: one of a millionth of it is still stored to 6 %. Compare-and-swap keeps 8
    // bits. The clamp is for unlit materials that are black.
    const float largest = std::clamp(largestEmission(scene.scene()), 1e-30f, 1e30f);
    if (emission_) emissionUnit_ = cas ? 1 / largest : std::exp2(24 - std::ceil(std::log2(largest)));
    framebuffer_ = gl::Framebuffer::withoutAttachments(settings_.resolution, settings_.resolution);
}

Voxels Voxelizer::allocate(const ClipmapLayout& layout) const {
    Voxels voxels;
    voxels.layout = layout;
    voxels.origin = layout.origin;
    voxels.emits = emission_;
    voxels.leaves = leaves_;
    const auto volume = [](GLenum format, const ClipmapVolume& shape) {
        const glm::ivec3 size = shape.size();
        gl::Texture texture = gl::Texture::create3D(format, size.x, size.y, size.z);
        texture.clear();
        return texture;
    };
    const ClipmapVolume plain(layout, 0), bordered(layout, 1);
    voxels.index = volume(GL_R32UI, plain);
    if (layers_) voxels.movingIndex = volume(GL_R32UI, plain);
    voxels.coveragePositive = volume(GL_RGB10_A2, bordered);
    if (settings_.storage == VoxelStorage::six_face) voxels.coverageNegative = volume(GL_RGB10_A2, bordered);
    if (leaves_) voxels.leafDepth = volume(GL_R11F_G11F_B10F, bordered);
    for (gl::Texture* texture : {&voxels.coveragePositive, &voxels.coverageNegative, &voxels.leafDepth})
        if (*texture) texture->filter(GL_LINEAR, GL_LINEAR);
    return voxels;
}

void Voxelizer::reserve(std::uint32_t records, Voxels& voxels) const {
    if (voxels.capacity > 0 && records <= voxels.capacity) return;
    // The first time exactly what is needed; then with room, so that a moving camera does not grow it every frame.
    const std::size_t recordBytes = 6 * sizeof(FaceRecord);
    const auto most = static_cast<std::uint32_t>(
        std::min<std::int64_t>(maxStorageBytes_ / static_cast<std::int64_t>(recordBytes), 1 << 30));
    const std::uint32_t roomy = std::min(voxels.capacity + voxels.capacity / 8, most);
    const std::uint32_t capacity = std::max({records, voxels.capacity == 0 ? 1u : roomy});
    const std::size_t faceBytes = recordBytes * capacity;
    if (faceBytes > static_cast<std::size_t>(maxStorageBytes_))
        throw DeviceError(
            fmt::format("{} voxels need a storage block of {} bytes; the device allows "
                        "GL_MAX_SHADER_STORAGE_BLOCK_SIZE = {}: lower voxel.resolution or cascade.levels",
                        capacity, faceBytes, maxStorageBytes_));
    voxels.places = grown(voxels.places, capacity * sizeof(std::uint32_t));
    voxels.freeSlots = grown(voxels.freeSlots, capacity * sizeof(std::uint32_t));
    voxels.faces = grown(voxels.faces, faceBytes);
    voxels.coverage = grown(voxels.coverage, capacity * sizeof(glm::uvec2));
    if (leaves_) voxels.matter = grown(voxels.matter, capacity * sizeof(glm::uvec4));
    if (emission_) voxels.emission = grown(voxels.emission, std::size_t{6} * sizeof(std::uint32_t) * capacity);
    voxels.capacity = capacity;
}

void Voxelizer::clear(const std::vector<Region>& regions, bool moving, Voxels& voxels) {
    voxels.setClipmapUniforms(clear_);
    bindVolumes(clear_, voxels);
    if (moving) {
        clear_.set("u_index", kOtherIndexImage);
        clear_.set("u_otherIndex", kIndexImage);
    } else if (layers_) {
        clear_.set("u_otherIndex", kOtherIndexImage);
    }
    voxels.places.bindBase(GL_SHADER_STORAGE_BUFFER, kPlaceStorage);
    voxels.coverage.bindBase(GL_SHADER_STORAGE_BUFFER, kCoverageStorage);
    if (leaves_) voxels.matter.bindBase(GL_SHADER_STORAGE_BUFFER, kMatterStorage);
    voxels.freeSlots.bindBase(GL_SHADER_STORAGE_BUFFER, kFreeStorage);
    for (const Region& region : regions) dispatchBox(clear_, region);
    gl::memoryBarrier(GL_SHADER_IMAGE_ACCESS_BARRIER_BIT | GL_SHADER_STORAGE_BARRIER_BIT);
}

void Voxelizer::draw(gl::Program& program, const gl::GpuScene& scene, const Region& region, bool moving, Voxels& voxels,
                     gl::TextureFiltering filtering) {
    const ClipmapLayout& layout = voxels.layout;
    const VoxelBox& window = voxels.windows[static_cast<std::size_t>(region.level)];
    const double edge = layout.voxelSizeOf(region.level);
    program.set("u_level", region.level);
    program.set("u_windowOrigin", window.low);
    program.set("u_boxLow", region.box.low);
    program.set("u_boxHigh", region.box.high);
    program.set("u_inverseVoxelSize", static_cast<float>(1 / edge));
    const gl::Texture& index = moving ? voxels.movingIndex : voxels.index;
    index.bindImage(kIndexImage, 0, &program == &mark_ ? GL_WRITE_ONLY : GL_READ_ONLY);
    program.set("u_index", kIndexImage);

    framebuffer_.bind();
    gl::DrawState{}.apply();
    // One scissor for each axis that a triangle may be seen along.
    const glm::ivec3 low = region.box.low - window.low, size = region.box.size();
    for (int axis = 0; axis < 3; ++axis) {
        const int u = (axis + 1) % 3, v = (axis + 2) % 3;
        glScissorIndexed(static_cast<GLuint>(axis), low[u], low[v], size[u], size[v]);
    }
    glEnable(GL_SCISSOR_TEST);
    Bounds box;
    box.add(voxels.origin + glm::dvec3(region.box.low) * edge);
    box.add(voxels.origin + glm::dvec3(region.box.high) * edge);
    voxels.trianglesDrawn += scene.drawInside(
        program, box, [&](const gl::Batch& batch) { return batch.moving == moving; }, filtering);
    glDisable(GL_SCISSOR_TEST);
}

void Voxelizer::allocateRecords(const ClipmapUpdate& update, const std::vector<Region>& mips, Voxels& voxels) {
    const VoxelCounters start = voxels.counters;
    for (;;) {
        gl::Buffer counters(sizeof start, &start);
        counters.bindBase(GL_SHADER_STORAGE_BUFFER, kCounterStorage);
        if (!voxels.fresh) voxels.fresh = gl::Buffer(sizeof(std::uint32_t) << 16);
        const auto capacity = static_cast<std::uint32_t>(voxels.fresh.bytes() / sizeof(std::uint32_t));
        voxels.fresh.bindBase(GL_SHADER_STORAGE_BUFFER, kFreshStorage);
        const auto prepare = [&](gl::Program& program) {
            voxels.setClipmapUniforms(program);
            bindVolumes(program, voxels);
            program.set("u_freshCapacity", capacity);
        };
        prepare(allocate_);
        for (const bool moving : {false, true}) {
            if (moving && !layers_) continue;
            allocate_.set("u_index", moving ? kOtherIndexImage : kIndexImage);
            allocate_.set("u_layer", moving ? 1 : 0);
            for (const Region& region : moving ? update.moving : update.fixed) dispatchBox(allocate_, region);
            gl::memoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
        }
        prepare(markMip_);
        for (const Region& region : mips) {
            dispatchBox(markMip_, region);
            gl::memoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
        }
        gl::memoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
        voxels.counters = counters.read<VoxelCounters>()[0];
        if (voxels.counters.fresh <= capacity) break;
        voxels.fresh = gl::Buffer(voxels.counters.fresh * sizeof(std::uint32_t));
    }
}

void Voxelizer::accumulate(const gl::GpuScene& scene, const std::vector<Region>& regions, bool moving,
                           std::uint32_t first, std::uint32_t count, Voxels& voxels) {
    const bool cas = settings_.averaging == VoxelAveraging::compare_and_swap;
    const std::size_t recordBytes =
        6 * sizeof(std::uint32_t) * static_cast<std::size_t>(faceWords(cas, emission_, leaves_));
    // No more than one dispatch of the resolve may hold, either.
    const std::size_t most =
        std::clamp<std::size_t>(static_cast<std::size_t>(maxRecordBytes_) / recordBytes, 1, 65535 * 64);
    const auto chunk = static_cast<std::uint32_t>(std::min<std::size_t>(count, most));
    if (chunk == 0) return;
    gl::Buffer sums(chunk * recordBytes);

    // When the sums of all voxels do not fit in one buffer, the regions are drawn once for every part of them.
    for (std::uint32_t done = 0; done < count; done += chunk) {
        const std::uint32_t part = std::min(chunk, count - done);
        sums.clear();
        sums.bindBase(GL_SHADER_STORAGE_BUFFER, kSumStorage);
        voxels.setClipmapUniforms(accumulate_);
        accumulate_.set("u_firstRecord", first + done);
        accumulate_.set("u_recordCount", part);
        accumulate_.set("u_emissionUnit", emissionUnit_);
        accumulate_.set("u_sheetGain", sheetGain_);
        for (const Region& region : regions)
            draw(accumulate_, scene, region, moving, voxels, gl::TextureFiltering::isotropic);
        gl::memoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);

        const auto resolve = [&](gl::Program& program) {
            voxels.setClipmapUniforms(program);
            bindVolumes(program, voxels);
            program.set("u_emissionUnit", emissionUnit_);
            program.set("u_freeCount", voxels.freeCount);
            program.set("u_firstSlot", voxels.slots);
            dispatchRecords(program, first + done, part);
        };
        bindRecords(voxels);
        if (leaves_) {
            voxels.matter.bindBase(GL_SHADER_STORAGE_BUFFER, kMatterStorage);
            resolve(matter_);
            // The list that it reads becomes one of slots, and the marks in the index volumes numbers of records.
            gl::memoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
        }
        voxels.faces.bindBase(GL_SHADER_STORAGE_BUFFER, kFaceStorage);
        resolve(resolve_);
        gl::memoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_SHADER_IMAGE_ACCESS_BARRIER_BIT |
                          GL_BUFFER_UPDATE_BARRIER_BIT);
    }
}

void Voxelizer::update(const gl::GpuScene& scene, const ClipmapUpdate& update, Voxels& voxels, gl::PassTimers& timers) {
    VOXCONE_CHECK(scene.origin() == voxels.origin, "scene and voxels differ in origin: {} and {}", scene.origin().x,
                  voxels.origin.x);
    voxels.trianglesDrawn = 0;
    voxels.freshCount = 0;
    voxels.counters = VoxelCounters{};
    const std::vector<Region> mips = mipRegions(voxels.layout, update);

    {
        const auto pass = timers.pass("voxelize: mark");
        // The volumes still hold what shaders stored into them last time, and who fetched it is done.
        gl::memoryBarrier(GL_TEXTURE_UPDATE_BARRIER_BIT | GL_SHADER_IMAGE_ACCESS_BARRIER_BIT |
                          GL_SHADER_STORAGE_BARRIER_BIT);
        if (update.all) {
            for (gl::Texture* texture : {&voxels.index, &voxels.movingIndex, &voxels.coveragePositive,
                                         &voxels.coverageNegative, &voxels.leafDepth})
                if (*texture) texture->clear();
            voxels.slots = voxels.freeCount = 0;
        } else if (voxels.slots > 0) {
            voxels.counters.freeCount = voxels.freeCount;
            gl::Buffer counters(sizeof voxels.counters, &voxels.counters);
            counters.bindBase(GL_SHADER_STORAGE_BUFFER, kCounterStorage);
            clear(update.fixed, false, voxels);
            if (layers_) clear(update.moving, true, voxels);
            clear(mips, false, voxels);
            gl::memoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
            voxels.freeCount = counters.read<VoxelCounters>()[0].freeCount;
        }
        voxels.windows = update.windows;
        voxels.setClipmapUniforms(mark_);
        for (const bool moving : {false, true})
            for (const Region& region : moving ? update.moving : update.fixed)
                draw(mark_, scene, region, moving, voxels, gl::TextureFiltering::isotropic);
        // The marks were written through images and are read so.
        gl::memoryBarrier(GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
    }
    {
        const auto pass = timers.pass("voxelize: allocate");
        allocateRecords(update, mips, voxels);
        const std::uint32_t fresh = voxels.counters.fresh;
        reserve(voxels.slots + (fresh > voxels.freeCount ? fresh - voxels.freeCount : 0), voxels);
    }
    const std::uint32_t fixed = voxels.counters.freshOfLayer[0], moving = voxels.counters.freshOfLayer[1];
    gl::Buffer counters(sizeof voxels.counters, &voxels.counters);
    counters.bindBase(GL_SHADER_STORAGE_BUFFER, kCounterStorage);
    {
        const auto pass = timers.pass("voxelize: accumulate");
        accumulate(scene, update.fixed, false, 0, fixed, voxels);
        accumulate(scene, update.moving, true, fixed, moving, voxels);
    }
    {
        const auto pass = timers.pass("voxelize: mips");
        const std::uint32_t surfaces = fixed + moving, fresh = voxels.counters.fresh;
        bindRecords(voxels);
        const auto resolve = [&](gl::Program& program, int level) {
            voxels.setClipmapUniforms(program);
            bindVolumes(program, voxels);
            program.set("u_freeCount", voxels.freeCount);
            program.set("u_firstSlot", voxels.slots);
            program.set("u_level", level);
            dispatchRecords(program, surfaces, fresh - surfaces);
            gl::memoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
        };
        for (int level = voxels.layout.levels; level < voxels.layout.count() && fresh > surfaces; ++level) {
            voxels.faces.bindBase(GL_SHADER_STORAGE_BUFFER, kFaceStorage);
            resolve(resolveMip_, level);
            if (!leaves_) continue;
            voxels.matter.bindBase(GL_SHADER_STORAGE_BUFFER, kMatterStorage);
            resolve(matterMip_, level);
        }
        gl::memoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT);
        voxels.counters = counters.read<VoxelCounters>()[0];
        voxels.freshCount = surfaces;
        const std::uint32_t taken = std::min(fresh, voxels.freeCount);
        voxels.freeCount -= taken;
        voxels.slots += fresh - taken;
    }
}

}  // namespace voxcone
