// Frames and plans over HTTP.
#pragma once

#include "plan/frame_request.h"
#include "scene/scene.h"
#include "server/call.h"

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
// What is left of the deadline.
std::chrono::duration<double> patience(Service& service, const Call& call);
// All that can change a byte of the answer: the request, and what stands behind its names.
std::string contentText(Service& service, const Scene& scene, const FrameRequest& request);

}  // namespace clerestory
