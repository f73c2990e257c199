// Diffuse gathering at listed points through the same cones as the picture.
#pragma once

#include <vector>

#include "cone/cone_uniforms.h"

namespace voxcone {

struct ConeProbe {
    glm::dvec3 position{0};  ///< on a surface, world space
    glm::vec3 normal{0, 1, 0};
};

struct ConeProbeResult {
    glm::vec3 radiance{0};  ///< irradiance / π from sky, emitters and bounces, W/(m² sr)
    float openness = 0;     ///< cosine-weighted, by ao.distance and ao.falloff
};

class ConeProber {
  public:
    /// The set is cone.diffuse; with cone.rotate its sixteen orientations are averaged, as the picture's filter does.
    ConeProber(const gl::ShaderLibrary& shaders, const Settings& settings, const Voxels& voxels, const Sky& sky);

    std::vector<ConeProbeResult> gather(const std::vector<ConeProbe>& probes, const RadianceVolume& volume,
                                        const Sky& sky);

  private:
    Settings settings_;
    gl::Program program_;
};

}  // namespace voxcone
