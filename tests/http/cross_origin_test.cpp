// Pages of other origins: which may read answers, and what answers the question of a browser.
#include "server/http/cross_origin.h"
#include "tests/support/raw_client.h"
#include "tests/support/server_process.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>

namespace clerestory::test {
namespace {

using Headers = std::map<std::string, std::string>;

Call callWith(const std::string& method, const Headers& headers) {
    return {.method = method, .path = "/v1/frames", .header = [headers](const char* name) {
                const auto found = headers.find(name);
                return found == headers.end() ? std::string() : found->second;
            }};
}

std::string fieldOf(const Answer& answer, const std::string& name) {
    for (const auto& [key, value] : answer.headers) {
        if (key == name) return value;
    }
    return "";
}

TEST(CrossOrigin, AnswersAreForAllowedOriginsOnly) {
    const CrossOrigin shop({"https://shop.example", "http://localhost:3000"});
    const auto allowed = [](const CrossOrigin& c, const std::string& origin) {
        const Answer answer = c.permitted(callWith("GET", {{"Origin", origin}}), {});
        return fieldOf(answer, "Access-Control-Allow-Origin");
    };
    EXPECT_EQ(allowed(shop, "https://shop.example"), "https://shop.example");
    EXPECT_EQ(allowed(shop, "http://localhost:3000"), "http://localhost:3000");
    for (const char* other : {"http://shop.example", "https://shop.example:444", "null", "",
                              "https://shop.example.evil.example", "https://shop.exampl"}) {
        EXPECT_EQ(allowed(shop, other), "") << other;
    }
    EXPECT_EQ(allowed(CrossOrigin({"*"}), "https://any.example"), "https://any.example");
    EXPECT_EQ(allowed(CrossOrigin({}), "https://any.example"), "");
    EXPECT_TRUE(CrossOrigin({}).permitted(callWith("GET", {}), {}).headers.empty());
    // A cache may not give an answer without the header to a page that needs it.
    EXPECT_EQ(fieldOf(shop.permitted(callWith("GET", {}), {}), "Vary"), "Origin");
}

TEST(CrossOrigin, OnlyABrowsersQuestionIsAPreflight) {
    const CrossOrigin shop({"https://shop.example"});
    const Headers asks = {{"Origin", "https://shop.example"},
                          {"Access-Control-Request-Method", "POST"}};
    EXPECT_TRUE(shop.preflight(callWith("OPTIONS", asks)));
    EXPECT_FALSE(shop.preflight(callWith("POST", asks)));
    EXPECT_FALSE(shop.preflight(callWith("OPTIONS", {{"Origin", "https://shop.example"}})));
    EXPECT_FALSE(shop.preflight(callWith("OPTIONS", {{"Access-Control-Request-Method", "POST"}})));
    EXPECT_FALSE(CrossOrigin({}).preflight(callWith("OPTIONS", asks)));
}

// A server with a token: the question carries none, the request does.
TEST(CrossOrigin, APageOfAnAllowedOriginDrawsAFrame) {
    std::filesystem::create_directories(CLERESTORY_TEST_OUTPUT);
    const std::string file = CLERESTORY_TEST_OUTPUT "/origin-token";
    std::ofstream(file) << "0123456789abcdef0123\n";
    const ServerProcess server(
        {"--scene", "six-walls", "--token-file", file, "--allow-origin", "https://shop.example"});
    ASSERT_TRUE(server.waitUntilReady());
    const std::string origin = "Origin: https://shop.example\r\n";
    const std::string token = "Authorization: Bearer 0123456789abcdef0123\r\n";
    const std::string question = "OPTIONS /v1/frames HTTP/1.1\r\nHost: localhost\r\n" + origin +
                                 "Access-Control-Request-Method: POST\r\n"
                                 "Access-Control-Request-Headers: authorization,content-type\r\n"
                                 "Connection: close\r\n\r\n";
    const std::string permission = ask(server.port(), question);
    EXPECT_EQ(statusOf(permission), 204);
    EXPECT_EQ(headerOf(permission, "Access-Control-Allow-Origin"), "https://shop.example");
    EXPECT_EQ(headerOf(permission, "Access-Control-Allow-Headers"), "Authorization, *");
    EXPECT_EQ(headerOf(permission, "Access-Control-Allow-Methods"), "GET, HEAD, POST, PUT, DELETE");

    const std::string body = R"({"width": 32, "height": 32})";
    const std::string frame = ask(server.port(), post("/v1/frames", body, origin + token));
    EXPECT_EQ(statusOf(frame), 200);
    EXPECT_EQ(headerOf(frame, "Access-Control-Allow-Origin"), "https://shop.example");
    EXPECT_EQ(headerOf(frame, "Access-Control-Expose-Headers"), "*");
    EXPECT_NE(frame.find("Vary: Origin\r\n"), std::string::npos);
    // Refusals are read by the page as well; other pages read nothing.
    const std::string without = ask(server.port(), post("/v1/frames", body, origin));
    EXPECT_EQ(statusOf(without), 401);
    EXPECT_EQ(headerOf(without, "Access-Control-Allow-Origin"), "https://shop.example");
    const std::string other =
        ask(server.port(), post("/v1/frames", body, "Origin: https://evil.example\r\n" + token));
    EXPECT_EQ(statusOf(other), 200);
    EXPECT_EQ(headerOf(other, "Access-Control-Allow-Origin"), "");
}

}  // namespace
}  // namespace clerestory::test
