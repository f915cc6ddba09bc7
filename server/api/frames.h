// Frames and plans over HTTP.
#pragma once

#include "plan/request/frame_request.h"
#include "scene/scene.h"
#include "server/base/call.h"
#include "server/queue/render_queue.h"

namespace clerestory {

class Service;

Answer postFrame(Service& service, const Call& call);
Answer getFrame(Service& service, const Call& call);
Answer postPlan(Service& service, const Call& call);

// For every route whose body is a frame's, or begins as one.

// Throws RequestError 415.
void requireJsonType(const Call& call);
// A POST's query holds nothing but `explain`. Throws RequestError 422.
void requireQuery(const Call& call, bool explainAllowed);
// How the call's work stands in line, with what is left of its deadline: the server's, or an
// earlier one of the header Clerestory-Deadline. Throws RequestError 400 when that is no number.
Turn turnOf(Service& service, const Call& call, std::uint64_t kind = 0);
// All that can change a byte of the answer: the request, and what stands behind its names.
std::string contentText(Service& service, const Scene& scene, const FrameRequest& request);

}  // namespace clerestory
