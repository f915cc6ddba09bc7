// Requests that ended workers, by a fingerprint of what they ask. Thread-safe.
#pragma once

#include "server/base/call.h"

#include <mutex>
#include <unordered_map>

namespace clerestory {

// Equal for calls that ask for the same, whoever asks.
std::uint64_t fingerprintOf(const Call& call);

class Quarantine {
public:
    static constexpr std::chrono::minutes kLasts{10};
    static constexpr std::size_t kMax = 4096;  // remembered; then the oldest is forgotten

    void add(std::uint64_t fingerprint, Clock::time_point now);
    bool holds(std::uint64_t fingerprint, Clock::time_point now) const;

private:
    mutable std::mutex mutex_;
    std::unordered_map<std::uint64_t, Clock::time_point> until_;
};

}  // namespace clerestory
