#include "server/jobs/truths.h"

#include <algorithm>

namespace clerestory {
namespace {

// 29 megabytes each at 1280 x 720.
constexpr std::size_t kMostKept = 4;

}  // namespace

std::shared_ptr<const Truth> Truths::find(
    const std::string& key, const std::function<std::shared_ptr<const Truth>()>& trace) {
    {
        const std::lock_guard lock(mutex_);
        const auto found =
            std::find_if(kept_.begin(), kept_.end(), [&](const Kept& k) { return k.key == key; });
        if (found != kept_.end()) {
            kept_.splice(kept_.begin(), kept_, found);
            return kept_.front().truth;
        }
    }
    const std::shared_ptr<const Truth> truth = trace();
    if (!truth) return nullptr;
    const std::lock_guard lock(mutex_);
    kept_.push_front({key, truth});
    if (kept_.size() > kMostKept) kept_.pop_back();
    return truth;
}

}  // namespace clerestory
