// The diffuse cones of one pixel with everything that they met on their way.
#pragma once

#include <vector>

#include "cone/gather.h"

namespace voxcone {

/// A sample of a cone: a segment of the filtered volumes, or a plane that the near field met.
struct ConeSample {
    double distance = 0;       ///< from the surface to its middle, metres
    double length = 0;         ///< metres; 0 for a plane
    double level = 0;          ///< of the clipmap; a fraction blends two
    double footprint = 0;      ///< edge of a voxel of that level, metres
    double transmittance = 1;  ///< after it
    double openness = 1;       ///< after it
    glm::vec3 radiance{0};     ///< gathered so far, W/(m² sr)
};

struct InspectedCone {
    glm::dvec3 direction{0};  ///< unit, world space
    double weight = 0;        ///< of the set; they add up to 1
    glm::vec3 radiance{0};    ///< of voxels, W/(m² sr)
    glm::vec3 sky{0};         ///< of the sky over the cone, which counts times the transmittance
    double transmittance = 0, openness = 0;
    bool truncated = false;  ///< it took more samples than were kept
    std::vector<ConeSample> samples;
    glm::vec3 total() const { return radiance + static_cast<float>(transmittance) * sky; }
};

struct PixelCones {
    bool hit = false;         ///< the pixel shows a surface; else there are no cones
    glm::dvec3 position{0};   ///< world space
    glm::vec3 normal{0};      ///< geometric
    double tanHalfAngle = 0;  ///< of each cone
    std::vector<InspectedCone> cones;
    /// Weighted sum of the cones' totals: what the pixel gathers before its neighbours are averaged.
    glm::vec3 radiance() const;
};

class ConeInspector {
  public:
    /// Arguments as DiffusePass.
    ConeInspector(const gl::ShaderLibrary& shaders, const Settings& settings, const Voxels& voxels, const Sky& sky,
                  const gl::Defines& gbufferDefines);

    /// `pixel` of the G-buffer, from the lower left.
    PixelCones inspect(const glm::ivec2& pixel, const RadianceVolume& volume, const Sky& sky,
                       const BindGBuffer& bindGBuffer);

  private:
    Settings settings_;
    gl::Program program_;
};

}  // namespace voxcone
