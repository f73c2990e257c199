// The records of occupied voxels and how they are packed. Twin of shaders/voxelize/records.glsl: same names, same
// arithmetic.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>

namespace voxcone {

/// A face of a resolved voxel. Faces: 0 +x, 1 −x, 2 +y, 3 −y, 4 +z, 5 −z, named by the side that the surface looks to.
struct FaceRecord {
    std::uint32_t albedo = 0;    ///< unorm 11:11:10
    std::uint32_t normal = 0;    ///< octahedral, snorm 16:16 (core/octahedral.h)
    std::uint32_t position = 0;  ///< place in the voxel, unorm 10:10:10; bit 31: the face holds a surface
    std::uint32_t emission = 0;  ///< shared exponent 9:9:9:5 (core/rgb9e5.h)
};

/// Words of a face's sums.
constexpr int faceWords(bool compareAndSwap, bool emission) {
    return compareAndSwap ? 4 : emission ? 16 : 10;
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

inline std::uint32_t packVoxel(const glm::ivec3& v) {
    const glm::uvec3 u(v);
    return u.x | (u.y << 10) | (u.z << 20);
}
inline glm::ivec3 unpackVoxel(std::uint32_t p) {
    return glm::ivec3(glm::uvec3(p & 1023u, (p >> 10) & 1023u, (p >> 20) & 1023u));
}

}  // namespace voxcone
