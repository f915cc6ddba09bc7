// The routes of what the renderer holds: scenes, its identity and limits, readiness, metrics.
#pragma once

#include "server/api/backend.h"
#include "server/api/metrics.h"
#include "server/api/route_table.h"
#include "server/jobs/jobs.h"
#include "server/queue/render_queue.h"
#include "server/scenes/scene_library.h"

#include <string>
#include <vector>

namespace clerestory {

// For GET /v1/renderer, in addition to those of the renderer.
struct ServerLimits {
    std::size_t bodyBytes = 0;
    std::size_t sequenceBytes = 0;
    std::size_t uploadBytes = 0;  // 0: no uploads
    std::size_t frameCacheBytes = 0;
    std::size_t queue = 0;  // frames that may wait
    double deadlineSeconds = 0.0;
};

struct RendererRoutes {
    RenderQueue& queue;
    SceneLibrary& library;
    const Jobs& jobs;
    Metrics& metrics;
    Canary& canary;
    ServerLimits limits;
};
void addRoutes(Routes& routes, const RendererRoutes& components);

// The body of GET /v1/scenes/{id}.
std::string sceneDescription(SceneLibrary& library, const SceneStatus& status);

// The body of GET /v1/renderer of one of several renderers, with a list of all of them.
std::string withRenderers(const std::string& body, const std::vector<RendererSummary>& renderers);

}  // namespace clerestory
