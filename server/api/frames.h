// The routes of frames and plans, and checks for routes with a JSON body.
#pragma once

#include "plan/request/frame_request.h"
#include "server/api/frame_service.h"
#include "server/api/route_table.h"
#include "server/base/call.h"

#include <chrono>
#include <optional>
#include <string>

namespace clerestory {

struct FrameRoutes {
    FrameService& frames;
    bool signedLinks = false;  // a link's query also has a signature, which was checked before
};
void addRoutes(Routes& routes, const FrameRoutes& components);

// What the query parameter `explain` adds to a frame.
enum class Explain { no, plan, health, maps };

// What a call of /v1/frames or /v1/plans requests, by GET or POST.
struct FrameCall {
    FrameRequest request;
    Explain explain = Explain::no;
};
// `signedLinks` as in FrameRoutes. Throws RequestError 400, 415, 422.
FrameCall frameCallFrom(const Call& call, bool signedLinks);

// Whether an If-None-Match header names the entity tag.
bool matchesEntityTag(const std::string& ifNoneMatch, const std::string& etag);

// Throws RequestError 415 if the body is not JSON by its Content-Type.
void requireJsonType(const Call& call);
// Throws RequestError 422 if the query of a POST has any name but `explain`.
void requireQuery(const Call& call, bool explainAllowed);
// The call's turn in the render queue, with the rest of its deadline: the server's, or that of the
// header Clerestory-Deadline if it is earlier. Throws RequestError 400 for a malformed header.
Turn turnOf(const FrameService& frames, const Call& call);
// The header Clerestory-Deadline. Throws RequestError 400 if it is malformed.
std::optional<std::chrono::milliseconds> deadlineIn(const Call& call);

}  // namespace clerestory
