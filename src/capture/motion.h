// What a script moves: keys over time for cameras, lights and nodes of the scene.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "capture/script.h"
#include "capture/strict_json.h"

namespace voxcone {

/// Reads "path" (keys with time, position and target) and "interpolation" of a camera.
CameraPath readCameraPath(JsonObject& camera);

/// Reads "path" and "interpolation" of a light: keys of intensity and, where its type has them, position and direction.
LightTrack readLightPath(JsonObject& light, bool hasPosition, bool hasDirection);

/// Reads "objects": each gives a node of `scene` keys for its translation, rotation and scale, which become an
/// animation. What the file itself animates there is dropped. Throws InputError of `file` for anything wrong.
void readObjects(const nlohmann::json& objects, const std::string& file, Scene& scene);

}  // namespace voxcone
