// The routes of clients' own scenes and environment maps: POST /v1/scenes, DELETE /v1/scenes/{id},
// POST /v1/environments and DELETE /v1/environments/{map}. The server keeps the files, so that
// every renderer finds them.
#pragma once

#include "server/api/backend.h"
#include "server/api/route_table.h"
#include "server/base/call.h"
#include "server/base/holdings.h"
#include "server/scenes/upload_store.h"

#include <atomic>
#include <chrono>

namespace clerestory {

struct UploadRoutes {
    RenderBackend& backend;
    UploadStore* store = nullptr;          // null: uploads are not allowed
    std::chrono::milliseconds importTime;  // the longest time that one import may take
    const std::atomic<bool>& stopping;     // the server ends: requests do not wait any longer
    Holdings& holdings;                    // Pool::waits, of uploads that wait for their scenes
};

// POST: the body is the file (a scene of one file, or an archive), the query may have a `title`.
// 201 for a new scene, 200 for a scene that was there, 202 while it loads: if the client prefers
// that, or if as many calls wait as may. Problems: uploads are
// not allowed (403), unknown type (415), no scene in the file (422), no room (507).
// POST of an environment map: the same, but the answer waits until the map is loaded.
void addRoutes(Routes& routes, const UploadRoutes& components);

}  // namespace clerestory
