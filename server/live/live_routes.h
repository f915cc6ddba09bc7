// The routes of many frames in one answer: GET /v1/stream sends a view as motion JPEG; PUT and GET
// of /v1/views/{name} set and read a view that others watch; POST /v1/sequences sends a sequence.
#pragma once

#include "server/api/route_table.h"
#include "server/live/frame_source.h"
#include "server/live/live_views.h"

namespace clerestory {

struct LiveRoutes {
    FrameSource& frames;
    LiveViews& views;
    StreamSlots& slots;
};
void addRoutes(Routes& routes, const LiveRoutes& components);

Answer postSequence(const LiveRoutes& routes, const Call& call);

// The answer when the first frame cannot be drawn. The frame source has counted its problem.
Answer firstFrameRefused(const Problem& problem, const Call& call);

}  // namespace clerestory
