#include "server/worker/supervisor.h"

#include "server/base/log.h"
#include "server/base/problem.h"

#include <algorithm>

namespace clerestory {
namespace {

// How long a call waits for a worker while one starts.
constexpr std::chrono::seconds kPatience{10};
// After a worker that ended before it answered anything, so that a machine on which none can live
// is not kept busy with starting them.
constexpr std::chrono::seconds kBetweenStarts{2};
// A suspect is guilty when so many workers crash while it is alone with them; or end in any way,
// for who takes all memory has them killed from outside.
constexpr int kMaxCrashes = 2, kMaxEnds = 8;
// How soon the end of a worker is seen that nobody asked anything.
constexpr std::chrono::seconds kPollInterval{1};
// How soon the keeper sees that the first standby may start.
constexpr std::chrono::milliseconds kStandbyPollInterval{50};

bool holdsAll(const std::vector<std::string>& there, const std::vector<std::string>& wanted) {
    return std::all_of(wanted.begin(), wanted.end(), [&](const std::string& id) {
        return std::find(there.begin(), there.end(), id) != there.end();
    });
}

}  // namespace

// Counts a frame from the call to its answer.
class Supervisor::FrameInFlight {
public:
    FrameInFlight(Supervisor& supervisor, bool counts) : supervisor_(supervisor), counts_(counts) {
        if (!counts_) return;
        const std::lock_guard lock(supervisor_.mutex_);
        ++supervisor_.framesInFlight_;
    }
    ~FrameInFlight() {
        if (!counts_) return;
        const std::lock_guard lock(supervisor_.mutex_);
        --supervisor_.framesInFlight_;
        supervisor_.lastFrameEnded_ = Clock::now();
    }
    FrameInFlight(const FrameInFlight&) = delete;
    FrameInFlight& operator=(const FrameInFlight&) = delete;

private:
    Supervisor& supervisor_;
    const bool counts_;
};

Supervisor::Supervisor(const SupervisorOptions& options) : options_(options) {
    keeper_ = std::thread([this] { keep(); });
    try {
        first_.get_future().get();
    } catch (...) {
        keeper_.join();
        throw;
    }
}

Supervisor::~Supervisor() {
    {
        const std::lock_guard lock(mutex_);
        ending_ = true;
    }
    changed_.notify_all();
    keeper_.join();
}

// The keeper's thread.
void Supervisor::keep() {
    try {
        Worker worker = started(options_.compileFastFirst && options_.standby);
        const std::lock_guard lock(mutex_);
        active_ = std::move(worker);
    } catch (...) {
        first_.set_exception(std::current_exception());
        return;
    }
    first_.set_value();
    std::unique_lock lock(mutex_);
    while (!ending_) {
        if (active_ && !active_->alive()) lost(active_);
        if (standby_ && !standby_->alive()) {
            standby_ = nullptr;
            shares_ = false;  // perhaps for want of memory; the next one makes do with less
        }
        share();
        if (active_ && active_->compilesFast() && standbyIsReady()) replaceFastWorker();
        if (active_ && (standby_ || !options_.standby)) {
            changed_.wait_for(lock, kPollInterval);
            continue;
        }
        if (active_ && standbyMustWait()) {
            changed_.wait_for(lock, kStandbyPollInterval);
            continue;
        }
        if (active_ && Clock::now() < calmFrom_) {
            changed_.wait_until(lock, calmFrom_);
            continue;
        }
        standbyStarted_ = standbyStarted_ || active_;
        lock.unlock();
        Worker worker;
        try {
            worker = started(false);
        } catch (const std::exception& error) {
            logError({"no new render worker: ", error.what()});
        }
        lock.lock();
        if (!worker) {
            changed_.wait_for(lock, kBetweenStarts, [&] { return ending_; });
            continue;
        }
        if (!active_ && !scenes_.empty()) worker->hold(scenes_);
        (active_ ? standby_ : active_) = std::move(worker);
        changed_.notify_all();
    }
}

// With the lock held: whether a standby would slow down the active worker, which is not warm, or
// has had the first frames to draw a moment ago. Metrics and health checks do not count.
bool Supervisor::standbyMustWait() {
    if (!active_->warm()) return true;
    if (standbyStarted_) return false;
    const auto now = Clock::now();
    if (!warmSince_) warmSince_ = now;
    if (now >= *warmSince_ + options_.standbyDelayLimit) return false;
    return framesInFlight_ > 0 ||
           now < std::max(*warmSince_, lastFrameEnded_) + options_.standbyIdle;
}

// With the lock held: the standby follows the scenes of the one that answers. What it could not
// load it is told again.
void Supervisor::share() {
    if (active_ && active_->warm()) scenes_ = active_->scenes();
    const bool follows = standby_ && standby_->warm() && shares_;
    if (follows && !holdsAll(standby_->scenes(), scenes_)) standby_->hold(scenes_);
}

// With the lock held. Calls that the fast worker has begun keep it alive until they are answered.
void Supervisor::replaceFastWorker() {
    logInfo({"optimised shaders are compiled: render worker ", std::to_string(standby_->id()),
             " replaces ", std::to_string(active_->id())});
    active_ = std::move(standby_);
    standby_ = nullptr;
    changed_.notify_all();
}

Supervisor::Worker Supervisor::started(bool compileFast) {
    auto worker =
        std::make_shared<WorkerProcess>(options_.program, ++counters_.started, compileFast);
    worker->awaitStanding();
    return worker;
}

// The worker that answers, once there is one; null when there is none until then.
Supervisor::Worker Supervisor::active(Clock::time_point until) {
    std::unique_lock lock(mutex_);
    changed_.wait_until(lock, until, [&] { return active_ || ending_; });
    return active_;
}

void Supervisor::ended(const Worker& worker) {
    const std::lock_guard lock(mutex_);
    if (worker == active_) lost(worker);  // otherwise somebody else has seen it too
}

// With the lock held. By value: active_ changes.
void Supervisor::lost(Worker worker) {
    ++counters_.ended;
    if (worker->wasSilent()) ++counters_.silent;
    logError({"the render worker ", std::to_string(worker->id()), " ended",
              (worker->wasSilent() ? ": it said nothing any more" : "")});
    active_ = standby_ && standby_->alive() ? std::move(standby_) : nullptr;
    standby_ = nullptr;
    shares_ = true;
    standbyStarted_ = true;
    calmFrom_ = Clock::now() + options_.calm;
    changed_.notify_all();
}

std::optional<Answer> Supervisor::askAlone(const Call& call, std::uint64_t fingerprint) {
    const ExclusiveGate::Entry entry = gate_.enterAlone();
    for (int crashes = 0, ends = 0; crashes < kMaxCrashes && ends < kMaxEnds; ++ends) {
        if (call.cancellation && call.cancellation->cancelled()) return std::nullopt;
        const Worker worker = active(Clock::now() + kPatience);
        if (!worker) return std::nullopt;
        ++counters_.askedAgain;
        if (auto answer = worker->ask(call)) return answer;
        if (!worker->wasKilled() && !worker->wasSilent()) ++crashes;
        ended(worker);
    }
    quarantine_.add(fingerprint, Clock::now());
    ++counters_.quarantined;
    throw RequestError(quarantined());
}

Answer Supervisor::ask(const Call& call) {
    const bool isFrame = call.path == "/v1/frames" || call.method == "POST";
    const FrameInFlight frame(*this, isFrame);
    const std::uint64_t fingerprint = fingerprintOf(call);
    if (quarantine_.holds(fingerprint, Clock::now())) {
        ++counters_.quarantined;
        throw RequestError(quarantined());
    }
    {
        const ExclusiveGate::Entry entry = gate_.enter();
        const Worker worker = active(Clock::now() + kPatience);
        if (!worker) throw RequestError(noWorker());
        if (auto answer = worker->ask(call)) return *std::move(answer);
        ended(worker);
    }
    if (auto answer = askAlone(call, fingerprint)) return *std::move(answer);
    throw RequestError(noWorker());
}

std::pair<pid_t, pid_t> Supervisor::processes() const {
    const std::lock_guard lock(mutex_);
    return {active_ ? active_->id() : 0, standby_ ? standby_->id() : 0};
}

std::pair<std::size_t, std::size_t> Supervisor::scenes() const {
    const std::lock_guard lock(mutex_);
    return {active_ ? active_->scenes().size() : 0, standby_ ? standby_->scenes().size() : 0};
}

bool Supervisor::standbyIsWarm() const {
    const std::lock_guard lock(mutex_);
    return standbyIsReady();
}

// With the lock held.
bool Supervisor::standbyIsReady() const {
    if (!active_ || !standby_ || !standby_->alive() || !standby_->warm()) return false;
    return !shares_ || holdsAll(standby_->scenes(), active_->scenes());
}

}  // namespace clerestory
