// The records of occupied voxels. Twin of src/voxelize/records.h.
//
// Faces of a voxel: 0 +x, 1 -x, 2 +y, 3 -y, 4 +z, 5 -z, named by the side that the surface looks to.
//
// Sums, while voxelizing (integer_sum): fixed point with kUnit for a weight of 1, all weighted by projected coverage.
//   0 coverage, 1-3 albedo, 4-6 normal (biased to n + 1), 7-9 position in the voxel (0 to 1),
//   10-15 emission as three 64-bit sums, low and high word (only with EMISSION)
// The running mean of compare_and_swap keeps four words a face: albedo, normal, position, emission as 8-bit RGB and a count.

#if COMPARE_AND_SWAP
const int kFaceWords = 4;
#elif EMISSION
const int kFaceWords = 16;
#else
const int kFaceWords = 10;
#endif
const int kRecordWords = 6 * kFaceWords;

// 2^15: 106,496 full coverages fit below the saturation bound, and a weight is stored with an error of at most 3e-5.
const float kUnit = 32768.0;
const uint kSaturated = 0xd0000000u;

/// A face of a resolved voxel.
struct FaceRecord {
    uint albedo;    // unorm 11:11:10
    uint normal;    // octahedral, snorm 16:16
    uint position;  // place in the voxel, unorm 10:10:10; bit 31: the face holds a surface
    uint emission;  // shared exponent 9:9:9:5
};

uint packAlbedo(vec3 a) {
    uvec3 q = uvec3(clamp(a, 0.0, 1.0) * vec3(2047.0, 2047.0, 1023.0) + 0.5);
    return q.x | (q.y << 11) | (q.z << 22);
}
vec3 unpackAlbedo(uint p) { return vec3(p & 2047u, (p >> 11) & 2047u, p >> 22) / vec3(2047.0, 2047.0, 1023.0); }

uint packPosition(vec3 p) {
    uvec3 q = uvec3(clamp(p, 0.0, 1.0) * 1023.0 + 0.5);
    return q.x | (q.y << 10) | (q.z << 20) | 0x80000000u;
}
vec3 unpackPosition(uint p) { return vec3(p & 1023u, (p >> 10) & 1023u, (p >> 20) & 1023u) / 1023.0; }
bool faceHoldsSurface(FaceRecord face) { return (face.position & 0x80000000u) != 0u; }

uint packVoxel(ivec3 v) { return uint(v.x) | (uint(v.y) << 10) | (uint(v.z) << 20); }
ivec3 unpackVoxel(uint p) { return ivec3(p & 1023u, (p >> 10) & 1023u, (p >> 20) & 1023u); }
