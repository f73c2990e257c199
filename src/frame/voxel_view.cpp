#include "frame/voxel_view.h"

#include <array>

#include "core/check.h"
#include "gl/bindings.h"

namespace voxcone {

VoxelView::VoxelView(const gl::ShaderLibrary& shaders, int width, int height)
    : program_(shaders.compute("frame/voxel_view.comp", {{"COMPARE_AND_SWAP", "0"}, {"EMISSION", "0"}})),
      picture_(gl::Texture::create2D(GL_RGBA32F, width, height)) {}

void VoxelView::draw(const std::string& what, const CameraView& view, const Voxels& voxels, const gl::Texture& index,
                     const gl::Buffer& faceRadiance) {
    constexpr std::array kNames{"voxel_albedo", "voxel_normal", "voxel_radiance", "voxel_opacity"};
    const auto name = std::find(kNames.begin(), kNames.end(), what);
    VOXCONE_CHECK(name != kNames.end(), "no voxel view {}", what);
    voxels.faces.bindBase(GL_SHADER_STORAGE_BUFFER, kFaceStorage);
    faceRadiance.bindBase(GL_SHADER_STORAGE_BUFFER, kRadianceStorage);
    index.bindTo(gl::kPassTextureUnit);
    program_.set("u_index", gl::kPassTextureUnit);
    program_.set("u_what", static_cast<int>(name - kNames.begin()));
    program_.set("u_resolution", voxels.grid.resolution);
    program_.set("u_inverseVoxelSize", static_cast<float>(1 / voxels.grid.voxelSize));
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
