#include "core/atomic_file.h"

#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <sstream>

#include "core/error.h"

namespace voxcone {

namespace fs = std::filesystem;

namespace {

// Names of the temporary files that exist, for the signal handler: it may neither allocate nor lock.
constexpr std::size_t kSlots = 64;
std::array<std::atomic<char*>, kSlots> temporaryNames{};
static_assert(std::atomic<char*>::is_always_lock_free);

/// Keeps a copy of `name`; answers kSlots when the table is full.
std::size_t remember(const std::string& name) {
    char* copy = ::strdup(name.c_str());
    for (std::size_t i = 0; copy != nullptr && i < kSlots; ++i) {
        char* empty = nullptr;
        if (temporaryNames[i].compare_exchange_strong(empty, copy)) return i;
    }
    std::free(copy);
    return kSlots;
}

void forget(std::size_t slot) {
    if (slot < kSlots) std::free(temporaryNames[slot].exchange(nullptr));
}

extern "C" void removeAndExit(int signal) {
    for (auto& slot : temporaryNames) {
        if (const char* name = slot.exchange(nullptr)) ::unlink(name);  // taken, so that nobody frees it
    }
    ::_exit(128 + signal);
}

}  // namespace

void removeTemporaryFilesOnSignals() {
    for (const int signal : {SIGINT, SIGTERM, SIGHUP}) std::signal(signal, removeAndExit);
}

AtomicFile::AtomicFile(fs::path finalPath) : final_(std::move(finalPath)) {
    std::error_code error;
    if (final_.has_parent_path()) fs::create_directories(final_.parent_path(), error);
    if (error) throw InputError(final_.string(), "", "cannot create the folder: " + error.message());
    temporary_ = final_.parent_path() /
                 fmt::format(".{}.{}.part{}", final_.stem().string(), getpid(), final_.extension().string());
    slot_ = remember(temporary_.string());
}

AtomicFile::~AtomicFile() {
    std::error_code ignored;
    if (!committed_) fs::remove(temporary_, ignored);
    forget(slot_);
}

void AtomicFile::commit() {
    std::error_code error;
    fs::rename(temporary_, final_, error);
    if (error) throw InputError(final_.string(), "", "cannot write: " + error.message());
    committed_ = true;
}

Marker::Marker(const fs::path& path) : path_(path) {
    std::error_code error;
    if (path_.has_parent_path()) fs::create_directories(path_.parent_path(), error);
    slot_ = remember(path_.string());
    if (!std::ofstream(path_))
        throw InputError(path_.string(), "", fmt::format("cannot write: {}", std::strerror(errno)));
}

Marker::~Marker() {
    std::error_code ignored;
    fs::remove(path_, ignored);
    forget(slot_);
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
