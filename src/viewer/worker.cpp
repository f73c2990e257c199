#include "viewer/worker.h"

#include <utility>

namespace voxcone {

Worker::Worker(std::function<void()> wake) : wake_(std::move(wake)) {
    thread_ = std::thread([this] { run(); });
}

Worker::~Worker() {
    {
        const std::scoped_lock lock(mutex_);
        quit_ = true;
    }
    changed_.notify_all();
    thread_.join();
}

void Worker::post(std::function<Result()> job) {
    {
        const std::scoped_lock lock(mutex_);
        jobs_.push_back(std::move(job));
    }
    changed_.notify_all();
}

std::size_t Worker::waiting() const {
    const std::scoped_lock lock(mutex_);
    return jobs_.size();
}

bool Worker::idle() const {
    const std::scoped_lock lock(mutex_);
    return jobs_.empty() && !busy_ && results_.empty();
}

void Worker::take() {
    std::vector<Result> results;
    {
        const std::scoped_lock lock(mutex_);
        if (failure_) std::rethrow_exception(failure_);
        results.swap(results_);
    }
    for (const Result& result : results) result();
}

void Worker::run() {
    for (;;) {
        std::function<Result()> job;
        {
            std::unique_lock lock(mutex_);
            changed_.wait(lock, [&] { return quit_ || !jobs_.empty(); });
            if (quit_) return;
            job = std::move(jobs_.front());
            jobs_.pop_front();
            busy_ = true;
        }
        Result result;
        std::exception_ptr failure;
        try {
            result = job();
        } catch (...) {
            failure = std::current_exception();
        }
        {
            const std::scoped_lock lock(mutex_);
            if (result) results_.push_back(std::move(result));
            if (failure) failure_ = failure;
            busy_ = false;
        }
        wake_();
    }
}

}  // namespace voxcone
