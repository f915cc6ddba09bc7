// Access control: tokens, host names, signed links.
#include "server/http/access.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

namespace clerestory::test {
namespace {

const std::string kToken = "a-token-of-some-length";
const std::string kKey = "0123456789abcdef0123456789abcdef";

std::string fileWith(const char* name, const std::string& text) {
    std::filesystem::create_directories(CLERESTORY_TEST_OUTPUT);
    const std::string file = std::string(CLERESTORY_TEST_OUTPUT) + "/" + name;
    std::ofstream(file, std::ios::binary) << text;
    return file;
}

const Access::Paths kPaths = {.open = [](std::string_view path) { return path == "/healthz"; },
                              .linked = [](std::string_view path) { return path == "/v1/frames"; }};

RequestHead head(const std::string& line, const std::string& more = "Host: localhost\r\n") {
    const HeadOutcome outcome = readHead(line + " HTTP/1.1\r\n" + more + "\r\n", {});
    EXPECT_FALSE(outcome.problem) << line;
    return outcome.head;
}

Access::Seconds at(std::int64_t seconds) {
    return Access::Seconds(std::chrono::seconds(seconds));
}

int refusal(const Access& access, const RequestHead& request, std::int64_t now = 1000) {
    const auto problem = access.refusal(request, at(now));
    return problem ? problem->status : 0;
}

TEST(Access, OnlyAddressesLocalhostAndAllowedNamesAreHosts) {
    const Access plain({}, kPaths);
    const auto of = [&](const Access& access, const std::string& host) {
        return refusal(access, head("GET /", "Host: " + host + "\r\n"));
    };
    for (const char* ours : {"localhost", "LOCALHOST:8080", "127.0.0.1", "127.0.0.1:1",
                             "10.1.2.3:80", "[::1]", "[::1]:8080", "[2001:db8::1]:80"}) {
        EXPECT_EQ(of(plain, ours), 0) << ours;
    }
    for (const char* others : {"evil.example", "evil.example:8080", "localhost.evil.example",
                               "127.0.0.1.evil.example", "[evil]", "1.2.3", "localhost@evil"}) {
        EXPECT_EQ(of(plain, others), 421) << others;
    }
    const Access named({.hosts = {"frames.example"}}, kPaths);
    EXPECT_EQ(of(named, "Frames.Example:443"), 0);
    EXPECT_EQ(of(named, "evil.example"), 421);
    EXPECT_EQ(of(Access({.hosts = {"*"}}, kPaths), "evil.example"), 0);
}

TEST(Access, ATokenIsRequiredExceptOnPublicPaths) {
    const Access access({.tokenFile = fileWith("token", kToken + "\n")}, kPaths);
    const auto with = [&](const std::string& line, const std::string& authorization) {
        return refusal(access,
                       head(line, "Host: localhost\r\nAuthorization: " + authorization + "\r\n"));
    };
    EXPECT_EQ(refusal(access, head("GET /healthz")), 0);
    EXPECT_EQ(refusal(access, head("GET /v1/scenes")), 401);
    EXPECT_EQ(refusal(access, head("GET /v1/frames")), 401);
    EXPECT_EQ(refusal(access, head("GET /v1/scenes?token=" + kToken)), 401) << "never in a link";
    EXPECT_EQ(with("GET /v1/scenes", "Bearer " + kToken), 0);
    EXPECT_EQ(with("GET /v1/scenes", "bearer " + kToken), 0);
    const Access marked({.tokenFile = fileWith("marked-token", "\xEF\xBB\xBF" + kToken)}, kPaths);
    EXPECT_EQ(refusal(marked, head("GET /v1/scenes",
                                   "Host: localhost\r\nAuthorization: Bearer " + kToken + "\r\n")),
              0)
        << "a byte order mark is not content";
    for (const std::string& wrong :
         {kToken, std::string("Bearer"), "Bearer " + kToken + "x", "Bearer " + kToken.substr(1),
          "Bearer  " + kToken, "Basic " + kToken, "Bearer x" + kToken.substr(1)}) {
        EXPECT_EQ(with("GET /v1/scenes", wrong), 401) << wrong;
    }
}

TEST(Access, SignatureIsHmacSha256OfThePrecedingText) {
    // By openssl dgst -sha256 -hmac KEY over the text before "&signature=".
    EXPECT_EQ(signedLink(kKey, "/v1/frames?scene=chapel", at(2000)),
              "/v1/frames?scene=chapel&expires=2000&signature="
              "8b1832270227339d910776c9dae98565caf8b35a044ede9a7409e3aba907f829");
    EXPECT_EQ(signedLink(kKey, "/v1/frames", at(1)),
              "/v1/frames?expires=1&signature="
              "f91e9359c30e43c40a6a0c88e51f5fa1a3c2763c38257de79168e9c82b8a3f7e");
}

TEST(Access, ALinkIsValidForItsRequestUntilItExpires) {
    const Access access({.linkKeyFile = fileWith("key", kKey)}, kPaths);
    const std::string link = signedLink(kKey, "/v1/frames?scene=chapel", at(2000));
    EXPECT_EQ(refusal(access, head("GET " + link)), 0);
    EXPECT_EQ(refusal(access, head("HEAD " + link)), 0);
    EXPECT_EQ(refusal(access, head("GET " + link), 2000), 0);
    EXPECT_EQ(refusal(access, head("GET " + link), 2001), 403);
    EXPECT_EQ(refusal(access, head("GET /v1/frames?scene=chapel")), 403);
    for (std::size_t i = link.find('?') + 1; i < link.size(); ++i) {
        std::string other = link;
        other[i] = other[i] == '1' ? '2' : '1';
        EXPECT_EQ(refusal(access, head("GET " + other)), 403) << other;
    }
    EXPECT_EQ(refusal(access, head("GET " + link + "&width=4096")), 403);
    EXPECT_EQ(refusal(access, head("GET " + link + "0")), 403);
    EXPECT_EQ(refusal(access, head("GET " + link.substr(0, link.size() - 1))), 403);
    // Without a token only links are answered, however a path is spelt.
    EXPECT_EQ(refusal(access, head("GET /healthz")), 0);
    for (const char* other : {"GET /v1/scenes", "GET /v1/%66rames?scene=chapel", "GET //v1/frames",
                              "GET /v1/stream?scene=chapel", "GET /metrics"}) {
        EXPECT_EQ(refusal(access, head(other)), 403) << other;
    }
    for (const char* path : {"/v1/frames", "/v1/plans", "/v1/sequences", "/v1/comparisons"}) {
        const RequestHead post =
            head(std::string("POST ") + path, "Host: localhost\r\nContent-Length: 0\r\n");
        EXPECT_EQ(refusal(access, post), 403) << path;
    }
}

TEST(Access, ALinkReplacesTheToken) {
    const Access access(
        {.tokenFile = fileWith("token", kToken), .linkKeyFile = fileWith("key", kKey)}, kPaths);
    const std::string link = signedLink(kKey, "/v1/frames?scene=chapel", at(2000));
    EXPECT_EQ(refusal(access, head("GET " + link)), 0);
    EXPECT_EQ(refusal(access, head("GET /v1/frames")), 403);
    EXPECT_EQ(refusal(access, head("GET /v1/frames",
                                   "Host: localhost\r\nAuthorization: Bearer " + kToken + "\r\n")),
              0);
    const std::string scenes = signedLink(kKey, "/v1/scenes", at(2000));
    EXPECT_EQ(refusal(access, head("GET " + scenes)), 401) << "only frames have links";
}

TEST(Access, SecretsHaveAMinimumLength) {
    EXPECT_THROW(secretFrom("/nonexistent/token"), std::runtime_error);
    EXPECT_THROW(secretFrom(fileWith("short", "fifteen bytes..\n")), std::runtime_error);
    EXPECT_EQ(secretFrom(fileWith("long", "sixteen bytes...\r\nmore")), "sixteen bytes...");
}

TEST(Access, OnlyTrustedProxiesMayNameTheirClient) {
    const RequestHead request =
        head("GET /", "Host: localhost\r\nX-Forwarded-For: 6.6.6.6, 10.0.0.7\r\n");
    EXPECT_EQ(Access({}, kPaths).clientOf(request, "127.0.0.1"), "127.0.0.1");
    const Access behind({.clientHeader = "X-Forwarded-For"}, kPaths);
    EXPECT_EQ(behind.clientOf(request, "127.0.0.1"), "10.0.0.7");
    EXPECT_EQ(behind.clientOf(head("GET /"), "127.0.0.1"), "127.0.0.1");
    // A proxy may append a line of its own.
    EXPECT_EQ(behind.clientOf(head("GET /",
                                   "Host: localhost\r\nX-Forwarded-For: 66.6.6.6\r\n"
                                   "x-forwarded-for: 10.0.0.8\r\n"),
                              "127.0.0.1"),
              "10.0.0.8");
    // The user of an IPv6 network chooses 64 bits of the address.
    const std::pair<const char*, const char*> same[] = {
        {"2001:db8:1:2:3:4:5:6", "2001:db8:1:2::"},
        {"2001:db8:1:2::1", "2001:db8:1:2::"},
        {"[2001:db8:1:2::9]:4711", "2001:db8:1:2::"},
        {"::ffff:10.0.0.7", "10.0.0.7"},
        {"10.0.0.7:4711", "10.0.0.7"}};
    for (const auto& [given, client] : same) {
        const RequestHead one =
            head("GET /", "Host: localhost\r\nX-Forwarded-For: " + std::string(given) + "\r\n");
        EXPECT_EQ(behind.clientOf(one, "127.0.0.1"), client) << given;
    }
}

}  // namespace
}  // namespace clerestory::test
