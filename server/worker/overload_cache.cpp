#include "server/worker/overload_cache.h"

#include <algorithm>

namespace clerestory {
namespace {

constexpr std::size_t kMaxClients = 1024;

int retryAfter(const Answer& answer) {
    for (const auto& [name, value] : answer.headers) {
        if (name == "Retry-After") return std::max(1, std::atoi(value.c_str()));
    }
    return 1;
}

}  // namespace

OverloadCache::Moment OverloadCache::begin() const {
    const std::lock_guard lock(mutex_);
    return moment_;
}

void OverloadCache::end(Moment begun, const std::string& client, const Answer& answer,
                        Clock::time_point now) {
    const bool refused = answer.problem == queueFull(1).code;
    const std::lock_guard lock(mutex_);
    if (!refused) {
        ++moment_;
        refused_.clear();
    } else if (begun == moment_) {
        if (refused_.size() >= kMaxClients) refused_.clear();
        refused_[client] = {retryAfter(answer), now + kLasts};
    }
}

std::optional<Problem> OverloadCache::refusalFor(const std::string& client,
                                                 Clock::time_point now) const {
    const std::lock_guard lock(mutex_);
    const auto found = refused_.find(client);
    if (found == refused_.end() || found->second.until <= now) return std::nullopt;
    return queueFull(found->second.retryAfterSeconds);
}

}  // namespace clerestory
