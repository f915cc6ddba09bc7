#include "server/warm_ups.h"

#include "server/compile_ahead.h"
#include "server/shader_cache.h"

namespace clerestory {

struct WarmUps::Task {
    std::vector<FrameRequest> frames;
    std::function<void()> whenFinished;
    std::optional<WarmUp> warmUp;  // the renderer's own, on its thread
    std::atomic<std::size_t> done{0}, total{0};
    std::atomic<bool> finished{false};
};

WarmUps::WarmUps(RenderQueue& queue, const RendererOptions& options)
    : queue_(queue), options_(options) {}

WarmUps::~WarmUps() {
    *ending_ = true;
}

void WarmUps::begin(Scene copy, std::vector<std::shared_ptr<const EnvironmentMap>> maps,
                    std::function<void()> whenFinished) {
    auto task = std::make_shared<Task>();
    task->frames = firstFramesOf(copy);
    const std::string mark = "first frames of " + std::to_string(copy.contentHash);
    task->whenFinished = [mark, then = std::move(whenFinished)] {
        setCompiled(mark);
        if (then) then();
    };
    const std::lock_guard lock(mutex_);
    tasks_[copy.id] = task;
    if (CompileAhead::helps(queue_.identity()) && !compiledBefore(mark) &&
        (!ahead_ || ahead_->ended())) {
        ahead_ = std::make_unique<CompileAhead>(options_, std::move(copy), std::move(maps),
                                                task->frames, [task] { return !task->finished; });
        aheadOf_ = task;
    }
    queue_.inBackground([task, ending = ending_](Renderer& renderer) {
        if (*ending) return false;
        try {
            advance(*task, renderer);
        } catch (...) {
            task->finished = true;
            throw;
        }
        return !task->finished;
    });
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
