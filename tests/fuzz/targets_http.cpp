#include "tests/fuzz/targets.h"

#include "server/http/httplib_adapter.h"
#include "server/http/request_reader.h"

namespace clerestory::test {
namespace {

class TextWriter final : public ResponseWriter {
public:
    bool send(std::string_view bytes, bool) override {
        text += bytes;
        return true;
    }
    std::string text;
};

// The server's interpretation of the bytes: the requests, and the final state.
struct ParsedRequests {
    std::vector<std::string> heads, bodies;
    RequestReader::State end = RequestReader::State::idle;
    int refusal = 0;
    bool operator==(const ParsedRequests&) const = default;
};

ParsedRequests understood(std::string_view bytes, std::size_t piece, const HttpLimits& limits) {
    ParsedRequests all;
    RequestReader reader(limits);
    while (!bytes.empty() && reader.state() != RequestReader::State::refused) {
        const std::size_t room = reader.room();
        require(room > 0, "a reader that is not done has room");
        const std::string_view now = bytes.substr(0, std::min(piece, room));
        bytes.remove_prefix(now.size());
        reader.take(now);
        while (reader.state() == RequestReader::State::complete) {
            require(reader.headBytes().size() <= limits.headBytes, "the head is within its limit");
            require(reader.body().size() <= limits.bodyBytes, "the body is within its limit");
            require(reader.body().size() == reader.head().contentLength, "the body is whole");
            require(reader.head().path().size() <= limits.path, "the path is within its limit");
            all.heads.emplace_back(reader.headBytes());
            all.bodies.emplace_back(reader.body());
            reader.next();
        }
    }
    all.end = reader.state();
    if (all.end == RequestReader::State::refused) all.refusal = reader.problem().status;
    return all;
}

Answer echoed(const Call& call) {
    std::string text = call.method + " " + call.path + "\n";
    for (const auto& [name, value] : call.query) text += name + "=" + value + "\n";
    return {.type = "text/plain", .body = text + call.body};
}

HttplibAdapter& library() {
    static HttplibAdapter only(HttpLimits{}, echoed, [](const Call&, const Problem& problem) {
        return Answer{.status = problem.status, .type = "application/problem+json", .body = "{}"};
    });
    return only;
}

}  // namespace

void fuzzHttp(Bytes input) {
    const std::string_view bytes(reinterpret_cast<const char*>(input.data()), input.size());
    const HttpLimits limits{
        .requestLine = 256, .path = 64, .headBytes = 1024, .headers = 8, .bodyBytes = 512};
    const ParsedRequests whole = understood(bytes, 4096, limits);
    require(whole == understood(bytes, 1, limits), "byte by byte means the same");
    require(whole == understood(bytes, 7, limits), "piece by piece means the same");
    for (std::size_t i = 0; i < whole.heads.size(); ++i) {
        Exchange exchange{.head = readHead(whole.heads[i], limits).head,
                          .headBytes = whole.heads[i],
                          .body = whole.bodies[i],
                          .requestId = "fuzz",
                          .cancellation = std::make_shared<CancellationToken>()};
        exchange.last = !exchange.head.keepAlive;
        TextWriter writer;
        const bool keepAlive = library().answer(exchange, writer);
        require(!(exchange.last && keepAlive), "the last answer is the last");
        require(writer.text.starts_with("HTTP/1.1 "), "there is an answer");
        require(writer.text.find("X-Request-Id: fuzz\r\n") != std::string::npos,
                "it is our answer, not the library's own");
    }
}

std::vector<std::string> httpSeeds() {
    return {
        "GET / HTTP/1.1\r\nHost: localhost\r\n\r\n",
        "GET /v1/frames?scene=a&eye=1,2,3&x=%41%zz+b#c HTTP/1.1\r\nHost: [::1]:8080\r\nRange: "
        "bytes=0-5,7-\r\n\r\n",
        "POST /v1/frames HTTP/1.1\r\nHost: localhost\r\nContent-Length: 2\r\nContent-Type: "
        "application/json\r\nConnection: keep-alive, close\r\n\r\n{}",
        "POST / HTTP/1.0\r\nContent-Length: 3\r\nExpect: 100-continue\r\n\r\nabcGET /x "
        "HTTP/1.1\r\nHost: a\r\n\r\n",
        "\r\n\r\nOPTIONS * HTTP/1.1\r\nHost: a\r\nAccept-Encoding: gzip, br\r\n\r\n",
        "HEAD /a%00b HTTP/1.1\r\nHost: a\r\nTransfer-Encoding: chunked\r\n\r\n0\r\n\r\n",
        "POST / HTTP/1.1\r\nHost: a\r\nContent-Type: multipart/form-data; "
        "boundary=x\r\nContent-Length: "
        "9\r\n\r\n--x--\r\n\r\n",
    };
}

}  // namespace clerestory::test
