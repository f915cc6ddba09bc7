#include "server/front/library.h"

#include "server/front/wire.h"
#include "server/log.h"

#include <httplib.h>

#include <atomic>
#include <cstring>

namespace clerestory {
namespace {

// The head of a request to read, and an outlet to write to.
class MemoryStream final : public httplib::Stream {
public:
    MemoryStream(const Exchange& exchange, Outlet& outlet)
        : exchange_(exchange), outlet_(outlet), rest_(exchange.headBytes) {}

    bool is_readable() const override { return true; }
    bool is_writable() const override { return !gone_; }

    ssize_t read(char* data, std::size_t size) override {
        const std::size_t count = std::min(size, rest_.size());
        std::memcpy(data, rest_.data(), count);
        rest_.remove_prefix(count);
        return static_cast<ssize_t>(count);
    }

    // Head and body come one after the other and leave together.
    ssize_t write(const char* data, std::size_t size) override {
        const std::string_view bytes(data, size);
        if (kept_.size() + size <= kKept) {
            kept_ += bytes;
        } else if (flush()) {
            gone_ = !outlet_.send(bytes, streamed_);
        }
        return gone_ ? -1 : static_cast<ssize_t>(size);
    }

    bool flush() {
        if (!kept_.empty() && !gone_) gone_ = !outlet_.send(kept_, streamed_);
        kept_.clear();
        return !gone_;
    }

    // From now on no faster than the client reads.
    void beginStream() { streamed_ = true; }

    void get_remote_ip_and_port(std::string& ip, int& port) const override {
        ip = exchange_.client;
        port = 0;
    }
    void get_local_ip_and_port(std::string& ip, int& port) const override {
        ip.clear();
        port = 0;
    }
    // The library compares it with the largest descriptor that select() can take.
    socket_t socket() const override { return 0; }

private:
    static constexpr std::size_t kKept = 16 * 1024;

    const Exchange& exchange_;
    Outlet& outlet_;
    std::string_view rest_;
    std::string kept_;
    bool streamed_ = false;
    bool gone_ = false;
};

// The library's handlers know neither stream nor exchange; a thread serves one at a time.
struct Serving {
    Exchange* exchange = nullptr;
    MemoryStream* stream = nullptr;
};
thread_local Serving serving;

std::size_t secondsIn(std::chrono::milliseconds time) {
    return static_cast<std::size_t>(std::chrono::ceil<std::chrono::seconds>(time).count());
}

}  // namespace

Call callOf(const Exchange& exchange) {
    const RequestHead& head = exchange.head;
    return {.method = head.method == "HEAD" ? "GET" : head.method,
            .path = std::string(head.path()),
            .requestId = exchange.requestId,
            .arrived = exchange.arrived,
            .header = [&head](const char* name) { return std::string(head.header(name)); },
            .client = exchange.client,
            .departure = exchange.departure};
}

class Library::Server final : public httplib::Server {
public:
    Server(const FrontLimits& limits, Responder responder, Refuser refuser)
        : responder_(std::move(responder)), refuser_(std::move(refuser)) {
        svr_sock_ = 0;  // "not stopped": the library asks before every piece of a stream
        // Only what the header Keep-Alive promises.
        set_keep_alive_timeout(static_cast<time_t>(secondsIn(limits.idle)));
        set_keep_alive_max_count(1'000'000);
        httplib::Headers everyAnswer;
        for (const auto& [name, value] : headersOfEveryAnswer()) everyAnswer.emplace(name, value);
        set_default_headers(everyAnswer);
        // Before the library's own routes, which match by recursive regular expressions, and before
        // it looks for a body, which the exchange has.
        set_pre_routing_handler(
            [this](const httplib::Request& request, httplib::Response& response) {
                Call call = callOf(*serving.exchange);
                call.path = request.path;
                call.query = request.params;
                call.body = std::move(serving.exchange->body);
                give(call, responder_(call), response);
                return HandlerResponse::Handled;
            });
        set_error_handler([this](const httplib::Request&, httplib::Response& response) {
            if (!response.has_header("X-Request-Id")) refuse(notHttp(), response);
        });
        set_exception_handler([this](const httplib::Request&, httplib::Response& response,
                                     std::exception_ptr) { refuse(internalError(), response); });
    }

    bool answer(Exchange& exchange, Outlet& outlet) {
        MemoryStream stream(exchange, outlet);
        serving = {&exchange, &stream};
        bool closing = false;
        const bool sent =
            process_request(stream, exchange.last, closing, [&](httplib::Request& request) {
                request.ranges.clear();           // a part of a picture helps nobody
                request.headers.erase("Expect");  // the event loop has seen to it
                if (exchange.last) request.set_header("Connection", "close");
            });
        return stream.flush() && sent && !closing && !exchange.last;
    }

    void endStreams() { ending_ = true; }

private:
    void refuse(const Problem& problem, httplib::Response& response) {
        const Call call = callOf(*serving.exchange);
        give(call, refuser_(call, problem), response);
    }

    void give(const Call& call, Answer answer, httplib::Response& response) {
        response.status = answer.status;
        for (const auto& [name, value] : answer.headers) response.set_header(name, value);
        response.set_header("X-Request-Id", call.requestId);
        if (answer.stream) return giveStream(answer, response);
        if (!answer.type.empty()) response.set_header("Content-Type", answer.type);
        response.body = std::move(answer.body);
    }

    void giveStream(Answer& answer, httplib::Response& response) {
        const auto pieces = [this, stream = std::move(answer.stream)](std::size_t,
                                                                      httplib::DataSink& sink) {
            serving.stream->beginStream();
            const bool whole = stream([&](std::string_view piece) {
                return !ending_ && !serving.exchange->departure->left() &&
                       sink.write(piece.data(), piece.size()) && serving.stream->flush();
            });
            if (whole) sink.done();
            return whole;
        };
        if (serving.exchange->head.minorVersion == 0) {  // knows no chunks: until the end
            response.set_content_provider(answer.type, pieces);
        } else {
            response.set_chunked_content_provider(answer.type, pieces);
        }
    }

    Responder responder_;
    Refuser refuser_;
    std::atomic<bool> ending_{false};
};

Library::Library(const FrontLimits& limits, Responder responder, Refuser refuser)
    : server_(std::make_unique<Server>(limits, std::move(responder), std::move(refuser))) {}
Library::~Library() = default;

bool Library::answer(Exchange& exchange, Outlet& outlet) {
    try {
        return server_->answer(exchange, outlet);
    } catch (const std::exception& error) {  // memory, mostly; the worker must live on
        logError({"request ", exchange.requestId, ": ", error.what()});
    }
    return false;
}

void Library::endStreams() {
    server_->endStreams();
}

}  // namespace clerestory
