// The queue of the server's process where it has several renderers: one bounded, fair queue, whose
// next entry goes to the first free renderer that holds its scene. Thread-safe.
//
//     const RendererQueue::Place place = queue.take(turn, {.scene = "chapel"});
//     Answer answer = supervisor.ask(call, place.renderer());
//
// Each renderer has one entry at a time, so that no entry waits behind another one while some other
// renderer is free.
#pragma once

#include "server/api/backend.h"
#include "server/queue/fair_queue.h"
#include "server/queue/render_queue.h"

#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

namespace clerestory {

// Of one of several renderers.
struct RendererState {
    bool isPresent = false;                      // its process runs
    bool isCompiling = false;                    // shaders, now or a moment ago
    std::uint64_t number = 0;                    // Answer::worker
    std::shared_ptr<const LoadedScenes> loaded;  // null until it is warm
};

// What an entry of the queue requires of its renderer.
struct RendererNeed {
    std::string scene;       // id; empty: the default scene
    bool onlyFirst = false;  // work that depends on what one renderer has measured
};

// The renderer for all that is not a frame: the first one whose process runs.
std::size_t firstRenderer(const std::vector<RendererState>& states);
// The scenes of all that are warm, without those that they hold with different contents; null if
// none is warm.
std::shared_ptr<const LoadedScenes> loadedInAll(const std::vector<RendererState>& states);
// A frame goes to a renderer that holds its scene. A scene that none holds is loaded by the first
// renderer; the others follow.
bool isLoaded(const std::vector<RendererState>& states, const std::string& scene);
bool mayDraw(const std::vector<RendererState>& states, const RendererNeed& need,
             std::size_t renderer);

class RendererQueue {
public:
    // One element for each renderer; it must not use this queue.
    using States = std::function<std::vector<RendererState>()>;

    // `limits.servers` is the number of renderers.
    RendererQueue(const FairQueue::Limits& limits, States states)
        : states_(std::move(states)), queue_(limits), busy_(limits.servers) {}

    // A renderer for the time of one frame.
    class Place {
    public:
        ~Place() { queue_.leave(renderer_); }
        Place(const Place&) = delete;
        Place& operator=(const Place&) = delete;
        std::size_t renderer() const { return renderer_; }

    private:
        friend class RendererQueue;
        Place(RendererQueue& queue, std::size_t renderer) : queue_(queue), renderer_(renderer) {}
        RendererQueue& queue_;
        const std::size_t renderer_;
    };

    // Waits for a renderer. The deadline of the turn stands still while shaders are compiled, as in
    // RenderQueue. Throws RequestError: full, stopping, left, or compiling for too long (503), over
    // the deadline (504).
    Place take(const Turn& turn, const RendererNeed& need);

    // The problem with which take() would certainly refuse this client now. Does not block.
    std::optional<Problem> refusalFor(const std::string& client) const;

    // From now on take() refuses; returns when every place is left.
    void refuseNew();

    QueueUsage usage() const;  // of what waits
    bool hasRoom() const;

private:
    struct Waiting {
        const RendererNeed& need;
        std::optional<std::size_t> renderer;
        std::optional<Problem> problem;
    };
    Clock::time_point queueTime(const std::vector<RendererState>& states);
    void dispatch();
    void leave(std::size_t renderer);

    const States states_;
    mutable std::mutex mutex_;
    std::condition_variable changed_;
    FairQueue queue_;
    std::unordered_map<FairQueue::Id, Waiting*> waiting_;
    std::vector<std::optional<FairQueue::Id>> busy_;  // by renderer
    Clock::duration compiled_{};                      // time that compiling took in all
    std::optional<Clock::time_point> compilingSince_;
    bool refusing_ = false;
};

}  // namespace clerestory
