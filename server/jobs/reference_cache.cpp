#include "server/jobs/reference_cache.h"

#include <algorithm>

namespace clerestory {
namespace {

// 29 megabytes each at 1280 x 720.
constexpr std::size_t kMaxKept = 4;

}  // namespace

std::shared_ptr<const ReferenceRender> ReferenceCache::find(
    const std::string& key, const std::function<std::shared_ptr<const ReferenceRender>()>& trace) {
    {
        const std::lock_guard lock(mutex_);
        const auto found =
            std::find_if(kept_.begin(), kept_.end(), [&](const Kept& k) { return k.key == key; });
        if (found != kept_.end()) {
            kept_.splice(kept_.begin(), kept_, found);
            return kept_.front().truth;
        }
    }
    const std::shared_ptr<const ReferenceRender> truth = trace();
    if (!truth) return nullptr;
    const std::lock_guard lock(mutex_);
    kept_.push_front({key, truth});
    if (kept_.size() > kMaxKept) kept_.pop_back();
    return truth;
}

}  // namespace clerestory
