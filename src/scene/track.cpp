#include "scene/track.h"

#include <algorithm>

#include "core/check.h"

namespace voxcone {

KeyPosition keyPosition(const std::vector<double>& times, double time) {
    VOXCONE_CHECK(!times.empty(), "a track without keys is read at {} s", time);
    if (!(time > times.front())) return {0, 0, 0};
    if (time >= times.back()) return {times.size() - 1, 0, 0};
    const auto next = std::upper_bound(times.begin(), times.end(), time);
    const auto index = static_cast<std::size_t>(next - times.begin()) - 1;
    const double span = times[index + 1] - times[index];
    return {index, (time - times[index]) / span, span};
}

glm::dvec3 Track::at(double time) const {
    VOXCONE_CHECK(values.size() == times.size(), "{} values at {} times", values.size(), times.size());
    VOXCONE_CHECK(interpolation != Interpolation::cubic_spline, "a track has no tangents of its own");
    const KeyPosition position = keyPosition(times, time);
    const std::size_t key = position.index;
    if (position.span == 0 || interpolation == Interpolation::step) return values[key];
    if (interpolation == Interpolation::linear) {
        return (1 - position.t) * values[key] + position.t * values[key + 1];
    }
    const auto slope = [&](std::size_t k) {
        const std::size_t before = k > 0 ? k - 1 : k, after = std::min(k + 1, times.size() - 1);
        return (values[after] - values[before]) / (times[after] - times[before]);
    };
    return hermite(values[key], position.span * slope(key), values[key + 1], position.span * slope(key + 1),
                   position.t);
}

}  // namespace voxcone
