// A request and its response as the routes see them: plain values without the HTTP library.
#pragma once

#include "server/base/problem.h"
#include "server/base/process.h"

#include <atomic>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace clerestory {

// Signals the work on a request that its client no longer waits for the answer. Thread-safe.
class CancellationToken {
public:
    // Takes no lock: the caller may hold one that the callback takes.
    bool cancelled() const { return cancelled_; }

    // Calls the callback, if one is set. Only the first call has an effect.
    void cancel() {
        const std::lock_guard lock(mutex_);
        if (cancelled_) return;
        cancelled_ = true;
        if (callback_) callback_();
    }

    // Replaces the callback for cancel(); null removes it. Calls it at once if the token is
    // cancelled already. The callback must not use this token.
    void onCancel(std::function<void()> callback) {
        const std::lock_guard lock(mutex_);
        callback_ = std::move(callback);
        if (cancelled_ && callback_) callback_();
    }

private:
    std::mutex mutex_;
    std::atomic<bool> cancelled_ = false;
    std::function<void()> callback_;
};

struct Call {
    std::string method;  // HEAD is passed as GET; its body is removed later
    std::string path;    // decoded, without the query
    std::multimap<std::string, std::string> query;
    std::string target;  // path and query as they were sent; empty for calls of the server itself
    std::string body;
    std::string requestId;
    Clock::time_point arrived;                            // time of its last byte
    std::function<std::string(const char* name)> header;  // empty if absent
    std::string client;                                   // its address, or its name from a proxy
    std::shared_ptr<CancellationToken> cancellation;      // null if rejected before routing
    std::string job = {};  // id of a job that is restarted; clients cannot set it
};

// Sends the next chunk of a response and blocks until the client can receive more. Returns false if
// the client disconnected.
using Sink = std::function<bool(std::string_view piece)>;

// What an answer says of the job that the call is about.
struct JobEvent {
    enum class Kind { started, unknown };
    Kind kind = Kind::started;
    std::string id;
};

struct Answer {
    int status = 200;
    std::string type;
    std::string body;
    std::vector<std::pair<std::string, std::string>> headers;
    std::string route;               // the pattern of its path, for the metrics
    std::optional<Problem> problem;  // that the body describes
    std::optional<JobEvent> job;
    std::optional<std::uint64_t> sceneHash;  // of a frame: content hash of its scene
    std::uint64_t worker = 0;  // number of the worker process that answered; 0: no worker
    // Instead of a body: writes a chunked body to the sink. Called once, on the thread of the
    // request. Must return when the sink returns false or the service stops. Returns false if the
    // body is incomplete; then the connection is closed without the last chunk.
    std::function<bool(const Sink&)> stream;
    // Instead of `body`: bytes that several answers share, such as those of the frame cache.
    std::shared_ptr<const std::string> shared;

    const std::string& content() const { return shared ? *shared : body; }
};

}  // namespace clerestory
