// Requests that crashed workers, by fingerprint. Thread-safe.
#pragma once

#include "server/worker/call_wire.h"

#include <mutex>
#include <unordered_map>

namespace clerestory {

// Equal for requests with equal content, from any client.
std::uint64_t fingerprintOf(const WorkerRequest& request);

class Quarantine {
public:
    static constexpr std::chrono::minutes kLifetime{10};
    static constexpr std::size_t kMax = 4096;  // then the oldest entry is removed

    void add(std::uint64_t fingerprint, Clock::time_point now);
    bool contains(std::uint64_t fingerprint, Clock::time_point now) const;

private:
    mutable std::mutex mutex_;
    std::unordered_map<std::uint64_t, Clock::time_point> until_;
};

}  // namespace clerestory
