// The running server: connects the HTTP server with the backend that renders, live views and
// uploads. Logs and counts every answer.
#pragma once

#include "server/api/backend.h"
#include "server/api/frame_cache.h"
#include "server/api/request_metrics.h"
#include "server/api/route_table.h"
#include "server/config.h"
#include "server/http/http_server.h"
#include "server/live/frame_source.h"
#include "server/live/live_views.h"
#include "server/scenes/upload_store.h"

#include <atomic>
#include <memory>
#include <optional>
#include <thread>

namespace clerestory {

class Server {
public:
    // Returns when the port is bound and the renderer created; answers nothing before start().
    // Throws std::runtime_error with a one-line message.
    explicit Server(const Config& config);
    ~Server();
    Server(const Server&) = delete;
    Server& operator=(const Server&) = delete;

    void start();
    // Refuses new frames (503), finishes the accepted ones, then closes the port.
    void stop();

    int port() const { return http_.port(); }
    RenderBackend& backend() { return *backend_; }
    // Without those of the backend.
    const Routes& routes() const { return routes_; }

private:
    Answer answer(const Call& call);
    std::optional<Answer> quickAnswer(const Call& call, std::string_view body);
    Answer refuse(const Call& call, const Problem& problem);
    Answer finish(const Call& call, Answer answer, const std::string& route);
    Answer answerWaiting(const Call& call);
    Answer answerFrom(const Call& call, std::string& route);

    RequestMetrics metrics_;
    std::optional<UploadStore> uploads_;  // empty: uploads are not allowed
    std::atomic<bool> stopping_{false};
    Routes routes_;
    HttpServer http_;  // before the backend: a port that is in use is found at once
    StreamSlots streams_;
    LiveViews views_;
    std::unique_ptr<RenderBackend> backend_;
    std::optional<FrameCache> cache_;
    std::optional<FrameSource> frames_;
    std::thread listener_;
};

}  // namespace clerestory
