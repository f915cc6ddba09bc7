// Runs the worker processes: the active one, which answers, or several, and a standby with the same
// scenes loaded, which replaces one of them when it ends, and repeats the requests that it had not
// answered. Thread-safe.
//
// A request that was pending when a worker ended may be the cause. It is repeated while no other
// request runs; if it ends workers again, it is quarantined: refused for a while.
#pragma once

#include "server/worker/messages.h"
#include "server/worker/renderer_queue.h"
#include "server/worker/worker_process.h"

#include <chrono>
#include <condition_variable>
#include <map>
#include <mutex>
#include <optional>
#include <unordered_map>
#include <vector>

namespace clerestory {

// A lock for many threads at once or for one alone. A thread that waits to be alone is not
// overtaken by threads that come later.
class ExclusiveGate {
public:
    class Entry {  // the lock is released when it ends
    public:
        ~Entry() { gate_.leave(alone_); }
        Entry(const Entry&) = delete;
        Entry& operator=(const Entry&) = delete;

    private:
        friend class ExclusiveGate;
        Entry(ExclusiveGate& gate, bool alone) : gate_(gate), alone_(alone) {}
        ExclusiveGate& gate_;
        bool alone_;
    };

    // Both block until they may enter.
    Entry enter();
    Entry enterAlone();

private:
    void leave(bool alone);

    std::mutex mutex_;
    std::condition_variable changed_;
    std::size_t inside_ = 0;
    std::size_t waitingAlone_ = 0;
    bool alone_ = false;
};

// Equal for requests with equal content, from any client.
std::uint64_t fingerprintOf(const WorkerRequest& request);

// Requests that crashed workers, by fingerprint. Thread-safe.
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

// Background work during which workers ended, by name: after a few ends it is left out for a while,
// and twice as long after each further one.
class EndedWork {
public:
    static constexpr int kMaxEnds = 3;
    static constexpr std::chrono::hours kFirstWhile{1}, kLongestWhile{24};
    static constexpr std::size_t kMax = 256;  // then the oldest entry is removed

    void add(const std::string& name, Clock::time_point now);
    std::vector<std::string> leftOut(Clock::time_point now) const;

private:
    struct Entry {
        int ends = 0;
        Clock::time_point last;
        Clock::duration outFor{0};
    };
    std::map<std::string, Entry> entries_;
};

struct SupervisorOptions {
    WorkerProgram program;
    bool standby = true;
    std::size_t renderers = 1;  // active workers; the others start when the first one is warm
    // The first worker compiles shaders without optimisation, so that it answers sooner. The
    // standby compiles with optimisation, and replaces it when it is warm. Needs a standby.
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

// Since the start; for the metrics.
struct SupervisorCounters {
    std::atomic<std::uint64_t> started{0};
    std::atomic<std::uint64_t> ended{0};        // by themselves or from outside
    std::atomic<std::uint64_t> silent{0};       // of those: killed because they sent nothing
    std::atomic<std::uint64_t> repeated{0};     // requests
    std::atomic<std::uint64_t> quarantined{0};  // requests refused
};

class Supervisor {
public:
    // Returns when the first worker is ready. Throws std::runtime_error with the worker's own
    // message if it cannot start.
    explicit Supervisor(const SupervisorOptions& options);
    ~Supervisor();  // kills the workers
    Supervisor(const Supervisor&) = delete;
    Supervisor& operator=(const Supervisor&) = delete;

    // `renderer`: which active worker, counted from 0; another one if it does not run. Throws
    // RequestError: the worker's refusal, quarantined (422), no worker (503).
    Answer ask(const Call& call, std::size_t renderer = 0);
    EncodedFrame ask(const FrameOrder& order, std::size_t renderer = 0);
    SceneReport ask(const SceneQuery& query, std::size_t renderer = 0);

    const SupervisorCounters& counters() const { return counters_; }
    // Of the first active worker and of the standby; 0 if there is none.
    std::pair<pid_t, pid_t> processes() const;
    std::pair<std::size_t, std::size_t> scenes() const;  // loaded, of both
    // Of the active workers that are warm; null if there is none. Of several, without scenes that
    // they hold with different contents.
    std::shared_ptr<const LoadedScenes> loadedScenes() const;
    // One element for each active worker.
    std::vector<RendererState> renderers() const;
    std::vector<pid_t> activeProcesses() const;  // 0 where none runs
    // Whether the standby has compiled its shaders and loaded the scenes of the active worker.
    bool standbyIsWarm() const;

private:
    using Worker = std::shared_ptr<WorkerProcess>;
    class FrameInFlight;
    void keep();
    Worker start(bool compileFast);
    bool standbyIsReady() const;
    bool startMustWait(bool isStandby);
    void replaceFastWorker();
    Worker runningFor(std::size_t renderer) const;
    Worker awaitActive(std::size_t renderer, Clock::time_point until);
    void reportEnd(const Worker& worker);
    void failOver(std::size_t renderer);
    void noteWork(const WorkerProcess& ended);
    void shareScenes();
    void tellRoles();
    WorkerReply ask(const WorkerRequest& request, std::size_t renderer, bool isFrame);
    std::optional<WorkerReply> askAlone(const WorkerRequest& request, std::size_t renderer,
                                        std::uint64_t fingerprint);

    const SupervisorOptions options_;
    SupervisorCounters counters_;
    Quarantine quarantine_;
    ExclusiveGate gate_;  // repeated requests enter it alone

    mutable std::mutex mutex_;
    mutable std::condition_variable changed_;
    std::vector<Worker> active_;  // of each renderer; null where none runs
    Worker standby_;
    EndedWork endedWork_;
    std::vector<std::string> scenes_;  // that the first active worker has loaded
    // Which scenes the others were requested to load. Not again: they may not have room for all.
    std::vector<std::vector<std::string>> requested_;
    Clock::time_point calmUntil_{};  // no standby starts before
    bool standbyStarted_ = false;    // or a failover happened: the next standby starts at once
    std::optional<Clock::time_point> warmSince_;  // of the first worker
    std::size_t framesInFlight_ = 0;
    Clock::time_point lastFrameEnded_{};
    bool sharesScenes_ = true;  // the standby loads them, too
    bool ending_ = false;
    std::promise<void> first_;
    std::thread keeper_;  // starts all workers: each ends with the thread that started it
};

}  // namespace clerestory
