#include "server/base/log.h"

#include <spdlog/async.h>
#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

#include <array>
#include <charconv>
#include <memory>

namespace clerestory {
namespace {

constexpr std::size_t kLogLines = 8192;  // size of the buffer

void write(spdlog::level::level_enum level, LogParts parts) noexcept {
    if (!spdlog::should_log(level)) return;
    try {
        spdlog::memory_buf_t line;
        for (const std::string_view part : parts)
            line.append(part.data(), part.data() + part.size());
        spdlog::log(level, spdlog::string_view_t(line.data(), line.size()));
    } catch (const std::exception&) {  // out of memory: the line is lost
    }
}

}  // namespace

void logToStandardError() {
    spdlog::set_default_logger(spdlog::stderr_logger_mt("clerestory"));
}

void logWithoutWaiting() {
    spdlog::init_thread_pool(kLogLines, 1);
    spdlog::set_default_logger(std::make_shared<spdlog::async_logger>(
        "clerestory", std::make_shared<spdlog::sinks::stderr_sink_mt>(), spdlog::thread_pool(),
        spdlog::async_overflow_policy::overrun_oldest));
}

void setLogLevel(const std::string& level) {
    spdlog::set_level(spdlog::level::from_str(level));
}

std::size_t logLinesDropped() {
    const auto pool = spdlog::thread_pool();
    return pool ? pool->overrun_counter() : 0;
}

void logDebug(LogParts parts) {
    write(spdlog::level::debug, parts);
}
void logInfo(LogParts parts) {
    write(spdlog::level::info, parts);
}
void logWarning(LogParts parts) {
    write(spdlog::level::warn, parts);
}
void logError(LogParts parts) {
    write(spdlog::level::err, parts);
}
void logCritical(LogParts parts) {
    write(spdlog::level::critical, parts);
}

std::string fixedPoint(double value, int places) {
    std::array<char, 512> text;  // the longest double has 309 digits before the point
    const auto [end, error] = std::to_chars(text.data(), text.data() + text.size(), value,
                                            std::chars_format::fixed, places);
    return {text.data(), end};
}

}  // namespace clerestory
