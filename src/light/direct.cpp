#include "light/direct.h"

namespace voxcone {

DirectPass::DirectPass(const gl::ShaderLibrary& shaders, const gl::Defines& gbufferDefines, int width, int height)
    : program_(shaders.compute("light/direct.comp", gbufferDefines)) {
    resize(width, height);
}

void DirectPass::resize(int width, int height) {
    texture_ = gl::Texture::create2D(GL_RGBA32F, width, height);
}

void DirectPass::run(const ShadowMaps& maps, const std::function<void(gl::Program&)>& bindGBuffer,
                     gl::PassTimers& timers) {
    const auto pass = timers.pass("direct");
    bindGBuffer(program_);
    maps.bind(program_);
    texture_.bindImage(0, 0, GL_WRITE_ONLY);
    gl::dispatch(program_, gl::groupsFor(texture_.width(), 8), gl::groupsFor(texture_.height(), 8), 1);
    gl::memoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
}

}  // namespace voxcone
