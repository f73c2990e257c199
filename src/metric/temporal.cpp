#include "metric/temporal.h"

#include <algorithm>
#include <cmath>

#include "core/check.h"

namespace voxcone {

namespace {

constexpr double kLeastAlbedo = 0.02, kLeastCosine = 0.9;

glm::dvec3 vectorOf(const Image& image, int x, int y) {
    const float* p = image.pixel(x, y);
    return {p[0], p[1], p[2]};
}

void checkFrame(const TemporalFrame& frame, const Image& like) {
    for (const Image* image : {&frame.indirectDiffuse, &frame.albedo, &frame.position, &frame.normal})
        VOXCONE_CHECK(image->width == like.width && image->height == like.height && image->channels == 3,
                      "{}x{}x{} beside {}x{}", image->width, image->height, image->channels, like.width, like.height);
}

/// Width of a pixel in the world, at distance `w` along the view. Row y of the matrix is the camera's upward axis over
/// the tangent of half the field of view.
double footprint(const glm::dmat4& worldToClip, double w, int height) {
    const double upward = glm::length(glm::dvec3(worldToClip[0][1], worldToClip[1][1], worldToClip[2][1]));
    return 2 * w / (upward * height);
}

/// Irradiance of a frame where a surface point of the next one was.
struct Warped {
    glm::dvec3 irradiance{0};
    glm::bvec3 valid{false};  ///< by component
};

Warped warp(const TemporalFrame& frame, const glm::dvec3& position, const glm::dvec3& normal, double tolerance) {
    Warped out;
    const int width = frame.position.width, height = frame.position.height;
    const glm::dvec4 clip = frame.worldToClip * glm::dvec4(position, 1);
    if (!(clip.w > 0)) return out;
    const double u = (0.5 + 0.5 * clip.x / clip.w) * width - 0.5, v = (0.5 - 0.5 * clip.y / clip.w) * height - 0.5;
    if (!(u >= 0 && v >= 0 && u < width - 1 && v < height - 1)) return out;
    const int left = static_cast<int>(u), top = static_cast<int>(v);
    const double fx = u - left, fy = v - top;

    out.valid = glm::bvec3(true);
    for (int i = 0; i < 4; ++i) {
        const int x = left + i % 2, y = top + i / 2;
        const bool sameSurface = glm::dot(vectorOf(frame.normal, x, y), normal) >= kLeastCosine &&
                                 std::abs(glm::dot(vectorOf(frame.position, x, y) - position, normal)) <= tolerance;
        if (!sameSurface) return {};
        const glm::dvec3 albedo = vectorOf(frame.albedo, x, y), light = vectorOf(frame.indirectDiffuse, x, y);
        const double weight = (i % 2 == 1 ? fx : 1 - fx) * (i / 2 == 1 ? fy : 1 - fy);
        for (int c = 0; c < 3; ++c) {
            if (albedo[c] > kLeastAlbedo)
                out.irradiance[c] += weight * light[c] / albedo[c];
            else
                out.valid[c] = false;
        }
    }
    return out;
}

}  // namespace

double TemporalChange::jump() const {
    return mean > 0 ? std::abs(meanChange) / mean : 0;
}

TemporalChange temporalChange(const TemporalFrame& before, const TemporalFrame& now) {
    checkFrame(before, now.position), checkFrame(now, now.position);
    const int width = now.position.width, height = now.position.height;
    double squared = 0, change = 0, sum = 0;
    std::size_t values = 0, pixels = 0;
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            const glm::dvec3 normal = vectorOf(now.normal, x, y);
            if (normal == glm::dvec3(0)) continue;
            const glm::dvec3 position = vectorOf(now.position, x, y);
            const double w = (now.worldToClip * glm::dvec4(position, 1)).w;
            const Warped old = warp(before, position, normal, footprint(now.worldToClip, w, height));
            const glm::dvec3 albedo = vectorOf(now.albedo, x, y), light = vectorOf(now.indirectDiffuse, x, y);
            bool any = false;
            for (int c = 0; c < 3; ++c) {
                if (!old.valid[c] || !(albedo[c] > kLeastAlbedo)) continue;
                const double difference = light[c] / albedo[c] - old.irradiance[c];
                squared += difference * difference, change += difference, sum += old.irradiance[c];
                ++values;
                any = true;
            }
            if (any) ++pixels;
        }
    }
    if (values == 0) return {};
    const auto n = static_cast<double>(values);
    return {std::sqrt(squared / n), change / n, sum / n,
            static_cast<double>(pixels) / (static_cast<double>(width) * height)};
}

TemporalChange changeInPlace(const Image& before, const Image& now, const Image& albedo) {
    VOXCONE_CHECK(before.data.size() == now.data.size() && now.data.size() == albedo.data.size(), "{} {} {} values",
                  before.data.size(), now.data.size(), albedo.data.size());
    double squared = 0, change = 0, sum = 0;
    std::size_t values = 0;
    for (std::size_t i = 0; i < now.data.size(); ++i) {
        const double a = static_cast<double>(albedo.data[i]);
        if (!(a > kLeastAlbedo)) continue;
        const double old = static_cast<double>(before.data[i]) / a;
        const double difference = static_cast<double>(now.data[i]) / a - old;
        squared += difference * difference, change += difference, sum += old;
        ++values;
    }
    if (values == 0) return {};
    const auto n = static_cast<double>(values);
    return {std::sqrt(squared / n), change / n, sum / n, n / static_cast<double>(now.data.size())};
}

TemporalFigure temporalFigure(const std::vector<TemporalChange>& changes) {
    TemporalFigure out;
    double squared = 0;
    int counted = 0;
    for (const TemporalChange& change : changes) {
        out.valid += change.valid / static_cast<double>(changes.size());
        if (change.valid == 0) continue;
        squared += change.rms * change.rms, out.mean += change.mean;
        out.worstJump = std::max(out.worstJump, change.jump());
        if (change.mean > 0) out.worstRms = std::max(out.worstRms, change.rms / change.mean);
        ++counted;
    }
    if (counted == 0) return out;
    out.mean /= counted;
    if (out.mean > 0) out.f = std::sqrt(squared / counted) / out.mean;
    return out;
}

}  // namespace voxcone
