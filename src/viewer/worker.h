// Arithmetic on pictures beside the window, which answers meanwhile.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace voxcone {

/// Does jobs one after another on a thread of its own.
class Worker {
  public:
    using Result = std::function<void()>;

    /// `wake` is called from the worker's thread whenever a job has ended.
    explicit Worker(std::function<void()> wake);
    /// Waits for the job that is under way; the others are forgotten.
    ~Worker();
    Worker(const Worker&) = delete;
    Worker& operator=(const Worker&) = delete;

    /// What `job` answers is run by take().
    void post(std::function<Result()> job);
    /// Jobs that have not begun yet.
    std::size_t waiting() const;
    /// All jobs have ended, and their results were taken.
    bool idle() const;
    /// Runs the results on the thread that calls it. Throws what a job has thrown.
    void take();

  private:
    void run();

    std::function<void()> wake_;
    mutable std::mutex mutex_;
    std::condition_variable changed_;
    bool quit_ = false, busy_ = false;
    std::deque<std::function<Result()>> jobs_;
    std::vector<Result> results_;
    std::exception_ptr failure_;
    std::thread thread_;
};

}  // namespace voxcone
