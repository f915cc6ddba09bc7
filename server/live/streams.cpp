#include "server/live/streams.h"

#include "server/base/problem.h"

namespace clerestory {

std::shared_ptr<void> Streams::take() {
    {
        const std::lock_guard lock(count_->mutex);
        if (count_->taken == most_) throw RequestError(streamsFull());
        ++count_->taken;
    }
    return {nullptr, [count = count_](void*) {
                const std::lock_guard lock(count->mutex);
                --count->taken;
            }};
}

}  // namespace clerestory
