// Unidirectional path tracing with next-event estimation and multiple importance sampling (Veach 1997, power
// heuristic).
//
// At every vertex one lobe is drawn and followed, and the light samples are weighted for each lobe apart. So the lobe
// of the first vertex says which channel a path feeds, all channels are unbiased, and they add up.
//
// A beam that a surface transmits is followed by its own lobe alone: no light samples are taken for it, and to samples
// of emitters and sky transmitting surfaces are opaque. Analytic lights shine straight through them instead
// (Geometry::transmittance), and are not met by transmitted beams.
#include "reference/path_tracer.h"

#include <tbb/parallel_for.h>

#include <array>
#include <chrono>
#include <cmath>
#include <glm/gtc/constants.hpp>
#include <limits>
#include <mutex>

#include "reference/geometry.h"
#include "reference/lights.h"
#include "reference/sampler.h"

namespace voxcone {
namespace {

constexpr float kPi = glm::pi<float>();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

// Sets of four sample dimensions: one for the openness ray, then three a vertex.
constexpr std::uint32_t kOpennessSet = 0, kFirstVertexSet = 1, kSetsPerVertex = 3;
constexpr std::uint32_t kBsdfSet = 0, kLightSet = 1, kEmitterSet = 2;
// Hashed (not stratified) decisions of transparent surfaces: camera ray, openness ray, then three rays a vertex.
constexpr std::uint32_t kCameraRay = 0, kOpennessRay = 1, kFirstVertexRay = 2;

// A lobe that reflects anything is drawn at least this often.
constexpr float kMinLobeProbability = 0.1f;
// GGX widths up to here are mirrors to the choice of lobes.
constexpr float kMirrorAlpha = 0.01f;
// Paths this long are ended by chance. Shorter ones carry most of the light.
constexpr int kRouletteDepth = 2;
// Smallest cosines that a shading normal is turned to meet: with the viewer, and of the mirrored viewer with the plane.
constexpr float kMinViewCosine = 1e-3f, kMinMirrorCosine = 0.01f;
// Samples of the first pass when the error decides how many there are.
constexpr int kFirstPass = 16;
constexpr int kTile = 16;

/// A point where a path scatters.
struct Vertex {
    glm::vec3 origin;       ///< of rays that leave, off the plane on the viewer's side
    glm::vec3 planeNormal;  ///< on the viewer's side
    glm::vec3 normal;       ///< shading
    glm::vec3 toViewer;
    Surface surface;
    glm::vec3 behind{0};  ///< as `origin`, on the other side
    Transmission transmission = {};
    bool solid = false, inside = false;  ///< as in Shading
};

/// Light that leaves the first vertex, by channel.
struct Scattered {
    glm::vec3 direct{0}, diffuse{0}, specular{0}, transmission{0};
};

/// By lobe: `beam` is what a surface transmits by a specular lobe, `scattered` what leaves it behind by a Lambert lobe.
struct LobeProbabilities {
    float diffuse = 0, specular = 0, beam = 0, scattered = 0;
};

Vertex makeVertex(const Hit& hit, const Shading& shading, const glm::vec3& toViewer) {
    Vertex vertex{hit.position + hit.offset * shading.planeNormal,
                  shading.planeNormal,
                  shading.normal,
                  toViewer,
                  shading.surface,
                  hit.position - hit.offset * shading.planeNormal,
                  shading.transmission,
                  shading.solid,
                  shading.inside};
    const float cosine = glm::dot(vertex.normal, toViewer);
    if (maxComponent(vertex.surface.f0) > 0 || vertex.surface.f90 > 0) {
        // A mirror image from below the plane would be black: it is lifted above, and the normal put half-way (Keller
        // et al., "The Iray Light Transport Simulation and Rendering System", 2017).
        const glm::vec3 mirrored = 2 * cosine * vertex.normal - toViewer;
        const float above = glm::dot(mirrored, vertex.planeNormal);
        const float wanted = std::min(0.9f * glm::dot(toViewer, vertex.planeNormal), kMinMirrorCosine);
        if (above < wanted)
            vertex.normal = glm::normalize(toViewer + glm::normalize(mirrored + (wanted - above) * vertex.planeNormal));
    } else if (cosine < kMinViewCosine) {
        vertex.normal = glm::normalize(vertex.normal + (kMinViewCosine - cosine) * toViewer);
    }
    return vertex;
}

glm::vec3 fresnelAt(const Vertex& vertex, float vDotH) {
    return vertex.inside ? fresnelFromInside(vertex.surface, vertex.transmission.ior, vDotH)
                         : fresnel(vertex.surface, vDotH);
}

LobeProbabilities lobeProbabilities(const Vertex& vertex) {
    const float cosine = glm::dot(vertex.normal, vertex.toViewer);
    const float diffuse = maxComponent(vertex.surface.diffuseColor) * diffuseAlbedoScale(vertex.surface, cosine);
    float specular = maxComponent(fresnelAt(vertex, cosine));
    const float entering = 1 - specular, passing = maxComponent(vertex.transmission.color);
    float beam = passing * entering;
    if (vertex.inside && passing > 0 && vertex.surface.alpha > kMirrorAlpha) {
        // Whether light is totally reflected differs among the facets of a rough surface.
        beam = std::max(beam, kMinLobeProbability);
        specular = std::max(specular, kMinLobeProbability);
    }
    LobeProbabilities lobes{diffuse, specular, beam, maxComponent(vertex.transmission.diffuseColor) * entering};
    const std::array<float*, 4> all = {&lobes.diffuse, &lobes.specular, &lobes.beam, &lobes.scattered};
    // Twice, as the smallest grow at the cost of the others.
    for (int pass = 0; pass < 2; ++pass) {
        float sum = 0;
        for (const float* p : all) sum += *p;
        if (!(sum > 0)) return {};
        for (float* p : all) *p = *p > 0 ? (pass == 0 ? std::max(*p / sum, kMinLobeProbability) : *p / sum) : 0;
    }
    return lobes;
}

/// Visible GGX normal of a viewer at `v` in the frame of the normal (Heitz, JCGT 7(4), 2018).
glm::vec3 visibleNormal(const glm::vec3& v, float alpha, const glm::vec2& u) {
    const glm::vec3 stretched = glm::normalize(glm::vec3(alpha * v.x, alpha * v.y, v.z));
    const float length2 = stretched.x * stretched.x + stretched.y * stretched.y;
    const glm::vec3 t1 =
        length2 > 0 ? glm::vec3(-stretched.y, stretched.x, 0) / std::sqrt(length2) : glm::vec3(1, 0, 0);
    const glm::vec3 t2 = glm::cross(stretched, t1);
    const float r = std::sqrt(u.x), phi = 2 * kPi * u.y;
    const float p1 = r * std::cos(phi), s = 0.5f * (1 + stretched.z);
    const float p2 = (1 - s) * std::sqrt(std::max(0.0f, 1 - p1 * p1)) + s * r * std::sin(phi);
    const glm::vec3 n = p1 * t1 + p2 * t2 + std::sqrt(std::max(0.0f, 1 - p1 * p1 - p2 * p2)) * stretched;
    return glm::normalize(glm::vec3(alpha * n.x, alpha * n.y, std::max(1e-9f, n.z)));
}

/// Density of reflecting the viewer about a visible normal, per sr of `l`.
float specularPdf(const Vertex& vertex, const glm::vec3& l) {
    const float nDotV = glm::dot(vertex.normal, vertex.toViewer);
    if (nDotV <= 0 || glm::dot(vertex.normal, l) <= 0) return 0;
    const glm::vec3 h = glm::normalize(vertex.toViewer + l);
    const glm::vec3 nCrossH = glm::cross(vertex.normal, h);
    const float alpha = vertex.surface.alpha, a2 = alpha * alpha;
    const float d = ggxDistribution(alpha, glm::dot(vertex.normal, h), glm::dot(nCrossH, nCrossH));
    // G1 / (4 n·v) without a division by n·v.
    return d * 0.5f / (nDotV + std::sqrt(nDotV * nDotV * (1 - a2) + a2));
}

glm::vec3 specularAt(const Vertex& vertex, const glm::vec3& l) {
    if (!vertex.inside) return evaluateSpecular(vertex.surface, vertex.normal, vertex.toViewer, l);
    Surface mirror = vertex.surface;
    mirror.f0 = glm::vec3(1);
    mirror.f90 = 1;
    return evaluateSpecular(mirror, vertex.normal, vertex.toViewer, l) *
           fresnelAt(vertex, 0.5f * glm::length(vertex.toViewer + l));
}

/// Lambert lobe on the other side, in 1/sr, without the cosine. What the surface reflects is that for the viewer's own
/// direction: light from behind has no half vector with it.
glm::vec3 scatteredAt(const Vertex& vertex) {
    return vertex.transmission.diffuseColor *
           (diffuseTransmission(vertex.surface, glm::dot(vertex.normal, vertex.toViewer)) / kPi);
}

/// A direction of the transmitted beam about the facet with unit normal `h`, and the beam's share over the density of
/// facets (reference/path_tracer.cpp, visibleNormal). False where the facet sends nothing to the other side.
bool transmittedDirection(const Vertex& vertex, const glm::vec3& h, glm::vec3& direction, glm::vec3& weight) {
    const glm::vec3 &v = vertex.toViewer, &n = vertex.normal;
    const float c = glm::dot(v, h), alpha = vertex.surface.alpha;
    if (c <= 0) return false;
    weight = vertex.transmission.color * (1 - maxComponent(fresnelAt(vertex, c)));
    if (vertex.solid) {
        // Walter et al., "Microfacet Models for Refraction through Rough Surfaces", 2007, eq. 40 and 21.
        const float eta = vertex.inside ? vertex.transmission.ior : 1 / vertex.transmission.ior;
        const float k = 1 - eta * eta * (1 - c * c);
        if (k < 0) return false;
        direction = glm::normalize((eta * c - std::sqrt(k)) * h - eta * v);
        const float nDotL = -glm::dot(n, direction);
        if (nDotL <= 0) return false;
        // Smith's G1 of the way out. Radiance over the squared index is what stays the same along a beam.
        const float tan2 = (1 - nDotL * nDotL) / (nDotL * nDotL);
        weight *= eta * eta * 2 / (1 + std::sqrt(1 + alpha * alpha * tan2));
    } else {
        // The lobe of reflection, mirrored to the other side (KHR_materials_transmission).
        const glm::vec3 reflected = glm::normalize(2 * c * h - v);
        const float nDotL = glm::dot(n, reflected);
        if (nDotL <= 0) return false;
        const float pdf = specularPdf(vertex, reflected);
        if (!(pdf > 0)) return false;
        Surface mirror = vertex.surface;
        mirror.f0 = glm::vec3(1);
        mirror.f90 = 1;
        weight *= evaluateSpecular(mirror, n, v, reflected) * (nDotL / pdf);
        direction = glm::normalize(reflected - 2 * nDotL * n);
    }
    return glm::dot(vertex.planeNormal, direction) < 0;
}

float diffusePdf(const Vertex& vertex, const glm::vec3& l) {
    return std::max(0.0f, glm::dot(vertex.normal, l)) / kPi;
}

float powerHeuristic(float own, float other) {
    const float ratio = other / own;
    return 1 / (1 + ratio * ratio);
}

/// Share of openness that an occluder at `distance` leaves.
float openWeight(float distance, const Settings::Ao& ao, float reach) {
    const float t = std::min(distance / reach, 1.0f);
    switch (ao.falloff) {
        case AoFalloff::linear:
            return t;
        case AoFalloff::square_root:
            return std::sqrt(t);
        default:
            return 0;
    }
}

/// Sums over a pixel's samples. What the error estimate needs is kept apart by half.
template <class Vec>
struct PixelSums {
    using Real = typename Vec::value_type;
    struct Half {
        Vec direct{0}, diffuse{0}, specular{0}, transmission{0}, own{0};  ///< own: emission and background
        Vec beauty() const { return direct + diffuse + specular + transmission + own; }
    };
    std::array<Half, 2> halves;
    Vec emission{0}, albedo{0}, normal{0}, position{0};
    Real openness = 0, depth = 0, hits = 0;

    template <class Other>
    void add(const PixelSums<Other>& other) {
        for (std::size_t h = 0; h < 2; ++h) {
            halves[h].direct += Vec(other.halves[h].direct);
            halves[h].diffuse += Vec(other.halves[h].diffuse);
            halves[h].specular += Vec(other.halves[h].specular);
            halves[h].transmission += Vec(other.halves[h].transmission);
            halves[h].own += Vec(other.halves[h].own);
        }
        emission += Vec(other.emission);
        albedo += Vec(other.albedo);
        normal += Vec(other.normal);
        position += Vec(other.position);
        openness += static_cast<Real>(other.openness);
        depth += static_cast<Real>(other.depth);
        hits += static_cast<Real>(other.hits);
    }
};

/// Rays through the pixels of a camera in tracing space.
struct View {
    glm::vec3 eye, right, up, forward;
    float nearPlane, farPlane;
    int width, height, grid;

    View(const Camera& camera, const Settings::Output& output, const TracingSpace& space)
        : eye(space.fromWorld(camera.position)), width(output.width), height(output.height), grid(output.supersample) {
        const glm::dvec3 f = glm::normalize(camera.target - camera.position);
        const glm::dvec3 r = glm::normalize(glm::cross(f, camera.up));
        const double halfHeight = std::tan(glm::radians(0.5 * camera.verticalFovDeg));
        forward = glm::vec3(f);
        right = glm::vec3(r * (halfHeight * width / height));
        up = glm::vec3(glm::cross(r, f) * halfHeight);
        nearPlane = static_cast<float>(camera.near * space.scale);
        farPlane = camera.far > 0 ? static_cast<float>(camera.far * space.scale) : kInfinity;
    }

    /// Unit direction through the centre of cell (cellX, cellY) of the pixel's grid².
    glm::vec3 direction(int x, int y, int cellX, int cellY) const {
        const auto place = [&](int pixel, int cell, int size) {
            const float at = static_cast<float>(pixel) + (static_cast<float>(cell) + 0.5f) / static_cast<float>(grid);
            return 2 * at / static_cast<float>(size) - 1;
        };
        return glm::normalize(forward + place(x, cellX, width) * right - place(y, cellY, height) * up);
    }
};

/// Root mean square over pixels of the standard error of `value`'s mean, relative to the mean over the picture. `value`
/// gives the mean over one half of a pixel's samples.
template <class Value>
double relativeError(std::size_t pixels, Value&& value) {
    double squares = 0, mean = 0;
    for (std::size_t k = 0; k < pixels; ++k) {
        const glm::dvec3 a = value(k, 0), b = value(k, 1);
        // Var((a+b)/2) = Var(a−b)/4 for independent halves.
        squares += glm::dot(a - b, a - b) / 4;
        mean += glm::dot(a + b, glm::dvec3(0.5));
    }
    const double values = 3 * static_cast<double>(pixels);
    return mean > 0 ? std::sqrt(squares / values) / (mean / values) : 0;
}

/// The relMSE of a picture without error against the mean of two independent halves: ε as in linearError().
template <class Value>
double noiseOf(std::size_t pixels, Value&& value) {
    double power = 0;
    for (std::size_t k = 0; k < pixels; ++k) {
        const glm::dvec3 mean = 0.5 * (value(k, 0) + value(k, 1));
        power += glm::dot(mean, mean);
    }
    if (power == 0) return 0;
    const double values = 3 * static_cast<double>(pixels), epsilon = 0.01 * power / values;
    double sum = 0;
    for (std::size_t k = 0; k < pixels; ++k) {
        const glm::dvec3 a = value(k, 0), b = value(k, 1), mean = 0.5 * (a + b);
        for (int c = 0; c < 3; ++c) sum += (a[c] - b[c]) * (a[c] - b[c]) / 4 / (mean[c] * mean[c] + epsilon);
    }
    return sum / values;
}

void setPixel(Image& image, std::size_t pixel, const glm::dvec3& value) {
    for (int c = 0; c < 3; ++c) image.data[3 * pixel + static_cast<std::size_t>(c)] = static_cast<float>(value[c]);
}

}  // namespace

struct PathTracer::Impl {
    Impl(const Scene& s, double time)
        : scene(s), geometry(s, time), lights(s, time, geometry.space()), emitters(s, geometry) {}

    const Scene& scene;
    Geometry geometry;
    AnalyticLights lights;
    Emitters emitters;

    Scattered scatter(Vertex vertex, const Sampler& sampler, int maxDepth) const;
    float openness(const Vertex& vertex, const Sampler& sampler, const Settings::Ao& ao) const;
};

Scattered PathTracer::Impl::scatter(Vertex vertex, const Sampler& sampler, int maxDepth) const {
    Scattered result;
    glm::vec3* channel = nullptr;
    glm::vec3 throughput(1);
    glm::vec3 absorption(0);  // of the medium that the path is in, per unit of tracing space
    float ior = 1;

    for (int depth = 0; depth < maxDepth; ++depth) {
        const auto step = static_cast<std::uint32_t>(depth);
        const std::uint32_t sets = kFirstVertexSet + kSetsPerVertex * step;
        const std::uint32_t rays = kFirstVertexRay + kSetsPerVertex * step;
        const LobeProbabilities lobes = lobeProbabilities(vertex);
        if (lobes.diffuse + lobes.specular + lobes.beam + lobes.scattered <= 0) break;

        /// What a light sample adds through each lobe, unshadowed, weighted against finding it by that lobe.
        struct Lit {
            glm::vec3 diffuse{0}, specular{0}, scattered{0};
            bool any() const { return maxComponent(diffuse + specular + scattered) > 0; }
        };
        const auto throughLobes = [&](const LightSample& light, bool fromBehind) {
            Lit lit;
            const float side = fromBehind ? -1.0f : 1.0f, cosine = side * glm::dot(vertex.normal, light.direction);
            if (light.pdf <= 0 || cosine <= 0 || side * glm::dot(vertex.planeNormal, light.direction) <= 0) return lit;
            const glm::vec3 incoming = light.radiance * (cosine / light.pdf);
            const auto weighted = [&](float lobePdf) {
                return throughput * incoming * (light.delta ? 1 : powerHeuristic(light.pdf, lobePdf));
            };
            if (maxComponent(incoming) <= 0) return lit;
            if (fromBehind) {
                lit.scattered = weighted(lobes.scattered * cosine / kPi) * scatteredAt(vertex);
                return lit;
            }
            if (lobes.diffuse > 0)
                lit.diffuse = weighted(lobes.diffuse * diffusePdf(vertex, light.direction)) *
                              evaluateDiffuse(vertex.surface, vertex.normal, vertex.toViewer, light.direction);
            if (lobes.specular > 0)
                lit.specular = weighted(lobes.specular * specularPdf(vertex, light.direction)) *
                               specularAt(vertex, light.direction);
            return lit;
        };
        // Light from behind only where a surface scatters it.
        for (const bool fromBehind : {false, true}) {
            if (fromBehind && lobes.scattered <= 0) continue;
            const glm::vec3& origin = fromBehind ? vertex.behind : vertex.origin;
            if (!lights.empty()) {
                const glm::vec4 u = sampler.set(sets + kLightSet);
                LightSample light = lights.sample(origin, glm::vec2(u), u.z);
                Lit lit = throughLobes(light, fromBehind);
                if (lit.any()) {
                    const glm::vec3 left =
                        geometry.transmittance(origin, light.toTarget, light.far, sampler.hashed(rays + kLightSet));
                    if (left != glm::vec3(1) && maxComponent(left) > 0) {
                        // No lobe finds a light behind a transmitting surface.
                        light.delta = true;
                        lit = throughLobes(light, fromBehind);
                    }
                    // Inside a solid, light that came straight goes on straight.
                    if (vertex.inside) lit.specular = glm::vec3(0);
                    (depth == 0 ? result.direct : *channel) += left * (lit.diffuse + lit.specular + lit.scattered);
                }
            }
            if (!emitters.empty()) {
                const glm::vec4 u = sampler.set(sets + kEmitterSet);
                const LightSample light = emitters.sample(origin, glm::vec2(u), u.z);
                const Lit lit = throughLobes(light, fromBehind);
                if (lit.any() &&
                    !geometry.occluded(origin, light.toTarget, light.far, sampler.hashed(rays + kEmitterSet))) {
                    if (depth == 0) {
                        result.direct += light.directShare * (lit.diffuse + lit.specular);
                        result.diffuse += (1.0f - light.directShare) * lit.diffuse;
                        result.specular += (1.0f - light.directShare) * lit.specular;
                        result.transmission += lit.scattered;
                    } else {
                        *channel += lit.diffuse + lit.specular + lit.scattered;
                    }
                }
            }
        }

        // Follow one lobe.
        const glm::vec4 u = sampler.set(sets + kBsdfSet);
        const glm::mat3 frame = frameAround(vertex.normal);
        const auto facet = [&] {
            return frame * visibleNormal(vertex.toViewer * frame, vertex.surface.alpha, glm::vec2(u));
        };
        const bool beam = u.z >= lobes.diffuse + lobes.specular && u.z < lobes.diffuse + lobes.specular + lobes.beam;
        const bool scattered = u.z >= lobes.diffuse + lobes.specular + lobes.beam && lobes.scattered > 0;
        glm::vec3 direction;
        float pdf = kInfinity;  // of a beam: no light sample competes with it
        if (beam) {
            glm::vec3 weight;
            if (!transmittedDirection(vertex, facet(), direction, weight)) break;
            throughput *= weight / lobes.beam;
            if (vertex.solid) {
                ior = vertex.inside ? 1 : vertex.transmission.ior;
                absorption = vertex.inside
                                 ? glm::vec3(0)
                                 : vertex.transmission.absorption / static_cast<float>(geometry.space().scale);
            }
        } else if (scattered) {
            direction = -(frame * cosineDirection(glm::vec2(u)));
            const float cosine = -glm::dot(vertex.normal, direction);
            if (cosine <= 0 || glm::dot(vertex.planeNormal, direction) >= 0) break;
            pdf = lobes.scattered * cosine / kPi;
            throughput *= (cosine / pdf) * scatteredAt(vertex);
        } else {
            const bool isDiffuse = u.z < lobes.diffuse;
            if (isDiffuse) {
                direction = frame * cosineDirection(glm::vec2(u));
            } else {
                const glm::vec3 h = facet();
                direction = 2 * glm::dot(vertex.toViewer, h) * h - vertex.toViewer;
            }
            direction = glm::normalize(direction);
            const float cosine = glm::dot(vertex.normal, direction);
            if (cosine <= 0 || glm::dot(vertex.planeNormal, direction) <= 0) break;
            pdf = isDiffuse ? lobes.diffuse * diffusePdf(vertex, direction)
                            : lobes.specular * specularPdf(vertex, direction);
            if (!(pdf > 0)) break;
            throughput *=
                (cosine / pdf) * (isDiffuse ? evaluateDiffuse(vertex.surface, vertex.normal, vertex.toViewer, direction)
                                            : specularAt(vertex, direction));
            if (depth == 0) channel = isDiffuse ? &result.diffuse : &result.specular;
        }
        const bool passes = beam || scattered;
        if (depth == 0 && passes) channel = &result.transmission;
        const glm::vec3& origin = passes ? vertex.behind : vertex.origin;

        Hit hit;
        const bool found = geometry.intersect(Geometry::RayKind::light, origin, direction, 0, kInfinity,
                                              sampler.hashed(rays + kBsdfSet), hit);
        const bool reflected = !passes && u.z >= lobes.diffuse;
        if (!beam && !(vertex.inside && reflected)) {
            lights.forEachHit(
                origin, direction, found ? hit.distance : kInfinity, [&](const glm::vec3& radiance, float lightPdf) {
                    (depth == 0 ? result.direct : *channel) += throughput * radiance * powerHeuristic(pdf, lightPdf);
                });
        }
        // What comes through the surface stays in its channel, whatever it is from.
        const auto addFound = [&](const glm::vec3& radiance, const glm::vec3& directShare) {
            const glm::vec3 share = depth == 0 && !passes ? directShare : glm::vec3(0);
            result.direct += throughput * radiance * share;
            *channel += throughput * radiance * (1.0f - share);
        };
        if (!found) {
            addFound(emitters.sky(direction) * powerHeuristic(pdf, emitters.pdfOfSky(direction)),
                     emitters.directShareOfSky(direction));
            break;
        }
        throughput *= glm::exp(-absorption * hit.distance);
        // Looking up a material costs as much as a ray: not for paths that end here. Inside a medium radiance is less
        // by its squared index, which the way out gives back.
        float survival = 1;
        if (depth + 1 >= kRouletteDepth) survival = std::min(1.0f, maxComponent(throughput) * ior * ior);
        const bool ends = depth + 1 == maxDepth || u.w >= survival;
        if (ends && !emitters.shines(hit)) break;
        const Shading shading = geometry.shade(hit, -direction);
        if (maxComponent(shading.emission) > 0)
            addFound(shading.emission * powerHeuristic(pdf, emitters.pdfOfHit(hit, direction)),
                     emitters.directShare(hit));
        if (ends) break;
        throughput /= survival;
        vertex = makeVertex(hit, shading, -direction);
    }
    return result;
}

float PathTracer::Impl::openness(const Vertex& vertex, const Sampler& sampler, const Settings::Ao& ao) const {
    const glm::vec3 direction = frameAround(vertex.normal) * cosineDirection(glm::vec2(sampler.set(kOpennessSet)));
    if (glm::dot(direction, vertex.planeNormal) <= 0) return 0;
    const float reach = static_cast<float>(ao.distance * geometry.space().scale);
    const std::uint32_t seed = sampler.hashed(kOpennessRay);
    if (reach <= 0 || ao.falloff == AoFalloff::none)
        return glm::dot(geometry.transmittance(vertex.origin, direction, reach > 0 ? reach : kInfinity, seed),
                        glm::vec3(1.0f / 3));
    Hit hit;
    if (!geometry.intersect(Geometry::RayKind::light, vertex.origin, direction, 0, reach, seed, hit)) return 1;
    return openWeight(hit.distance, ao, reach);
}

PathTracer::PathTracer(const Scene& scene, double time) : impl_(std::make_unique<Impl>(scene, time)) {}
PathTracer::~PathTracer() = default;

ReferenceImages PathTracer::render(const Camera& camera, const Settings& settings,
                                   const std::function<void(double)>& progress) const {
    const auto start = std::chrono::steady_clock::now();
    const TracingSpace& space = impl_->geometry.space();
    const View view(camera, settings.output, space);
    const int cells = view.grid * view.grid;
    const auto pixels = static_cast<std::size_t>(view.width) * static_cast<std::size_t>(view.height);
    std::vector<PixelSums<glm::vec3>> sums(pixels);

    // Every grid cell of every half gets the same number of samples.
    const auto samplesPerCell = [&](int perPixel) { return (perPixel + 2 * cells - 1) / (2 * cells); };
    const int most = samplesPerCell(settings.reference.samples);
    int done = 0;
    std::mutex progressMutex;
    double progressed = 0;  // pixels × samples per cell

    const auto tracePixel = [&](int x, int y, int first, int end) {
        PixelSums<glm::dvec3> sum;
        for (int stream = 0; stream < 2 * cells; ++stream) {
            auto& half = sum.halves[static_cast<std::size_t>(stream % 2)];
            const int cell = stream / 2;
            const glm::vec3 direction = view.direction(x, y, cell % view.grid, cell / view.grid);
            const float along = glm::dot(direction, view.forward);
            std::uint32_t seed = hashBits(static_cast<std::uint32_t>(settings.reference.seed));
            for (const int part : {x, y, stream}) seed = hashCombine(seed, static_cast<std::uint32_t>(part));
            for (int index = first; index < end; ++index) {
                const Sampler sampler(seed, static_cast<std::uint32_t>(index));
                Hit hit;
                if (!impl_->geometry.intersect(Geometry::RayKind::camera, view.eye, direction, view.nearPlane / along,
                                               view.farPlane / along, sampler.hashed(kCameraRay), hit)) {
                    half.own += glm::dvec3(impl_->emitters.sky(direction));
                    sum.openness += 1;
                    continue;
                }
                const Shading shading = impl_->geometry.shade(hit, -direction);
                const Vertex vertex = makeVertex(hit, shading, -direction);
                const Scattered light = impl_->scatter(vertex, sampler, settings.reference.maxDepth);
                half.direct += glm::dvec3(light.direct);
                half.diffuse += glm::dvec3(light.diffuse);
                half.specular += glm::dvec3(light.specular);
                half.transmission += glm::dvec3(light.transmission);
                half.own += glm::dvec3(shading.emission);
                sum.emission += glm::dvec3(shading.emission);
                sum.albedo += glm::dvec3(shading.baseColor);
                sum.normal += glm::dvec3(shading.normal);
                sum.position += glm::dvec3(hit.position);
                sum.depth += static_cast<double>(hit.distance * along);
                sum.openness += static_cast<double>(impl_->openness(vertex, sampler, settings.ao));
                sum.hits += 1;
            }
        }
        sums[static_cast<std::size_t>(y) * static_cast<std::size_t>(view.width) + static_cast<std::size_t>(x)].add(sum);
    };
    const auto tracePass = [&](int end) {
        const int columns = (view.width + kTile - 1) / kTile, rows = (view.height + kTile - 1) / kTile;
        tbb::parallel_for(0, columns * rows, [&](int tile) {
            const int x0 = tile % columns * kTile, y0 = tile / columns * kTile;
            const int x1 = std::min(x0 + kTile, view.width), y1 = std::min(y0 + kTile, view.height);
            for (int y = y0; y < y1; ++y)
                for (int x = x0; x < x1; ++x) tracePixel(x, y, done, end);
            if (!progress) return;
            const std::lock_guard lock(progressMutex);
            progressed += static_cast<double>((x1 - x0) * (y1 - y0)) * (end - done);
            progress(progressed / (static_cast<double>(pixels) * most));
        });
        done = end;
    };

    ReferenceImages images;
    const auto halfMean = [&](std::size_t k, std::size_t h, auto&& select) {
        return glm::dvec3(select(sums[k].halves[h])) / static_cast<double>(done * cells);
    };
    const bool adaptive = settings.reference.error > 0;
    int end = adaptive ? std::min(samplesPerCell(kFirstPass), most) : most;
    while (true) {
        tracePass(end);
        images.beautyError = relativeError(
            pixels, [&](std::size_t k, std::size_t h) { return halfMean(k, h, [](auto& s) { return s.beauty(); }); });
        if (done == most || images.beautyError <= settings.reference.error) break;
        end = std::min(2 * done, most);
    }
    images.indirectDiffuseError = relativeError(
        pixels, [&](std::size_t k, std::size_t h) { return halfMean(k, h, [](auto& s) { return s.diffuse; }); });
    const auto noise = [&](const char* channel, auto select) {
        images.noise[channel] = noiseOf(pixels, [&](std::size_t k, std::size_t h) { return halfMean(k, h, select); });
    };
    noise("beauty", [](auto& s) { return s.beauty(); });
    noise("direct", [](auto& s) { return s.direct; });
    noise("indirect_diffuse", [](auto& s) { return s.diffuse; });
    noise("indirect_specular", [](auto& s) { return s.specular; });
    noise("transmission", [](auto& s) { return s.transmission; });
    if (progress) progress(1);
    images.samples = 2 * cells * done;

    for (Image* image : {&images.beauty, &images.direct, &images.indirectDiffuse, &images.indirectSpecular,
                         &images.transmission, &images.emission, &images.albedo, &images.normal, &images.position})
        *image = Image(view.width, view.height, 3);
    images.ao = Image(view.width, view.height, 1);
    images.depth = Image(view.width, view.height, 1);
    const double count = images.samples;
    for (std::size_t k = 0; k < pixels; ++k) {
        const PixelSums<glm::vec3>& sum = sums[k];
        const auto total = [&](auto&& select) {
            return (glm::dvec3(select(sum.halves[0])) + glm::dvec3(select(sum.halves[1]))) / count;
        };
        setPixel(images.beauty, k, total([](auto& s) { return s.beauty(); }));
        setPixel(images.direct, k, total([](auto& s) { return s.direct; }));
        setPixel(images.indirectDiffuse, k, total([](auto& s) { return s.diffuse; }));
        setPixel(images.indirectSpecular, k, total([](auto& s) { return s.specular; }));
        setPixel(images.transmission, k, total([](auto& s) { return s.transmission; }));
        setPixel(images.emission, k, glm::dvec3(sum.emission) / count);
        setPixel(images.albedo, k, glm::dvec3(sum.albedo) / count);
        setPixel(images.normal, k, glm::dvec3(sum.normal) / count);
        images.ao.data[k] = static_cast<float>(static_cast<double>(sum.openness) / count);
        if (sum.hits <= 0) continue;  // depth and position of the background stay 0
        images.depth.data[k] = static_cast<float>(static_cast<double>(sum.depth / sum.hits) / space.scale);
        setPixel(images.position, k, space.toWorld(sum.position / sum.hits));
    }
    images.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return images;
}

std::vector<PathTracer::ProbeResult> PathTracer::probe(const std::vector<Probe>& probes,
                                                       const Settings& settings) const {
    std::vector<ProbeResult> results(probes.size());
    const int samples = settings.reference.samples;
    tbb::parallel_for(std::size_t{0}, probes.size(), [&](std::size_t k) {
        const TracingSpace& space = impl_->geometry.space();
        const glm::vec3 normal = glm::normalize(probes[k].normal);
        const glm::vec3 position = space.fromWorld(probes[k].position);
        // The triangle it lies on is not known: it may be as large as the scene.
        const glm::vec3 magnitude = glm::max(glm::abs(position), space.halfExtent);
        // A white Lambert surface turns irradiance E into radiance E/π.
        Surface white;
        white.diffuseColor = glm::vec3(1);
        const Vertex vertex{position + Geometry::offset(position, normal, magnitude) * normal, normal, normal, normal,
                            white};
        const std::uint32_t seed =
            hashCombine(hashBits(static_cast<std::uint32_t>(settings.reference.seed)), static_cast<std::uint32_t>(k));
        glm::dvec3 direct(0), indirect(0);
        double open = 0;
        for (int index = 0; index < samples; ++index) {
            const Sampler sampler(seed, static_cast<std::uint32_t>(index));
            const Scattered light = impl_->scatter(vertex, sampler, settings.reference.maxDepth);
            direct += glm::dvec3(light.direct);
            indirect += glm::dvec3(light.diffuse);
            open += static_cast<double>(impl_->openness(vertex, sampler, settings.ao));
        }
        const double perSample = glm::pi<double>() / samples;
        results[k].directIrradiance = glm::vec3(direct * perSample);
        results[k].indirectIrradiance = glm::vec3(indirect * perSample);
        results[k].openness = static_cast<float>(open / samples);
    });
    return results;
}

}  // namespace voxcone
