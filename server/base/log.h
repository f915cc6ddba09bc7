// The program's log, one line a call. Only log.cpp includes spdlog: a formatted spdlog call costs
// about four seconds of compilation in each file that contains one.
#pragma once

#include <cstddef>
#include <initializer_list>
#include <string>
#include <string_view>

namespace clerestory {

// Every command's log: lines to standard error, written by the calling thread.
void logToStandardError();
// The server's: a thread of its own writes, and when nobody reads, the oldest lines are dropped.
void logWithoutWaiting();
// debug, info, warn, error or off; lines below it are not written.
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

// A number with that many decimal places.
std::string fixedPoint(double value, int places);

}  // namespace clerestory
