// Whether a client still waits for its answer. Thread-safe.
#pragma once

#include <functional>
#include <mutex>

namespace clerestory {

class CancellationToken {
public:
    bool left() const {
        const std::lock_guard lock(mutex_);
        return left_;
    }

    // The client has closed its side.
    void leave() {
        const std::lock_guard lock(mutex_);
        if (left_) return;
        left_ = true;
        if (then_) then_();
    }

    // Calls `then` when the client leaves, at once if it has left; null takes that back. One at a
    // time. `then` must not come back here.
    void whenLeft(std::function<void()> then) {
        const std::lock_guard lock(mutex_);
        then_ = std::move(then);
        if (left_ && then_) then_();
    }

private:
    mutable std::mutex mutex_;
    bool left_ = false;
    std::function<void()> then_;
};

}  // namespace clerestory
