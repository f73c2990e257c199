#include "metric/temporal.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "core/check.h"

namespace voxcone {

namespace {

constexpr double kLeastAlbedo = 0.02, kLeastCosine = 0.9, kSnap = 1e-3;

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

/// A surface point of the next frame.
struct Point {
    glm::dvec3 position, normal;
    double tolerance;  ///< how far from its tangent plane its surface may be found
};

/// Where the frame showed the point, in pixels from the middle of the upper left one; nothing behind its camera.
std::optional<glm::dvec2> placeOf(const TemporalFrame& frame, const Point& point) {
    const glm::dvec4 clip = frame.worldToClip * glm::dvec4(point.position, 1);
    if (!(clip.w > 0)) return std::nullopt;
    return glm::dvec2((0.5 + 0.5 * clip.x / clip.w) * frame.position.width - 0.5,
                      (0.5 - 0.5 * clip.y / clip.w) * frame.position.height - 0.5);
}

bool showsSurface(const TemporalFrame& frame, int x, int y, const Point& point) {
    return glm::dot(vectorOf(frame.normal, x, y), point.normal) >= kLeastCosine &&
           std::abs(glm::dot(vectorOf(frame.position, x, y) - point.position, point.normal)) <= point.tolerance;
}

Warped warp(const TemporalFrame& frame, const Point& point, bool snap) {
    Warped out;
    const auto place = placeOf(frame, point);
    if (!place) return out;
    glm::dvec2 at = *place;
    if (snap)
        for (int c = 0; c < 2; ++c)
            if (std::abs(at[c] - std::round(at[c])) < kSnap) at[c] = std::round(at[c]);
    const glm::dvec2 last(frame.position.width - 1, frame.position.height - 1);
    const bool inside =
        at.x >= 0 && at.y >= 0 && (snap ? at.x <= last.x && at.y <= last.y : at.x < last.x && at.y < last.y);
    if (!inside) return out;
    const int left = static_cast<int>(at.x), top = static_cast<int>(at.y);
    const double fx = at.x - left, fy = at.y - top;

    out.valid = glm::bvec3(true);
    for (int i = 0; i < 4; ++i) {
        const int x = left + i % 2, y = top + i / 2;
        const double weight = (i % 2 == 1 ? fx : 1 - fx) * (i / 2 == 1 ? fy : 1 - fy);
        if (snap && weight == 0) continue;
        if (!showsSurface(frame, x, y, point)) return {};
        const glm::dvec3 albedo = vectorOf(frame.albedo, x, y), light = vectorOf(frame.indirectDiffuse, x, y);
        for (int c = 0; c < 3; ++c) {
            if (albedo[c] > kLeastAlbedo)
                out.irradiance[c] += weight * light[c] / albedo[c];
            else
                out.valid[c] = false;
        }
    }
    return out;
}

/// The surface of a pixel, which may lie as far off as the pixel is wide there; nothing on the background.
std::optional<Point> pointOf(const TemporalFrame& frame, int x, int y) {
    const glm::dvec3 normal = vectorOf(frame.normal, x, y);
    if (normal == glm::dvec3(0)) return std::nullopt;
    const glm::dvec3 position = vectorOf(frame.position, x, y);
    const double w = (frame.worldToClip * glm::dvec4(position, 1)).w;
    return Point{position, normal, footprint(frame.worldToClip, w, frame.position.height)};
}

/// `map`: set to the mean change of each pixel, not yet over the whole picture's mean, if not null.
TemporalChange compareFrames(const TemporalFrame& before, const TemporalFrame& now, Image* map) {
    checkFrame(before, now.position), checkFrame(now, now.position);
    const int width = now.position.width, height = now.position.height;
    if (map) *map = Image(width, height, 1);
    double squared = 0, change = 0, sum = 0;
    std::size_t values = 0, pixels = 0;
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            const auto point = pointOf(now, x, y);
            if (!point) continue;
            const Warped old = warp(before, *point, map != nullptr);
            const glm::dvec3 albedo = vectorOf(now.albedo, x, y), light = vectorOf(now.indirectDiffuse, x, y);
            double here = 0;
            int components = 0;
            for (int c = 0; c < 3; ++c) {
                if (!old.valid[c] || !(albedo[c] > kLeastAlbedo)) continue;
                const double difference = light[c] / albedo[c] - old.irradiance[c];
                squared += difference * difference, change += difference, sum += old.irradiance[c];
                here += difference;
                ++components;
            }
            if (components > 0) ++pixels;
            values += static_cast<std::size_t>(components);
            if (map)
                *map->pixel(x, y) =
                    components > 0 ? static_cast<float>(here / components) : std::numeric_limits<float>::quiet_NaN();
        }
    }
    if (values == 0) return {};
    const auto n = static_cast<double>(values);
    return {std::sqrt(squared / n), change / n, sum / n,
            static_cast<double>(pixels) / (static_cast<double>(width) * height)};
}

}  // namespace

double TemporalChange::jump() const {
    return mean > 0 ? std::abs(meanChange) / mean : 0;
}

TemporalChange temporalChange(const TemporalFrame& before, const TemporalFrame& now) {
    return compareFrames(before, now, nullptr);
}

ChangeMap changeMap(const TemporalFrame& before, const TemporalFrame& now) {
    ChangeMap out;
    out.figures = compareFrames(before, now, &out.change);
    const auto scale = static_cast<float>(out.figures.mean > 0 ? 1 / out.figures.mean : 0);
    for (float& v : out.change.data) v *= scale;
    return out;
}

Image carried(const Image& values, const TemporalFrame& before, const TemporalFrame& now) {
    VOXCONE_CHECK(
        values.channels == 1 && values.width == before.position.width && values.height == before.position.height,
        "{}x{}x{} of {}x{}", values.width, values.height, values.channels, before.position.width,
        before.position.height);
    // The coarser picture says how near is near enough.
    const double coarser = std::max(1.0, static_cast<double>(now.position.height) / before.position.height);
    Image out(now.position.width, now.position.height, 1);
    for (int y = 0; y < out.height; ++y) {
        for (int x = 0; x < out.width; ++x) {
            auto point = pointOf(now, x, y);
            if (!point) continue;
            point->tolerance *= coarser;
            float& value = *out.pixel(x, y);
            value = std::numeric_limits<float>::quiet_NaN();
            const auto place = placeOf(before, *point);
            if (!place) continue;
            const glm::dvec2 at = glm::floor(*place + 0.5);
            if (!(at.x >= 0 && at.y >= 0 && at.x < values.width && at.y < values.height)) continue;
            const int i = static_cast<int>(at.x), j = static_cast<int>(at.y);
            if (showsSurface(before, i, j, *point)) value = *values.pixel(i, j);
        }
    }
    return out;
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
