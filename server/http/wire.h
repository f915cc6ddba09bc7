// What every answer carries, and the bytes of an answer that is written without the library.
#pragma once

#include "server/base/call.h"

#include <span>

namespace clerestory {

// Name and value of the headers against sniffing, framing and scripts of others.
std::span<const std::pair<const char*, const char*>> headersOfEveryAnswer();

// A whole answer, head and body, of HTTP/1.1. No body for a HEAD.
std::string wireBytes(const Answer& answer, const std::string& requestId, bool keepAlive,
                      bool isHead);

// The client's own id when it is plain, otherwise a new one.
std::string requestIdFrom(std::string_view given);

}  // namespace clerestory
