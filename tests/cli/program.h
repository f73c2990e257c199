// Runs the built program the way a user does.
#pragma once

#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

namespace voxcone {

/// What a run left behind.
struct Outcome {
    int status = -1;  ///< exit status; 128 + signal when it was killed
    std::string out, err;
};

inline std::string contentOf(const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    std::ostringstream text;
    text << in.rdbuf();
    return text.str();
}

/// A folder of its own for every test, removed afterwards.
class TemporaryFolder {
  public:
    TemporaryFolder() {
        std::string name = (std::filesystem::temp_directory_path() / "voxcone_cli_XXXXXX").string();
        path_ = mkdtemp(name.data());
    }
    ~TemporaryFolder() { std::filesystem::remove_all(path_); }
    TemporaryFolder(const TemporaryFolder&) = delete;
    TemporaryFolder& operator=(const TemporaryFolder&) = delete;
    const std::filesystem::path& path() const { return path_; }

  private:
    std::filesystem::path path_;
};

/// Runs `voxcone` with `arguments` (none may hold a quote); `environment` is put before it, e.g. "A=b".
inline Outcome voxcone(const std::vector<std::string>& arguments, const std::string& environment = "") {
    const TemporaryFolder folder;
    std::string line = environment + " '" VOXCONE_PROGRAM "'";
    for (const std::string& argument : arguments) line += " '" + argument + "'";
    line += " >'" + (folder.path() / "out").string() + "' 2>'" + (folder.path() / "err").string() + "' </dev/null";
    const int status = std::system(line.c_str());
    Outcome outcome;
    outcome.status = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    outcome.out = contentOf(folder.path() / "out");
    outcome.err = contentOf(folder.path() / "err");
    return outcome;
}

}  // namespace voxcone
