// The running server: the way in, whoever draws behind it, and what needs no renderer.
#pragma once

#include "server/api/request_metrics.h"
#include "server/worker/job_journal.h"
#include "server/live/live_views.h"
#include "server/live/streams.h"
#include "server/worker/overload_cache.h"
#include "server/service.h"
#include "server/worker/supervisor.h"

#include <thread>

namespace clerestory {

// Whether a call waits in the line before the renderer.
bool takesTurn(const Call& call);

class Server {
public:
    // Port and renderer stand when this returns; nobody is answered before start(). Throws
    // std::runtime_error with one line for people.
    explicit Server(const Config& config);
    ~Server();
    Server(const Server&) = delete;
    Server& operator=(const Server&) = delete;

    void start();
    // Refuses new frames (503) while those it has are finished, then closes the port.
    void stop();
    // Whoever sends for longer than a frame takes looks at it now and then.
    bool stopping() const { return stopping_; }

    // The answer of whoever draws, in this process or in another. Throws RequestError when there is
    // nobody, or the server stops.
    Answer ask(const Call& call);
    // Why it would surely be refused now, as far as that is known without asking. Does not wait.
    std::optional<Problem> refusalFor(const Call& call) const;

    int port() const { return http_.port(); }
    RequestMetrics& metrics() { return metrics_; }
    const ConnectionCounters& connections() const { return http_.counters(); }
    Streams& streams() { return streams_; }
    LiveViews& views() { return views_; }
    // Null when nobody may upload.
    UploadStore* uploads() { return uploads_ ? &*uploads_ : nullptr; }
    const ImportLimits& uploadLimits() const { return uploadLimits_; }

    // Null when it lives in a worker.
    Service* service() { return service_.get(); }
    // Null when the service lives here.
    Supervisor* supervisor() { return supervisor_.get(); }

private:
    RequestMetrics metrics_;
    Streams streams_;
    LiveViews views_;
    std::optional<UploadStore> uploads_;
    const ImportLimits uploadLimits_;
    std::atomic<bool> stopping_{false};
    HttpServer http_;  // binds before there is a renderer: a taken port is known at once
    std::unique_ptr<Service> service_;
    std::unique_ptr<Supervisor> supervisor_;
    OverloadCache overloadCache_;  // of the worker, as JobJournal
    JobJournal jobs_;
    std::thread listener_;
};

}  // namespace clerestory
