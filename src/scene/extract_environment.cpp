#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include "scene/extract.h"

namespace voxcone {
namespace {

using glm::dvec3;

/// Sources have a texel this many times as bright as the mean over the sphere.
constexpr double kBright = 8;
/// A source reaches down to this share of its brightest texel.
constexpr double kEdge = 1.0 / 16;
/// Share of all light below which a source is not worth a shadow map.
constexpr double kLeastShare = 0.005;
/// Cones of the sets of 16 have a half-angle of 14°: wider sources than this are theirs.
constexpr double kWidest = 10 * glm::pi<double>() / 180;
/// Sources found at most before the strongest are chosen.
constexpr std::size_t kMostFound = 32;

/// All channels count alike: a source has one direction for them, which must suit the weakest to the eye too.
double brightness(const dvec3& rgb) {
    return (rgb.x + rgb.y + rgb.z) / 3;
}

struct Source {
    std::vector<std::size_t> texels;
    std::vector<double> parts;  ///< of each texel's radiance
    dvec3 direction{0};         ///< unit, towards it, before the rotation
    dvec3 irradiance{0};        ///< on a facing plane
    double radius = 0;          ///< of the disc, radians
    double fluence = 0;         ///< brightness over the sphere
};

class Panorama {
  public:
    explicit Panorama(const Environment& environment)
        : environment_(environment),
          width_(static_cast<std::size_t>(environment.width)),
          height_(static_cast<std::size_t>(environment.height)) {
        brightness_.reserve(environment.radiance.size());
        for (std::size_t y = 0; y < height_; ++y) {
            for (std::size_t x = 0; x < width_; ++x) {
                brightness_.push_back(brightness(radiance(y * width_ + x)));
                total_ += brightness_.back() * solidAngle(y);
            }
        }
    }

    /// The sources one after another, each where most is left by those before it.
    std::vector<Source> sources() {
        std::vector<Source> found;
        std::vector<std::uint8_t> rejected(brightness_.size(), 0), marked(brightness_.size(), 0);
        const double least = kBright * total_ / (4 * glm::pi<double>());
        while (found.size() < kMostFound) {
            std::vector<std::size_t> seeds;
            for (std::size_t i = 0; i < brightness_.size(); ++i) {
                if (!rejected[i] && brightness_[i] > least) seeds.push_back(i);
            }
            std::sort(seeds.begin(), seeds.end(), [&](std::size_t a, std::size_t b) {
                return brightness_[a] != brightness_[b] ? brightness_[a] > brightness_[b] : a < b;
            });
            const std::size_t before = found.size();
            for (const std::size_t seed : seeds) {
                if (rejected[seed]) continue;
                Source source = around(seed, rejected, marked);
                if (source.fluence >= kLeastShare * total_ && source.radius <= kWidest) {
                    for (std::size_t k = 0; k < source.texels.size(); ++k)
                        brightness_[source.texels[k]] *= 1 - source.parts[k];
                    found.push_back(std::move(source));
                    break;
                }
                for (const std::size_t i : source.texels) rejected[i] = 1;
            }
            if (found.size() == before) break;
        }
        return found;
    }

  private:
    dvec3 radiance(std::size_t i) const { return dvec3(environment_.color) * dvec3(environment_.radiance[i]); }
    double polar(double row) const { return glm::pi<double>() * row / static_cast<double>(height_); }
    double solidAngle(std::size_t row) const {
        const auto y = static_cast<double>(row);
        return 2 * glm::pi<double>() / static_cast<double>(width_) * (std::cos(polar(y)) - std::cos(polar(y + 1)));
    }
    dvec3 direction(std::size_t i) const {
        const double theta = polar(static_cast<double>(i / width_) + 0.5);
        const double longitude =
            2 * glm::pi<double>() * ((static_cast<double>(i % width_) + 0.5) / static_cast<double>(width_) - 0.5);
        return {std::sin(theta) * std::sin(longitude), std::cos(theta), -std::sin(theta) * std::cos(longitude)};
    }

    template <class Visitor>
    void forNeighbours(std::size_t i, Visitor&& visit) const {
        const std::size_t x = i % width_, row = i - x;
        visit(row + (x + 1) % width_);
        visit(row + (x + width_ - 1) % width_);
        if (row >= width_) visit(i - width_);
        if (i + width_ < brightness_.size()) visit(i + width_);
    }

    /// What is connected with the texel `seed` and as bright as kEdge of it, over the mean level of the texels around.
    /// `marked` is all zero before and after.
    Source around(std::size_t seed, const std::vector<std::uint8_t>& rejected,
                  std::vector<std::uint8_t>& marked) const {
        Source source;
        const double edge = kEdge * brightness_[seed];
        double level = 0, levelTexels = 0;
        source.texels.push_back(seed);
        marked[seed] = 1;
        for (std::size_t k = 0; k < source.texels.size(); ++k) {
            forNeighbours(source.texels[k], [&](std::size_t i) {
                if (marked[i]) return;
                if (brightness_[i] > edge && !rejected[i]) {
                    marked[i] = 1;
                    source.texels.push_back(i);
                } else {
                    level += std::min(brightness_[i], edge);
                    levelTexels += 1;
                }
            });
        }
        for (const std::size_t i : source.texels) marked[i] = 0;
        if (levelTexels > 0) level /= levelTexels;

        dvec3 flux[3] = {dvec3(0), dvec3(0), dvec3(0)}, whole(0);
        double blur = 0;
        for (const std::size_t i : source.texels) {
            const double part = 1 - level / brightness_[i];
            const double weight = part * brightness_[i] * solidAngle(i / width_);
            const dvec3 d = direction(i);
            // Of what earlier sources have left of the texel.
            const dvec3 left = radiance(i) * (brightness_[i] / std::max(brightness(radiance(i)), 1e-300));
            for (int c = 0; c < 3; ++c) flux[c] += part * left[c] * solidAngle(i / width_) * d;
            whole += weight * d;
            source.fluence += weight;
            source.parts.push_back(part);
            // A bilinear texel is a tent, with the variance step²/6 along either axis.
            const double step = glm::pi<double>() / static_cast<double>(height_);
            const double across = 2 * glm::pi<double>() / static_cast<double>(width_) * std::sqrt(1 - d.y * d.y);
            blur += weight * (step * step + across * across) / 6;
        }
        if (!(source.fluence > 0)) return source;
        source.direction = glm::normalize(whole);
        for (int c = 0; c < 3; ++c) source.irradiance[c] = std::max(glm::dot(flux[c], source.direction), 0.0);
        // A disc of radius r has the mean direction cosine (1 + cos r)/2, and the variance r²/2.
        const double cosine = 2 * std::min(glm::length(whole) / source.fluence, 1.0) - 1;
        const double sharp = std::acos(std::clamp(cosine, -1.0, 1.0));
        source.radius = std::sqrt(sharp * sharp + 2 * blur / source.fluence);
        return source;
    }

    const Environment& environment_;
    std::size_t width_, height_;
    std::vector<double> brightness_;  ///< of what is left
    double total_ = 0;                ///< over the sphere
};

}  // namespace

void extractEnvironment(Scene& scene, int most) {
    Environment& sky = scene.environment;
    if (most <= 0 || sky.radiance.empty() || sky.black()) return;
    std::vector<Source> sources = Panorama(sky).sources();
    // Which parts of a texel are taken is known for each source alone, so they are summed before any is left out.
    std::vector<float> before(sky.radiance.size(), 1);
    std::vector<std::vector<float>> taken;
    for (const Source& source : sources) {
        std::vector<float>& parts = taken.emplace_back();
        for (std::size_t k = 0; k < source.texels.size(); ++k) {
            float& left = before[source.texels[k]];
            parts.push_back(left * static_cast<float>(source.parts[k]));
            left -= parts.back();
        }
    }
    std::vector<std::size_t> order(sources.size());
    for (std::size_t k = 0; k < order.size(); ++k) order[k] = k;
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return sources[a].fluence > sources[b].fluence; });
    if (order.size() > static_cast<std::size_t>(most)) order.resize(static_cast<std::size_t>(most));
    if (order.empty()) return;

    std::vector<float> left(sky.radiance.size(), 1);
    const glm::dmat3 turn(glm::rotate(glm::dmat4(1), glm::radians(sky.rotationDeg), dvec3(0, 1, 0)));
    for (const std::size_t k : order) {
        const Source& source = sources[k];
        for (std::size_t t = 0; t < source.texels.size(); ++t) left[source.texels[t]] -= taken[k][t];
        Light light;
        light.name = fmt::format("panorama {}", scene.lights.size());
        light.type = LightType::directional;
        light.intensity = glm::vec3(source.irradiance);
        light.direction = -glm::normalize(turn * source.direction);
        light.angularRadius = source.radius;
        light.extracted = true;
        scene.lights.push_back(light);
    }
    sky.residual = sky.radiance;
    for (std::size_t i = 0; i < left.size(); ++i) sky.residual[i] *= std::max(left[i], 0.0f);
}

}  // namespace voxcone
