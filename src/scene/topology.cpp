#include "scene/topology.h"

#include <algorithm>
#include <array>
#include <bit>
#include <numeric>

namespace voxcone {

namespace {

/// Disjoint sets with path halving.
class Sets {
  public:
    explicit Sets(std::size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), 0u); }
    std::uint32_t find(std::uint32_t i) {
        while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
        return i;
    }
    void join(std::uint32_t a, std::uint32_t b) { parent_[find(a)] = find(b); }

  private:
    std::vector<std::uint32_t> parent_;
};

/// For every position the index of the first one equal to it.
std::vector<std::uint32_t> weld(const std::vector<glm::vec3>& positions) {
    auto key = [&](std::uint32_t i) {
        // + 0 turns −0 into +0, which are the same place.
        const glm::vec3 p = positions[i] + 0.0f;
        return std::array{std::bit_cast<std::uint32_t>(p.x), std::bit_cast<std::uint32_t>(p.y),
                          std::bit_cast<std::uint32_t>(p.z)};
    };
    std::vector<std::uint32_t> order(positions.size());
    std::iota(order.begin(), order.end(), 0u);
    std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
        const auto ka = key(a), kb = key(b);
        return ka != kb ? ka < kb : a < b;
    });
    std::vector<std::uint32_t> first(positions.size());
    for (std::size_t i = 0; i < order.size(); ++i) {
        const bool same = i > 0 && key(order[i]) == key(order[i - 1]);
        first[order[i]] = same ? first[order[i - 1]] : order[i];
    }
    return first;
}

struct Edge {
    std::uint32_t low, high, triangle;
    bool forward;  ///< the triangle runs from low to high
};

}  // namespace

std::vector<std::uint8_t> closedTriangles(const std::vector<glm::vec3>& positions,
                                          const std::vector<std::uint32_t>& indices) {
    const std::vector<std::uint32_t> welded = weld(positions);
    const auto triangleCount = static_cast<std::uint32_t>(indices.size() / 3);
    auto corner = [&](std::uint32_t triangle, std::uint32_t k) { return welded[indices[3 * triangle + k]]; };
    auto collapsed = [&](std::uint32_t t) {
        return corner(t, 0) == corner(t, 1) || corner(t, 1) == corner(t, 2) || corner(t, 2) == corner(t, 0);
    };

    std::vector<Edge> edges;
    edges.reserve(indices.size());
    for (std::uint32_t t = 0; t < triangleCount; ++t) {
        if (collapsed(t)) continue;
        for (std::uint32_t k = 0; k < 3; ++k) {
            const std::uint32_t a = corner(t, k), b = corner(t, (k + 1) % 3);
            edges.push_back({std::min(a, b), std::max(a, b), t, a < b});
        }
    }
    std::sort(edges.begin(), edges.end(), [](const Edge& a, const Edge& b) {
        return std::array{a.low, a.high, a.triangle} < std::array{b.low, b.high, b.triangle};
    });

    Sets parts(triangleCount);
    std::vector<std::uint8_t> open(triangleCount, 0);  // by triangle first, gathered to its part below
    for (std::size_t begin = 0; begin < edges.size();) {
        std::size_t end = begin;
        while (end < edges.size() && edges[end].low == edges[begin].low && edges[end].high == edges[begin].high) ++end;
        const bool sealed = end - begin == 2 && edges[begin].forward != edges[begin + 1].forward;
        for (std::size_t i = begin; i < end; ++i) {
            parts.join(edges[begin].triangle, edges[i].triangle);
            if (!sealed) open[edges[i].triangle] = 1;
        }
        begin = end;
    }

    // Six times the signed volume, about a point of the part itself so that far origins lose nothing.
    std::vector<double> volume(triangleCount, 0.0);
    std::vector<std::uint8_t> partOpen(triangleCount, 0);
    for (std::uint32_t t = 0; t < triangleCount; ++t) {
        const std::uint32_t part = parts.find(t);
        if (collapsed(t)) continue;
        partOpen[part] |= open[t];
        const glm::dvec3 origin(positions[indices[3 * part]]);
        const glm::dvec3 a = glm::dvec3(positions[indices[3 * t]]) - origin;
        const glm::dvec3 b = glm::dvec3(positions[indices[3 * t + 1]]) - origin;
        const glm::dvec3 c = glm::dvec3(positions[indices[3 * t + 2]]) - origin;
        volume[part] += glm::dot(a, glm::cross(b, c));
    }

    std::vector<std::uint8_t> closed(triangleCount, 0);
    std::vector<std::uint8_t> vertexClosed(positions.size(), 0);
    for (std::uint32_t t = 0; t < triangleCount; ++t) {
        const std::uint32_t part = parts.find(t);
        if (collapsed(t) || partOpen[part] || !(volume[part] > 0)) continue;
        closed[t] = 1;
        for (std::uint32_t k = 0; k < 3; ++k) vertexClosed[corner(t, k)] = 1;
    }
    for (std::uint32_t t = 0; t < triangleCount; ++t)
        if (collapsed(t) && vertexClosed[corner(t, 0)]) closed[t] = 1;
    return closed;
}

std::size_t degenerateTriangles(const std::vector<glm::vec3>& positions, const std::vector<std::uint32_t>& indices) {
    std::size_t count = 0;
    for (std::size_t i = 0; i + 2 < indices.size(); i += 3) {
        const glm::dvec3 a(positions[indices[i]]), b(positions[indices[i + 1]]), c(positions[indices[i + 2]]);
        count += glm::cross(b - a, c - a) == glm::dvec3(0);
    }
    return count;
}

}  // namespace voxcone
