#include "server/base/worker_pool.h"

#include <exception>

namespace clerestory {

void WorkerPool::finish() {
    {
        const std::lock_guard lock(mutex_);
        ending_ = true;
    }
    wake_.notify_all();
    for (std::thread& thread : threads_) thread.join();
    threads_.clear();
}

void WorkerPool::run(std::function<void()> work) {
    const std::lock_guard lock(mutex_);
    if (idle_ <= waiting_.size() && threads_.size() < maxThreads_) {
        try {
            threads_.emplace_back([this] { serve(); });
        } catch (const std::exception&) {
            if (threads_.empty()) throw;  // otherwise an existing thread runs it later
        }
    }
    waiting_.push_back(std::move(work));
    wake_.notify_one();
}

void WorkerPool::serve() {
    std::unique_lock lock(mutex_);
    for (;;) {
        ++idle_;
        wake_.wait(lock, [&] { return ending_ || !waiting_.empty(); });
        --idle_;
        if (waiting_.empty()) return;
        const std::function<void()> work = std::move(waiting_.front());
        waiting_.pop_front();
        lock.unlock();
        work();
        lock.lock();
    }
}

}  // namespace clerestory
