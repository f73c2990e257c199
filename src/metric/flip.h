// ꟻLIP: the difference between two pictures as a viewer sees it who flips between them. P. Andersson, J. Nilsson,
// T. Akenine-Möller, M. Oskarsson, K. Åström, M. D. Fairchild: "FLIP: A Difference Evaluator for Alternating Images",
// HPG 2020; and, for high dynamic range, P. Andersson, J. Nilsson, P. Shirley, T. Akenine-Möller: "Visualizing Errors
// in Rendered High Dynamic Range Images", Eurographics 2021. Written from the papers.
#pragma once

#include "metric/image.h"

namespace voxcone {

/// Pixels per degree of a 0.7 m wide display of 3840 pixels seen from 0.7 m, the papers' default.
constexpr double kFlipPixelsPerDegree = 67.0206432765823;

/// ꟻLIP error in [0,1] of every pixel, one channel. Both pictures are linear display-referred (values are clipped to
/// [0,1]) with 1 or 3 channels and of one size (VOXCONE_CHECK).
Image flip(const Image& reference, const Image& test, double pixelsPerDegree = kFlipPixelsPerDegree);

/// HDR-ꟻLIP: the largest ꟻLIP error over a range of exposures, each tone mapped.
struct HdrFlip {
    Image error;                                 ///< one channel, [0,1]
    double startExposure = 0, stopExposure = 0;  ///< stops: the range that the reference asks for
    int exposures = 0;
};

/// Both pictures are linear radiance with 1 or 3 channels and of one size; negative values count as 0.
HdrFlip hdrFlip(const Image& reference, const Image& test, double pixelsPerDegree = kFlipPixelsPerDegree);

/// Mean of all values.
double meanOf(const Image& image);

}  // namespace voxcone
