// Errors as colours.
#pragma once

#include "metric/image.h"

namespace voxcone {

/// Colours of a one-channel image (VOXCONE_CHECK) for writePng: 0 is black, `full` and above the lightest of the
/// perceptually uniform map "magma" (S. van der Walt, N. Smith; public domain).
Image heatmap(const Image& values, double full = 1);

}  // namespace voxcone
