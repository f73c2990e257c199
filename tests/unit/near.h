// Vectors that are nearly equal.
#pragma once

#include <gtest/gtest.h>

#include <glm/glm.hpp>

namespace voxcone::test {

inline void expectNear(const glm::dvec3& a, const glm::dvec3& b, double tolerance = 1e-6) {
    EXPECT_LE(glm::length(a - b), tolerance)
        << "(" << a.x << " " << a.y << " " << a.z << ") against (" << b.x << " " << b.y << " " << b.z << ")";
}

}  // namespace voxcone::test
