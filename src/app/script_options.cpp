#include "app/commands.h"
#include "core/settings.h"
#include "scene/extract.h"

namespace voxcone {

void ScriptOptions::addTo(CLI::App& parser, bool fileRequired) {
    parser.add_option("file", file, "capture script (.json) or scene (.gltf, .glb)")
        ->type_name("SCRIPT.json|SCENE.gltf")
        ->required(fileRequired);
    parser
        .add_option("--set", assignments,
                    "change a setting of the script, e.g. --set voxel.resolution=64; may be repeated; "
                    "preset=NAME or preset=FILE.json sets many")
        ->type_name("KEY=VALUE")
        ->allow_extra_args(false);
    parser.footer("Settings, with default and range (presets: thesis, fast, balanced, accurate):\n" +
                  describeSettings());
}

CaptureScript ScriptOptions::load() const {
    CaptureScript script = loadAsWritten();
    extractLights(script.scene, script.settings.light);
    return script;
}

CaptureScript ScriptOptions::loadAsWritten() const {
    Settings probe;  // a wrong assignment is told before a large scene is read
    for (const std::string& assignment : assignments) applyAssignment(probe, assignment);
    CaptureScript script = loadCaptureScript(file);
    for (const std::string& assignment : assignments) applyAssignment(script.settings, assignment);
    return script;
}

}  // namespace voxcone
