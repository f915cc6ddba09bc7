// The options of `clerestory serve`.
#pragma once

#include "server/backend/local_backend.h"
#include "server/http/http_server.h"
#include "server/scenes/cache_folder.h"
#include "server/scenes/scene_library.h"
#include "server/worker/supervisor.h"
#include "server/worker/worker.h"
#include "server/worker/worker_backend.h"

namespace clerestory {

// Samples that one frame may shade unless --max-work says otherwise; see plan/graph/work.h.
inline constexpr std::uint64_t kMaxSamplesServed = 2'000'000'000;

struct Config {
    RendererOptions renderer;
    HttpServerOptions http;
    SceneSources scenes;
    CacheOptions cache;
    std::filesystem::path shaderCache;         // see useShaderCache()
    std::shared_ptr<const CurveStore> curves;  // of budgets; null: kept in memory alone
    std::size_t queue = 16;                    // frames that may wait
    double queueSeconds = 2.0;                 // of predicted work that may wait
    double deadlineSeconds = 10.0;             // from a request's arrival to its answer
    std::size_t frameCacheBytes = 64 << 20;    // see FrameCache::Options::maxBytes
    std::size_t sequenceBytes = 4 << 20;       // of a sequence's body
    std::string logLevel = "info";
    // The renderer in this process; otherwise in workers, which `workers` says how to start.
    bool singleProcess = true;
    SupervisorOptions workers;
    bool fastStart = true;      // see SupervisorOptions::compileFastFirst
    double hangSeconds = 60.0;  // a worker that draws one thing for longer is ended
    std::uint64_t workerMemoryBytes = 8ull << 30;  // address space; 0: any
};

// The part of the options that a backend in this process needs.
LocalBackendOptions localBackendOptions(const Config& config);
// The part that a worker process needs.
WorkerOptions workerOptions(const Config& config);
// The part that the server needs to run workers.
WorkerBackendOptions workerBackendOptions(const Config& config);

}  // namespace clerestory
