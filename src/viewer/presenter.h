// Pictures as the window shows them.
#pragma once

#include <memory>

#include "gl/shader_library.h"
#include "gl/texture.h"
#include "metric/image.h"

namespace voxcone {

/// Lives in one context, whose textures the window's context shares.
class Presenter {
  public:
    Presenter() : program_(gl::ShaderLibrary().compute("viewer/present.comp")) {}

    /// `picture` (RGBA32F, linear display-referred) sRGB encoded as RGBA8. Waits until it is done, so that another
    /// context may read it. `smooth`: for pictures that are shown larger.
    std::shared_ptr<const gl::Texture> encode(const gl::Texture& picture, bool smooth);
    /// The same of an image as writePng takes it, of one channel or three.
    std::shared_ptr<const gl::Texture> encode(const Image& picture, bool smooth);

  private:
    gl::Program program_;
};

}  // namespace voxcone
