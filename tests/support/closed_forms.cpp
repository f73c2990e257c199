#include "support/closed_forms.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace voxcone::test {

using glm::dvec3;
constexpr double kPi = std::numbers::pi;

double polygonFactor(const dvec3& point, const dvec3& normal, const std::vector<dvec3>& corners) {
    std::vector<dvec3> above;
    for (std::size_t i = 0; i < corners.size(); ++i) {
        const dvec3 a = corners[i] - point, b = corners[(i + 1) % corners.size()] - point;
        const double heightA = glm::dot(a, normal), heightB = glm::dot(b, normal);
        if (heightA >= 0) above.push_back(a);
        if (heightA * heightB < 0) above.push_back(a + (b - a) * (heightA / (heightA - heightB)));
    }
    double sum = 0;
    for (std::size_t i = 0; i < above.size(); ++i) {
        const dvec3& a = above[i];
        const dvec3& b = above[(i + 1) % above.size()];
        const dvec3 across = glm::cross(a, b);
        const double sine = glm::length(across);
        if (sine > 0) sum += std::atan2(sine, glm::dot(a, b)) * glm::dot(normal, across) / sine;
    }
    return std::abs(sum) / (2 * kPi);
}

double rectangleFactor(const dvec3& point, const dvec3& normal, const dvec3& corner, const dvec3& sideU,
                       const dvec3& sideV) {
    return polygonFactor(point, normal, {corner, corner + sideU, corner + sideU + sideV, corner + sideV});
}

double boxFactor(const dvec3& point, const dvec3& normal, const dvec3& low, const dvec3& high) {
    double sum = 0;
    for (int axis = 0; axis < 3; ++axis) {
        dvec3 corner = low, u(0), v(0);
        u[(axis + 1) % 3] = (high - low)[(axis + 1) % 3];
        v[(axis + 2) % 3] = (high - low)[(axis + 2) % 3];
        if (point[axis] > high[axis]) corner[axis] = high[axis];
        // Of a convex body exactly the faces that look at the point fill its outline.
        if (point[axis] > high[axis] || point[axis] < low[axis]) sum += rectangleFactor(point, normal, corner, u, v);
    }
    return sum;
}

double sphereFactor(const dvec3& point, const dvec3& normal, const dvec3& center, double radius) {
    const double distance = glm::distance(center, point), h = distance / radius;
    const double c = glm::dot(center - point, normal) / distance, k = 1 - h * h * c * c;
    if (k <= 0) return c > 0 ? c / (h * h) : 0;
    return ((c * std::acos(-c * std::sqrt((h * h - 1) / (1 - c * c))) - std::sqrt(k * (h * h - 1))) / (h * h) +
            std::atan(std::sqrt(k / (h * h - 1)))) /
           kPi;
}

double discPastEdge(double t) {
    t = std::clamp(t, -1.0, 1.0);
    return 0.5 + (t * std::sqrt(1 - t * t) + std::asin(t)) / kPi;
}

}  // namespace voxcone::test
