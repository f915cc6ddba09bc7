// Tells the work on a request that its client no longer waits for the answer. Thread-safe.
#pragma once

#include <functional>
#include <mutex>

namespace clerestory {

class CancellationToken {
public:
    bool cancelled() const {
        const std::lock_guard lock(mutex_);
        return cancelled_;
    }

    // Calls the callback, if one is set. Only the first call has an effect.
    void cancel() {
        const std::lock_guard lock(mutex_);
        if (cancelled_) return;
        cancelled_ = true;
        if (callback_) callback_();
    }

    // Replaces the callback for cancel(); null removes it. Calls it at once if the token is
    // cancelled already. The callback must not use this token.
    void onCancel(std::function<void()> callback) {
        const std::lock_guard lock(mutex_);
        callback_ = std::move(callback);
        if (cancelled_ && callback_) callback_();
    }

private:
    mutable std::mutex mutex_;
    bool cancelled_ = false;
    std::function<void()> callback_;
};

}  // namespace clerestory
