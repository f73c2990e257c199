// How much the indirect light of a picture changes from frame to frame where nothing in the scene does.
#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "metric/image.h"

namespace voxcone {

/// Linear channels of one frame, all of one size (VOXCONE_CHECK), 3 components; normals are zero on the background.
struct TemporalFrame {
    Image indirectDiffuse, albedo;
    Image position;             ///< world space, metres
    Image normal;               ///< unit, world space
    glm::dmat4 worldToClip{1};  ///< perspective of the frame's camera: w is the distance along the view, y points up
};

/// Change of the demodulated irradiance e = indirect diffuse / albedo from one frame to the next.
struct TemporalChange {
    double rms = 0;         ///< root of the mean of (e − warped e)², in the unit of e
    double meanChange = 0;  ///< mean of e − warped e
    double mean = 0;        ///< mean of the warped e
    double valid = 0;       ///< share of the pixels that were compared; when 0, so is all the rest

    /// How far the whole picture moved, relative to its brightness.
    double jump() const;
};

/// Compares `now` with `before` warped to it. A pixel's world position is projected into `before`, and the four pixels
/// around that place are averaged bilinearly. They must show the pixel's own surface: their normals are within 26
/// degrees (cosine 0.9) of its own, and they lie no farther from its tangent plane than the pixel is wide there. Pixels
/// of which this is not so, that were outside of the picture, or whose albedo is at most 0.02, are left out; the last
/// by component, also of the four. Surfaces that move by themselves are compared as if they stood still, or left out.
TemporalChange temporalChange(const TemporalFrame& before, const TemporalFrame& now);

/// The same without a warp: two pictures of the indirect diffuse light of the same surface points, pixel by pixel,
/// where `albedo` is above 0.02 by component.
TemporalChange changeInPlace(const Image& before, const Image& now, const Image& albedo);

/// Figures of a whole shot, over those of its changes that have valid pixels.
struct TemporalFigure {
    double f = 0;          ///< root of the mean of rms² over frames, over `mean`
    double worstJump = 0;  ///< largest jump
    double worstRms = 0;   ///< largest rms, over its frame's mean
    double mean = 0;       ///< mean irradiance over frames
    double valid = 0;      ///< mean share of valid pixels, over all changes
};

TemporalFigure temporalFigure(const std::vector<TemporalChange>& changes);

/// temporalChange() pixel by pixel.
struct ChangeMap {
    /// One channel: mean over the compared components of e − warped e, over `figures.mean`; 0 on the background, NaN on
    /// surfaces that could not be compared.
    Image change;
    TemporalChange figures;
};

/// A place in `before` within a thousandth of a pixel of a pixel's centre counts as that pixel alone, so that under a
/// camera that stands still every pixel is compared with itself.
ChangeMap changeMap(const TemporalFrame& before, const TemporalFrame& now);

/// One-channel `values` of the picture `before` on the surfaces of `now`: those of the nearest pixel. 0 on the
/// background, NaN where `before` did not show the surface. The two may differ in size; only their positions, normals
/// and matrices play a part.
Image carried(const Image& values, const TemporalFrame& before, const TemporalFrame& now);

}  // namespace voxcone
