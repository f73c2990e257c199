#include "support/voxel_lab.h"

#include <algorithm>

namespace voxcone::test {

namespace {

Settings withVoxelSize(Settings settings, double voxelSize) {
    settings.voxel.size = voxelSize;
    return settings;
}

std::size_t texelAt(const gl::Texture& volume, const glm::ivec3& t) {
    return static_cast<std::size_t>(t.x + volume.width() * (t.y + volume.height() * t.z));
}

}  // namespace

std::map<VoxelName, std::uint32_t> readSlots(const Voxels& voxels) {
    std::map<VoxelName, std::uint32_t> slots;
    if (voxels.slots == 0) return slots;
    const ClipmapVolume volume(voxels.layout, 0);
    const std::vector<std::uint32_t> index = voxels.index.readUints();
    std::vector<std::uint32_t> movingIndex;
    if (voxels.anyMoving()) movingIndex = voxels.movingIndex.readUints();
    const auto places = voxels.places.read<std::uint32_t>(0, voxels.slots);
    for (std::uint32_t slot = 0; slot < voxels.slots; ++slot) {
        const std::uint32_t place = places[slot];
        if (!placeInUse(place)) continue;
        const int level = placeLevel(place);
        const bool moving = placeMoves(place);
        const glm::ivec3 v = fromToroidal(placeTexel(place), voxels.windows[static_cast<std::size_t>(level)].low,
                                          voxels.layout.resolutionOf(level));
        const VoxelName name{level, moving, v.x, v.y, v.z};
        EXPECT_TRUE(slots.emplace(name, slot).second) << "a voxel has two records";
        EXPECT_EQ((moving ? movingIndex : index)[texelAt(voxels.index, volume.texel(v, level))], slot + 1)
            << "level " << level << " voxel " << v.x << " " << v.y << " " << v.z << (moving ? " moving" : "");
    }
    EXPECT_EQ(slots.size(), voxels.occupied());
    const auto found = [](std::uint32_t word) { return word != 0; };
    EXPECT_EQ(slots.size(), std::count_if(index.begin(), index.end(), found) +
                                std::count_if(movingIndex.begin(), movingIndex.end(), found))
        << "texels that point to no record";
    return slots;
}

std::map<VoxelName, VoxelFaces> readRecords(const Voxels& voxels) {
    std::map<VoxelName, VoxelFaces> records;
    const std::map<VoxelName, std::uint32_t> slots = readSlots(voxels);
    if (slots.empty()) return records;
    const auto faces = voxels.faces.read<FaceRecord>(0, std::size_t{6} * voxels.slots);
    const auto coverage = voxels.coverage.read<glm::uvec2>(0, voxels.slots);
    std::vector<std::uint32_t> emission(faces.size());
    if (voxels.emits) emission = voxels.emission.read<std::uint32_t>(0, faces.size());
    for (const auto& [name, slot] : slots) {
        VoxelFaces& out = records[name];
        for (std::size_t f = 0; f < 6; ++f) {
            const std::size_t at = 6 * slot + f;
            // Emission of a face without a surface is never read.
            out[f] = {faces[at], faceHoldsSurface(faces[at]) ? emission[at] : 0,
                      faceCoverage(coverage[slot], static_cast<int>(f))};
        }
    }
    return records;
}

VoxelMap readVoxels(const Voxels& voxels, int level, bool moving) {
    VoxelMap map;
    map.counters = voxels.counters;
    for (const auto& [name, faces] : readRecords(voxels))
        if (name[0] == level && name[1] == static_cast<int>(moving)) map.voxels[{name[2], name[3], name[4]}] = faces;
    return map;
}

ClipmapLab::ClipmapLab(const gl::Context& context, const gl::ShaderLibrary& shaders, const Scene& scene,
                       const Settings& settings)
    : scene_(scene),
      gpuScene_(scene),
      voxelizer_(context, shaders, gpuScene_, settings),
      voxels_(voxelizer_.allocate(layoutClipmap(scene.motionBounds(), settings))),
      schedule_(voxels_.layout, 0, gpuScene_.anyMoving()) {
    gpuScene_.setOrigin(voxels_.origin);
}

void ClipmapLab::show(const glm::dvec3& eye, double time) {
    const glm::dvec3 origin = clipmapOrigin(voxels_.layout, eye);
    if (origin != voxels_.origin) {
        voxels_.origin = origin;
        gpuScene_.setOrigin(origin);
        schedule_.reset();
    }
    gpuScene_.setTime(time);
    voxels_.center = eye - origin;
    std::vector<Bounds> moved;
    for (const Bounds& box : gpuScene_.takeMoved().moving) moved.push_back({box.min - origin, box.max - origin});
    voxelizer_.update(gpuScene_, schedule_.next(voxels_.center, moved), voxels_, timers_);
}

Voxels ClipmapLab::anew() {
    gl::GpuScene gpuScene(scene_, gpuScene_.time());
    gpuScene.setOrigin(voxels_.origin);
    Voxels voxels = voxelizer_.allocate(voxels_.layout);
    voxels.origin = voxels_.origin;
    voxels.center = voxels_.center;
    voxelizer_.update(gpuScene, ClipmapSchedule(voxels.layout, 0, gpuScene.anyMoving()).next(voxels.center, {}), voxels,
                      timers_);
    return voxels;
}

VoxelLab::VoxelLab(gl::Context& context, const Scene& scene, const Settings& settings, double voxelSize,
                   const glm::dvec3& eye)
    : settings_(withVoxelSize(settings, voxelSize)),
      clipmap_(context, shaders_, scene, settings_),
      sky_{scene.environment.color},
      shadowMaps_(context, shaders_, settings_.light),
      field_(shaders_, settings_, clipmap_.voxels(), sky_, !scene.lights.empty()) {
    clipmap_.show(eye);
    shadowMaps_.update(clipmap_.gpuScene(), timers_);
    field_.update(
        voxels(), sky_, RadianceField::Change{}, [this](gl::Program& program) { shadowMaps_.bind(program); }, timers_);
}

std::vector<ConeProbeResult> VoxelLab::gather(const std::vector<ConeProbe>& probes) {
    return ConeProber(shaders_, settings_, voxels(), sky_).gather(probes, field_.volume(voxels()), sky_);
}

}  // namespace voxcone::test
