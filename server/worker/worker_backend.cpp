#include "server/worker/worker_backend.h"

#include "server/api/frame_service.h"
#include "server/api/frames.h"
#include "server/api/job_routes.h"
#include "server/api/metrics.h"
#include "server/api/renderer_routes.h"
#include "server/api/route_table.h"

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

WorkerBackend::WorkerBackend(const WorkerBackendOptions& options)
    : options_(options), supervisor_(options.workers) {
    if (options.workers.renderers < 2) return;
    queue_.emplace(options.queue, [this] { return supervisor_.renderers(); });
}

void WorkerBackend::stop() {
    stopping_ = true;
    if (queue_) queue_->refuseNew();
}

Answer WorkerBackend::answer(const Call& call) {
    if (stopping_) throw RequestError(shuttingDown());
    if (queue_) return answerByOneOfSeveral(call);
    const auto ask = [this](const Call& asked) { return supervisor_.ask(asked); };
    if (!needsRenderQueue(call)) return jobs_.ask(call, ask);
    const OverloadCache::Moment begun = overload_.begin();
    Answer answer = ask(call);
    overload_.end(begun, call.client, answer.problem, Clock::now());
    return answer;
}

// What is no frame is answered by the first renderer, which also runs the jobs.
Answer WorkerBackend::answerByOneOfSeveral(const Call& call) {
    if (needsRenderQueue(call)) {
        Answer answer = guarded(call, [&] { return drawnByOneOfSeveral(call); });
        answer.route = call.path;
        return answer;
    }
    if (call.path == "/metrics") return metricsOfAll(call);
    Answer answer = jobs_.ask(call, [this](const Call& asked) { return supervisor_.ask(asked); });
    if (answer.problem) return answer;
    const bool isScene = covers("/v1/scenes/{id}", call.path);
    if (call.method == "DELETE" && isScene) tellOthers(call);
    if (call.method == "GET" && call.path == "/v1/renderer") {
        std::vector<RendererSummary> list;
        for (const RendererState& state : supervisor_.renderers()) {
            list.push_back({.worker = state.number,
                            .isWarm = state.loaded != nullptr,
                            .scenes = state.loaded ? state.loaded->scenes.size() : 0});
        }
        answer.body = withRenderers(answer.body, list);
    }
    return answer;
}

Answer WorkerBackend::drawnByOneOfSeveral(const Call& call) {
    FrameCall frame;
    std::optional<std::chrono::milliseconds> deadline;
    try {
        frame = frameCallFrom(call, options_.signedLinks);
        deadline = deadlineIn(call);
    } catch (const RequestError&) {
        return supervisor_.ask(call);  // it knows the problem, without its queue
    }
    const RendererNeed need{.scene = frame.request.scene,
                            .onlyFirst = frame.request.accuracy.isBudget()};
    const std::vector<RendererState> states = supervisor_.renderers();
    // As with one renderer: a call waits for its scene, or for a comparison of its entity tag,
    // without a place in the queue. If a frame must be drawn it waits in that renderer's own queue.
    if (!isLoaded(states, need.scene)) return supervisor_.ask(call);
    if (!call.header("If-None-Match").empty()) {
        std::size_t renderer = 0;
        while (renderer + 1 < states.size() && !mayDraw(states, need, renderer)) ++renderer;
        return supervisor_.ask(call, renderer);
    }
    Turn turn = turnFor(call.arrived, options_.deadlineSeconds, deadline);
    turn.client = call.client;
    turn.cancellation = call.cancellation;
    turn.kind = call.path == "/v1/plans" ? kPlanKind : kindOf(frame.request);
    const RendererQueue::Place place = queue_->take(turn, need);
    return supervisor_.ask(call, place.renderer());
}

Answer WorkerBackend::metricsOfAll(const Call& call) {
    std::vector<std::pair<std::size_t, std::string>> texts;
    const std::vector<RendererState> states = supervisor_.renderers();
    for (std::size_t i = 0; i < states.size(); ++i) {
        if (!states[i].isPresent) continue;
        const Answer answer = supervisor_.ask(call, i);
        if (!answer.problem) texts.emplace_back(i + 1, answer.body);
    }
    return {.type = kMetricsType, .body = joinedMetrics(texts), .route = call.path};
}

// After the first renderer: the others may not have the scene.
void WorkerBackend::tellOthers(const Call& call) {
    const std::vector<RendererState> states = supervisor_.renderers();
    for (std::size_t i = 0; i < states.size(); ++i) {
        if (states[i].isPresent && i != firstRenderer(states)) supervisor_.ask(call, i);
    }
}

std::optional<Problem> WorkerBackend::refusalFor(const std::string& client) const {
    if (queue_) return queue_->refusalFor(client);
    return overload_.refusalFor(client, Clock::now());
}

EncodedFrame WorkerBackend::draw(const FrameOrder& order) {
    if (stopping_) throw RequestError(shuttingDown());
    const RendererNeed need{.scene = order.request.scene,
                            .onlyFirst = order.request.accuracy.isBudget()};
    if (!queue_ || !isLoaded(supervisor_.renderers(), need.scene)) return supervisor_.ask(order);
    Turn turn = turnFor(order.arrived, options_.deadlineSeconds);
    turn.client = order.client;
    turn.cancellation = order.cancellation;
    turn.kind = kindOf(order.request);
    const RendererQueue::Place place = queue_->take(turn, need);
    return supervisor_.ask(order, place.renderer());
}

SceneReport WorkerBackend::sceneReport(const std::string& id) {
    if (stopping_) throw RequestError(shuttingDown());
    return supervisor_.ask(SceneQuery{id});
}

std::optional<WorkerStatus> WorkerBackend::workerStatus() const {
    const SupervisorCounters& counters = supervisor_.counters();
    const auto [active, standby] = supervisor_.processes();
    const auto [activeScenes, standbyScenes] = supervisor_.scenes();
    WorkerStatus status{.started = counters.started,
                        .ended = counters.ended,
                        .silent = counters.silent,
                        .repeatedCalls = counters.repeated,
                        .quarantinedCalls = counters.quarantined,
                        .hasStandby = standby != 0,
                        .standbyIsWarm = supervisor_.standbyIsWarm(),
                        .queue = queue_ ? std::optional(queue_->usage()) : std::nullopt,
                        .activeScenes = activeScenes,
                        .standbyScenes = standbyScenes};
    for (const RendererState& state : supervisor_.renderers()) {
        status.active += state.isPresent;
        status.warm += state.loaded != nullptr;
    }
    return status;
}

}  // namespace clerestory
