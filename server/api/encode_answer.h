// Encodes a frame to the bytes, media type and plan of an answer; also used by the command line.
#pragma once

#include "image/image.h"
#include "plan/request/frame_request.h"
#include "server/api/backend.h"

#include <string>

namespace clerestory {

std::string_view mediaType(OutputFormat format);

// The format for an Accept header: JPEG if it is acceptable, otherwise the first supported format
// that is, otherwise JPEG.
OutputFormat formatFor(const std::string& accept);

// A picture in any format but json.
Bytes encoded(const Image& image, const Output& output);
Bytes encoded(const Frame& frame, const Output& output);

// Sets the members of `encoded` that describe the plan.
void addPlan(EncodedFrame& encoded, const Frame& frame);

}  // namespace clerestory
