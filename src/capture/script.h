// A capture script: scene, environment, lights, settings and shots, as JSON.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/settings.h"
#include "scene/scene.h"

namespace voxcone {

/// Names of the picture channels in the order of the documentation: beauty, direct, indirect_diffuse,
/// indirect_specular, transmission, ao, soft_shadow, emission, albedo, normal, depth, position, cascade, seam, and
/// voxel views. The last may be followed by bounce, face and level (core/voxel_channel.h): "voxel_opacity:+x:2".
const std::vector<std::string>& channelNames();

/// `channel` without what follows the first colon.
std::string baseChannel(const std::string& channel);

/// World space positions over time, both tracks with the same times or empty.
struct CameraPath {
    Track position, target;
    bool empty() const { return position.empty(); }
};

/// Frames of one camera. Frame n is the scene and the camera at `timeOf(n)`, whatever was rendered before it.
struct Shot {
    std::string name;
    Camera camera;                      ///< world space, or bound to a node of the scene
    CameraPath path;                    ///< where not empty: position and target of `camera`, whose `up` is as given
    std::vector<std::string> channels;  ///< at least one, all valid
    int firstFrame = 0, lastFrame = 0;  ///< numbers of the frames, as in the names of their files
    double fps = 24;                    ///< frames a second
    double start = 0;                   ///< seconds of frame 0
    bool temporal = false;              ///< measure the change from frame to frame

    int frameCount() const { return lastFrame - firstFrame + 1; }
    double timeOf(int frame) const { return start + frame / fps; }
};

/// The `up` of a camera that looks along `view` (unit), from the one that a script gives: what of it is perpendicular
/// to the view, unit. The two must not be parallel.
glm::dvec3 uprightOf(const glm::dvec3& up, const glm::dvec3& view);

/// Camera of `shot` at `time` seconds in world space; `up` is unit and perpendicular to the view where a path gives it.
Camera cameraAt(const Shot& shot, const Scene& scene, double time);

struct CaptureScript {
    Scene scene;  ///< loaded, with the script's lights, environment and motion added
    Settings settings;
    std::vector<Shot> shots;
};

/// Loads a script (.json), or a scene (.gltf, .glb) with one default shot: its first camera, or one that sees all of
/// it, and its lights, or a sun and sky when it has neither lights nor emitters. Every key is checked: unknown keys,
/// wrong types and values out of range are InputErrors with file and JSON path. `scene`, where not empty, is taken
/// instead of the one that a script names.
CaptureScript loadCaptureScript(const std::filesystem::path& file, const std::filesystem::path& scene = {});

}  // namespace voxcone
