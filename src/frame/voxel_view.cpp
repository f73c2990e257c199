#include "frame/voxel_view.h"

#include <algorithm>
#include <array>

#include "core/check.h"
#include "gl/bindings.h"

namespace voxcone {

namespace {

constexpr int kLobeStorage = 4;  // shaders/frame/voxel_view.comp

}  // namespace

VoxelView::VoxelView(const gl::ShaderLibrary& shaders, const Voxels& voxels, VoxelStorage storage, int width,
                     int height)
    : program_(shaders.compute("frame/voxel_view.comp", {{"LAYERS", voxels.anyMoving() ? "2" : "1"},
                                                         {"SIX_FACE", voxels.sixFace() ? "1" : "0"},
                                                         {"SH1", storage == VoxelStorage::sh1 ? "1" : "0"}})) {
    resize(width, height);
}

void VoxelView::resize(int width, int height) {
    picture_ = gl::Texture::create2D(GL_RGBA32F, width, height);
}

void VoxelView::draw(const VoxelChannel& channel, const CameraView& view, const RadianceVolume& volume,
                     const gl::Buffer& faceRadiance, const VoxelViewOptions& options) {
    const auto& names = VoxelChannel::kNames;
    const auto name = std::find(names.begin(), names.end(), channel.base);
    VOXCONE_CHECK(name != names.end(), "no voxel view {}", channel.base);
    const int level = channel.level;
    const Voxels& voxels = *volume.voxels;
    const ClipmapLayout& layout = voxels.layout;
    VOXCONE_CHECK(level < layout.count(), "level {} of {}", level, layout.count());

    std::array<glm::vec3, 16> low{}, high{};
    for (int l = 0; l < layout.count(); ++l) {
        const auto i = static_cast<std::size_t>(l);
        const double edge = static_cast<double>(1 << l);
        low[i] = glm::dvec3(voxels.windows[i].low) * edge;
        high[i] = glm::dvec3(voxels.windows[i].high) * edge;
        if (level < 0 && layout.moves(l)) {
            const glm::dvec3 c = voxels.center / layout.voxelSize;
            low[i] = glm::max(low[i], glm::vec3(c - voxels.radius() * edge));
            high[i] = glm::min(high[i], glm::vec3(c + voxels.radius() * edge));
        }
    }
    voxels.bindRecords(program_, gl::kPassTextureUnit);
    faceRadiance.bindBase(GL_SHADER_STORAGE_BUFFER, kRadianceStorage);
    volume.radiance->bindBase(GL_SHADER_STORAGE_BUFFER, kLobeStorage);
    program_.set("u_what", static_cast<int>(name - names.begin()));
    program_.set("u_face", channel.face);
    program_.set("u_firstLevel", level < 0 ? 0 : level);
    program_.set("u_lastLevel", level < 0 ? layout.levels - 1 : level);
    program_.set("u_coarsest", layout.count() - 1);
    program_.set("u_boxLow", std::span<const glm::vec3>(low));
    program_.set("u_boxHigh", std::span<const glm::vec3>(high));
    program_.set("u_inverseVoxelSize", static_cast<float>(1 / layout.voxelSize));
    program_.set("u_radianceScale", volume.scale);
    program_.set("u_cut",
                 glm::vec4(options.cutNormal,
                           (options.cutOffset - glm::dot(options.cutNormal, voxels.origin)) / layout.voxelSize));
    program_.set("u_edges", options.edges);
    program_.set("u_cameraPosition", view.position);
    program_.set("u_cameraRays", view.rays);
    // The picture of another kind may just have been fetched.
    gl::memoryBarrier(GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
    picture_.bindImage(0, 0, GL_WRITE_ONLY);
    program_.set("u_picture", 0);
    gl::dispatch(program_, gl::groupsFor(picture_.width(), 8), gl::groupsFor(picture_.height(), 8), 1);
    gl::memoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
}

}  // namespace voxcone
