// Files appear whole or not at all.
#include "core/atomic_file.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <fstream>

#include "core/error.h"

namespace voxcone {
namespace {

namespace fs = std::filesystem;

class AtomicFiles : public testing::Test {
  protected:
    AtomicFiles() { fs::create_directories(folder_); }
    ~AtomicFiles() override { fs::remove_all(folder_); }
    fs::path folder_ = fs::temp_directory_path() / ("voxcone_atomic_" + std::to_string(getpid()));
};

TEST_F(AtomicFiles, CommitPutsTheWholeFileInPlace) {
    const fs::path file = folder_ / "new" / "a.txt";
    {
        AtomicFile atomic(file);
        EXPECT_EQ(atomic.temporaryPath().extension(), ".txt");
        std::ofstream(atomic.temporaryPath()) << "whole";
        EXPECT_FALSE(fs::exists(file));
        atomic.commit();
    }
    EXPECT_EQ(readTextFile(file), "whole");
    EXPECT_EQ(std::distance(fs::directory_iterator(folder_ / "new"), {}), 1);
}

TEST_F(AtomicFiles, WithoutCommitTheOldFileStays) {
    writeTextFile(folder_ / "a.txt", "old");
    {
        AtomicFile atomic(folder_ / "a.txt");
        std::ofstream(atomic.temporaryPath()) << "half";
    }
    EXPECT_EQ(readTextFile(folder_ / "a.txt"), "old");
    EXPECT_EQ(std::distance(fs::directory_iterator(folder_), {}), 1);
}

TEST_F(AtomicFiles, SignalsRemoveWhatIsHalfWritten) {
    for (const int signal : {SIGINT, SIGTERM}) {
        const pid_t child = fork();
        ASSERT_GE(child, 0);
        if (child == 0) {
            removeTemporaryFilesOnSignals();
            const AtomicFile first(folder_ / "a.txt"), second(folder_ / "b.txt");
            std::ofstream(first.temporaryPath()) << "half";
            std::ofstream(second.temporaryPath()) << "half";
            std::raise(signal);
            _exit(0);
        }
        int status = 0;
        ASSERT_EQ(waitpid(child, &status, 0), child);
        EXPECT_TRUE(WIFEXITED(status));
        EXPECT_EQ(WEXITSTATUS(status), 128 + signal);
        EXPECT_TRUE(fs::is_empty(folder_));
    }
}

TEST_F(AtomicFiles, FoldersAndAbsentFilesAreNamed) {
    EXPECT_THROW(readTextFile(folder_), InputError);
    EXPECT_THROW(readTextFile(folder_ / "absent"), InputError);
    writeTextFile(folder_ / "file", "");
    EXPECT_THROW(writeTextFile(folder_ / "file" / "a.txt", ""), InputError);
}

}  // namespace
}  // namespace voxcone
