// A capture script: scene, environment, lights, settings and shots, as JSON.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/settings.h"
#include "scene/scene.h"

namespace voxcone {

/// Names of the picture channels in the order of the documentation: beauty, direct, indirect_diffuse,
/// indirect_specular, ao, soft_shadow, emission, albedo, normal, depth, position, and voxel views.
const std::vector<std::string>& channelNames();

struct Shot {
    std::string name;
    Camera camera;                      ///< world space, or bound to a node of the scene
    std::vector<std::string> channels;  ///< at least one, all valid
    int frames = 1;
};

struct CaptureScript {
    Scene scene;  ///< loaded, with the script's lights and environment added
    Settings settings;
    std::vector<Shot> shots;
};

/// Loads a script (.json), or a scene (.gltf, .glb) with one default shot: its first camera, or one that sees all of
/// it, and its lights, or a sun and sky when it has neither lights nor emitters. Every key is checked: unknown keys,
/// wrong types and values out of range are InputErrors with file and JSON path.
CaptureScript loadCaptureScript(const std::filesystem::path& file);

}  // namespace voxcone
