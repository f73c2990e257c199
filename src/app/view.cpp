// voxcone view: the window.
#include <cstdlib>
#include <memory>

#include "app/commands.h"
#include "viewer/viewer.h"

namespace voxcone {

namespace {

/// Where a desktop keeps what programs remember; empty when it says nowhere.
std::filesystem::path configFolder() {
    const char* config = std::getenv("XDG_CONFIG_HOME");
    if (config && *config) return std::filesystem::path(config) / "voxcone";
    const char* home = std::getenv("HOME");
    if (home && *home) return std::filesystem::path(home) / ".config" / "voxcone";
    return {};
}

}  // namespace

Command viewCommand(CLI::App& app) {
    struct Options : ScriptOptions {
        std::string out = ".", shaders;
    };
    const auto options = std::make_shared<Options>();
    CLI::App* parser = app.add_subcommand("view", "Look at a scene or the shots of a script in a window");
    options->addTo(*parser, false);
    parser->add_option("--out", options->out, "folder for screenshots and scripts")->type_name("DIR");
    parser
        ->add_option("--shaders", options->shaders,
                     "a copy of shaders/: read instead of the program's own, and again whenever a file of it changes")
        ->type_name("DIR");
    return {parser, "voxcone view [SCRIPT.json|SCENE.gltf] [--out DIR] [--shaders DIR] [--set KEY=VALUE]…", [options] {
#ifdef NDEBUG
                constexpr bool kDebug = false;
#else
                constexpr bool kDebug = true;
#endif
                Settings probe;  // a wrong assignment is told before a window is opened
                for (const std::string& assignment : options->assignments) applyAssignment(probe, assignment);
                ViewerOptions viewer;
                viewer.file = options->file;
                viewer.prepare = [options](Settings& settings) {
                    for (const std::string& assignment : options->assignments) applyAssignment(settings, assignment);
                };
                viewer.folders = {options->out, configFolder()};
                viewer.shaders = options->shaders;
                viewer.debug = kDebug;
                Viewer(viewer).run();
                return 0;
            }};
}

}  // namespace voxcone
