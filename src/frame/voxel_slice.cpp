#include "frame/voxel_slice.h"

#include <algorithm>
#include <glm/gtc/packing.hpp>

#include "core/check.h"
#include "core/octahedral.h"
#include "gl/bindings.h"

namespace voxcone {
namespace {

constexpr int kSliceStorage = 4, kWords = 25;  // shaders/frame/voxel_slice.comp

/// The axes that run along u and v.
glm::ivec2 axesOf(int axis) {
    return axis == 0 ? glm::ivec2(2, 1) : axis == 1 ? glm::ivec2(0, 2) : glm::ivec2(0, 1);
}

}  // namespace

float VoxelFacts::opacity() const {
    float most = 0;
    for (const VoxelFace& face : faces) most = std::max(most, face.coverage);
    return most;
}

glm::ivec3 VoxelSlice::index(int u, int v) const {
    glm::ivec3 i = low;
    i[axesOf(axis).x] += u;
    i[axesOf(axis).y] += v;
    return i;
}

void Occupancy::add(const VoxelSlice& slice) {
    voxels += slice.voxels.size();
    const auto bins = static_cast<float>(histogram.size());
    for (const VoxelFacts& voxel : slice.voxels) {
        if (!voxel.occupied) continue;
        ++occupied;
        ++histogram[static_cast<std::size_t>(std::clamp(bins * voxel.opacity(), 0.0f, bins - 1))];
    }
}

VoxelSlicer::VoxelSlicer(const gl::ShaderLibrary& shaders, const Voxels& voxels)
    : program_(shaders.compute("frame/voxel_slice.comp", {{"LAYERS", voxels.anyMoving() ? "2" : "1"}})) {}

VoxelSlice VoxelSlicer::read(int level, int axis, int depth, const RadianceVolume& volume,
                             const gl::Buffer& faceRadiance) {
    const Voxels& voxels = *volume.voxels;
    VOXCONE_CHECK(level >= 0 && level < voxels.layout.count() && axis >= 0 && axis < 3, "level {}, axis {}", level,
                  axis);
    const VoxelBox& window = voxels.windows[static_cast<std::size_t>(level)];
    VoxelSlice slice;
    slice.level = level;
    slice.axis = axis;
    slice.low = window.low;
    slice.low[axis] += std::clamp(depth, 0, window.size()[axis] - 1);
    slice.width = window.size()[axesOf(axis).x];
    slice.height = window.size()[axesOf(axis).y];
    slice.voxelSize = voxels.layout.voxelSizeOf(level);
    slice.origin = voxels.origin;
    const auto count = static_cast<std::size_t>(slice.width) * static_cast<std::size_t>(slice.height);
    gl::Buffer words(count * kWords * sizeof(std::uint32_t));

    voxels.bindRecords(program_, gl::kPassTextureUnit);
    faceRadiance.bindBase(GL_SHADER_STORAGE_BUFFER, kRadianceStorage);
    words.bindBase(GL_SHADER_STORAGE_BUFFER, kSliceStorage);
    program_.set("u_level", level);
    program_.set("u_low", slice.low);
    program_.set("u_size", glm::ivec2(slice.width, slice.height));
    program_.set("u_axis", axis);
    gl::dispatch(program_, gl::groupsFor(slice.width, 8), gl::groupsFor(slice.height, 8), 1);
    gl::memoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);

    const auto data = words.read<std::uint32_t>();
    slice.voxels.resize(count);
    for (std::size_t i = 0; i < count; ++i) {
        const std::uint32_t* w = &data[i * kWords];
        VoxelFacts& voxel = slice.voxels[i];
        voxel.occupied = w[0] != 0;
        if (!voxel.occupied) continue;
        for (std::size_t f = 0; f < 6; ++f, w += 4) {
            VoxelFace& face = voxel.faces[f];
            const glm::vec2 redGreen = glm::unpackHalf2x16(w[3]), blueShare = glm::unpackHalf2x16(w[4]);
            face.coverage = blueShare.y;
            if (face.coverage <= 0) continue;
            face.albedo = unpackAlbedo(w[1]);
            face.normal = unpackOctahedral(w[2]);
            face.radiance = volume.scale * glm::vec3(redGreen, blueShare.x);
        }
    }
    return slice;
}

}  // namespace voxcone
