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

/// The node of `scene` that `object` has at "node": by its name, which no other may have, or by its index in the file.
/// Fails for any other.
int readNode(JsonObject& object, const Scene& scene);
/// What readNode() finds `node` by: its name, or its index in the file where that names none or several.
nlohmann::json nodeReference(const Scene& scene, int node);

/// The same for "light" and the lights of the glTF, which come first among those of `scene` and are counted in the
/// order of the nodes that carry them.
std::size_t readSceneLightIndex(JsonObject& object, const Scene& scene);
nlohmann::json sceneLightReference(const Scene& scene, std::size_t light);

/// Reads "objects": each puts a node of `scene` elsewhere by its translation, rotation and scale, or moves it by keys
/// of them, which become an animation. What the file itself animates there is dropped. Throws InputError of `file` for
/// anything wrong.
void readObjects(const nlohmann::json& objects, const std::string& file, Scene& scene);

}  // namespace voxcone
