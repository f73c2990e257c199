// Errors a user can cause. Bugs of ours are asserts (core/check.h), never these.
#pragma once

#include <stdexcept>
#include <string>

namespace voxcone {

/// Exit status of the program, one for each kind of outcome.
enum class ExitCode : int { done = 0, over_bound = 1, usage = 2, bad_input = 3, no_device = 4 };

/// Base of every error whose message is one line meant for the user.
class Error : public std::runtime_error {
  public:
    Error(ExitCode code, const std::string& line) : std::runtime_error(line), exitCode(code) {}
    ExitCode exitCode;
};

/// A file that cannot be used. `where` is a line number, a JSON path such as `meshes[0].primitives[1].indices`, or
/// empty. The message reads "FILE: WHERE: REASON".
class InputError : public Error {
  public:
    InputError(const std::string& file, const std::string& where, const std::string& reason)
        : Error(ExitCode::bad_input, file + ": " + (where.empty() ? "" : where + ": ") + reason) {}
};

/// Wrong command line or setting; the message says the right usage.
class UsageError : public Error {
  public:
    explicit UsageError(const std::string& line) : Error(ExitCode::usage, line) {}
};

/// No OpenGL context, or one whose limits are too small; the message says what was tried.
class DeviceError : public Error {
  public:
    explicit DeviceError(const std::string& line) : Error(ExitCode::no_device, line) {}
};

}  // namespace voxcone
