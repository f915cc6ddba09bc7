// Threads that carry requests through. They come as they are needed and stay.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace clerestory {

class WorkerPool {
public:
    explicit WorkerPool(std::size_t most) : most_(most) { threads_.reserve(most); }
    ~WorkerPool();  // finishes what was given
    WorkerPool(const WorkerPool&) = delete;
    WorkerPool& operator=(const WorkerPool&) = delete;

    // `work` must not throw. Throws when there is no thread and none can be made, and for want of
    // memory; then `work` is not done.
    void run(std::function<void()> work);

private:
    void serve();

    const std::size_t most_;
    std::mutex mutex_;
    std::condition_variable wake_;
    std::deque<std::function<void()>> waiting_;
    std::size_t idle_ = 0;
    bool ending_ = false;
    std::vector<std::thread> threads_;
};

}  // namespace clerestory
