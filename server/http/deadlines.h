// Deadlines by id, in the order of time.
#pragma once

#include "server/base/clock.h"

#include <cstdint>
#include <optional>
#include <set>
#include <unordered_map>
#include <utility>

namespace clerestory {

class Deadlines {
public:
    using Id = std::uint64_t;

    void set(Id id, Clock::time_point time) {
        forget(id);
        times_[id] = time;
        order_.emplace(time, id);
    }

    // Sets the deadline unless the present one is earlier.
    void shorten(Id id, Clock::time_point time) {
        const auto found = times_.find(id);
        if (found == times_.end() || found->second > time) set(id, time);
    }

    void forget(Id id) {
        const auto found = times_.find(id);
        if (found == times_.end()) return;
        order_.erase({found->second, id});
        times_.erase(found);
    }

    std::optional<Id> due(Clock::time_point now) const {
        if (order_.empty() || order_.begin()->first > now) return std::nullopt;
        return order_.begin()->second;
    }

    const std::set<std::pair<Clock::time_point, Id>>& inOrder() const { return order_; }

private:
    std::unordered_map<Id, Clock::time_point> times_;
    std::set<std::pair<Clock::time_point, Id>> order_;
};

}  // namespace clerestory
