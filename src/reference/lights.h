// What shines: analytic lights, emitting triangles and the sky, how to sample them, and with which density. Positions
// and lengths are in tracing space (reference/geometry.h).
#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "reference/distribution.h"
#include "reference/geometry.h"
#include "scene/scene.h"

namespace voxcone {

/// One direction towards a light.
struct LightSample {
    glm::vec3 direction{0};  ///< unit
    glm::vec3 toTarget{0};   ///< shadow ray: origin + t·toTarget, 0 < t < far
    float far = 0;
    glm::vec3 radiance{0};  ///< of a delta light: irradiance on a plane that faces it
    float pdf =
        0;  ///< per sr, choice of the light included; of a delta light the probability of the choice; 0 = no light
    bool delta = false;
    glm::vec3 directShare{1};  ///< of the radiance: what counts as direct at the visible surface
};

/// Scene::lights but for extracted ones, for which Emitters have the truth: unseen by the camera, blocking nothing.
class AnalyticLights {
  public:
    AnalyticLights(const Scene& scene, double time, const TracingSpace& space);

    bool empty() const { return choice_.empty(); }
    LightSample sample(const glm::vec3& origin, const glm::vec2& u, float uChoice) const;

    /// Calls `visit(radiance, pdf)` for each sphere, rectangle and disc in the sky that the ray meets before `far`;
    /// `pdf` is that of `sample`.
    template <class Visitor>
    void forEachHit(const glm::vec3& origin, const glm::vec3& direction, float far, Visitor&& visit) const {
        for (const std::size_t k : areaLights_) {
            float distance = 0, pdf = 0;
            // A light that lies on a surface is in front of it.
            if (hit(lights_[k], origin, direction, distance, pdf) && distance < far * (1 + kLightClearance))
                visit(lights_[k].radiance, pdf * choice_.probability(k));
        }
    }

  private:
    /// Shadow rays end this share of their length before the light.
    static constexpr float kLightClearance = 1e-5f;

    struct PlacedLight {
        LightType type;
        glm::vec3 radiance;  ///< or intensity (point, spot), or irradiance (directional)
        glm::vec3 position, direction, right, up;
        float radius = 0, halfWidth = 0, halfHeight = 0, range = 0, cosInner = 1, cosOuter = 0;
    };
    static bool hit(const PlacedLight& light, const glm::vec3& origin, const glm::vec3& direction, float& distance,
                    float& pdf);

    std::vector<PlacedLight> lights_;
    std::vector<std::size_t> areaLights_;
    Distribution choice_;
};

/// Emitting triangles and the environment's image. Constant skies are left to the BRDF's samples.
class Emitters {
  public:
    Emitters(const Scene& scene, const Geometry& geometry);

    bool empty() const { return triangleShare_ == 0 && skyShare_ == 0; }
    LightSample sample(const glm::vec3& origin, const glm::vec2& u, float uChoice) const;

    /// Whether the material at a hit may emit.
    bool shines(const Hit& hit) const { return !pdfPerArea_[hit.instance].empty(); }
    /// Density of `sample` for a hit on a triangle that is seen along unit `direction`.
    float pdfOfHit(const Hit& hit, const glm::vec3& direction) const;
    float pdfOfSky(const glm::vec3& direction) const;
    glm::vec3 sky(const glm::vec3& direction) const;
    /// Share of the light of a hit or of the sky that analytic lights stand for: LightSample::directShare.
    glm::vec3 directShare(const Hit& hit) const { return glm::vec3(geometry_->material(hit.instance).extracted); }
    glm::vec3 directShareOfSky(const glm::vec3& direction) const;

  private:
    struct Triangle {
        std::uint32_t instance, triangle;
    };
    LightSample sampleTriangle(const glm::vec3& origin, const glm::vec2& u, float uChoice) const;
    LightSample sampleSky(glm::vec2 u) const;

    const Geometry* geometry_;
    const Environment* environment_;
    float triangleShare_ = 0, skyShare_ = 0;  ///< probabilities of choosing either kind
    std::vector<Triangle> triangles_;
    Distribution triangleChoice_;
    std::vector<std::vector<float>> pdfPerArea_;  ///< by instance and triangle; empty for instances without emission
    Distribution rows_;
    std::vector<Distribution> columns_;  ///< one a row
};

float luminance(const glm::vec3& rgb);

/// Right-handed orthonormal frame around unit `n`; its third column is `n` (Duff et al. 2017).
glm::mat3 frameAround(const glm::vec3& n);

/// Direction about +z with density cosθ/π.
glm::vec3 cosineDirection(const glm::vec2& u);

}  // namespace voxcone
