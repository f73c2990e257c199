// The cones of one pixel with everything that they met on their way.
#pragma once

#include <string>
#include <vector>

#include "cone/refraction.h"

namespace voxcone {

/// A sample of a cone: a segment of the filtered volumes, or a plane that the near field met.
struct ConeSample {
    double distance = 0;       ///< from the cone's origin to its middle, metres
    double length = 0;         ///< metres; 0 for a plane
    double level = 0;          ///< of the clipmap; a fraction blends two
    double footprint = 0;      ///< edge of a voxel of that level, metres
    double transmittance = 1;  ///< after it
    double openness = 1;       ///< after it
    glm::vec3 radiance{0};     ///< gathered so far, W/(m² sr)
};

struct InspectedCone {
    glm::dvec3 origin{0};     ///< world space: the surface, or where a beam leaves the body
    glm::dvec3 direction{0};  ///< unit, world space
    double tanHalfAngle = 0;
    double skyTanHalfAngle = 0;  ///< what the sky is seen with
    double weight = 0;           ///< in its lobe, where they add up to 1
    glm::vec3 radiance{0};       ///< of voxels, W/(m² sr)
    glm::vec3 sky{0};            ///< of the sky over the cone, which counts times the transmittance
    double transmittance = 0, openness = 0;
    bool truncated = false;  ///< it took more samples than were kept
    std::vector<ConeSample> samples;
    glm::vec3 total() const { return radiance + static_cast<float>(transmittance) * sky; }
};

/// What a pixel gathers by cones. A beam is one cone, from where the eye's ray leaves what transmits it.
enum class ConeLobe { diffuse, specular, beam, scattered };

/// "diffuse", "specular", "beam" or "scattered".
const char* nameOf(ConeLobe lobe);
/// The channel that a lobe is in: beam and scattered light together are `transmission`.
const char* channelOf(ConeLobe lobe);

/// The cones of one lobe.
struct PixelCones {
    ConeLobe lobe = ConeLobe::diffuse;
    glm::dvec3 position{0};            ///< of the surface, world space
    glm::vec3 normal{0};               ///< geometric
    glm::vec3 share{0};                ///< of what is gathered, that leaves towards the eye
    std::vector<InspectedCone> cones;  ///< none when the surface has no such lobe
    /// Weighted sum of the cones' totals: what the pixel gathers before its neighbours are averaged.
    glm::vec3 radiance() const;
    /// What of it leaves towards the eye: the pixel of the lobe's channel, but for the mean over neighbours.
    glm::vec3 outgoing() const { return share * radiance(); }
};

class ConeInspector {
  public:
    /// Arguments as those of the lobe's pass: DiffusePass, SpecularPass or RefractionPass.
    ConeInspector(ConeLobe lobe, const gl::ShaderLibrary& shaders, const Settings& settings, const Scene& scene,
                  const Voxels& voxels, const Sky& sky, const gl::Defines& gbufferDefines,
                  const gl::Texture& specularAlbedo);

    /// `pixel` of the G-buffer, from the lower left.
    PixelCones inspect(const glm::ivec2& pixel, const RadianceVolume& volume, const Sky& sky,
                       const BindGBuffer& bindGBuffer);

  private:
    ConeLobe lobe_;
    Settings settings_;
    const gl::Texture& specularAlbedo_;
    int cones_ = 0;  ///< at most
    gl::Program program_;
};

}  // namespace voxcone
