// Pictures of the voxels themselves: the first occupied voxel along each pixel's ray.
#pragma once

#include <string>

#include "frame/gbuffer.h"
#include "voxelize/voxelizer.h"

namespace voxcone {

class VoxelView {
  public:
    /// Size in pixels of the G-buffer.
    VoxelView(const gl::ShaderLibrary& shaders, int width, int height);

    /// `what`: voxel_albedo, voxel_normal, voxel_radiance (of the face that looks to the eye) or voxel_opacity (its
    /// coverage). `faceRadiance` is RadianceField::faces().
    void draw(const std::string& what, const CameraView& view, const Voxels& voxels, const gl::Texture& index,
              const gl::Buffer& faceRadiance);

    /// RGBA32F; 0 where no voxel is met.
    const gl::Texture& texture() const { return picture_; }

  private:
    gl::Program program_;
    gl::Texture picture_;
};

}  // namespace voxcone
