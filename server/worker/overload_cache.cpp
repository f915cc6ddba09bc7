#include "server/worker/overload_cache.h"

namespace clerestory {
namespace {

constexpr std::size_t kMaxClients = 1024;

}  // namespace

OverloadCache::Moment OverloadCache::begin() const {
    const std::lock_guard lock(mutex_);
    return moment_;
}

void OverloadCache::end(Moment begun, const std::string& client,
                        const std::optional<Problem>& problem, Clock::time_point now) {
    const bool refused = problem && problem->code == queueFull(1).code;
    const std::lock_guard lock(mutex_);
    if (!refused) {
        ++moment_;
        refusals_.clear();
    } else if (begun == moment_) {
        if (refusals_.size() >= kMaxClients) refusals_.clear();
        refusals_[client] = {*problem, now + kLifetime};
    }
}

std::optional<Problem> OverloadCache::refusalFor(const std::string& client,
                                                 Clock::time_point now) const {
    const std::lock_guard lock(mutex_);
    const auto found = refusals_.find(client);
    if (found == refusals_.end() || found->second.until <= now) return std::nullopt;
    return found->second.problem;
}

}  // namespace clerestory
