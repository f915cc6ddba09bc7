// The routes of frames and plans, and checks for routes with a JSON body.
#pragma once

#include "server/api/frame_service.h"
#include "server/api/route_table.h"
#include "server/base/call.h"

namespace clerestory {

struct FrameRoutes {
    FrameService& frames;
    bool signedLinks = false;  // a link's query also has a signature, which was checked before
};
void addRoutes(Routes& routes, const FrameRoutes& components);

// Throws RequestError 415 if the body is not JSON by its Content-Type.
void requireJsonType(const Call& call);
// Throws RequestError 422 if the query of a POST has any name but `explain`.
void requireQuery(const Call& call, bool explainAllowed);
// The call's turn in the render queue, with the rest of its deadline: the server's, or that of the
// header Clerestory-Deadline if it is earlier. Throws RequestError 400 for a malformed header.
Turn turnOf(const FrameService& frames, const Call& call);

}  // namespace clerestory
