// Call, Answer and lists of ids <-> bytes, for the way between front and worker. Times travel as
// they are: both processes read the same clock.
#pragma once

#include "server/base/call.h"

namespace clerestory {

// Of the headers only those travel that some route of the worker reads.
std::string packed(const Call& call);
// Without a stream, which cannot travel.
std::string packed(const Answer& answer);
std::string packed(const std::vector<std::string>& ids);

// Throw std::runtime_error for bytes that are not of packed().
Call unpackedCall(std::string_view bytes);
Answer unpackedAnswer(std::string_view bytes);
std::vector<std::string> unpackedIds(std::string_view bytes);

}  // namespace clerestory
