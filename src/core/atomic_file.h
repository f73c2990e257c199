// Files appear under their final name whole or not at all.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace voxcone {

/// A temporary file beside `finalPath` that `commit` renames to it; without commit the destructor removes it.
class AtomicFile {
  public:
    /// Creates missing parent folders. The temporary name keeps the final extension, which image writers go by.
    explicit AtomicFile(std::filesystem::path finalPath);
    ~AtomicFile();
    AtomicFile(const AtomicFile&) = delete;
    AtomicFile& operator=(const AtomicFile&) = delete;

    const std::filesystem::path& temporaryPath() const { return temporary_; }
    void commit();

  private:
    std::filesystem::path final_, temporary_;
    bool committed_ = false;
    std::size_t slot_ = 0;  ///< where the signal handler finds the temporary name
};

/// An empty file that is there as long as this object. One that is found later was left by a program that crashed or
/// was killed: removeTemporaryFilesOnSignals() holds for it as well.
class Marker {
  public:
    /// Creates missing parent folders. Throws InputError when the file cannot be written.
    explicit Marker(const std::filesystem::path& path);
    ~Marker();
    Marker(const Marker&) = delete;
    Marker& operator=(const Marker&) = delete;

  private:
    std::filesystem::path path_;
    std::size_t slot_ = 0;
};

/// From now on SIGINT, SIGTERM and SIGHUP remove all temporary files and end the process with status 128 + signal.
void removeTemporaryFilesOnSignals();

/// Writes `content` whole. Throws InputError that names the file when it cannot.
void writeTextFile(const std::filesystem::path& path, std::string_view content);

/// Reads a whole file. Throws InputError that names the file when it cannot.
std::string readTextFile(const std::filesystem::path& path);

}  // namespace voxcone
