#include "server/scenes/warm_ups.h"

#include "server/scenes/compile_ahead.h"
#include "server/scenes/shader_cache.h"

namespace clerestory {

struct WarmUps::Task {
    std::vector<FrameRequest> frames;
    std::function<void()> whenFinished;
    std::optional<WarmUp> warmUp;  // used on the renderer's thread
    std::atomic<std::size_t> done{0}, total{0};
    std::atomic<bool> finished{false};  // or cancelled
};

namespace {

std::string markOf(const Scene& scene) {
    return "first frames of " + std::to_string(scene.contentHash);
}

}  // namespace

WarmUps::WarmUps(RenderQueue& queue, const RendererOptions& options)
    : queue_(queue), options_(options) {}

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
    task->frames = firstFramesOf(scene);
    task->whenFinished = [mark = markOf(scene), then = std::move(whenFinished)] {
        setCompiled(mark);
        if (then) then();
    };
    const std::lock_guard lock(mutex_);
    tasks_[scene.id] = task;
    if (copy && CompileAhead::helps(queue_.identity()) && (!ahead_ || ahead_->ended())) {
        ahead_ = std::make_unique<CompileAhead>(options_, *std::move(copy), std::move(maps),
                                                task->frames, [task] { return !task->finished; });
        aheadOf_ = task;
    }
    queue_.inBackground([task, ending = ending_](Renderer& renderer) {
        if (*ending || task->finished) return false;
        try {
            advance(*task, renderer);
        } catch (...) {
            task->finished = true;
            throw;
        }
        return !task->finished;
    });
}

void WarmUps::forget(const std::string& scene) {
    const std::lock_guard lock(mutex_);
    const auto found = tasks_.find(scene);
    if (found == tasks_.end()) return;
    found->second->finished = true;
    tasks_.erase(found);
}

// One step, on the renderer's thread.
void WarmUps::advance(Task& task, Renderer& renderer) {
    if (!task.warmUp) {
        task.warmUp = renderer.beginWarmUp(task.frames);
        task.total = task.warmUp->total();
        return;
    }
    const bool more = renderer.advance(*task.warmUp);
    task.done = task.warmUp->done();
    if (more) return;
    task.warmUp.reset();
    task.finished = true;
    task.whenFinished();
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
