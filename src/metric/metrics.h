// How far a picture is from a reference. All means are over pixels and channels.
#pragma once

#include <map>
#include <string>

#include "metric/image.h"

namespace voxcone {

/// Errors of linear values, high dynamic range.
struct LinearError {
    double rmse = 0;          ///< root of the mean squared error
    double relMse = 0;        ///< mean((I−R)²/(R²+ε))
    double epsilon = 0;       ///< ε of relMse: 1 % of the mean squared reference
    double bias = 0;          ///< mean(I−R)
    double relativeBias = 0;  ///< bias over mean(R); 0 when both are 0
    double p99 = 0;           ///< 99th percentile of |I−R|: nearest rank
};

/// Errors of sRGB-encoded values in [0,1], as a display shows them.
struct DisplayError {
    double psnr = 0;   ///< dB, peak 1; infinite for equal pictures
    double ssim = 0;   ///< mean structural similarity, see ssimMap
    double grade = 0;  ///< 0 to 10: Y. ten Brug's, mean of 10·SSIM^1000, pixels black in both left out
    double flip = 0;   ///< mean ꟻLIP
};

/// Both pictures must have one size and number of channels (VOXCONE_CHECK; requireComparable tells the user).
LinearError linearError(const Image& reference, const Image& test);

/// Signed relative error of every pixel, one channel: mean over the channels of (I−R)/√(R²+ε), ε as in LinearError, so
/// that relMSE is the mean of the squares of one channel. Both pictures have one size and number of channels
/// (VOXCONE_CHECK).
Image relativeErrorMap(const Image& reference, const Image& test);

/// Pictures are linear display-referred with 1 or 3 channels; they are clipped to [0,1] and encoded here.
DisplayError displayError(const Image& reference, const Image& test);

/// The same by the names that `voxcone compare` prints: relmse, rmse, bias, relative_bias, p99; psnr, ssim, grade, flip.
std::map<std::string, double> metricsByName(const LinearError& error);
std::map<std::string, double> metricsByName(const DisplayError& error);

/// Structural similarity of every pixel and channel: Z. Wang, A. Bovik, H. Sheikh, E. Simoncelli 2004, eq. 13; 11×11
/// Gaussian window, σ 1.5, K1 0.01, K2 0.03, on values in [0,1] (not encoded here). The window's weights are
/// renormalised at borders.
Image ssimMap(const Image& reference, const Image& test);

/// Throws InputError that names `testName` and what differs when size or channels do, and one that names file, pixel
/// and channel for the first NaN or Inf in either picture.
void requireComparable(const Image& reference, const std::string& referenceName, const Image& test,
                       const std::string& testName);

}  // namespace voxcone
