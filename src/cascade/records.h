// The records of occupied voxels and how they are packed. Twin of shaders/cascade/records.glsl: same names, same
// arithmetic.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>

namespace voxcone {

/// A face of a resolved voxel; emission (shared exponent 9:9:9:5) is kept apart, for scenes that have some. Faces: 0
/// +x, 1 −x, 2 +y, 3 −y, 4 +z, 5 −z, named by the side that the surface looks to.
struct FaceRecord {
    std::uint32_t albedo = 0;    ///< unorm 11:11:10
    std::uint32_t normal = 0;    ///< octahedral, snorm 16:16 (core/octahedral.h)
    std::uint32_t position = 0;  ///< place in the voxel, unorm 10:10:10; bit 31: the face holds a surface
};

/// Words of a face's sums.
constexpr int faceWords(bool compareAndSwap, bool emission, bool leaves) {
    return compareAndSwap ? 4 : 17 + (emission ? 6 : 0) + (leaves ? 2 : 0);
}

inline std::uint32_t packAlbedo(const glm::vec3& a) {
    const glm::uvec3 q(glm::clamp(a, glm::vec3(0), glm::vec3(1)) * glm::vec3(2047, 2047, 1023) + 0.5f);
    return q.x | (q.y << 11) | (q.z << 22);
}
inline glm::vec3 unpackAlbedo(std::uint32_t p) {
    return glm::vec3(glm::uvec3(p & 2047u, (p >> 11) & 2047u, p >> 22)) / glm::vec3(2047, 2047, 1023);
}

inline std::uint32_t packPosition(const glm::vec3& p) {
    const glm::uvec3 q(glm::clamp(p, glm::vec3(0), glm::vec3(1)) * 1023.0f + 0.5f);
    return q.x | (q.y << 10) | (q.z << 20) | 0x80000000u;
}
inline glm::vec3 unpackPosition(std::uint32_t p) {
    return glm::vec3(glm::uvec3(p & 1023u, (p >> 10) & 1023u, (p >> 20) & 1023u)) / 1023.0f;
}
inline bool faceHoldsSurface(const FaceRecord& face) {
    return (face.position & 0x80000000u) != 0;
}

/// Coverages of three faces, unorm 10:10:10.
inline glm::vec3 unpackCoverage(std::uint32_t p) {
    return glm::vec3(glm::uvec3(p & 1023u, (p >> 10) & 1023u, (p >> 20) & 1023u)) / 1023.0f;
}
/// Coverage of face `f` of a voxel whose faces +xyz and −xyz are in x and y.
inline float faceCoverage(const glm::uvec2& p, int f) {
    return unpackCoverage(f % 2 == 0 ? p.x : p.y)[f / 2];
}

/// Where a record belongs: texel in its level, 8 bits each, level (4), moving geometry (1); bit 31 while it is in use.
inline std::uint32_t packPlace(const glm::ivec3& texel, int level, bool moving) {
    const glm::uvec3 u(texel);
    return u.x | (u.y << 8) | (u.z << 16) | (static_cast<std::uint32_t>(level) << 24) | (moving ? 1u << 28 : 0u) |
           0x80000000u;
}
inline bool placeInUse(std::uint32_t p) {
    return (p & 0x80000000u) != 0;
}
inline glm::ivec3 placeTexel(std::uint32_t p) {
    return glm::ivec3(glm::uvec3(p & 255u, (p >> 8) & 255u, (p >> 16) & 255u));
}
inline int placeLevel(std::uint32_t p) {
    return static_cast<int>((p >> 24) & 15u);
}
inline bool placeMoves(std::uint32_t p) {
    return ((p >> 28) & 1u) != 0;
}

}  // namespace voxcone
