// Pictures of the voxels themselves: the first occupied voxel along each pixel's ray, but for that around the eye.
#pragma once

#include "cone/cone_uniforms.h"
#include "core/voxel_channel.h"
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
    VoxelView(const gl::ShaderLibrary& shaders, const Voxels& voxels, VoxelStorage storage, int width, int height);

    /// Another size of the G-buffer.
    void resize(int width, int height);

    /// The view that `channel` names, of the light that `volume` holds; `channel.bounce` is whoever chose it.
    /// `faceRadiance` is RadianceField::faces() of the same light.
    ///
    /// Lobes: what cones read of a record, by direction, painted on the sides of its voxel. The point that the unit
    /// vector n from the voxel's centre meets shows the radiance that a cone along −n takes.
    void draw(const VoxelChannel& channel, const CameraView& view, const RadianceVolume& volume,
              const gl::Buffer& faceRadiance, const VoxelViewOptions& options = {});

    /// RGBA32F; 0 where no voxel is met.
    const gl::Texture& texture() const { return picture_; }

  private:
    gl::Program program_;
    gl::Texture picture_;
};

}  // namespace voxcone
