// The request reader: complete requests, rejections, and the byte at which they happen.
#include "server/http/request_reader.h"

#include <gtest/gtest.h>

namespace clerestory::test {
namespace {

using State = RequestReader::State;

HttpLimits small() {
    return {.requestLine = 64, .path = 32, .headBytes = 256, .headers = 4, .bodyBytes = 16};
}

int statusAfter(const std::string& bytes, const HttpLimits& limits = small()) {
    RequestReader reader(limits);
    for (const char byte : bytes) {
        if (reader.room() > 0) reader.take({&byte, 1});
    }
    if (reader.state() == State::complete) return 200;
    return reader.state() == State::refused ? reader.problem().status : 0;
}

std::string request(const std::string& more, const std::string& body = "",
                    const std::string& line = "POST / HTTP/1.1") {
    return line + "\r\nHost: a\r\n" + more + "\r\n" + body;
}

TEST(RequestReader, BodyLimitsDependOnTheRoute) {
    HttpLimits limits = small();
    limits.large = {{"POST", "/big", 64}};
    const auto statusOf = [&](const char* line, std::size_t size) {
        return statusAfter(request("Content-Length: " + std::to_string(size) + "\r\n",
                                   std::string(size, 'b'), line),
                           limits);
    };
    EXPECT_EQ(statusOf("POST /big HTTP/1.1", 64), 200);
    EXPECT_EQ(statusOf("POST /big HTTP/1.1", 65), 413);
    EXPECT_EQ(statusOf("POST /big?a=b HTTP/1.1", 64), 200);
    for (const char* other : {"PUT /big HTTP/1.1", "POST /big/ HTTP/1.1", "POST /b%69g HTTP/1.1"}) {
        EXPECT_EQ(statusOf(other, 17), 413) << other;
    }
}

TEST(RequestReader, ReadingABodyLeavesTheFollowingRequest) {
    for (const bool whole : {true, false}) {  // how much is there when the body is complete
        const HttpLimits limits = small();
        RequestReader reader(limits);
        const std::string first = request("Content-Length: 4\r\n", "body");
        const std::string second = request("", "", "GET /2 HTTP/1.1");
        reader.take(whole ? first + second : first);
        ASSERT_EQ(reader.state(), State::complete);
        EXPECT_EQ(reader.takeBody(), "body");
        EXPECT_EQ(reader.headBytes(), first.substr(0, first.size() - 4));
        reader.next();
        if (!whole) reader.take(second);
        ASSERT_EQ(reader.state(), State::complete);
        EXPECT_EQ(reader.headBytes(), second);
        EXPECT_EQ(reader.takeBody(), "");
    }
}

TEST(RequestReader, LimitsAreExactToTheByte) {
    const auto line = [](std::size_t size) {  // of that many bytes, the path short
        const std::string begin = "GET /?", end = " HTTP/1.1";
        return begin + std::string(size - begin.size() - end.size(), 'q') + end;
    };
    EXPECT_EQ(statusAfter(request("", "", line(64))), 200);
    EXPECT_EQ(statusAfter(request("", "", line(65))), 414);
    const auto path = [](std::size_t size) {
        return "GET /" + std::string(size - 1, 'p') + " HTTP/1.1";
    };
    EXPECT_EQ(statusAfter(request("", "", path(32))), 200);
    EXPECT_EQ(statusAfter(request("", "", path(33))), 414);
    const auto headers = [](int more) {
        std::string text;
        for (int i = 0; i < more; ++i) text += "X: y\r\n";
        return request(text, "", "GET / HTTP/1.1");
    };
    EXPECT_EQ(statusAfter(headers(3)), 200);  // with Host: 4
    EXPECT_EQ(statusAfter(headers(4)), 431);
    const auto head = [](std::size_t size) {
        const std::string text =
            request("X: ", "", "GET / HTTP/1.1");  // "...X: \r\n" stays one line
        const std::size_t at = text.size() - 2;
        return text.substr(0, at) + std::string(size - text.size() - 2, 'h') + "\r\n\r\n";
    };
    ASSERT_EQ(head(256).size(), 256u);
    EXPECT_EQ(statusAfter(head(256)), 200);
    EXPECT_EQ(statusAfter(head(257)), 431);
    EXPECT_EQ(statusAfter(request("Content-Length: 16\r\n", std::string(16, 'b'))), 200);
    EXPECT_EQ(statusAfter(request("Content-Length: 17\r\n", std::string(17, 'b'))), 413);
    EXPECT_EQ(statusAfter(request("Content-Length: 15\r\n", std::string(14, 'b'))), 0) << "waits";
}

TEST(RequestReader, TargetsInAbsoluteFormBecomePaths) {
    const auto read = [](const std::string& line, const std::string& more) {
        return readHead(line + "\r\n" + more + "\r\n", {});
    };
    const HeadOutcome full = read("GET http://frames.example:80/v1/frames?width=9 HTTP/1.1",
                                  "Host: other.example\r\nRange: bytes=9-1\r\n");
    ASSERT_FALSE(full.problem);
    EXPECT_EQ(full.head.target, "/v1/frames?width=9");
    EXPECT_EQ(full.head.header("Host"), "frames.example:80") << "the target's authority counts";
    EXPECT_EQ(headText(full.head),
              "GET /v1/frames?width=9 HTTP/1.1\r\nHost: frames.example:80\r\n\r\n")
        << "without the range";
    const HeadOutcome bare = read("GET HTTPS://frames.example HTTP/1.0", "");
    ASSERT_FALSE(bare.problem);
    EXPECT_EQ(bare.head.target, "/");
    EXPECT_EQ(bare.head.header("Host"), "frames.example");
    for (const char* wrong : {"GET http:///v1 HTTP/1.1", "GET http://a@b/v1 HTTP/1.1",
                              "GET ftp://a/v1 HTTP/1.1", "GET http://a HTTP/1.1 HTTP/1.1"}) {
        EXPECT_TRUE(read(wrong, "Host: a\r\n").problem) << wrong;
    }
}

TEST(RequestReader, OverlongLinesAreRejectedAtTheLimit) {
    const HttpLimits limits = small();
    RequestReader reader(limits);
    std::size_t taken = 0;
    while (reader.room() > 0) {
        reader.take("a");
        ++taken;
    }
    EXPECT_EQ(reader.state(), State::refused);
    EXPECT_LE(taken, 70u);
}

TEST(RequestReader, PipelinedRequestsAreSplit) {
    const HttpLimits limits;
    RequestReader reader(limits);
    reader.take(
        "POST /a HTTP/1.1\r\nHost: a\r\nContent-Length: 2\r\n\r\n{}\r\nGET /b HTTP/1.1\r\nHost: "
        "a\r\n\r\nGET");
    ASSERT_EQ(reader.state(), State::complete);
    EXPECT_EQ(reader.head().target, "/a");
    EXPECT_EQ(reader.body(), "{}");
    reader.next();
    ASSERT_EQ(reader.state(), State::complete);
    EXPECT_EQ(reader.head().target, "/b");
    EXPECT_EQ(reader.body(), "");
    reader.next();
    EXPECT_EQ(reader.state(), State::head);
}

TEST(RequestReader, ConnectionCloseIsObeyed) {
    const auto keeps = [](const std::string& line, const std::string& more) {
        const HeadOutcome outcome = readHead(line + "\r\nHost: a\r\n" + more + "\r\n", {});
        EXPECT_FALSE(outcome.problem);
        return outcome.head.keepAlive;
    };
    EXPECT_TRUE(keeps("GET / HTTP/1.1", ""));
    EXPECT_TRUE(keeps("GET / HTTP/1.1", "Connection: keep-alive\r\n"));
    EXPECT_FALSE(keeps("GET / HTTP/1.1", "connection: Upgrade , CLOSE\r\n"));
    EXPECT_FALSE(keeps("GET / HTTP/1.0", ""));
}

TEST(RequestReader, OtherProtocolsAreDetectedByTheirFirstByte) {
    EXPECT_EQ(statusAfter("\x16"), 400);
    EXPECT_EQ(statusAfter("{"), 400);
    EXPECT_EQ(statusAfter("\r\n\r\n"), 0) << "blank lines before a request are ignored";
    EXPECT_EQ(statusAfter("\r\n\r\n\r\n\r\n\r\n"), 400) << "but not forever";
}

}  // namespace
}  // namespace clerestory::test
