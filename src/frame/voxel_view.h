// Pictures of the voxels themselves: the first occupied voxel along each pixel's ray.
#pragma once

#include <string>

#include "cone/cone_uniforms.h"
#include "frame/gbuffer.h"

namespace voxcone {

/// What of the voxels is shown; by default all, as captures have it.
struct VoxelViewOptions {
    /// Voxels whose centres lie beyond the plane dot(normal, x) = offset (world space, on the side that the normal
    /// looks to) are left away; a zero normal cuts nothing.
    glm::dvec3 cutNormal{0};
    double cutOffset = 0;
    bool edges = false;  ///< darken the edges of voxels
    bool operator==(const VoxelViewOptions&) const = default;
};

class VoxelView {
  public:
    /// Size in pixels of the G-buffer.
    VoxelView(const gl::ShaderLibrary& shaders, const Voxels& voxels, int width, int height);

    /// Another size of the G-buffer.
    void resize(int width, int height);

    /// `what`: voxel_albedo, voxel_normal, voxel_radiance (of the face that looks to the eye) or voxel_opacity (its
    /// coverage). `level`: all of one level or mip; −1 each level where cones read it. `faceRadiance` is
    /// RadianceField::faces().
    void draw(const std::string& what, int level, const CameraView& view, const RadianceVolume& volume,
              const gl::Buffer& faceRadiance, const VoxelViewOptions& options = {});

    /// RGBA32F; 0 where no voxel is met.
    const gl::Texture& texture() const { return picture_; }

  private:
    gl::Program program_;
    gl::Texture picture_;
};

}  // namespace voxcone
