// Sums of the faces of new voxels (integer_sum). Needs the defines COMPARE_AND_SWAP, EMISSION and LEAVES.
//
// Fixed point with kUnit for a weight of 1, weighted by projected coverage.
//   0 coverage, 1-3 albedo, 4-6 normal (biased to n + 1), 7-9 position in the voxel (0 to 1),
//   10 weight, 11-13 normal and 14-16 position, weighted by planeWeight() as well,
//   17-22 emission as three 64-bit sums, low and high word (only with EMISSION),
//   last two (only with LEAVES): coverage of leaves, and their optical depth in steps of 1/kDepthUnit
// The running mean of compare_and_swap keeps four words a face: albedo, normal, position, emission as 8-bit RGB and a count.

#if COMPARE_AND_SWAP
const int kFaceWords = 4;
#else
const int kFaceWords = 17 + 6 * EMISSION + 2 * LEAVES;
#endif
// Lengths of mean normals: below the first a face holds surfaces that look different ways; above the other it may pass for
// one. A rest of it below kRest is nothing.
const float kMixed = 0.97, kPure = 0.95, kRest = 0.1, kFlat = 0.05;
const int kPlaneWord = 10, kEmissionWord = 17;
const int kLeafWord = kFaceWords - 2;
const int kRecordWords = 6 * kFaceWords;

// 2^15: 106,496 full coverages fit below the saturation bound, and a weight is stored with an error of at most 3e-5.
const float kUnit = 32768.0;
const uint kSaturated = 0xd0000000u;
// Depths are at most 1.6 times the coverage, and must not wrap before it is full.
const float kDepthUnit = 16384.0;

/// What a face's plane weighs a surface by, over its coverage, for the component `n` of its normal along the face's axis. Of
/// two walls that meet in a voxel each looks along some axis more than the other, and is nearly alone in that face's plane.
/// 1,664 full coverages fit below the saturation bound.
float planeWeight(float n) {
    n *= n, n *= n;
    return 64.0 * max(n * n, 1.0 / 256.0);
}
