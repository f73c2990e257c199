// Errors as colours.
#pragma once

#include "metric/image.h"

namespace voxcone {

/// Colours of a one-channel image (VOXCONE_CHECK) for writePng: 0 is black, `full` and above the lightest of the
/// perceptually uniform map "magma" (S. van der Walt, N. Smith; public domain).
Image heatmap(const Image& values, double full = 1);

/// Colours of a one-channel image (VOXCONE_CHECK) whose values have signs: 0 is black, `full` and above yellow by way
/// of red, −`full` and below cyan by way of blue, NaN (no value) grey.
Image signedHeatmap(const Image& values, double full = 1);

}  // namespace voxcone
