// The log of the program, one line per call. Only log.cpp includes spdlog: a formatted spdlog call
// costs about four seconds of compilation in each file that contains one.
#pragma once

#include <cstddef>
#include <initializer_list>
#include <string>
#include <string_view>

namespace clerestory {

// For commands: lines are written to standard error by the calling thread.
void logToStandardError();
// For the server: a separate thread writes; if its buffer is full, the oldest lines are dropped.
void logWithoutWaiting();
// debug, info, warn, error or off: the minimum level.
void setLogLevel(const std::string& level);
// Lines dropped by logWithoutWaiting() so far.
std::size_t logLinesDropped();

// A line of several parts. Allocates nothing up to 250 bytes, so that a failed allocation can be
// logged.
using LogParts = std::initializer_list<std::string_view>;
void logDebug(LogParts parts);
void logInfo(LogParts parts);
void logWarning(LogParts parts);
void logError(LogParts parts);
void logCritical(LogParts parts);

// The number with `places` decimal places.
std::string fixedPoint(double value, int places);

}  // namespace clerestory
