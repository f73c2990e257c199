#include "gl/gpu_environment.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

namespace voxcone::gl {

namespace {

using glm::dvec3;
constexpr double kPi = std::numbers::pi;

/// Sums along the rows of a panorama, so that the mean of any part of a row costs two look-ups.
class RowSums {
  public:
    RowSums(const Environment& e, const std::vector<glm::vec3>& texels)
        : width_(e.width), sums_(static_cast<std::size_t>(e.width + 1) * e.height) {
        for (int row = 0; row < e.height; ++row) {
            dvec3 sum(0);
            for (int x = 0; x < width_; ++x) {
                sum += dvec3(texels[static_cast<std::size_t>(row) * width_ + x]);
                at(row, x + 1) = sum;
            }
        }
    }
    /// Mean over the longitudes within `half` of `center`, both in revolutions, 0 < half ≤ 1/2.
    dvec3 mean(int row, double center, double half) const {
        return (upTo(row, center + half) - upTo(row, center - half)) / (2 * half);
    }

  private:
    dvec3& at(int row, int x) { return sums_[static_cast<std::size_t>(row) * (width_ + 1) + x]; }
    const dvec3& at(int row, int x) const { return sums_[static_cast<std::size_t>(row) * (width_ + 1) + x]; }
    /// ∫ from longitude 0 to `u` revolutions.
    dvec3 upTo(int row, double u) const {
        const double turns = std::floor(u), x = (u - turns) * width_;
        const int column = std::min(static_cast<int>(x), width_ - 1);
        return (turns * at(row, width_) + glm::mix(at(row, column), at(row, column + 1), x - column)) /
               static_cast<double>(width_);
    }

    int width_;
    std::vector<dvec3> sums_;
};

/// A mip: means over the caps of half-angle `angle` around `height` polar angles from pole to pole and `width`
/// longitudes.
std::vector<glm::vec3> capMeans(const RowSums& sums, int rows, int width, int height, double angle) {
    // Caps are cut into circles of latitude, of which each row of the panorama has two.
    constexpr int kCircles = 2;
    struct Arc {
        int row;
        double half, weight;
    };
    std::vector<glm::vec3> means;
    std::vector<Arc> arcs;
    const double step = kPi / (rows * kCircles);
    for (int y = 0; y < height; ++y) {
        const double polar = height > 1 ? kPi * y / (height - 1) : 0.5 * kPi;
        arcs.clear();
        double whole = 0;
        const int first = static_cast<int>(std::max((polar - angle) / step, 0.0)),
                  last = std::min(static_cast<int>((polar + angle) / step), rows * kCircles - 1);
        for (int i = first; i <= last; ++i) {
            const double circle = step * (i + 0.5);
            const double cosHalf = (std::cos(angle) - std::cos(polar) * std::cos(circle)) /
                                   std::max(std::sin(polar) * std::sin(circle), 1e-12);
            if (cosHalf >= 1) continue;
            const double half = cosHalf <= -1 ? 0.5 : std::acos(cosHalf) / (2 * kPi);
            arcs.push_back({i / kCircles, half, half * std::sin(circle)});
            whole += arcs.back().weight;
        }
        for (int x = 0; x < width; ++x) {
            dvec3 sum(0);
            for (const Arc& arc : arcs) sum += arc.weight * sums.mean(arc.row, (x + 0.5) / width, arc.half);
            means.emplace_back(sum / whole);
        }
    }
    return means;
}

}  // namespace

GpuEnvironment::GpuEnvironment(const Environment& environment, const std::vector<glm::vec3>& texels)
    : color(environment.color), rotation(static_cast<float>(glm::radians(environment.rotationDeg))) {
    if (environment.radiance.empty() || environment.black()) return;
    const int levels = fullMipLevels(environment.width, environment.height);
    panorama = Texture::create2D(GL_RGB32F, environment.width, environment.height, levels);
    const std::vector<glm::vec3>& radiance = texels.empty() ? environment.radiance : texels;
    panorama.upload(0, GL_RGB, GL_FLOAT, radiance.data());
    const RowSums sums(environment, radiance);
    for (int level = 1; level < levels; ++level) {
        const int width = panorama.width(level), height = panorama.height(level);
        panorama.upload(level, GL_RGB, GL_FLOAT,
                        capMeans(sums, environment.height, width, height, std::min(2 * kPi / height, kPi)).data());
    }
    panorama.filter(GL_LINEAR_MIPMAP_LINEAR, GL_LINEAR);
    panorama.wrap(GL_REPEAT, GL_CLAMP_TO_EDGE);
}

}  // namespace voxcone::gl
