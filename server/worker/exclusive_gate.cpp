#include "server/worker/exclusive_gate.h"

namespace clerestory {

ExclusiveGate::Entry ExclusiveGate::enter() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return !alone_ && waitingAlone_ == 0; });
    ++inside_;
    return {*this, false};
}

ExclusiveGate::Entry ExclusiveGate::enterAlone() {
    std::unique_lock lock(mutex_);
    ++waitingAlone_;
    changed_.wait(lock, [&] { return !alone_ && inside_ == 0; });
    --waitingAlone_;
    alone_ = true;
    return {*this, true};
}

void ExclusiveGate::leave(bool alone) {
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
