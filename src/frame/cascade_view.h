// Pictures of the clipmap: which level a surface reads, and how large the step between two levels is.
#pragma once

#include <vector>

#include "cone/gather.h"
#include "frame/gbuffer.h"
#include "frame/renderer.h"
#include "frame/tonemap.h"

namespace voxcone {

/// The steps, and where they are.
struct Seam {
    Image picture;  ///< one channel: (coarser − finer) / their mean, 0 where no levels blend
    std::vector<SeamStep> steps;
};

class CascadeView {
  public:
    CascadeView(const gl::ShaderLibrary& shaders, const GBuffer& gbuffer, const Voxels& voxels);

    /// Another size of the G-buffer.
    void resize(int width, int height);

    /// Colour of the level in rgb (shaders/frame/cascade_view.comp), and in a the level; its fraction is the weight of
    /// the next one, −1 where nothing was hit.
    const gl::Texture& draw(const GBuffer& gbuffer, const Voxels& voxels);

    /// `finer` and `coarser`: indirect diffuse radiance of both sides, `levels` the texture above in four channels.
    static Seam seam(const Image& finer, const Image& coarser, const Image& levels);

  private:
    gl::Program program_;
    gl::Texture picture_;
};

}  // namespace voxcone
