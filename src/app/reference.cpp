// voxcone reference: the same shots, path traced.
#include <fmt/format.h>

#include <cstdio>
#include <memory>

#include "app/commands.h"
#include "capture/reference.h"

namespace voxcone {

Command referenceCommand(CLI::App& app) {
    struct Options : ScriptOptions {
        std::string out, samples, error;
    };
    const auto options = std::make_shared<Options>();
    CLI::App* parser =
        app.add_subcommand("reference", "Path trace the shots of a script: the truth that captures are compared with");
    options->addTo(*parser, true);
    parser->add_option("--out", options->out, "folder for <shot>/<channel>.<frame>.exr and .png and <shot>/stats.json")
        ->type_name("DIR")
        ->required();
    parser->add_option("--spp", options->samples, "paths a pixel, short for --set reference.samples=N")->type_name("N");
    parser
        ->add_option("--error", options->error,
                     "stop when the reference's own relative error is below E, short for --set reference.error=E")
        ->type_name("E");
    return {parser, "voxcone reference SCRIPT.json|SCENE.gltf --out DIR [--spp N] [--error E] [--set KEY=VALUE]…",
            [options] {
                if (!options->samples.empty()) options->assignments.push_back("reference.samples=" + options->samples);
                if (!options->error.empty()) options->assignments.push_back("reference.error=" + options->error);
                for (const auto& file : runReference(options->load(), options->out)) std::puts(file.c_str());
                return 0;
            }};
}

}  // namespace voxcone
