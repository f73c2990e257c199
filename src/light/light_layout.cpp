#include "light/light_layout.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>

#include "core/error.h"

namespace voxcone {
namespace {

using glm::dvec3;

/// Part of the scene's diagonal next to a light where nothing casts a shadow. Smaller values cost depth precision:
/// a 32-bit depth buffer resolves z·(z/near)·2⁻²⁴.
constexpr double kNearOfDiagonal = 1.0 / 2048;
/// A light narrower than this part of the diagonal has one sample point, whose shadow is widened by a blocker search.
constexpr double kSmallLightOfDiagonal = 1.0 / 64;
/// A directional light has one sample point if the tangent of its angular radius is at most this.
constexpr double kSmallDisc = 1.0 / 64;
/// Sample points of a wider one.
constexpr int kDiscSamples = 12;
/// Spot lights wider than this half-angle are seen through a cube: one perspective view would waste its middle.
constexpr double kWidestSpot = 1.0;
/// Sample points of a rectangle, about.
constexpr int kRectangleSamples = 12;
constexpr int kSmallestTile = 64;  // texels
/// Texels of the atlas at most (half a gibibyte).
constexpr std::int64_t kMaxAtlasTexels = std::int64_t{1} << 27;

struct Frame {
    dvec3 right, up, forward;
};

Frame frameOf(const dvec3& forward, const dvec3& hint) {
    dvec3 right = glm::cross(forward, hint);
    if (glm::dot(right, right) < 1e-12) {
        const dvec3 other = std::abs(forward.x) < 0.9 ? dvec3(1, 0, 0) : dvec3(0, 1, 0);
        right = glm::cross(forward, other);
    }
    right = glm::normalize(right);
    return {right, glm::cross(right, forward), forward};
}

/// Faces of a cube: forward, right, left, up, down, backward. lights.glsl picks them in this order.
std::array<Frame, 6> cubeFaces(const Frame& f) {
    return {{{f.right, f.up, f.forward},
             {-f.forward, f.up, f.right},
             {f.forward, f.up, -f.right},
             {f.right, -f.forward, f.up},
             {f.right, f.forward, -f.up},
             {-f.right, f.up, -f.forward}}};
}

struct Builder {
    LightLayout out;
    Bounds bounds;  // relative to the origin
    double diagonal = 0;
    double filter = 0;

    /// Half-width in texels of the widest filter: what the border of a tile leaves room for.
    double maxKernel(int tile) const { return std::max(std::ceil(filter) + 1, tile / 32.0); }
    /// Texels on each side of a tile that only filters read.
    double border(int tile) const { return maxKernel(tile) + 2; }

    void addView(const dvec3& origin, const Frame& frame, int tile, bool perspective, double halfExtent,
                 const glm::dvec2& depth) {
        const double whole = halfExtent * tile / (tile - 2 * border(tile));
        ShadowViewRecord view;
        view.origin = origin;
        view.right = frame.right;
        view.up = frame.up;
        view.forward = frame.forward;
        view.texel = static_cast<float>(2 * whole / tile);
        view.scale = static_cast<float>(1 / whole);
        view.perspective = perspective ? 1.f : 0.f;
        view.maxKernel = static_cast<float>(maxKernel(tile));
        view.filterRadius = static_cast<float>(filter);
        view.depth = depth;
        out.views.push_back(view);
        out.tiles.push_back({0, 0, tile});
    }

    void addPerspective(const dvec3& origin, const Frame& frame, int tile, double tanHalfAngle) {
        const dvec3 nearest = glm::clamp(origin, bounds.min, bounds.max);
        const dvec3 farthest = glm::max(glm::abs(bounds.min - origin), glm::abs(bounds.max - origin));
        // On a face of a cube the depth of a point is at least its distance over √3.
        const double near = std::max(kNearOfDiagonal * diagonal, 0.5 * glm::distance(nearest, origin));
        const double far = std::max(1.01 * glm::length(farthest), 2 * near);
        addView(origin, frame, tile, true, tanHalfAngle, {far / (far - near), far * near / (far - near)});
    }

    void addDirectional(const Frame& frame, int tile) {
        const dvec3 center = bounds.center();
        dvec3 half(0);
        for (int corner = 0; corner < 8; ++corner) {
            const dvec3 p = dvec3(corner & 1 ? bounds.max.x : bounds.min.x, corner & 2 ? bounds.max.y : bounds.min.y,
                                  corner & 4 ? bounds.max.z : bounds.min.z) -
                            center;
            half = glm::max(
                half, glm::abs(dvec3(glm::dot(p, frame.right), glm::dot(p, frame.up), glm::dot(p, frame.forward))));
        }
        const double depthHalf = 1.01 * std::max(half.z, kNearOfDiagonal * diagonal);
        const double planeHalf = std::max({half.x, half.y, kNearOfDiagonal * diagonal});
        addView(center, frame, tile, false, planeHalf, {0.5, 0.5 / depthHalf});
    }

    void addCube(const dvec3& origin, const Frame& frame, int tile, int faces) {
        const std::array<Frame, 6> all = cubeFaces(frame);
        for (int face = 0; face < faces; ++face) {
            addPerspective(origin, all[static_cast<std::size_t>(face)], tile, 1);
        }
    }
};

/// Sample points of a sphere light: the corners of an icosahedron at kSphereSampleRadius, which look much alike from
/// everywhere. From any side a uniform disc has the variance r²/4 along an axis, the points have ρ²/3, and the square
/// of half-edge s that each stands for has s²/3: so s² = 3r²/4 − ρ².
constexpr double kSphereSampleRadius = 0.8;

std::vector<dvec3> sphereSamples(const dvec3& center, double radius) {
    const dvec3 corner = kSphereSampleRadius * radius * glm::normalize(dvec3(0, 1, std::numbers::phi));
    std::vector<dvec3> points;
    for (int axis = 0; axis < 3; ++axis) {
        for (int signs = 0; signs < 4; ++signs) {
            dvec3 p(0);
            p[(axis + 1) % 3] = signs & 1 ? -corner.y : corner.y;
            p[(axis + 2) % 3] = signs & 2 ? -corner.z : corner.z;
            points.push_back(center + p);
        }
    }
    return points;
}

/// Points of a disc of radius 1 on a spiral (Vogel 1979). Each stands for a square of area π/n, whose half-edge is
/// `stratumSize`; with its variance s²/3 the points have that of the disc, 1/4 along an axis.
std::vector<glm::dvec2> discSamples(float& stratumSize) {
    const double half = 0.5 * std::sqrt(std::numbers::pi / kDiscSamples);
    const double scale = std::sqrt(1 - 4 * half * half / 3);
    std::vector<glm::dvec2> points;
    for (int i = 0; i < kDiscSamples; ++i) {
        const double r = scale * std::sqrt((i + 0.5) / kDiscSamples),
                     angle = i * std::numbers::pi * (3 - std::sqrt(5.0));
        points.emplace_back(r * std::cos(angle), r * std::sin(angle));
    }
    stratumSize = static_cast<float>(half);
    return points;
}

/// Centres of nearly square strata.
std::vector<dvec3> rectangleSamples(const dvec3& center, const Frame& frame, double width, double height,
                                    double& stratumSize) {
    const int nx = static_cast<int>(std::clamp(std::round(std::sqrt(kRectangleSamples * width / height)), 1.0,
                                               static_cast<double>(kRectangleSamples)));
    const int ny = static_cast<int>(std::round(static_cast<double>(kRectangleSamples) / nx));
    std::vector<dvec3> points;
    for (int y = 0; y < ny; ++y) {
        for (int x = 0; x < nx; ++x) {
            points.push_back(center + ((x + 0.5) / nx - 0.5) * width * frame.right +
                             ((y + 0.5) / ny - 0.5) * height * frame.up);
        }
    }
    stratumSize = 0.5 * std::sqrt(width / nx * height / ny);
    return points;
}

/// Shelves of tiles, largest first. False when an edge of more than `maxSize` or too many texels would be needed.
bool packTiles(LightLayout& layout, int maxSize) {
    if (layout.tiles.empty()) return true;
    std::vector<std::size_t> order(layout.tiles.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return layout.tiles[a].size > layout.tiles[b].size; });
    std::int64_t area = 0;
    for (const ShadowTile& tile : layout.tiles) area += std::int64_t{tile.size} * tile.size;
    // About as wide as high, in whole tiles of the largest size.
    const int largest = layout.tiles[order[0]].size;
    const int columns = static_cast<int>(std::ceil(std::sqrt(static_cast<double>(area)) / largest));
    const int width = largest * columns;
    int x = 0, y = 0, shelf = 0;
    for (const std::size_t i : order) {
        ShadowTile& tile = layout.tiles[i];
        if (x + tile.size > width) {
            y += shelf;
            x = 0;
            shelf = 0;
        }
        tile.x = x;
        tile.y = y;
        x += tile.size;
        shelf = std::max(shelf, tile.size);
    }
    layout.atlasWidth = y == 0 ? x : width;
    layout.atlasHeight = y + shelf;
    return layout.atlasWidth <= maxSize && layout.atlasHeight <= maxSize &&
           std::int64_t{layout.atlasWidth} * layout.atlasHeight <= kMaxAtlasTexels;
}

LightLayout layoutAt(const std::vector<Light>& lights, const Bounds& worldBounds, const dvec3& origin, int resolution,
                     double filter) {
    Builder builder;
    builder.filter = filter;
    if (!worldBounds.empty()) {
        builder.bounds.add(worldBounds.min - origin);
        builder.bounds.add(worldBounds.max - origin);
    }
    builder.diagonal = glm::length(builder.bounds.size());
    const bool casters = builder.diagonal > 0;
    const auto tileSize = [&](int divisor) { return std::max(resolution / divisor, kSmallestTile); };

    for (Light light : lights) {
        if (light.type == LightType::sphere && light.radius <= 0) light.type = LightType::point;
        LightRecord record;
        const dvec3 position = light.type == LightType::directional ? dvec3(0) : light.position - origin;
        const Frame frame = light.type == LightType::point || light.type == LightType::sphere
                                ? Frame{dvec3(1, 0, 0), dvec3(0, 1, 0), dvec3(0, 0, -1)}
                                : frameOf(light.direction, light.up);
        record.position = position;
        record.type = static_cast<std::uint32_t>(light.type);
        record.direction = frame.forward;
        record.range = static_cast<float>(light.range);
        record.intensity = light.intensity;
        record.right = frame.right;
        record.up = frame.up;
        record.cosInnerCone = static_cast<float>(std::cos(light.innerConeAngle));
        record.cosOuterCone = static_cast<float>(std::cos(light.outerConeAngle));
        record.firstView = static_cast<std::uint32_t>(builder.out.views.size());
        record.samples = 1;
        record.faces = 1;

        std::vector<dvec3> points = {position};
        double stratum = 0;
        switch (light.type) {
            case LightType::directional: {
                const double tangent = std::tan(light.angularRadius);
                record.radius = static_cast<float>(std::sin(light.angularRadius));
                if (tangent <= kSmallDisc) {
                    record.stratumSize = static_cast<float>(std::sqrt(0.75) * tangent);
                    if (casters) builder.addDirectional(frame, tileSize(1));
                    break;
                }
                const std::vector<glm::dvec2> places = discSamples(record.stratumSize);
                record.stratumSize *= static_cast<float>(tangent);
                record.samples = static_cast<std::uint32_t>(places.size());
                for (const glm::dvec2& place : places) {
                    const dvec3 towards =
                        glm::normalize(frame.forward + tangent * (place.x * frame.right + place.y * frame.up));
                    if (casters) builder.addDirectional(frameOf(towards, frame.up), tileSize(4));
                }
                break;
            }
            case LightType::spot:
                if (light.outerConeAngle <= kWidestSpot) {
                    if (casters) {
                        builder.addPerspective(position, frame, tileSize(1), std::tan(light.outerConeAngle));
                    }
                    break;
                }
                [[fallthrough]];
            case LightType::point:
                record.faces = 6;
                if (casters) builder.addCube(position, frame, tileSize(2), 6);
                break;
            case LightType::sphere:
                record.faces = 6;
                record.radius = static_cast<float>(light.radius);
                // A square of half-edge s has the variance s²/3, a disc of radius r has r²/4.
                stratum = std::sqrt(0.75) * light.radius;
                if (2 * light.radius > kSmallLightOfDiagonal * builder.diagonal) {
                    points = sphereSamples(position, light.radius);
                    stratum = std::sqrt(0.75 - kSphereSampleRadius * kSphereSampleRadius) * light.radius;
                }
                break;
            case LightType::rectangle:
                record.faces = 5;
                record.halfWidth = static_cast<float>(0.5 * light.width);
                record.halfHeight = static_cast<float>(0.5 * light.height);
                stratum = 0.5 * std::sqrt(light.width * light.height);
                if (std::max(light.width, light.height) > kSmallLightOfDiagonal * builder.diagonal) {
                    points = rectangleSamples(position, frame, light.width, light.height, stratum);
                }
                break;
        }
        if (light.type == LightType::sphere || light.type == LightType::rectangle) {
            record.stratumSize = static_cast<float>(stratum);
            record.samples = static_cast<std::uint32_t>(points.size());
            const int tile = tileSize(points.size() == 1 ? 2 : 4);
            if (casters) {
                for (const dvec3& p : points) builder.addCube(p, frame, tile, static_cast<int>(record.faces));
            }
        }
        if (!casters) record.samples = 0;
        builder.out.lights.push_back(record);
    }
    return std::move(builder.out);
}

}  // namespace

LightLayout layoutLights(const std::vector<Light>& worldLights, const Bounds& bounds, const dvec3& origin,
                         int resolution, double filter, int maxAtlasSize) {
    LightLayout layout;
    for (int shrunk = 0;; ++shrunk) {
        layout = layoutAt(worldLights, bounds, origin, resolution >> shrunk, filter);
        layout.shrunk = shrunk;
        if (packTiles(layout, maxAtlasSize)) break;
        if (resolution >> shrunk < kSmallestTile) {
            throw DeviceError(fmt::format("{} lights need {} shadow maps, more than a texture of {}² holds",
                                          worldLights.size(), layout.views.size(), maxAtlasSize));
        }
    }
    const glm::dvec2 atlas(std::max(layout.atlasWidth, 1), std::max(layout.atlasHeight, 1));
    for (std::size_t i = 0; i < layout.views.size(); ++i) {
        const ShadowTile& tile = layout.tiles[i];
        const glm::dvec2 half(0.5 * tile.size);
        layout.views[i].tileCenter = (glm::dvec2(tile.x, tile.y) + half) / atlas;
        layout.views[i].tileHalfSize = half / atlas;
    }
    return layout;
}

}  // namespace voxcone
