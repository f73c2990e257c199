#include "gl/gpu_environment.h"

namespace voxcone::gl {

GpuEnvironment::GpuEnvironment(const Environment& environment, const std::vector<glm::vec3>& texels)
    : color(environment.color), rotation(static_cast<float>(glm::radians(environment.rotationDeg))) {
    if (environment.radiance.empty() || environment.black()) return;
    panorama = Texture::create2D(GL_RGB32F, environment.width, environment.height,
                                 fullMipLevels(environment.width, environment.height));
    panorama.upload(0, GL_RGB, GL_FLOAT, (texels.empty() ? environment.radiance : texels).data());
    panorama.generateMipmaps();
    panorama.filter(GL_LINEAR_MIPMAP_LINEAR, GL_LINEAR);
    panorama.wrap(GL_REPEAT, GL_CLAMP_TO_EDGE);
}

}  // namespace voxcone::gl
