// Values over time at keys: how animated nodes, lights and camera paths are read between them.
#pragma once

#include <cstddef>
#include <glm/glm.hpp>
#include <vector>

namespace voxcone {

enum class Interpolation : int { linear, step, cubic_spline, catmull_rom };

/// Where a time lies among keys: in `span` seconds from key `index` to the next one, at share `t` in [0,1] of them.
/// Before the first and after the last key `span` is 0 and `index` is that key.
struct KeyPosition {
    std::size_t index = 0;
    double t = 0, span = 0;
};

/// `times` strictly increasing, not empty.
KeyPosition keyPosition(const std::vector<double>& times, double time);

/// Cubic Hermite polynomial at `t` in [0,1] from `a` to `b`; tangents are per unit of `t`.
template <class Vector>
Vector hermite(const Vector& a, const Vector& tangentA, const Vector& b, const Vector& tangentB, double t) {
    const double t2 = t * t, t3 = t2 * t;
    return (2 * t3 - 3 * t2 + 1) * a + (t3 - 2 * t2 + t) * tangentA + (3 * t2 - 2 * t3) * b + (t3 - t2) * tangentB;
}

/// A vector over time. Clamped to the first and the last key.
struct Track {
    Interpolation interpolation = Interpolation::linear;  ///< linear, step or catmull_rom
    std::vector<double> times;                            ///< seconds, strictly increasing
    std::vector<glm::dvec3> values;                       ///< one a key

    bool empty() const { return times.empty(); }

    /// Value at `time` seconds; the track must not be empty. catmull_rom: cubic Hermite with tangents
    /// (v[i+1] − v[i−1]) / (t[i+1] − t[i−1]), one-sided at the ends (Catmull and Rom 1974, for uneven times).
    glm::dvec3 at(double time) const;
    bool operator==(const Track&) const = default;
};

}  // namespace voxcone
