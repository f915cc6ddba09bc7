#include "server/worker/job_journal.h"

#include "server/api/job_routes.h"
#include "server/worker/call_wire.h"
#include "server/worker/worker_process.h"

#include <algorithm>

namespace clerestory {
namespace {

std::string headerOf(const Answer& answer, std::string_view name) {
    for (const auto& [key, value] : answer.headers) {
        if (key == name) return value;
    }
    return "";
}

// What passes by itself: a scene that loads, a full line, no renderer.
bool comesLater(int status) {
    return status == 409 || status == 503;
}

}  // namespace

Answer JobJournal::ask(const Call& call, const Ask& ask) {
    Answer answer = ask(call);
    if (answer.status == 202) begun(call, answer);
    const std::string id = jobIdIn(call.path);
    if (id.empty() || answer.status != 404) return answer;
    const auto job = find(id);
    if (!job) return answer;
    if (call.method == "DELETE") {
        forget(id);
        return toldJob({.id = id, .state = JobState::cancelled});
    }
    // The same renderer let its result go; or another client had it begun again just now.
    if (job->worker == headerOf(answer, kWorkerHeader)) return ask(call);
    if (auto instead = begunAgain(*job, ask)) return *std::move(instead);
    return ask(call);
}

// What to tell instead of how far it is.
std::optional<Answer> JobJournal::begunAgain(const Job& job, const Ask& ask) {
    if (job.runs >= kMaxRuns) {
        return toldJob({.id = job.id,
                        .state = JobState::failed,
                        .failure = "The renderer ended each of the " + std::to_string(job.runs) +
                                   " times that it worked on this job. Post it again, or a "
                                   "smaller one."});
    }
    Call call = unpackedCall(job.call);
    call.arrived = Clock::now();
    call.job = job.id;
    const Answer answer = ask(call);
    if (answer.status == 202) {
        ranAgain(job.id, headerOf(answer, kWorkerHeader));
        return std::nullopt;
    }
    if (comesLater(answer.status)) return toldJob({.id = job.id});
    return toldJob({.id = job.id,
                    .state = JobState::failed,
                    .failure = "The renderer ended, and the next one refuses the job. Post it "
                               "again to see why."});
}

void JobJournal::begun(const Call& call, const Answer& answer) {
    const std::string id = jobIdIn(headerOf(answer, "Location"));
    if (id.empty() || !call.job.empty()) return;
    const std::lock_guard lock(mutex_);
    jobs_.push_back({.id = id, .call = packed(call), .worker = headerOf(answer, kWorkerHeader)});
    if (jobs_.size() > kMaxJobs) jobs_.pop_front();
}

std::optional<JobJournal::Job> JobJournal::find(const std::string& id) const {
    const std::lock_guard lock(mutex_);
    const auto found =
        std::find_if(jobs_.begin(), jobs_.end(), [&](const Job& job) { return job.id == id; });
    return found == jobs_.end() ? std::nullopt : std::optional(*found);
}

void JobJournal::forget(const std::string& id) {
    const std::lock_guard lock(mutex_);
    std::erase_if(jobs_, [&](const Job& job) { return job.id == id; });
}

void JobJournal::ranAgain(const std::string& id, const std::string& worker) {
    const std::lock_guard lock(mutex_);
    for (Job& job : jobs_) {
        if (job.id != id || job.worker == worker) continue;
        job.worker = worker;
        ++job.runs;
    }
}

}  // namespace clerestory
