#include "core/atomic_file.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cstring>
#include <fstream>
#include <sstream>

#include "core/error.h"

namespace voxcone {

namespace fs = std::filesystem;

AtomicFile::AtomicFile(fs::path finalPath) : final_(std::move(finalPath)) {
    std::error_code error;
    if (final_.has_parent_path()) fs::create_directories(final_.parent_path(), error);
    if (error) throw InputError(final_.string(), "", "cannot create the folder: " + error.message());
    temporary_ = final_.parent_path() /
                 fmt::format(".{}.{}.part{}", final_.stem().string(), getpid(), final_.extension().string());
}

AtomicFile::~AtomicFile() {
    std::error_code ignored;
    if (!committed_) fs::remove(temporary_, ignored);
}

void AtomicFile::commit() {
    std::error_code error;
    fs::rename(temporary_, final_, error);
    if (error) throw InputError(final_.string(), "", "cannot write: " + error.message());
    committed_ = true;
}

void writeTextFile(const fs::path& path, std::string_view content) {
    AtomicFile file(path);
    {
        std::ofstream out(file.temporaryPath(), std::ios::binary);
        out.write(content.data(), static_cast<std::streamsize>(content.size()));
        out.flush();
        if (!out) throw InputError(path.string(), "", fmt::format("cannot write: {}", std::strerror(errno)));
    }
    file.commit();
}

std::string readTextFile(const fs::path& path) {
    if (fs::is_directory(path)) throw InputError(path.string(), "", "is a folder, not a file");
    std::ifstream in(path, std::ios::binary);
    if (!in) throw InputError(path.string(), "", fmt::format("cannot read: {}", std::strerror(errno)));
    std::ostringstream content;
    content << in.rdbuf();
    return std::move(content).str();
}

}  // namespace voxcone
