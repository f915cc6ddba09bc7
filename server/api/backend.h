// Where frames are drawn: in this process (server/backend/local_backend.h) or in a worker process
// (server/worker/worker_backend.h).
#pragma once

#include "plan/request/frame_request.h"
#include "server/api/frame_json.h"
#include "server/base/call.h"
#include "server/base/process.h"
#include "server/queue/fair_queue.h"
#include "server/scenes/scene_entries.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace clerestory {

// A frame that the server draws for its own use: for a sequence or a live stream.
struct FrameOrder {
    FrameRequest request;
    bool withPlan = false;
    std::string requestId;      // of the client's request, for the log
    std::string client;         // for which it is drawn; see Call::client
    Clock::time_point arrived;  // the deadline counts from here
    std::shared_ptr<CancellationToken> cancellation = {};  // null: cannot be cancelled
    // Whether a frame that is being drawn ends before its next pass when it is cancelled.
    bool endsInProgress = true;
    // Waits for complete light of surfaces, two minutes at most, without occupying the renderer.
    bool wholeLight = false;
};

struct EncodedFrame {
    std::string type;   // media type
    std::string bytes;  // the encoded picture
    // Time of planning, drawing and encoding; without that of waiting and of compiling shaders.
    double milliseconds = 0.0;
    double lightShare = 1.0;  // of the light of surfaces that it shows; LightProgress::share

    // Empty unless requested with FrameOrder::withPlan.
    std::optional<FrameCamera> camera;
    double passMilliseconds = 0.0;  // sum over the passes
    // planJson() with the time of each pass, as indented text. Opaque like `bytes`: it is copied
    // into a file for the client, and this program does not parse it again.
    std::string plan;
};

// How far a scene is loaded.
struct SceneReport {
    SceneState state = SceneState::waiting;
    bool isKnown = false;         // it was loaded now or earlier: the description is complete
    std::string failure, reason;  // of SceneStatus
    // The finished body of GET /v1/scenes/{id}. Opaque: it is sent to the client unparsed.
    std::string description;
    std::uint64_t worker = 0;  // of Answer::worker
};

// What the renderer holds, as far as the bytes of frames depend on it.
struct LoadedScenes {
    std::string defaultScene;    // id
    std::uint64_t renderer = 0;  // hash over the program, the driver and the environment maps
    // Id and content hash of each loaded scene, the most recently used one last.
    std::vector<std::pair<std::string, std::uint64_t>> scenes;

    bool operator==(const LoadedScenes&) const = default;
};

// Worker processes and their calls; the numbers of events count from the start of the server.
struct WorkerStatus {
    std::uint64_t started = 0;
    std::uint64_t ended = 0;
    std::uint64_t silent = 0;
    std::uint64_t repeatedCalls = 0;
    std::uint64_t quarantinedCalls = 0;
    bool hasStandby = false, standbyIsWarm = false;
    std::size_t active = 0;
    std::size_t warm = 0;  // active ones that have compiled the shaders of the default scene
    std::optional<QueueUsage> queue;  // of several renderers
    std::size_t activeScenes = 0, standbyScenes = 0;
};

// One of several renderers, for GET /v1/renderer.
struct RendererSummary {
    std::uint64_t worker = 0;  // of Answer::worker; 0: it is being started
    bool isWarm = false;
    std::size_t scenes = 0;  // loaded
};

// Thread-safe.
class RenderBackend {
public:
    virtual ~RenderBackend() = default;

    // Answers a client's call on a route of the renderer. Throws RequestError if no renderer is
    // available, and while the server stops.
    virtual Answer answer(const Call& call) = 0;

    // The problem with which a frame or plan of this client would certainly be refused now, as far
    // as this process knows. Does not block.
    virtual std::optional<Problem> refusalFor(const std::string& client) const = 0;

    // Throws RequestError.
    virtual EncodedFrame draw(const FrameOrder& order) = 0;

    // Starts to load the scene if it is not loaded. Throws RequestError 404.
    virtual SceneReport sceneReport(const std::string& id) = 0;

    // As far as this process knows; null if it does not know yet. Does not block. An answer that
    // depends on a change is given after the change is known here.
    virtual std::shared_ptr<const LoadedScenes> loadedScenes() const = 0;

    // Empty where the renderer is in this process.
    virtual std::optional<WorkerStatus> workerStatus() const = 0;

    // A scene file is being read in a way that delays the end of this process.
    virtual bool importing() const = 0;

    // Refuses new frames; returns when the accepted ones are finished.
    virtual void stop() = 0;
};

// Whether a call waits in the render queue.
inline bool needsRenderQueue(const Call& call) {
    return call.path == "/v1/frames" || call.path == "/v1/plans";
}

}  // namespace clerestory
