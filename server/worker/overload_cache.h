// What the line before a renderer in another process would say to whom it has just refused, without
// asking it: under overload nearly all requests are refused, and the renderer needs the processor.
// Thread-safe; waits for nobody.
#pragma once

#include "server/base/call.h"
#include "server/base/problem.h"

#include <mutex>
#include <optional>
#include <unordered_map>

namespace clerestory {

class OverloadCache {
public:
    // What leaves the line without our seeing it, the renderer's own work, is seen after that.
    static constexpr std::chrono::milliseconds kLasts{100};

    // Before a call that takes a place in the line, and with its answer. A refusal counts until
    // another call comes back, if none did in the meantime.
    using Moment = std::uint64_t;
    Moment begin() const;
    void end(Moment begun, const std::string& client, const Answer& answer, Clock::time_point now);

    // Why this client would be refused; nothing when that is not sure.
    std::optional<Problem> refusalFor(const std::string& client, Clock::time_point now) const;

private:
    struct Refusal {
        int retryAfterSeconds = 1;
        Clock::time_point until;
    };
    mutable std::mutex mutex_;
    Moment moment_ = 0;
    std::unordered_map<std::string, Refusal> refused_;
};

}  // namespace clerestory
