#include "server/render_queue.h"

#include "server/problem.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>

namespace clerestory {

RenderQueue::RenderQueue(const RendererOptions& options, std::size_t capacity)
    : capacity_(capacity),
      identity_(made_.get_future().share()),
      thread_([this, options] { serve(options); }) {}

RenderQueue::~RenderQueue() {
    {
        const std::lock_guard lock(mutex_);
        refusing_ = true;
        ending_ = true;
    }
    wake_.notify_all();
    thread_.join();
}

const RendererIdentity& RenderQueue::identity() const {
    return identity_.get();
}

void RenderQueue::post(std::function<void(Renderer&)> work) {
    {
        const std::lock_guard lock(mutex_);
        if (ending_) return;
        jobs_.push_back({.work = std::move(work), .counted = false});
    }
    wake_.notify_one();
}

void RenderQueue::push(Job job) {
    {
        const std::lock_guard lock(mutex_);
        if (refusing_) throw RequestError(shuttingDown());
        if (counted_ >= capacity_) throw RequestError(queueFull(retryAfterSeconds()));
        ++counted_;
        jobs_.push_back(std::move(job));
    }
    wake_.notify_one();
}

void RenderQueue::refuseNew() {
    std::unique_lock lock(mutex_);
    refusing_ = true;
    idle_.wait(lock, [&] { return counted_ == 0; });
}

void RenderQueue::refuseLate(std::chrono::duration<double> patience) {
    throw RequestError(overDeadline(patience.count()));
}

std::size_t RenderQueue::depth() const {
    const std::lock_guard lock(mutex_);
    return counted_;
}

// Until half of what waits is done. Called with the lock held.
int RenderQueue::retryAfterSeconds() const {
    const double seconds = 0.5 * meanSeconds_ * static_cast<double>(counted_);
    return static_cast<int>(std::clamp(std::ceil(seconds), 1.0, 60.0));
}

void RenderQueue::serve(const RendererOptions& options) {
    std::unique_ptr<Renderer> renderer;
    try {
        renderer = std::make_unique<Renderer>(options);
        made_.set_value(renderer->identity());
    } catch (...) {
        made_.set_exception(std::current_exception());
        return;
    }
    std::unique_lock lock(mutex_);
    for (;;) {
        wake_.wait(lock, [&] { return ending_ || !jobs_.empty(); });
        if (jobs_.empty()) return;
        Job job = std::move(jobs_.front());
        jobs_.pop_front();
        lock.unlock();
        const auto start = Clock::now();
        const bool inTime = start < job.deadline;
        if (inTime) {
            try {
                job.work(*renderer);
            } catch (const std::exception& error) {  // of post(); run() keeps its own
                spdlog::error("work on the OpenGL thread failed: {}", error.what());
            }
        }
        job.work = nullptr;  // frees what it holds before the lock is taken again
        const double seconds = millisecondsSince(start) / 1000.0;
        lock.lock();
        if (job.counted) {
            if (--counted_ == 0) idle_.notify_all();
            if (inTime) meanSeconds_ += 0.1 * (seconds - meanSeconds_);
        }
    }
}

}  // namespace clerestory
