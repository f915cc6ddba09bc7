#include "server/worker/worker_backend.h"

#include "server/api/job_routes.h"

#include <algorithm>

namespace clerestory {
namespace {

constexpr std::size_t kMaxClients = 1024;

}  // namespace

Answer JobJournal::ask(const Call& call, const Ask& ask) {
    Answer answer = ask(call);
    if (!answer.job) return answer;
    if (answer.job->kind == JobEvent::Kind::started) {
        add(call, answer);
        return answer;
    }
    const auto job = find(answer.job->id);
    if (!job) return answer;
    if (call.method == "DELETE") {
        remove(job->id);
        return jobAnswer({.id = job->id, .state = JobState::cancelled});
    }
    // The worker that ran it last has discarded its result; or another client's call has just
    // restarted it.
    if (job->worker == answer.worker) return ask(call);
    if (auto instead = restart(*job, ask)) return *std::move(instead);
    return ask(call);
}

// Empty if the job runs again; otherwise what to answer.
std::optional<Answer> JobJournal::restart(const Job& job, const Ask& ask) {
    if (job.runs >= kMaxRuns) {
        return jobAnswer({.id = job.id,
                          .state = JobState::failed,
                          .failure = "The renderer ended each of the " + std::to_string(job.runs) +
                                     " times that it worked on this job. Post it again, or a "
                                     "smaller one."});
    }
    Call call = job.call;
    call.arrived = Clock::now();
    call.job = job.id;
    const Answer answer = ask(call);
    if (answer.job) {
        countRun(job.id, answer.worker);
        return std::nullopt;
    }
    if (answer.problem && isTemporary(*answer.problem)) return jobAnswer({.id = job.id});
    return jobAnswer({.id = job.id,
                      .state = JobState::failed,
                      .failure = "The renderer ended, and the next one refuses the job. Post it "
                                 "again to see why."});
}

void JobJournal::add(const Call& call, const Answer& answer) {
    if (!call.job.empty()) return;
    Job job{.id = answer.job->id, .call = call, .worker = answer.worker};
    job.call.cancellation = nullptr;
    // The header function may refer to the client's request, which ends with its answer.
    job.call.header = [type = call.header ? call.header("Content-Type") : "",
                       deadline = call.header ? call.header("Clerestory-Deadline")
                                              : ""](const char* name) -> std::string {
        const std::string_view wanted(name);
        return wanted == "Content-Type" ? type : wanted == "Clerestory-Deadline" ? deadline : "";
    };
    const std::lock_guard lock(mutex_);
    jobs_.push_back(std::move(job));
    if (jobs_.size() > kMaxJobs) jobs_.pop_front();
}

std::optional<JobJournal::Job> JobJournal::find(const std::string& id) const {
    const std::lock_guard lock(mutex_);
    const auto found =
        std::find_if(jobs_.begin(), jobs_.end(), [&](const Job& job) { return job.id == id; });
    return found == jobs_.end() ? std::nullopt : std::optional(*found);
}

void JobJournal::remove(const std::string& id) {
    const std::lock_guard lock(mutex_);
    std::erase_if(jobs_, [&](const Job& job) { return job.id == id; });
}

void JobJournal::countRun(const std::string& id, std::uint64_t worker) {
    const std::lock_guard lock(mutex_);
    for (Job& job : jobs_) {
        if (job.id != id || job.worker == worker) continue;
        job.worker = worker;
        ++job.runs;
    }
}

OverloadCache::Moment OverloadCache::begin() const {
    const std::lock_guard lock(mutex_);
    return moment_;
}

void OverloadCache::end(Moment begun, const std::string& client,
                        const std::optional<Problem>& problem, Clock::time_point now) {
    const bool refused = problem && problem->code == ProblemCode::queueFull;
    const std::lock_guard lock(mutex_);
    if (!refused) {
        ++moment_;
        refusals_.clear();
    } else if (begun == moment_) {
        if (refusals_.size() >= kMaxClients) refusals_.clear();
        refusals_[client] = {*problem, now + kLifetime};
    }
}

std::optional<Problem> OverloadCache::refusalFor(const std::string& client,
                                                 Clock::time_point now) const {
    const std::lock_guard lock(mutex_);
    const auto found = refusals_.find(client);
    if (found == refusals_.end() || found->second.until <= now) return std::nullopt;
    return found->second.problem;
}

Answer WorkerBackend::answer(const Call& call) {
    if (stopping_) throw RequestError(shuttingDown());
    const auto ask = [this](const Call& asked) { return supervisor_.ask(asked); };
    if (!needsRenderQueue(call)) return jobs_.ask(call, ask);
    const OverloadCache::Moment begun = overload_.begin();
    Answer answer = ask(call);
    overload_.end(begun, call.client, answer.problem, Clock::now());
    return answer;
}

std::optional<Problem> WorkerBackend::refusalFor(const std::string& client) const {
    return overload_.refusalFor(client, Clock::now());
}

EncodedFrame WorkerBackend::draw(const FrameOrder& order) {
    if (stopping_) throw RequestError(shuttingDown());
    return supervisor_.ask(order);
}

SceneReport WorkerBackend::sceneReport(const std::string& id) {
    if (stopping_) throw RequestError(shuttingDown());
    return supervisor_.ask(SceneQuery{id});
}

std::optional<WorkerStatus> WorkerBackend::workerStatus() const {
    const SupervisorCounters& counters = supervisor_.counters();
    const auto [active, standby] = supervisor_.processes();
    const auto [activeScenes, standbyScenes] = supervisor_.scenes();
    return WorkerStatus{.started = counters.started,
                        .ended = counters.ended,
                        .silent = counters.silent,
                        .repeatedCalls = counters.repeated,
                        .quarantinedCalls = counters.quarantined,
                        .hasActive = active != 0,
                        .hasStandby = standby != 0,
                        .standbyIsWarm = supervisor_.standbyIsWarm(),
                        .warm = supervisor_.loadedScenes() ? 1u : 0u,
                        .activeScenes = activeScenes,
                        .standbyScenes = standbyScenes};
}

}  // namespace clerestory
