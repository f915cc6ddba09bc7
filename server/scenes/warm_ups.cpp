#include "server/scenes/warm_ups.h"

#include "server/base/log.h"
#include "server/scenes/compile_ahead.h"
#include "server/scenes/shader_cache.h"

#include <algorithm>

namespace clerestory {

struct WarmUps::Task {
    std::string scene;
    std::vector<FrameRequest> frames;
    std::size_t planned = 0;          // of `frames`
    std::vector<FrameRequest> later;  // last ones first
    std::function<void()> whenFinished;
    std::optional<WarmUp> warmUp;  // used on the renderer's thread
    std::atomic<std::size_t> done{0}, total{0};
    std::atomic<bool> finished{false};  // with `frames`
    std::atomic<bool> cancelled{false};
    std::shared_ptr<const void> work;  // see BackgroundWork; used on the renderer's thread
};

namespace {

std::string markOf(const Scene& scene) {
    return "first frames of " + std::to_string(scene.contentHash);
}

std::string workOf(const std::string& scene) {
    return "compiling the programs of " + scene + " in advance";
}

}  // namespace

WarmUps::WarmUps(RenderQueue& queue, const RendererOptions& options,
                 std::shared_ptr<BackgroundWork> work)
    : queue_(queue), options_(options), work_(std::move(work)) {}

WarmUps::~WarmUps() {
    *ending_ = true;
}

bool WarmUps::needsCopy(const Scene& scene) {
    return !compiledBefore(markOf(scene));
}

void WarmUps::begin(const Scene& scene, std::optional<Scene> copy,
                    std::vector<std::shared_ptr<const EnvironmentMap>> maps,
                    std::function<void()> whenFinished) {
    auto task = std::make_shared<Task>();
    task->scene = scene.id;
    task->frames = firstFramesOf(scene);
    // A process that compiles without optimisation is replaced soon.
    if (queue_.identity().software && !compilesFast()) {
        task->later = nearbyFramesOf(scene);
        std::reverse(task->later.begin(), task->later.end());
    }
    task->whenFinished = [mark = markOf(scene), then = std::move(whenFinished)] {
        setCompiled(mark);
        if (then) then();
    };
    const std::lock_guard lock(mutex_);
    tasks_[scene.id] = task;
    if (copy && CompileAhead::helps(queue_.identity()) && (!ahead_ || ahead_->ended())) {
        if (auto work = work_->begin(workOf(scene.id))) {
            ahead_ = std::make_unique<CompileAhead>(
                options_, *std::move(copy), std::move(maps), task->frames,
                [task, work] { return !task->finished && !task->cancelled; });
            aheadOf_ = task;
        }
    }
    queue_.inBackground([task, work = work_, ending = ending_](Renderer& renderer) {
        if (*ending || task->cancelled) return false;
        if (!task->work) task->work = work->begin(workOf(task->scene));
        bool more = false;
        try {
            more = task->work && advance(*task, renderer);
        } catch (const std::exception& error) {
            logError({workOf(task->scene), ": ", error.what()});
        }
        if (!more) {
            task->work.reset();
            if (!task->finished.exchange(true)) renderer.expectCompilation(task->scene, false);
        }
        return more;
    });
}

void WarmUps::forget(const std::string& scene) {
    const std::lock_guard lock(mutex_);
    const auto found = tasks_.find(scene);
    if (found == tasks_.end()) return;
    found->second->cancelled = true;
    tasks_.erase(found);
}

// One step, on the renderer's thread. Returns whether steps are left.
bool WarmUps::advance(Task& task, Renderer& renderer) {
    if (!task.warmUp) task.warmUp = renderer.beginWarmUp({});
    if (task.planned < task.frames.size()) {
        renderer.extend(*task.warmUp, task.frames[task.planned++]);
        task.total = task.warmUp->total();
        return true;
    }
    const bool more = renderer.advance(*task.warmUp);
    if (!task.finished) task.done = task.warmUp->done();
    if (more) return true;
    if (!task.finished) {
        task.finished = true;
        renderer.expectCompilation(task.scene, false);
        task.whenFinished();
    }
    if (task.later.empty()) {
        task.warmUp.reset();
        return false;
    }
    renderer.extend(*task.warmUp, task.later.back());
    task.later.pop_back();
    return true;
}

WarmUps::Progress WarmUps::of(const std::string& scene) const {
    const std::lock_guard lock(mutex_);
    const auto found = tasks_.find(scene);
    if (found == tasks_.end()) return {};
    const Task& task = *found->second;
    const bool helping = aheadOf_.lock() == found->second && !ahead_->ended();
    return {task.done, task.total, task.finished && !helping};
}

}  // namespace clerestory
