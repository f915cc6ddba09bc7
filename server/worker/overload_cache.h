// Remembers for a moment that the render queue of the worker was full, so that the server can
// refuse frames without asking the worker: under overload nearly all requests are refused, and the
// worker needs the processor. Thread-safe; does not block.
#pragma once

#include "server/base/call.h"
#include "server/base/clock.h"
#include "server/base/problem.h"

#include <mutex>
#include <optional>
#include <unordered_map>

namespace clerestory {

class OverloadCache {
public:
    // Frames that the worker finishes for its own use are noticed after this time.
    static constexpr std::chrono::milliseconds kLifetime{100};

    // Call begin() before a request that needs a place in the queue, and end() with its problem, if
    // there was one. A refusal is remembered until another request ends, and only if none ended
    // since its begin().
    using Moment = std::uint64_t;
    Moment begin() const;
    void end(Moment begun, const std::string& client, const std::optional<Problem>& problem,
             Clock::time_point now);

    // The problem with which the client would be refused; empty if that is not certain.
    std::optional<Problem> refusalFor(const std::string& client, Clock::time_point now) const;

private:
    struct Refusal {
        Problem problem;
        Clock::time_point until;
    };
    mutable std::mutex mutex_;
    Moment moment_ = 0;
    std::unordered_map<std::string, Refusal> refusals_;  // by client
};

}  // namespace clerestory
