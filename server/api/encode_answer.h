// From a finished frame to the bytes and the media type of an answer; shared with the command line.
#pragma once

#include "image/encode.h"
#include "plan/request/frame_request.h"

#include <string>

namespace clerestory {

std::string_view mediaType(OutputFormat format);

// The format that an Accept header asks for: JPEG wherever it is allowed, otherwise the first of
// ours that is, otherwise JPEG all the same.
OutputFormat formatFor(const std::string& accept);

Bytes encoded(const Image& image, const Output& output);

}  // namespace clerestory
