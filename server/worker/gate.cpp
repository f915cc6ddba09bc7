#include "server/worker/gate.h"

namespace clerestory {

Gate::Entry Gate::enter() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return !alone_ && wantAlone_ == 0; });
    ++inside_;
    return {*this, false};
}

Gate::Entry Gate::enterAlone() {
    std::unique_lock lock(mutex_);
    ++wantAlone_;
    changed_.wait(lock, [&] { return !alone_ && inside_ == 0; });
    --wantAlone_;
    alone_ = true;
    return {*this, true};
}

void Gate::leave(bool alone) {
    {
        const std::lock_guard lock(mutex_);
        if (alone) {
            alone_ = false;
        } else {
            --inside_;
        }
    }
    changed_.notify_all();
}

}  // namespace clerestory
