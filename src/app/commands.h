// The subcommands: each file adds one to the command line.
#pragma once

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <functional>
#include <string>
#include <vector>

#include "capture/script.h"

namespace voxcone {

/// A subcommand and what it does once its options are parsed; `run` answers the exit status and throws core/error.h.
struct Command {
    CLI::App* parser = nullptr;
    std::string usage;  ///< one line, shown after a mistake
    std::function<int()> run;
};

Command captureCommand(CLI::App& app);
Command referenceCommand(CLI::App& app);
Command compareCommand(CLI::App& app);
Command infoCommand(CLI::App& app);
Command reportCommand(CLI::App& app);
Command tuneCommand(CLI::App& app);
Command viewCommand(CLI::App& app);

/// What `capture`, `reference` and `info` are given: a script or scene and changes to its settings.
struct ScriptOptions {
    std::string file;
    std::vector<std::string> assignments;

    /// Adds the positional argument and --set. The settings table goes to the end of --help.
    void addTo(CLI::App& parser, bool fileRequired);

    /// Reads the script, then applies the assignments in the order given.
    CaptureScript load() const;

    /// The same without the lights that settings extract.
    CaptureScript loadAsWritten() const;
};

}  // namespace voxcone
