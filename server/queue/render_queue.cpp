#include "server/queue/render_queue.h"

#include "server/base/log.h"
#include "server/base/process.h"

#include "plan/graph/work.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace clerestory {
namespace {

// After this idle time the memory is released that compilation and loading needed.
constexpr std::chrono::seconds kIdleTime{1};
// After this one also what frames keep for the next one, which then takes longer: by
// 0.1 s in the chapel at 1280x720.
constexpr std::chrono::seconds kRestTime{10};

// Cannot be the id of a scene of the library.
const char* const kCanaryScene = "(canary)";
// How long a drawn frame, or a compiled shader, counts as a check.
constexpr std::chrono::seconds kCanaryLifetime{3};
constexpr std::chrono::seconds kCanaryPatience{2};

std::int64_t nowMilliseconds() {
    return std::chrono::ceil<std::chrono::milliseconds>(Clock::now().time_since_epoch()).count();
}

// Frames of fewer samples say little about the time of a sample.
constexpr std::uint64_t kMinPricedSamples = 100'000;

// No surfaces under an environment of radiance 1: every pixel must be white.
Scene canaryScene() {
    Scene scene;
    scene.id = kCanaryScene;
    scene.environment = "white";
    scene.defaultView = DefaultView{};
    updateContentHash(scene);
    return scene;
}

FrameRequest canaryRequest() {
    FrameRequest request;
    request.scene = kCanaryScene;
    request.width = request.height = 4;
    request.toneMap = ToneMap::linear;
    request.accuracy = accuracyOf(Preset::draft);
    return request;
}

std::uint64_t objectsOf(const RendererCounters& counters) {
    return counters.programsMade + counters.texturesMade + counters.buffersMade;
}

}  // namespace

void SamplePrice::update(std::uint64_t samples, double seconds) {
    if (samples < kMinPricedSamples) return;
    const double latest = seconds / static_cast<double>(samples);
    if (secondsPerSample_ == 0.0 || latest < secondsPerSample_) secondsPerSample_ = latest;
}

double SamplePrice::leastSeconds(std::uint64_t samples) const {
    return secondsPerSample_ * static_cast<double>(samples);
}

RenderQueue::RenderQueue(const RendererOptions& options, const FairQueue::Limits& limits)
    : queue_(limits),
      identity_(made_.get_future().share()),
      thread_([this, options] { serve(options); }) {}

RenderQueue::~RenderQueue() {
    {
        const std::lock_guard lock(mutex_);
        refusing_ = true;
        ending_ = true;
    }
    wake_.notify_all();
    thread_.join();
}

const RendererIdentity& RenderQueue::identity() const {
    return identity_.get();
}

void RenderQueue::post(Work work) {
    {
        const std::lock_guard lock(mutex_);
        if (ending_) return;
        posted_.push_back(std::move(work));
    }
    wake_.notify_one();
}

void RenderQueue::inBackground(std::function<bool(Renderer&)> step) {
    {
        const std::lock_guard lock(mutex_);
        if (ending_) return;
        background_.push_back(std::move(step));
    }
    wake_.notify_one();
}

// With the lock held: the time without that of compilation.
Clock::time_point RenderQueue::queueTime() const {
    return compilingSince_.value_or(Clock::now()) - compiled_;
}

// On the renderer's thread, within a piece of work.
void RenderQueue::compiling(bool begins) {
    const std::lock_guard lock(mutex_);
    const auto now = Clock::now();
    lastCompiled_ = now;
    if (begins) {
        compilingSince_ = now;
        return;
    }
    compiled_ += now - *compilingSince_;
    compilingSince_.reset();
    if (workingSince_) workingSince_ = now;
}

CompileTotals RenderQueue::compileTotals() const {
    const std::lock_guard lock(mutex_);
    return compileTotals_;
}

bool RenderQueue::compiledSince(Clock::time_point then) const {
    const std::lock_guard lock(mutex_);
    return compilingSince_ || lastCompiled_ >= then;
}

RenderQueue::Place::Place(RenderQueue& queue, const Turn& turn, Work work)
    : owner_(queue), cancellation_(turn.cancellation), patience_(turn.patience) {
    const auto patience = std::chrono::duration_cast<Clock::duration>(turn.patience);
    longest_ =
        Clock::now() + patience + std::chrono::duration_cast<Clock::duration>(turn.compilePatience);
    {
        const std::lock_guard lock(queue.mutex_);
        deadline_ = queue.queueTime() + patience;
    }
    id_ = queue.push(turn, deadline_, {std::move(work), dropped_, turn.cancellation, deadline_});
    if (cancellation_) cancellation_->onCancel([this] { owner_.withdraw(id_, clientLeft()); });
}

Clock::duration RenderQueue::Place::left() const {
    const std::lock_guard lock(owner_.mutex_);
    const auto now = Clock::now();
    const Clock::duration inQueueTime = deadline_ - owner_.queueTime();
    if (inQueueTime <= Clock::duration::zero()) {
        throw RequestError(overDeadline(patience_.count()));
    }
    if (now >= longest_) throw RequestError(stillCompiling(owner_.compileTotals_.programs));
    return std::min(inQueueTime, longest_ - now);
}

RenderQueue::Place::~Place() {
    if (cancellation_) cancellation_->onCancel(nullptr);
    owner_.withdraw(id_, internalError());  // the reason is not used
}

FairQueue::Id RenderQueue::push(const Turn& turn, Clock::time_point deadline, Job job) {
    std::vector<Job> gone;  // destroyed after the lock, which wakes the threads that wait
    FairQueue::Id id = 0;
    {
        const std::lock_guard lock(mutex_);
        if (refusing_) throw RequestError(shuttingDown());
        const auto now = queueTime();
        if (deadline <= now) throw RequestError(overDeadline(turn.patience.count()));
        const FairQueue::Added added = queue_.add({turn.client, turn.kind, deadline}, now);
        for (const FairQueue::Id out : added.evicted)
            gone.push_back(dropped(out, queueFull(queue_.retryAfterSeconds())));
        if (!added.id) throw RequestError(queueFull(queue_.retryAfterSeconds()));
        id = *added.id;
        try {
            jobs_.emplace(id, std::move(job));
        } catch (...) {  // out of memory: undo
            queue_.remove(id);
            throw;
        }
    }
    wake_.notify_one();
    return id;
}

// With the lock held: removes a job that is no longer queued.
RenderQueue::Job RenderQueue::dropped(FairQueue::Id id, const Problem& why) {
    const auto found = jobs_.find(id);
    Job job = std::move(found->second);
    jobs_.erase(found);
    *job.dropped = why;
    if (jobs_.empty() && !running_) idle_.notify_all();
    return job;
}

void RenderQueue::withdraw(FairQueue::Id id, const Problem& why) {
    Job gone;
    const std::lock_guard lock(mutex_);
    if (queue_.remove(id)) gone = dropped(id, why);
}

void RenderQueue::refuseNew() {
    std::unique_lock lock(mutex_);
    refusing_ = true;
    idle_.wait(lock, [&] { return jobs_.empty() && !running_; });
}

std::optional<Problem> RenderQueue::refusalFor(const std::string& client) const {
    const std::lock_guard lock(mutex_);
    if (refusing_) return shuttingDown();
    if (queue_.refuses(client)) return queueFull(queue_.retryAfterSeconds());
    return std::nullopt;
}

std::size_t RenderQueue::depth() const {
    const std::lock_guard lock(mutex_);
    return jobs_.size() + (running_ ? 1 : 0);
}

QueueUsage RenderQueue::usage() const {
    const std::lock_guard lock(mutex_);
    return queue_.usage();
}

bool RenderQueue::hasWaiting() const {
    const std::lock_guard lock(mutex_);
    return !jobs_.empty();
}

bool RenderQueue::hasRoom() const {
    const std::lock_guard lock(mutex_);
    return queue_.hasRoom();
}

void RenderQueue::serve(const RendererOptions& options) {
    std::unique_ptr<Renderer> renderer;
    try {
        RendererOptions own = options;
        own.onCompiling = [this](bool begins) { compiling(begins); };
        own.beforeDrawing = [this, next = options.beforeDrawing](const FramePlan& plan) {
            requireTime(plan);
            if (next) next(plan);
        };
        renderer = std::make_unique<Renderer>(own);
        made_.set_value(renderer->identity());
    } catch (...) {
        made_.set_exception(std::current_exception());
        return;
    }
    std::unique_lock lock(mutex_);
    for (;;) {
        const auto asked = [&] {
            return ending_ || !posted_.empty() || !jobs_.empty() || !background_.empty();
        };
        while (!wake_.wait_for(lock, kIdleTime, asked)) releaseIdleMemory(*renderer, lock);
        const bool background = !background_.empty() && !ending_;
        if (!posted_.empty()) {
            servePosted(*renderer, lock);
        } else if (!jobs_.empty() && !(background && backgroundIsNext_)) {
            backgroundIsNext_ = true;
            serveOne(*renderer, lock);
        } else if (background) {
            backgroundIsNext_ = false;
            serveBackground(*renderer, lock);
        } else if (ending_) {
            return;
        }
        const RendererCounters made = renderer->counters();
        compileTotals_ = {made.programsMade, made.pipelinesMade, 1e-3 * made.compileMilliseconds};
    }
}

// Within a piece of work: refuses a frame that cannot be finished before its deadline, before
// others wait for it. A frame without a time of its own, such as a step of a job, has none.
void RenderQueue::requireTime(const FramePlan& plan) {
    const std::lock_guard lock(mutex_);
    if (!running_) return;
    running_->samples = shadedSamples(plan);
    const double needed = samplePrice_.leastSeconds(running_->samples);
    const std::chrono::duration<double> left = running_->deadline - queueTime();
    if (needed <= left.count()) return;
    running_->samples = 0;  // its time says nothing
    throw RequestError(tooLongForDeadline(needed, left.count()));
}

bool RenderQueue::isOverdue() const {
    const std::lock_guard lock(mutex_);
    return running_ && queueTime() >= running_->deadline;
}

std::shared_ptr<CancellationToken> RenderQueue::runningToken() const {
    const std::lock_guard lock(mutex_);
    return running_ ? running_->cancellation : nullptr;
}

void RenderQueue::servePosted(Renderer& renderer, std::unique_lock<std::mutex>& lock) {
    Work work = std::move(posted_.front());
    posted_.pop_front();
    workingSince_ = Clock::now();
    lock.unlock();
    try {
        work(renderer);
    } catch (const std::exception& error) {
        logError({"work on the OpenGL thread failed: ", error.what()});
    }
    work = nullptr;  // its destructor must not run under the lock
    lock.lock();
    workingSince_.reset();
}

void RenderQueue::serveBackground(Renderer& renderer, std::unique_lock<std::mutex>& lock) {
    std::function<bool(Renderer&)> step = std::move(background_.front());
    background_.pop_front();
    workingSince_ = Clock::now();
    lock.unlock();
    bool more = false;
    try {
        more = step(renderer);
    } catch (const std::exception& error) {
        logError({"background work on the OpenGL thread failed: ", error.what()});
    }
    if (!more) step = nullptr;
    lock.lock();
    if (more) background_.push_front(std::move(step));
    workingSince_.reset();
}

// Called with the lock held after each idle time. Compilation and loading fragment the heap: up to
// 90 MB after an empty shader cache. Frames that create no objects do not need that again.
void RenderQueue::releaseIdleMemory(Renderer& renderer, std::unique_lock<std::mutex>& lock) {
    const RendererCounters now = renderer.counters();
    const bool hasMade = std::exchange(objectsMade_, objectsOf(now)) != objectsOf(now);
    // Triangles, because a canary frame has none and keeps nothing.
    const bool hasDrawn = std::exchange(trianglesDrawn_, now.triangles) != now.triangles;
    if (hasDrawn) programsReleased_ = false;
    if (hasDrawn || hasMade) {
        idleSince_ = Clock::now() - kIdleTime;
        resting_ = false;
    }
    const bool rests = !resting_ && Clock::now() - idleSince_ >= kRestTime;
    if (!hasMade && !rests) return;
    // Once: a canary frame makes a few again.
    const bool releasesPrograms = standby_ && !programsReleased_ && renderer.identity().software;
    lock.unlock();
    if (rests) {
        if (releasesPrograms) renderer.releasePrograms();
        programsReleased_ = programsReleased_ || releasesPrograms;
        renderer.releaseScratch();
        resting_ = true;
        objectsMade_ = objectsOf(renderer.counters());
    }
    renderer.releaseCompiler();
    releaseUnusedMemory();
    lock.lock();
}

void RenderQueue::setStandby(bool standby) {
    const std::lock_guard lock(mutex_);
    standby_ = standby;
    resting_ = false;
}

std::chrono::duration<double> RenderQueue::workingFor() const {
    const std::lock_guard lock(mutex_);
    if (!workingSince_) return std::chrono::duration<double>(0.0);
    return Clock::now() - *workingSince_;
}

// Runs one piece of a client's work; drops work whose deadline has passed.
void RenderQueue::serveOne(Renderer& renderer, std::unique_lock<std::mutex>& lock) {
    std::vector<Job> gone;
    Job job;
    const auto began = queueTime();
    const FairQueue::Next next = queue_.next(began);
    for (const FairQueue::Id late : next.expired) gone.push_back(dropped(late, overDeadline(0.0)));
    if (next.id) {
        workingSince_ = Clock::now();
        const auto found = jobs_.find(*next.id);
        job = std::move(found->second);
        jobs_.erase(found);
        running_ = Running{.cancellation = job.cancellation, .deadline = job.deadline};
    }
    lock.unlock();
    gone.clear();
    const std::uint64_t made = objectsOf(renderer.counters());
    if (job.work) job.work(renderer);  // a packaged task: does not throw
    job.work = nullptr;
    const bool warm = objectsOf(renderer.counters()) == made;
    lock.lock();
    if (!next.id) return;
    const auto now = queueTime();
    const bool complete =
        (!job.cancellation || !job.cancellation->cancelled()) && now < job.deadline;
    queue_.finished(*next.id, now, complete);
    const std::chrono::duration<double> took = now - began;
    // Another frame does not repeat what was made for this one.
    if (complete && warm) samplePrice_.update(running_->samples, took.count());
    running_.reset();
    if (jobs_.empty()) idle_.notify_all();
    lock.unlock();
    try {
        renderer.beginNeededLights();
    } catch (const std::exception& error) {
        logError({"light between surfaces could not be begun: ", error.what()});
    }
    lock.lock();
    workingSince_.reset();
}

Canary::Canary(RenderQueue& queue) : queue_(queue) {
    queue_.post([](Renderer& renderer) { renderer.addScene(canaryScene()); });
}

void Canary::frameWasDrawn() {
    lastDrawn_ = nowMilliseconds();
}

void Canary::check() {
    // The driver compiles on the renderer's thread, so that a compiled shader shows that both work.
    const auto start = Clock::now();
    if (queue_.compiledSince(start - kCanaryLifetime)) return;
    const std::int64_t age = nowMilliseconds() - lastDrawn_;
    if (age < std::chrono::milliseconds(kCanaryLifetime).count()) return;
    Image image;
    try {
        image = queue_.run(
            Turn{.patience = kCanaryPatience, .compilePatience = std::chrono::seconds(0)},
            [](Renderer& r) { return r.render(canaryRequest()).image; });
    } catch (const RequestError& error) {
        // A busy renderer is no broken one: the watchdog ends one that hangs.
        if (queue_.compiledSince(start) || queue_.workingFor() > kCanaryPatience ||
            error.problem().code == ProblemCode::queueFull) {
            return;
        }
        logError({"the canary frame failed: ", error.what()});
        throw RequestError(notReady("A canary frame could not be drawn."));
    } catch (const std::exception& error) {
        if (queue_.compiledSince(start)) return;
        logError({"the canary frame failed: ", error.what()});
        throw RequestError(notReady("A canary frame could not be drawn."));
    }
    const bool white = std::all_of(image.data.begin(), image.data.end(),
                                   [](std::byte b) { return b == std::byte{255}; });
    if (!white || image.data.empty()) {
        throw RequestError(notReady("A canary frame has wrong pixels."));
    }
    frameWasDrawn();
}

}  // namespace clerestory
