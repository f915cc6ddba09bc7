#include "server/http/httplib_adapter.h"

#include "server/base/log.h"

#include <httplib.h>

#include <atomic>
#include <cstdio>
#include <cstring>
#include <utility>

namespace clerestory {
namespace {

// Reads the headers of a request from memory and writes to a ResponseWriter.
class MemoryStream final : public httplib::Stream {
public:
    MemoryStream(const Exchange& exchange, ResponseWriter& writer)
        : exchange_(exchange), writer_(writer), rest_(exchange.headBytes) {}

    bool is_readable() const override { return true; }
    bool is_writable() const override { return !failed_; }

    ssize_t read(char* data, std::size_t size) override {
        const std::size_t count = std::min(size, rest_.size());
        std::memcpy(data, rest_.data(), count);
        rest_.remove_prefix(count);
        return static_cast<ssize_t>(count);
    }

    // Collects small writes, so that headers and body are sent together.
    ssize_t write(const char* data, std::size_t size) override {
        const std::string_view bytes(data, size);
        if (buffer_.size() + size <= kBufferBytes) {
            buffer_ += bytes;
        } else if (flush()) {
            failed_ = !writer_.send(bytes, streamed_);
        }
        return failed_ ? -1 : static_cast<ssize_t>(size);
    }

    bool flush() {
        if (!buffer_.empty() && !failed_) failed_ = !writer_.send(buffer_, streamed_);
        buffer_.clear();
        return !failed_;
    }

    // Writes block from now on until the client has read them.
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
    static constexpr std::size_t kBufferBytes = 16 * 1024;

    const Exchange& exchange_;
    ResponseWriter& writer_;
    std::string_view rest_;
    std::string buffer_;
    bool streamed_ = false;
    bool failed_ = false;
};

// The handlers of the library do not pass an exchange; a thread handles one at a time.
struct Serving {
    Exchange* exchange = nullptr;
    ResponseWriter* writer = nullptr;
    std::function<bool(const Sink&)> pieces = {};  // writes the body of a streamed response
    std::shared_ptr<const std::string> body = {};  // of a response that the library does not copy
};
// A pointer: the C library ends the process if it has no memory for the destructor of an object.
thread_local Serving* serving = nullptr;

// A protected member of the library, whose parameters differ by version.
using Prepare = std::function<void(httplib::Request&)>;
using ProcessBefore0_16 = bool (httplib::Server::*)(httplib::Stream&, bool, bool&, const Prepare&);
using ProcessSince0_16 = bool (httplib::Server::*)(httplib::Stream&, const std::string&, int,
                                                   const std::string&, int, bool, bool&,
                                                   const Prepare&);

std::string chunkOf(std::string_view piece) {
    char size[24];
    std::snprintf(size, sizeof size, "%zx\r\n", piece.size());
    return std::string(size).append(piece).append("\r\n");
}

std::size_t secondsIn(std::chrono::milliseconds time) {
    return static_cast<std::size_t>(std::chrono::ceil<std::chrono::seconds>(time).count());
}

}  // namespace

class HttplibAdapter::Server final : public httplib::Server {
public:
    Server(const HttpLimits& limits, Responder responder, Refuser refuser)
        : responder_(std::move(responder)), refuser_(std::move(refuser)) {
        // Used for the header Keep-Alive only.
        set_keep_alive_timeout(static_cast<time_t>(secondsIn(limits.idle)));
        set_keep_alive_max_count(1'000'000);
        httplib::Headers common;
        for (const auto& [name, value] : commonHeaders()) common.emplace(name, value);
        set_default_headers(common);
        // Runs before the routes of the library, which match with recursive regular expressions,
        // and before the library reads a body.
        set_pre_routing_handler(
            [this](const httplib::Request& request, httplib::Response& response) {
                Call call = callOf(*serving->exchange);
                call.path = request.path;
                call.query = request.params;
                call.body = std::move(serving->exchange->body);
                Answer answer = responder_(call);
                // Too late to save the work, but not the memory.
                const bool isHead = serving->exchange->head.method == "HEAD";
                if (!serving->writer->reserve(isHead ? 0 : answer.content().size())) {
                    answer = refuser_(call, responsesFull());
                }
                give(call, std::move(answer), response);
                return HandlerResponse::Handled;
            });
        // Called with the final headers. The library does not know the body of a stream, and would
        // copy a large one.
        set_post_routing_handler([](const httplib::Request&, httplib::Response& response) {
            if (response.body.size() > kUncountedBytes) {
                serving->body =
                    std::make_shared<const std::string>(std::exchange(response.body, {}));
            }
            const bool hasNoBody = response.status == 204 || response.status == 304;
            if (serving->pieces || serving->body || hasNoBody) {
                response.headers.erase("Content-Length");
            }
            if (!serving->body) return;
            response.set_header("Content-Length", std::to_string(serving->body->size()));
        });
        set_error_handler([this](const httplib::Request&, httplib::Response& response) {
            if (!response.has_header("X-Request-Id")) refuse(notHttp(), response);
        });
        set_exception_handler([this](const httplib::Request&, httplib::Response& response,
                                     std::exception_ptr) { refuse(internalError(), response); });
    }

    bool answer(Exchange& exchange, ResponseWriter& writer) {
        MemoryStream stream(exchange, writer);
        Serving current{&exchange, &writer};
        serving = &current;
        bool closing = false;
        const Prepare prepare = [&](httplib::Request& request) {
            request.ranges.clear();           // range requests are not supported
            request.headers.erase("Expect");  // handled by the event loop
            if (exchange.last) request.set_header("Connection", "close");
        };
        const bool sent = process(&Server::process_request, stream, exchange, closing, prepare) &&
                          sendBody(stream, exchange, writer) && sendPieces(stream, exchange);
        return stream.flush() && sent && !closing && !exchange.last;
    }

    void endStreams() { ending_ = true; }

private:
    void refuse(const Problem& problem, httplib::Response& response) {
        const Call call = callOf(*serving->exchange);
        give(call, refuser_(call, problem), response);
    }

    void give(const Call& call, Answer answer, httplib::Response& response) {
        response.status = answer.status;
        for (const auto& [name, value] : answer.headers) response.set_header(name, value);
        response.set_header("X-Request-Id", call.requestId);
        if (!answer.type.empty()) response.set_header("Content-Type", answer.type);
        response.body = std::move(answer.body);
        serving->body = std::move(answer.shared);
        serving->pieces = std::move(answer.stream);
        if (serving->pieces && serving->exchange->head.minorVersion > 0) {
            response.set_header("Transfer-Encoding", "chunked");
        }
    }

    bool process(ProcessBefore0_16 inherited, MemoryStream& stream, const Exchange& exchange,
                 bool& closing, const Prepare& prepare) {
        return (this->*inherited)(stream, exchange.last, closing, prepare);
    }
    bool process(ProcessSince0_16 inherited, MemoryStream& stream, const Exchange& exchange,
                 bool& closing, const Prepare& prepare) {
        return (this->*inherited)(stream, exchange.client, 0, "", 0, exchange.last, closing,
                                  prepare);
    }

    bool sendBody(MemoryStream& stream, const Exchange& exchange, ResponseWriter& writer) {
        auto body = std::exchange(serving->body, nullptr);
        if (!body || exchange.head.method == "HEAD") return true;
        return stream.flush() && writer.sendBody(std::move(body));
    }

    // The library stops a stream unless its own socket listens, and it has none. So the chunks are
    // written here, after its headers.
    bool sendPieces(MemoryStream& stream, const Exchange& exchange) {
        const auto pieces = std::exchange(serving->pieces, nullptr);
        if (!pieces || exchange.head.method == "HEAD") return true;
        const bool chunked =
            exchange.head.minorVersion > 0;  // otherwise the end of the connection ends the body
        stream.beginStream();
        const bool whole = pieces([&](std::string_view piece) {
            if (ending_ || exchange.cancellation->cancelled()) return false;
            if (piece.empty()) return true;
            const std::string bytes = chunked ? chunkOf(piece) : std::string(piece);
            return stream.write(bytes.data(), bytes.size()) >= 0 && stream.flush();
        });
        return whole && (!chunked || stream.write("0\r\n\r\n", 5) >= 0);
    }

    Responder responder_;
    Refuser refuser_;
    std::atomic<bool> ending_{false};
};

HttplibAdapter::HttplibAdapter(const HttpLimits& limits, Responder responder, Refuser refuser)
    : server_(std::make_unique<Server>(limits, std::move(responder), std::move(refuser))) {}
HttplibAdapter::~HttplibAdapter() = default;

bool HttplibAdapter::answer(Exchange& exchange, ResponseWriter& writer) {
    try {
        return server_->answer(exchange, writer);
    } catch (const std::exception& error) {  // usually out of memory; the thread must continue
        logError({"request ", exchange.requestId, ": ", error.what()});
    }
    return false;
}

void HttplibAdapter::endStreams() {
    server_->endStreams();
}

}  // namespace clerestory
