#include "server/jobs/jobs.h"

#include "server/base/log.h"
#include "server/base/problem.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <random>

namespace clerestory {
namespace {

// A result with its pictures takes a few megabytes as a rule; one can take more than a hundred.
constexpr std::size_t kMaxFinished = 16;
constexpr std::size_t kMaxFinishedBytes = 256 << 20;

std::size_t bytesOf(const JobStatus& status) {
    std::size_t bytes = 0;
    if (!status.result) return bytes;
    for (const JobPicture& picture : status.result->pictures) bytes += picture.bytes.size();
    return bytes;
}

std::string newId() {
    std::random_device random;
    char text[33];
    std::snprintf(text, sizeof text, "%08x%08x%08x%08x", random(), random(), random(), random());
    return text;
}

std::string failureMessage(const std::exception& error) {
    if (const auto* known = dynamic_cast<const RequestError*>(&error)) {
        return known->problem().detail;
    }
    if (const auto* known = dynamic_cast<const InvalidRequest*>(&error)) {
        return invalidFields(known->errors()).detail;
    }
    return internalError().detail;
}

// A frame of a job may take long.
constexpr std::chrono::seconds kFramePatience{300};
// Time on a frame of a job while clients wait, and how often it may take longer.
constexpr std::chrono::seconds kMaxWhileOthersWait{5};
constexpr int kMaxInterruptions = 4;
constexpr std::chrono::milliseconds kRetryInterval{200};

}  // namespace

std::string_view nameOf(JobState state) {
    switch (state) {
        case JobState::queued:
            return "queued";
        case JobState::running:
            return "running";
        case JobState::done:
            return "done";
        case JobState::failed:
            return "failed";
        case JobState::cancelled:
            return "cancelled";
    }
    return "";
}

Jobs::Jobs(std::size_t capacity)
    : open_({{Pool::jobs, {.most = std::max<std::size_t>(capacity, 1)}}}),
      thread_([this] { serve(); }) {}

Jobs::~Jobs() {
    {
        const std::lock_guard lock(mutex_);
        ending_ = true;
        for (const auto& job : jobs_) job->cancelled = true;
    }
    wake_.notify_all();
    thread_.join();
}

JobStatus Jobs::start(std::function<Work(const std::string& id)> work, const std::string& client,
                      const std::string& knownId) {
    auto job = std::make_shared<Job>();
    job->status.id = knownId.empty() ? newId() : knownId;
    job->work = work(job->status.id);
    const std::lock_guard lock(mutex_);
    if (const Job* same = find(job->status.id, lock)) return same->status;
    // A job that continues had its place before.
    job->place = open_.take(Pool::jobs, client, knownId.empty() ? 1 : 0);
    if (!job->place) throw RequestError(jobsFull());
    job->place->resize(1);
    // A round has one job of each client.
    job->round = round_;
    std::size_t ended = 0;
    for (const auto& other : jobs_) {
        if (!other->place) {
            ++ended;
        } else if (other->place->client() == client) {
            job->round = std::max(job->round, other->round + 1);
        }
    }
    // Discards the oldest result.
    if (ended >= kMaxFinished) {
        jobs_.erase(
            std::find_if(jobs_.begin(), jobs_.end(), [](const auto& j) { return !j->place; }));
    }
    jobs_.push_back(job);
    wake_.notify_all();
    return job->status;
}

Jobs::Job* Jobs::find(std::string_view id, const std::lock_guard<std::mutex>&) const {
    const auto found = std::find_if(jobs_.begin(), jobs_.end(),
                                    [&](const auto& job) { return job->status.id == id; });
    return found == jobs_.end() ? nullptr : found->get();
}

Jobs::Job& Jobs::jobFor(const std::string& id, const std::lock_guard<std::mutex>& lock) const {
    if (Job* job = find(id, lock)) return *job;
    throw RequestError(notFound("There is no such job, or its result was discarded."));
}

std::optional<JobStatus> Jobs::lookUp(const std::string& id) const {
    const std::lock_guard lock(mutex_);
    const Job* job = find(id, lock);
    return job ? std::optional(job->status) : std::nullopt;
}

JobStatus Jobs::find(const std::string& id) const {
    const std::lock_guard lock(mutex_);
    return jobFor(id, lock).status;
}

JobStatus Jobs::cancel(const std::string& id) {
    const std::lock_guard lock(mutex_);
    Job& job = jobFor(id, lock);
    job.cancelled = true;
    if (job.status.state == JobState::queued) job.end(JobState::cancelled);
    return job.status;
}

void Jobs::Job::end(JobState state) {
    status.state = state;
    place.reset();
}

// With the lock held: the oldest one of the first round.
std::shared_ptr<Jobs::Job> Jobs::nextQueued() const {
    std::shared_ptr<Job> next;
    for (const auto& job : jobs_) {
        if (job->status.state != JobState::queued) continue;
        if (!next || job->round < next->round) next = job;
    }
    return next;
}

void Jobs::serve() {
    std::unique_lock lock(mutex_);
    for (;;) {
        std::shared_ptr<Job> job;
        wake_.wait(lock, [&] { return ending_ || (job = nextQueued()); });
        if (ending_) return;
        job->status.state = JobState::running;
        round_ = job->round;
        lock.unlock();
        run(*job);
        lock.lock();
    }
}

void Jobs::run(Job& job) {
    const JobControl control([&](double progress) {
        const std::lock_guard lock(mutex_);
        if (std::isfinite(progress)) {
            job.status.progress = std::clamp(progress, job.status.progress, 1.0);
        }
        return !job.cancelled;
    });
    std::shared_ptr<const JobResult> result;
    std::string failure;
    try {
        result = std::make_shared<const JobResult>(job.work(control));
    } catch (const std::exception& error) {
        logError({"job ", job.status.id, ": ", error.what()});
        failure = failureMessage(error);
    }
    job.work = nullptr;
    const std::lock_guard lock(mutex_);
    if (job.cancelled) {
        job.end(JobState::cancelled);
    } else if (!result) {
        job.end(JobState::failed);
        job.status.failure = failure;
    } else {
        job.end(JobState::done);
        job.status.progress = 1.0;
        job.status.result = result;
        discardOldResults(job, lock);
    }
}

// Keeps the newest one whatever its size.
void Jobs::discardOldResults(const Job& newest, const std::lock_guard<std::mutex>&) {
    std::size_t bytes = 0;
    for (const auto& job : jobs_) bytes += bytesOf(job->status);
    for (auto job = jobs_.begin(); job != jobs_.end() && bytes > kMaxFinishedBytes;) {
        const bool mayGo = job->get() != &newest && !(*job)->place;
        if (mayGo) bytes -= bytesOf((*job)->status);
        job = mayGo ? jobs_.erase(job) : std::next(job);
    }
}

Scene wholeScene(SceneLibrary& library, const FrameRequest& frame) {
    if (frame.parts.empty()) return library.whole(frame.scene);
    std::map<std::string, Scene> whole;
    std::vector<const Scene*> scenes;
    for (const PlacedScene& part : frame.parts) {
        auto found = whole.find(part.scene);
        if (found == whole.end())
            found = whole.emplace(part.scene, library.whole(part.scene)).first;
        scenes.push_back(&found->second);
    }
    const std::vector<ScenePart> parts = scenePartsOf(frame.parts, scenes);
    try {
        Scene all = joined(parts);
        copyTexels(all, parts);
        return all;
    } catch (const std::length_error& tooLarge) {
        throw InvalidRequest({problemOf(tooLarge)});
    }
}

std::shared_ptr<const ReferenceRender> traceReference(EnvironmentLibrary& environments,
                                                      const Scene& scene, const FrameRequest& frame,
                                                      ReferenceMode mode, std::uint32_t samples,
                                                      std::uint64_t seed,
                                                      const std::function<bool(double)>& progress) {
    const auto start = Clock::now();
    EnvironmentMaps maps;
    for (const std::string& name : environments.names()) {
        maps[name] = environments.find(name);
    }
    for (auto& map : environments.requireUploads(frame, kUnlimitedMapPatience)) {
        maps[map->name] = std::move(map);
    }
    const auto lighting = maps.find(frame.environment.map.value_or(scene.environment));
    if (lighting == maps.end()) {
        throw InvalidRequest({{"/environment/map", "is not the name of a loaded map",
                               "a name that GET /v1/renderer lists"}});
    }
    auto image = traceReference({.scene = scene,
                                 .frame = frame,
                                 .environment = *lighting->second,
                                 .maps = maps,
                                 .mode = mode,
                                 .samples = samples,
                                 .seed = seed},
                                progress);
    if (!image) return nullptr;
    return std::make_shared<const ReferenceRender>(
        ReferenceRender{*std::move(image), millisecondsSince(start)});
}

DrawnFrame drawTimed(Renderer& renderer, const FrameRequest& request,
                     const std::function<bool()>& abandoned) {
    const auto start = Clock::now();
    Frame frame = renderer.render(request, Readback::picture, abandoned);
    return {std::move(frame.image), millisecondsSince(start), std::move(frame.plan)};
}

namespace {

// Whether a frame is still needed by its job, which may stop waiting while the frame is drawn.
class Need {
public:
    explicit Need(const JobControl& control) : control_(&control) {}
    bool isGone() {
        const std::lock_guard lock(mutex_);
        return !control_ || !control_->proceed(0.0);
    }
    void end() {
        const std::lock_guard lock(mutex_);
        control_ = nullptr;
    }

private:
    std::mutex mutex_;
    const JobControl* control_;  // null: the job does not wait
};

// The queue's work owns what it uses; see RenderQueue::run().
DrawnFrame drawOnce(RenderQueue& queue, const FrameRequest& request, const JobControl& control) {
    const auto need = std::make_shared<Need>(control);
    const std::shared_ptr<void> whileWaiting(nullptr, [need](void*) { need->end(); });
    return queue.run(kFramePatience, [request, need, &queue](Renderer& renderer) {
        const auto end = Clock::now() + kMaxWhileOthersWait;
        return drawTimed(renderer, request, [&] {
            return need->isGone() || (Clock::now() > end && queue.hasWaiting());
        });
    });
}

}  // namespace

DrawnFrame drawInQueue(const JobResources& resources, const FrameRequest& request,
                       const JobControl& control) {
    const auto cancelled = [&] { return !control.proceed(0.0); };
    for (int interruptions = 0;;) {
        if (cancelled()) throw JobCancelled{};
        try {
            const auto scene = resources.library.require(request.scene);
            const auto maps = resources.library.environments().requireUploads(request);
            if (request.effects.indirectLight) {
                const LightState light = resources.queue.run(
                    kFramePatience,
                    [request](Renderer& renderer) { return renderer.light(request); });
                if (light.wait) light.wait(cancelled);
                if (cancelled()) throw JobCancelled{};
            }
            return drawOnce(resources.queue, request, control);
        } catch (const FrameAbandoned&) {
            if (cancelled()) throw JobCancelled{};
            if (++interruptions == kMaxInterruptions) {
                throw RequestError(
                    tooLongForJob(std::chrono::duration<double>(kMaxWhileOthersWait).count()));
            }
        } catch (const RequestError& error) {
            const ProblemCode code = error.problem().code;
            if (code != ProblemCode::queueFull && code != ProblemCode::stillLoading) throw;
        }
        std::this_thread::sleep_for(kRetryInterval);
    }
}

}  // namespace clerestory
