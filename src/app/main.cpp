// The program: finds the subcommand, runs it, and turns every error into one line and an exit status.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <new>

#include "app/commands.h"
#include "core/atomic_file.h"
#include "core/error.h"
#include "core/log.h"

namespace {

using namespace voxcone;

int status(ExitCode code) {
    return static_cast<int>(code);
}

int run(int argc, char** argv) {
    CLI::App app("Lights a glTF scene by voxel cone tracing and says how wrong it is.", "voxcone");
    app.set_version_flag("--version", "voxcone " VOXCONE_VERSION);
    app.require_subcommand(1);
    app.footer(
        "Exit status: 0 done, 1 a comparison over its bound or nothing that meets one, 2 wrong usage, 3 bad input, 4 "
        "no usable device.\n"
        "Results go to standard output, messages to standard error. `voxcone COMMAND --help` says more.");
    const Command commands[] = {captureCommand(app), referenceCommand(app), compareCommand(app), infoCommand(app),
                                reportCommand(app), tuneCommand(app), viewCommand(app)};
    const auto chosen = [&]() -> const Command* {
        for (const Command& command : commands) {
            if (command.parser->parsed()) return &command;
        }
        return nullptr;
    };
    const auto usage = [&] {
        const Command* command = chosen();
        return command != nullptr ? command->usage
                                  : "voxcone capture|reference|compare|info|report|tune|view … (see voxcone --help)";
    };
    try {
        app.parse(argc, argv);
        return chosen()->run();
    } catch (const CLI::ParseError& error) {
        if (error.get_exit_code() == 0) return app.exit(error);  // --help, --version
        log::message("", error.what());
        log::message("usage: ", usage());
        return status(ExitCode::usage);
    } catch (const UsageError& error) {
        log::message("", error.what());
        log::message("usage: ", usage());
        return status(error.exitCode);
    } catch (const Error& error) {
        log::message("", error.what());
        return status(error.exitCode);
    }
}

}  // namespace

int main(int argc, char** argv) {
    removeTemporaryFilesOnSignals();
    try {
        return run(argc, argv);
    } catch (const std::bad_alloc&) {
        log::message("", "out of memory");
        return status(ExitCode::no_device);
    } catch (const std::exception& error) {
        log::message("bug: ", error.what());
        std::abort();
    }
}
