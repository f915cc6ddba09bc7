// The jobs that clients started, as the server remembers them. Jobs end with their worker process;
// when a client requests a lost job, it is started again in the next worker, under the same id.
// Thread-safe.
#pragma once

#include "server/base/call.h"

#include <deque>
#include <functional>
#include <mutex>
#include <optional>

namespace clerestory {

class JobJournal {
public:
    using Ask = std::function<Answer(const Call&)>;

    static constexpr int kMaxRuns = 3;           // of one job; each lost run ended with its worker
    static constexpr std::size_t kMaxJobs = 32;  // remembered: more than a worker keeps

    // Answers any call; `ask` answers it by a worker, whose number is in Answer::worker. Throws
    // what `ask` throws.
    Answer ask(const Call& call, const Ask& ask);

private:
    struct Job {
        std::string id;
        Call call;  // that started it
        std::uint64_t worker = 0;
        int runs = 1;
    };
    void add(const Call& call, const Answer& answer);
    std::optional<Job> find(const std::string& id) const;
    void remove(const std::string& id);
    void countRun(const std::string& id, std::uint64_t worker);
    std::optional<Answer> restart(const Job& job, const Ask& ask);

    mutable std::mutex mutex_;
    std::deque<Job> jobs_;  // oldest first
};

}  // namespace clerestory
