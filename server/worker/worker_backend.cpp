#include "server/worker/worker_backend.h"

namespace clerestory {

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
                        .activeScenes = activeScenes,
                        .standbyScenes = standbyScenes};
}

}  // namespace clerestory
