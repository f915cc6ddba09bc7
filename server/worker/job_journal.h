// Jobs as the port's side remembers them. A renderer's process that ends takes its jobs with it;
// the next one does them again when somebody asks for them, under the same id. Thread-safe.
//
// Does not: know what a job does, or keep results.
#pragma once

#include "server/base/call.h"

#include <deque>
#include <mutex>
#include <optional>

namespace clerestory {

class JobJournal {
public:
    using Ask = std::function<Answer(const Call&)>;

    static constexpr int kMaxRuns = 3;           // of one job; each ended its renderer, or met it
    static constexpr std::size_t kMaxJobs = 32;  // remembered: more than a renderer keeps

    // `ask`: what a renderer answers, with the number of its process in kWorkerHeader. Throws what
    // that throws.
    Answer ask(const Call& call, const Ask& ask);

private:
    struct Job {
        std::string id;
        std::string call;  // that began it, packed
        std::string worker;
        int runs = 1;
    };
    void begun(const Call& call, const Answer& answer);
    std::optional<Job> find(const std::string& id) const;
    void forget(const std::string& id);
    void ranAgain(const std::string& id, const std::string& worker);
    std::optional<Answer> begunAgain(const Job& job, const Ask& ask);

    mutable std::mutex mutex_;
    std::deque<Job> jobs_;  // oldest first
};

}  // namespace clerestory
