#include "server/worker/supervisor.h"

#include "server/base/log.h"
#include "server/base/problem.h"

#include "scene/hash.h"

#include <algorithm>

namespace clerestory {
namespace {

// How long a request waits for an active worker.
constexpr std::chrono::seconds kPatience{10};
// After a worker that could not start.
constexpr std::chrono::seconds kRestartInterval{2};
// A request is quarantined after this many crashes of workers that had no other request and no
// background work; or ends of any kind, since a process that takes all memory is killed from
// outside.
constexpr int kMaxCrashes = 2, kMaxEnds = 8;
// How soon the end of an idle worker is noticed.
constexpr std::chrono::seconds kPollInterval{1};
// How soon the keeper sees that the first standby may start.
constexpr std::chrono::milliseconds kStandbyPollInterval{50};

bool includesAll(const std::vector<std::string>& list, const std::vector<std::string>& wanted) {
    return std::all_of(wanted.begin(), wanted.end(), [&](const std::string& id) {
        return std::find(list.begin(), list.end(), id) != list.end();
    });
}

// The reply of the type that answers the request.
template <class Reply>
Reply expect(WorkerReply reply) {
    if (const auto* problem = std::get_if<Problem>(&reply)) throw RequestError(*problem);
    return std::get<Reply>(std::move(reply));
}

}  // namespace

ExclusiveGate::Entry ExclusiveGate::enter() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return !alone_ && waitingAlone_ == 0; });
    ++inside_;
    return {*this, false};
}

ExclusiveGate::Entry ExclusiveGate::enterAlone() {
    std::unique_lock lock(mutex_);
    ++waitingAlone_;
    changed_.wait(lock, [&] { return !alone_ && inside_ == 0; });
    --waitingAlone_;
    alone_ = true;
    return {*this, true};
}

void ExclusiveGate::leave(bool alone) {
    {
        const std::lock_guard lock(mutex_);
        if (alone) {
            alone_ = false;
        } else {
            --inside_;
        }
    }
    changed_.notify_all();
}

std::uint64_t fingerprintOf(const WorkerRequest& request) {
    if (const auto* call = std::get_if<Call>(&request)) {
        std::string text = call->method + '\n' + call->path + '\n';
        for (const auto& [name, value] : call->query) text += name + '=' + value + '\n';
        text += '\n' + call->body;
        return hashOf(text);
    }
    if (const auto* order = std::get_if<FrameOrder>(&request)) {
        return hashOf(packed(FrameOrder{.request = order->request, .withPlan = order->withPlan}));
    }
    return hashOf(std::get<SceneQuery>(request).id);
}

void Quarantine::add(std::uint64_t fingerprint, Clock::time_point now) {
    const std::lock_guard lock(mutex_);
    if (until_.size() >= kMax) {
        until_.erase(
            std::min_element(until_.begin(), until_.end(),
                             [](const auto& a, const auto& b) { return a.second < b.second; }));
    }
    until_[fingerprint] = now + kLifetime;
}

bool Quarantine::contains(std::uint64_t fingerprint, Clock::time_point now) const {
    const std::lock_guard lock(mutex_);
    const auto found = until_.find(fingerprint);
    return found != until_.end() && now < found->second;
}

void EndedWork::add(const std::string& name, Clock::time_point now) {
    if (entries_.size() >= kMax && !entries_.contains(name)) {
        entries_.erase(std::min_element(
            entries_.begin(), entries_.end(),
            [](const auto& a, const auto& b) { return a.second.last < b.second.last; }));
    }
    Entry& entry = entries_[name];
    entry.last = now;
    if (++entry.ends < kMaxEnds) return;
    entry.outFor = entry.ends == kMaxEnds
                       ? Clock::duration(kFirstWhile)
                       : std::min<Clock::duration>(2 * entry.outFor, kLongestWhile);
}

std::vector<std::string> EndedWork::leftOut(Clock::time_point now) const {
    std::vector<std::string> names;
    for (const auto& [name, entry] : entries_) {
        if (now - entry.last < entry.outFor) names.push_back(name);
    }
    return names;
}

// Counts a frame from its request to its answer.
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

Supervisor::Supervisor(const SupervisorOptions& options)
    : options_(options), active_(options.renderers), requested_(options.renderers) {
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
        Worker worker = start(options_.compileFastFirst && options_.standby);
        const std::lock_guard lock(mutex_);
        active_[0] = std::move(worker);
    } catch (...) {
        first_.set_exception(std::current_exception());
        return;
    }
    first_.set_value();
    std::unique_lock lock(mutex_);
    while (!ending_) {
        for (std::size_t i = 0; i < active_.size(); ++i) {
            if (active_[i] && !active_[i]->alive()) failOver(i);
        }
        if (standby_ && !standby_->alive()) {
            noteWork(*standby_);
            standby_ = nullptr;
            sharesScenes_ = false;  // perhaps for lack of memory: the next one loads fewer scenes
        }
        shareScenes();
        tellRoles();
        if (active_[0] && active_[0]->compilesFast() && standbyIsReady()) replaceFastWorker();
        const auto free = std::find(active_.begin(), active_.end(), nullptr);
        const bool isStandby = free == active_.end();
        if (isStandby && (standby_ || !options_.standby)) {
            changed_.wait_for(lock, kPollInterval);
            continue;
        }
        const bool anyRuns = runningFor(0) != nullptr;
        if (anyRuns && startMustWait(isStandby)) {
            changed_.wait_for(lock, kStandbyPollInterval);
            continue;
        }
        if (anyRuns && Clock::now() < calmUntil_) {
            changed_.wait_until(lock, calmUntil_);
            continue;
        }
        standbyStarted_ = standbyStarted_ || isStandby;
        lock.unlock();
        Worker worker;
        try {
            worker = start(false);
        } catch (const std::exception& error) {
            logError({"no new render worker: ", error.what()});
        }
        lock.lock();
        if (!worker) {
            changed_.wait_for(lock, kRestartInterval, [&] { return ending_; });
            continue;
        }
        const auto place = std::find(active_.begin(), active_.end(), nullptr);
        if (place != active_.end() && !scenes_.empty()) worker->loadScenes(scenes_);
        (place != active_.end() ? *place : standby_) = std::move(worker);
        changed_.notify_all();
    }
}

// With the lock held: whether one more worker would slow down those that are not warm; a standby
// also, if they have had the first frames to draw a moment ago. Metrics and health checks do not
// count.
bool Supervisor::startMustWait(bool isStandby) {
    const bool allWarm = std::all_of(active_.begin(), active_.end(),
                                     [](const Worker& one) { return !one || one->warm(); });
    if (!allWarm) return true;
    if (!isStandby || standbyStarted_) return false;
    const auto now = Clock::now();
    if (!warmSince_) warmSince_ = now;
    if (now >= *warmSince_ + options_.standbyDelayLimit) return false;
    return framesInFlight_ > 0 ||
           now < std::max(*warmSince_, lastFrameEnded_) + options_.standbyIdle;
}

// With the lock held: tells the others to load the scenes of the first active worker; the standby
// again if it could not load some.
void Supervisor::shareScenes() {
    if (active_[0] && active_[0]->warm()) scenes_ = active_[0]->scenes();
    std::vector<std::string> wanted = scenes_;  // in any order
    std::sort(wanted.begin(), wanted.end());
    for (std::size_t i = 1; i < active_.size(); ++i) {
        if (!active_[i] || !active_[i]->warm() || requested_[i] == wanted) continue;
        requested_[i] = wanted;
        if (!includesAll(active_[i]->scenes(), scenes_)) active_[i]->loadScenes(scenes_);
    }
    const bool shares = standby_ && standby_->warm() && sharesScenes_;
    if (shares && !includesAll(standby_->scenes(), scenes_)) standby_->loadScenes(scenes_);
}

// With the lock held.
void Supervisor::tellRoles() {
    for (const Worker& worker : active_) {
        if (worker) worker->setStandby(false);
    }
    if (standby_) standby_->setStandby(true);
}

// With the lock held. Pending requests keep the fast worker alive until they are answered.
void Supervisor::replaceFastWorker() {
    logInfo({"optimised shaders are compiled: render worker ", std::to_string(standby_->id()),
             " replaces ", std::to_string(active_[0]->id())});
    active_[0] = std::move(standby_);
    standby_ = nullptr;
    changed_.notify_all();
}

Supervisor::Worker Supervisor::start(bool compileFast) {
    std::vector<std::string> leftOut;
    {
        const std::lock_guard lock(mutex_);
        leftOut = endedWork_.leftOut(Clock::now());
    }
    auto worker = std::make_shared<WorkerProcess>(options_.program, ++counters_.started,
                                                  compileFast, leftOut);
    try {
        worker->awaitReady();
    } catch (const std::exception&) {
        const std::lock_guard lock(mutex_);
        noteWork(*worker);
        throw;
    }
    return worker;
}

// With the lock held: that active worker, or another one if it does not run; null if none runs.
Supervisor::Worker Supervisor::runningFor(std::size_t renderer) const {
    if (active_[renderer]) return active_[renderer];
    const auto any = std::find_if(active_.begin(), active_.end(),
                                  [](const Worker& one) { return one != nullptr; });
    return any == active_.end() ? nullptr : *any;
}

// Null if none runs until then.
Supervisor::Worker Supervisor::awaitActive(std::size_t renderer, Clock::time_point until) {
    std::unique_lock lock(mutex_);
    changed_.wait_until(lock, until, [&] { return runningFor(renderer) || ending_; });
    return runningFor(renderer);
}

void Supervisor::reportEnd(const Worker& worker) {
    const std::lock_guard lock(mutex_);
    const auto found = std::find(active_.begin(), active_.end(), worker);
    if (found == active_.end()) return;  // another thread reported it
    failOver(static_cast<std::size_t>(found - active_.begin()));
}

// With the lock held.
void Supervisor::noteWork(const WorkerProcess& ended) {
    for (const std::string& name : ended.work()) {
        logError({"the render worker ", std::to_string(ended.id()), " ended during ", name});
        endedWork_.add(name, Clock::now());
    }
}

// With the lock held.
void Supervisor::failOver(std::size_t renderer) {
    const Worker worker = active_[renderer];
    logError({"the render worker ", std::to_string(worker->id()), " ended",
              (worker->wasSilent() ? ": it sent nothing any more" : "")});
    if (worker->hungOn() != 0) {  // its client may have had an answer long ago
        logError({"a request is quarantined: the renderer hung on it"});
        quarantine_.add(worker->hungOn(), Clock::now());
    }
    noteWork(*worker);
    ++counters_.ended;
    if (worker->wasSilent()) ++counters_.silent;
    active_[renderer] = standby_ && standby_->alive() ? std::move(standby_) : nullptr;
    requested_[renderer].clear();
    standby_ = nullptr;
    sharesScenes_ = true;
    standbyStarted_ = true;
    calmUntil_ = Clock::now() + options_.calm;
    changed_.notify_all();
}

// Empty if the client has left, or no worker starts.
std::optional<WorkerReply> Supervisor::askAlone(const WorkerRequest& request, std::size_t renderer,
                                                std::uint64_t fingerprint) {
    const auto cancellation = cancellationOf(request);
    const ExclusiveGate::Entry entry = gate_.enterAlone();
    for (int crashes = 0, ends = 0; crashes < kMaxCrashes && ends < kMaxEnds; ++ends) {
        if (quarantine_.contains(fingerprint, Clock::now())) break;
        if (cancellation && cancellation->cancelled()) return std::nullopt;
        const Worker worker = awaitActive(renderer, Clock::now() + kPatience);
        if (!worker) return std::nullopt;
        ++counters_.repeated;
        if (auto reply = worker->ask(request, fingerprint)) return reply;
        const bool isClear = !worker->wasKilled() && !worker->wasSilent() && worker->work().empty();
        if (isClear) ++crashes;
        reportEnd(worker);
    }
    quarantine_.add(fingerprint, Clock::now());
    ++counters_.quarantined;
    throw RequestError(quarantined());
}

WorkerReply Supervisor::ask(const WorkerRequest& request, std::size_t renderer, bool isFrame) {
    const FrameInFlight frame(*this, isFrame);
    const std::uint64_t fingerprint = fingerprintOf(request);
    if (quarantine_.contains(fingerprint, Clock::now())) {
        ++counters_.quarantined;
        throw RequestError(quarantined());
    }
    {
        const ExclusiveGate::Entry entry = gate_.enter();
        const Worker worker = awaitActive(renderer, Clock::now() + kPatience);
        if (!worker) throw RequestError(noWorker());
        if (auto reply = worker->ask(request, fingerprint)) return *std::move(reply);
        reportEnd(worker);
    }
    if (auto reply = askAlone(request, renderer, fingerprint)) return *std::move(reply);
    throw RequestError(noWorker());
}

Answer Supervisor::ask(const Call& call, std::size_t renderer) {
    const bool isFrame = needsRenderQueue(call) || call.method == "POST";
    return expect<Answer>(ask(WorkerRequest(call), renderer, isFrame));
}

EncodedFrame Supervisor::ask(const FrameOrder& order, std::size_t renderer) {
    return expect<EncodedFrame>(ask(WorkerRequest(order), renderer, true));
}

SceneReport Supervisor::ask(const SceneQuery& query, std::size_t renderer) {
    return expect<SceneReport>(ask(WorkerRequest(query), renderer, false));
}

std::pair<pid_t, pid_t> Supervisor::processes() const {
    const std::lock_guard lock(mutex_);
    return {active_[0] ? active_[0]->id() : 0, standby_ ? standby_->id() : 0};
}

std::vector<pid_t> Supervisor::activeProcesses() const {
    const std::lock_guard lock(mutex_);
    std::vector<pid_t> ids;
    for (const Worker& one : active_) ids.push_back(one ? one->id() : 0);
    return ids;
}

std::pair<std::size_t, std::size_t> Supervisor::scenes() const {
    const std::lock_guard lock(mutex_);
    return {active_[0] ? active_[0]->scenes().size() : 0, standby_ ? standby_->scenes().size() : 0};
}

std::vector<RendererState> Supervisor::renderers() const {
    const std::lock_guard lock(mutex_);
    std::vector<RendererState> states;
    for (const Worker& one : active_) {
        if (one) {
            states.push_back({.isPresent = true,
                              .isCompiling = one->compiling(),
                              .number = one->number(),
                              .loaded = one->loadedScenes()});
        } else {
            states.emplace_back();
        }
    }
    return states;
}

std::shared_ptr<const LoadedScenes> Supervisor::loadedScenes() const {
    return loadedInAll(renderers());
}

bool Supervisor::standbyIsWarm() const {
    const std::lock_guard lock(mutex_);
    return standbyIsReady();
}

// With the lock held.
bool Supervisor::standbyIsReady() const {
    if (!active_[0] || !standby_ || !standby_->alive() || !standby_->warm()) return false;
    return !sharesScenes_ || includesAll(standby_->scenes(), active_[0]->scenes());
}

}  // namespace clerestory
