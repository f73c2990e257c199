// Small bright sources as analytic lights: cones are wider than they are, so they would be blurred, missed from some
// pixels and found from others. What becomes a light no longer reaches cones, so that nothing is counted twice.
//
// The scene keeps its panorama and its meshes, which the camera sees and the path tracer samples. Added are lights with
// Light::extracted, Environment::residual and Material::extracted: whatever comes straight from what was extracted is
// direct light, in both renderers.
#pragma once

#include "core/settings.h"
#include "scene/scene.h"

namespace voxcone {

/// Turns at most `most` parts of the panorama, those with most irradiance, into directional lights with an angular
/// radius. A part is what surrounds a texel far brighter than the mean, down to a sixteenth of it, over the level of
/// the texels around; parts wider than cones, or with hardly any of the light, stay in the sky. No light is gained or
/// lost: fluence is that of before in every channel, and so is irradiance on planes that see a part as a whole, but for
/// parts whose channels come from different directions.
void extractEnvironment(Scene& scene, int most);

/// Turns emitting meshes that are made of at most six rectangles into rectangle lights, the brightest first, as long as
/// there are at most `most` of them: opaque ones of one colour whose every rectangle is small next to the scene and
/// that nothing deforms. Sheets that shine to both sides have two lights each.
void extractEmitters(Scene& scene, int most);

/// Both, as the settings say. For a scene from which nothing has been extracted yet.
void extractLights(Scene& scene, const Settings::Light& settings);

}  // namespace voxcone
