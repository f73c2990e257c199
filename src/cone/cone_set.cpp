#include "cone/cone_set.h"

#include <cmath>
#include <numbers>

#include "core/check.h"

namespace voxcone {

namespace {

using std::numbers::pi;

glm::dvec3 polar(double cosine, double azimuth) {
    const double sine = std::sqrt(std::max(0.0, 1 - cosine * cosine));
    return {sine * std::cos(azimuth), sine * std::sin(azimuth), cosine};
}

/// The normal with weight `w0` and `count` cones around it, at the angle that makes Σw cosθ = 2/3.
ConeSet ring(int count, double w0) {
    ConeSet set;
    set.directions.push_back({0, 0, 1});
    set.weights.push_back(w0);
    for (int i = 0; i < count; ++i) {
        set.directions.push_back(polar((2.0 / 3 - w0) / (1 - w0), 2 * pi * i / count));
        set.weights.push_back((1 - w0) / count);
    }
    set.tanHalfAngle = std::tan(pi / 6);
    return set;
}

/// Weights of the parts of the hemisphere nearest to each direction, by midpoint integration.
void weighByNearest(ConeSet& set) {
    constexpr int kSine2 = 512, kAzimuth = 2048;
    std::vector<int> hits(set.directions.size());
    for (int i = 0; i < kSine2; ++i)
        for (int j = 0; j < kAzimuth; ++j) {
            const glm::dvec3 d = polar(std::sqrt(1 - (i + 0.5) / kSine2), 2 * pi * (j + 0.5) / kAzimuth);
            std::size_t nearest = 0;
            for (std::size_t k = 1; k < set.directions.size(); ++k)
                if (glm::dot(d, set.directions[k]) > glm::dot(d, set.directions[nearest])) nearest = k;
            ++hits[nearest];
        }
    for (const int h : hits) set.weights.push_back(static_cast<double>(h) / (kSine2 * kAzimuth));
}

}  // namespace

ConeSet coneSet(int count) {
    ConeSet set;
    switch (count) {
        case 1:
            set.directions = {{0, 0, 1}};
            set.weights = {1};
            set.tanHalfAngle = 1;
            return set;
        case 5:
            return ring(4, 1.0 / 3);
        case 6:
            return ring(5, 1.0 / 4);
        case 9:
            set.directions.push_back({0, 0, 1});
            for (int i = 0; i < 4; ++i) set.directions.push_back(polar(std::sqrt(0.5), pi / 2 * i));
            for (int i = 0; i < 4; ++i) set.directions.push_back(polar(std::sqrt(1.0 / 3), pi / 2 * (i + 0.5)));
            weighByNearest(set);
            set.tanHalfAngle = std::tan(pi / 6);
            return set;
        case 16:
        case 32:
            for (int i = 0; i < count; ++i) {
                const double golden = pi * (3 - std::sqrt(5.0));
                set.directions.push_back(polar(std::sqrt(1 - (i + 0.5) / count), golden * i));
                set.weights.push_back(1.0 / count);
            }
            // A cone's share of the solid angle weighted by cosine, π/n, as a disc: tan² = 1/n.
            set.tanHalfAngle = 1 / std::sqrt(static_cast<double>(count));
            set.spiral = true;
            return set;
        default:
            VOXCONE_CHECK(false, "no set of {} cones", count);
    }
    return set;
}

}  // namespace voxcone
