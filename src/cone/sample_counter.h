// How many places the cones of a pass look at: what they cost, whatever the device.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "gl/program.h"
#include "gl/shader_library.h"

namespace voxcone {

/// A pass over pixels whose shader includes cone/trace.glsl, compiled a second time with COUNT_SAMPLES.
class SampleCounter {
  public:
    /// Those of the pass itself. `shaders` must outlive this object.
    SampleCounter(const gl::ShaderLibrary& shaders, std::string path, gl::Defines defines)
        : shaders_(&shaders), path_(std::move(path)), defines_(std::move(defines)) {}

    /// Runs `dispatch` with the counting program, which is compiled at the first call. Voxels of near fields and steps
    /// beyond them count alike. Waits for the device.
    std::uint64_t count(const std::function<void(gl::Program&)>& dispatch);

  private:
    const gl::ShaderLibrary* shaders_;
    std::string path_;
    gl::Defines defines_;
    gl::Program program_;
};

}  // namespace voxcone
