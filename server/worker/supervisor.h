// Keeps render workers: one that answers, one that is warm and waits for its turn. When the first
// ends, the second takes its place and answers what was asked of the first; it holds the same
// scenes by then. Thread-safe.
//
// A call that was pending when a worker ended is a suspect: it is asked again, alone, so that what
// happens then is its own doing. Who ends a worker twice in that way is refused for a while.
#pragma once

#include "server/worker/exclusive_gate.h"
#include "server/worker/quarantine.h"
#include "server/worker/worker_process.h"

namespace clerestory {

struct SupervisorOptions {
    WorkerProgram program;
    bool standby = true;
    // The first worker compiles shaders without optimising, so that it answers sooner; the standby,
    // which optimises, replaces it when its own are compiled. Needs a standby.
    bool compileFastFirst = false;
    // The first standby starts when the active worker is warm and has had no frame to draw for
    // `standbyIdle`, so that it does not compete with a user's first frame; at the latest
    // `standbyDelayLimit` after the active worker is warm.
    std::chrono::milliseconds standbyIdle{1000};
    std::chrono::milliseconds standbyDelayLimit{10000};
    // After a failover the next standby starts this much later, so that the calls of the lost
    // worker are answered first.
    std::chrono::milliseconds calm{400};
};

// For the metrics; since the start.
struct SupervisorCounters {
    std::atomic<std::uint64_t> started{0};
    std::atomic<std::uint64_t> ended{0};        // not by us
    std::atomic<std::uint64_t> silent{0};       // of those: killed because they said nothing
    std::atomic<std::uint64_t> askedAgain{0};   // calls
    std::atomic<std::uint64_t> quarantined{0};  // calls refused for what they did before
};

class Supervisor {
public:
    // Returns when the first worker stands. Throws std::runtime_error with the worker's own words
    // when it cannot.
    explicit Supervisor(const SupervisorOptions& options);
    ~Supervisor();  // kills them
    Supervisor(const Supervisor&) = delete;
    Supervisor& operator=(const Supervisor&) = delete;

    // The worker's answer. Throws RequestError: quarantined (422), no worker stands (503).
    Answer ask(const Call& call);

    const SupervisorCounters& counters() const { return counters_; }
    // Of the worker that answers and of the one that waits; 0 where there is none.
    std::pair<pid_t, pid_t> processes() const;
    // How many scenes either of them holds.
    std::pair<std::size_t, std::size_t> scenes() const;
    // Whether the one that waits has loaded its first scene, and what the other one holds.
    bool standbyIsWarm() const;

private:
    using Worker = std::shared_ptr<WorkerProcess>;
    class FrameInFlight;
    void keep();
    Worker started(bool compileFast);
    bool standbyIsReady() const;
    void replaceFastWorker();
    Worker active(Clock::time_point until);
    bool standbyMustWait();
    void ended(const Worker& worker);
    void lost(Worker worker);
    void share();
    std::optional<Answer> askAlone(const Call& call, std::uint64_t fingerprint);

    const SupervisorOptions options_;
    SupervisorCounters counters_;
    Quarantine quarantine_;
    ExclusiveGate gate_;  // a suspect is alone in it

    mutable std::mutex mutex_;
    mutable std::condition_variable changed_;
    Worker active_, standby_;
    std::vector<std::string> scenes_;  // that whoever answers holds
    Clock::time_point calmFrom_{};     // when the next standby may start
    bool standbyStarted_ = false;      // now or earlier, or a worker was lost: no need to wait
    std::optional<Clock::time_point> warmSince_;  // of the first worker
    std::size_t framesInFlight_ = 0;
    Clock::time_point lastFrameEnded_{};
    bool shares_ = true;  // the standby is to hold them, too
    bool ending_ = false;
    std::promise<void> first_;
    std::thread keeper_;  // starts every worker: they end when the thread that started them does
};

}  // namespace clerestory
