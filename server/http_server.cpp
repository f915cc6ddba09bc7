#include "server/http_server.h"

#include "server/connection.h"

#include <spdlog/spdlog.h>
#include <sys/eventfd.h>

#include <algorithm>
#include <atomic>
#include <random>

namespace clerestory {
namespace {

constexpr std::size_t kMaxPath = 512;
constexpr std::size_t kMaxHeaders = 64;
constexpr int kBacklog = 1024;  // the library's 5 makes bursts of clients wait a second
constexpr std::size_t kHeadBytes = 16 * 1024;

const httplib::Headers kEveryAnswer = {
    {"X-Content-Type-Options", "nosniff"},
    {"Content-Security-Policy",
     "default-src 'self'; img-src 'self' blob: data:; frame-ancestors 'none'"},
    {"Referrer-Policy", "no-referrer"}};

// The client's own id when it is plain, otherwise a new one.
std::string requestIdFor(const httplib::Request& request) {
    const std::string given = request.get_header_value("X-Request-Id");
    const bool plain = !given.empty() && given.size() <= 64 &&
                       std::all_of(given.begin(), given.end(), [](unsigned char c) {
                           return std::isalnum(c) || c == '-' || c == '_' || c == '.';
                       });
    if (plain) return given;
    static const std::uint32_t start = std::random_device{}();
    static std::atomic<std::uint32_t> count{0};
    char text[32];
    std::snprintf(text, sizeof text, "%08x-%06x", start, count.fetch_add(1));
    return text;
}

bool takesBody(const std::string& method) {
    return method == "POST" || method == "PUT" || method == "PATCH" || method == "DELETE";
}

// What the head alone rules out, before a byte of the body is read.
std::optional<Problem> refusal(const httplib::Request& request, std::size_t maxBody) {
    if (request.path.size() > kMaxPath) return uriTooLong(kMaxPath);
    if (request.headers.size() > kMaxHeaders) return badRequest("There are too many headers.");
    if (request.has_header("Transfer-Encoding")) return lengthRequired();
    if (request.has_header("Content-Encoding")) return encodedBody();
    const std::size_t lengths = request.get_header_value_count("Content-Length");
    if (lengths == 0) return std::nullopt;
    const std::string length = request.get_header_value("Content-Length");
    const bool digits =
        std::all_of(length.begin(), length.end(), [](unsigned char c) { return std::isdigit(c); });
    if (lengths > 1 || length.empty() || !digits) {
        return badRequest("The Content-Length is not a number.");
    }
    if (length.size() > 12 || std::stoull(length) > maxBody) return tooLarge(maxBody);
    if (!takesBody(request.method) && std::stoull(length) > 0) {
        return badRequest("A " + request.method + " has no body.");
    }
    return std::nullopt;
}

}  // namespace

class HttpServer::Library final : public httplib::Server {
public:
    Library(const HttpOptions& options, Responder responder, Refuser refuser)
        : options_(options),
          responder_(std::move(responder)),
          refuser_(std::move(refuser)),
          wakeFd_(eventfd(0, EFD_CLOEXEC)),
          port_(options.port),
          workers_(options.threads) {
        limits_.requestBytes = kHeadBytes + options.maxBody;
        new_task_queue = [this] { return new Doorway(workers_); };
        set_tcp_nodelay(true);  // otherwise a kept-alive answer takes 40 ms more
        // Not the library's SO_REUSEPORT: a second server on a taken port must fail, not share it.
        set_socket_options([](socket_t socket) {
            const int on = 1;
            setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
        });
        set_payload_max_length(options.maxBody);
        // Only what the header Keep-Alive promises: connections end by ConnectionLimits.
        set_keep_alive_timeout(std::chrono::ceil<std::chrono::seconds>(limits_.idle).count());
        set_keep_alive_max_count(1'000'000);
        set_default_headers(kEveryAnswer);
        setRoutes();
        if (!bound()) {
            workers_.shutdown();
            throw std::runtime_error("cannot listen on " + options_.host + ":" +
                                     std::to_string(options_.port) +
                                     ": the port is taken or the address is not ours");
        }
    }

    ~Library() override {
        if (!ended_) workers_.shutdown();
        close(wakeFd_);
    }

    int port() const { return port_; }

    // The library leaves its accept loop for good on one aborted connection or a lack of
    // descriptors; then it is begun again. Connections live on meanwhile.
    void serveUntilStopped() {
        while (!listen_after_bind() && !stopping_) {
            spdlog::warn("accepting connections failed; beginning again");
            do {
                std::this_thread::sleep_for(std::chrono::milliseconds(100));
            } while (!stopping_ && !bound());
        }
        ended_ = true;
        workers_.shutdown();  // waits for every answer
    }

    void stopServing() {
        stopping_ = true;
        eventfd_write(wakeFd_, 1);
        // stop() does nothing before the accept loop runs, which may be about to begin.
        while (!ended_ && !is_running()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
        if (!ended_) stop();
    }

private:
    // What the accept loop gets: it may end and begin again, the workers stay.
    struct Doorway final : httplib::TaskQueue {
        explicit Doorway(httplib::ThreadPool& pool) : workers(pool) {}
        void enqueue(std::function<void()> work) override { workers.enqueue(std::move(work)); }
        void shutdown() override {}
        httplib::ThreadPool& workers;
    };

    // Port 0 turns into the one that was given, so that beginning again finds the same.
    bool bound() {
        if (port_ == 0) {
            port_ = std::max(0, bind_to_any_port(options_.host));
        } else if (!bind_to_port(options_.host, port_)) {
            return false;
        }
        return port_ > 0 && ::listen(svr_sock_, kBacklog) == 0;
    }

    void setRoutes() {
        set_pre_routing_handler(
            [this](const httplib::Request& request, httplib::Response& response) {
                const auto problem = refusal(request, options_.maxBody);
                if (!problem) return HandlerResponse::Unhandled;
                refuse(request, *problem, response);
                return HandlerResponse::Handled;
            });
        // Paths are at most kMaxPath long here, so that matching cannot exhaust the stack.
        const auto all = [this](const httplib::Request& request, httplib::Response& response) {
            const Call call = callFrom(request);
            send(call, responder_(call), response);
        };
        Get(".*", all);
        Post(".*", all);
        Put(".*", all);
        Patch(".*", all);
        Delete(".*", all);
        Options(".*", all);
        set_error_handler([this](const httplib::Request& request, httplib::Response& response) {
            if (!response.body.empty() || response.has_header("X-Request-Id")) return;
            switch (response.status) {
                case 413:
                    return refuse(request, tooLarge(options_.maxBody), response);
                case 414:
                    return refuse(request, uriTooLong(kMaxPath), response);
                default:
                    return refuse(request, badRequest("This is not a request of HTTP/1.1."),
                                  response);
            }
        });
        set_exception_handler(
            [this](const httplib::Request& request, httplib::Response& response,
                   std::exception_ptr) { refuse(request, internalError(), response); });
    }

    Call callFrom(const httplib::Request& request) const {
        return {.method = request.method == "HEAD" ? "GET" : request.method,
                .path = request.path,
                .query = request.params,
                .body = request.body,
                .requestId = requestIdFor(request),
                .arrived = Clock::now(),
                .header = [&request](const char* name) { return request.get_header_value(name); }};
    }

    void refuse(const httplib::Request& request, const Problem& problem,
                httplib::Response& response) {
        const Call call = callFrom(request);
        send(call, refuser_(call, problem), response);
    }

    static void send(const Call& call, Answer answer, httplib::Response& response) {
        response.status = answer.status;
        for (const auto& [name, value] : answer.headers) response.set_header(name, value);
        response.set_header("X-Request-Id", call.requestId);
        if (answer.stream) {
            response.set_chunked_content_provider(
                answer.type,
                [stream = std::move(answer.stream)](std::size_t, httplib::DataSink& sink) {
                    const bool whole = stream([&](std::string_view piece) {
                        return sink.write(piece.data(), piece.size());
                    });
                    if (whole) sink.done();
                    return whole;
                });
            return;
        }
        if (!answer.type.empty()) response.set_header("Content-Type", answer.type);
        response.body = std::move(answer.body);
    }

    bool process_and_close_socket(socket_t socket) override {
        try {
            Connection connection(socket, wakeFd_, limits_);
            while (connection.nextRequest() && answered(connection)) {
            }
        } catch (const std::exception& error) {  // memory, mostly; the worker must live on
            spdlog::error("a connection failed: {}", error.what());
        }
        return true;
    }

    // One request; true when the connection may carry another.
    bool answered(Connection& connection) {
        bool understood = false, closing = false;
        const bool sent =
            process_request(connection, stopping_, closing, [&](httplib::Request& request) {
                understood = !refusal(request, options_.maxBody);
                if (!understood) {  // makes the library tell the client
                    request.headers.erase("Connection");
                    request.set_header("Connection", "close");
                }
                request.ranges.clear();  // a part of a picture helps nobody
                if (takesBody(request.method) && !request.has_header("Content-Length")) {
                    request.set_header("Content-Length", "0");
                }
            });
        if (!understood) connection.drain();  // the body of what was refused lies unread
        return sent && understood && !closing && !stopping_;
    }

    const HttpOptions options_;
    ConnectionLimits limits_;
    Responder responder_;
    Refuser refuser_;
    int wakeFd_;
    int port_;
    httplib::ThreadPool workers_;
    std::atomic<bool> stopping_{false};
    std::atomic<bool> ended_{false};
};

HttpServer::HttpServer(const HttpOptions& options, Responder responder, Refuser refuser)
    : library_(std::make_unique<Library>(options, std::move(responder), std::move(refuser))) {}
HttpServer::~HttpServer() = default;
int HttpServer::port() const {
    return library_->port();
}
void HttpServer::serve() {
    library_->serveUntilStopped();
}
void HttpServer::stop() {
    library_->stopServing();
}

}  // namespace clerestory
