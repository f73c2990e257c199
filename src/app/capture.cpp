// voxcone capture: scripted pictures without a display.
#include "capture/capture.h"

#include <cstdio>
#include <memory>

#include "app/commands.h"
#include "gl/context.h"

namespace voxcone {

Command captureCommand(CLI::App& app) {
    struct Options : ScriptOptions {
        std::string out;
    };
    const auto options = std::make_shared<Options>();
    CLI::App* parser = app.add_subcommand("capture", "Render the shots of a script by voxel cone tracing, headless");
    options->addTo(*parser, true);
    parser->add_option("--out", options->out, "folder for <shot>/<channel>.<frame>.exr and .png and <shot>/stats.json")
        ->type_name("DIR")
        ->required();
    return {parser, "voxcone capture SCRIPT.json|SCENE.gltf --out DIR [--set KEY=VALUE]…", [options] {
#ifdef NDEBUG
                constexpr bool kDebug = false;
#else
                constexpr bool kDebug = true;
#endif
                const CaptureScript script = options->load();
                const auto context = gl::Context::createHeadless(kDebug);
                for (const auto& file : runCapture(script, *context, options->out)) std::puts(file.c_str());
                return 0;
            }};
}

}  // namespace voxcone
