// The truth: a path tracer on Embree with the renderer's scene, BRDF, lights, environment, camera and channels.
#pragma once

#include <functional>
#include <glm/glm.hpp>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "core/settings.h"
#include "metric/image.h"
#include "scene/scene.h"

namespace voxcone {

/// Conventions shared with the renderer (docs/architecture.md, "What light does"):
///  - A surface blocks light from both sides. The back of a single-sided material reflects like its front but does not
///    emit, and the camera's own rays pass through it.
///  - `direct` is light from analytic lights (Scene::lights) straight to the visible surface, diffuse and specular; of
///    extracted ones (scene/extract.h) that of the panorama and the meshes that they stand for.
///    Everything else that arrives (sky, emitting surfaces, bounced light) is indirect: `indirectDiffuse` through the
///    diffuse lobe, `indirectSpecular` through the specular lobe. What comes through the visible surface from behind is
///    `transmission`, but for analytic lights on a sheet's other side, which are `direct`. beauty = direct + both +
///    transmission + emission + background.
///  - Pixel samples lie on the regular supersample² grid inside the pixel (pixel centre for 1).
///  - Nothing is clamped, so that nothing is biased. Light that a near-mirror throws from a point or directional
///    light on a wall therefore shows as few, bright pixels until there are many samples.
///  - BLEND surfaces stop a ray with probability alpha.
///  - A transmitting closed body with a thickness is a solid: beams are refracted, and absorbed along their way. Its
///    media do not nest: the last surface that was crossed says which one a beam is in. All else that transmits is a
///    thin sheet, which bends nothing; a thickness then absorbs as if it were crossed straight.
///  - Analytic lights shine straight through transmitting surfaces, dimmed by Fresnel reflection, tint and absorption;
///    roughness and refraction do not scatter or bend their light, and transmitted beams do not meet them.
///
/// Channels are means over a pixel's samples, background included (0, and 1 in ao); depth and position are means over
/// the samples that hit something.
struct ReferenceImages {
    Image beauty, direct, indirectDiffuse, indirectSpecular, transmission, emission, albedo,
        normal;       ///< 3 channels,
                      ///< linear radiance
    Image ao, depth;  ///< 1 channel; ao is cosine-weighted openness; depth is view-space distance −z, 0 = background
    Image position;   ///< 3 channels, world space
    /// Standard error of the mean of beauty and of indirectDiffuse, as RMS over pixels relative to the mean value, from
    /// two independent halves of the samples.
    double beautyError = 0, indirectDiffuseError = 0;
    /// The relMSE (metric/metrics.h) that a picture without any error would show against a channel, because of the noise
    /// that the channel has left: from the halves. Of beauty, direct, indirect_diffuse, indirect_specular, transmission.
    std::map<std::string, double> noise;
    int samples = 0;  ///< per pixel
    double seconds = 0;
};

class PathTracer {
  public:
    /// Builds the BVH of `scene` at `time` seconds. `scene` must outlive this object.
    PathTracer(const Scene& scene, double time = 0);
    ~PathTracer();
    PathTracer(const PathTracer&) = delete;
    PathTracer& operator=(const PathTracer&) = delete;

    /// Renders all channels at settings.output's size. Deterministic for a seed, whatever the number of threads.
    /// settings.reference: `samples` a pixel, rounded up to a multiple of 2·supersample²; with `error` > 0 passes
    /// double the samples until beautyError is as small or `samples` is reached; `maxDepth` is the most reflections a
    /// path has, the visible surface's own included. `progress` gets 0…1, from one thread at a time, or is empty.
    ReferenceImages render(const Camera& worldCamera, const Settings& settings,
                           const std::function<void(double)>& progress = {}) const;

    /// A point on a surface that is not part of the picture: what tests, voxel probes and the cone inspector ask for.
    struct Probe {
        glm::dvec3 position;
        glm::vec3 normal;
    };
    struct ProbeResult {
        glm::vec3 indirectIrradiance;  ///< from sky, emitters and bounces, W/m²
        glm::vec3 directIrradiance;    ///< from analytic lights
        float openness;  ///< cosine-weighted fraction of the sky that is visible (ao.distance, ao.falloff)
    };
    /// settings.reference.samples paths a probe; the probe's own reflection counts as the first of maxDepth.
    std::vector<ProbeResult> probe(const std::vector<Probe>& probes, const Settings& settings) const;

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace voxcone
