// Rejections: their status, and the pointer to the error.
#include "tests/support/test_server.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sys/socket.h>

namespace clerestory::test {
namespace {

using nlohmann::json;
using testing::Contains;
using testing::HasSubstr;

struct WrongBody {
    const char* body;
    int status;
    std::vector<const char*> pointers;  // each must be named; none for a body that is not JSON
};

const std::vector<WrongBody> kWrongBodies = {
    // Not JSON.
    {"", 400, {}},
    {"{", 400, {}},
    {"}", 400, {}},
    {"{} {}", 400, {}},
    {"{'width': 3}", 400, {}},
    {"{\"width\": 64,}", 400, {}},
    {"{\"width\": NaN}", 400, {}},
    {"{\"width\": Infinity}", 400, {}},
    {"{\"width\": 0x10}", 400, {}},
    {"{\"width\": 064}", 400, {}},
    {"// a comment\n{}", 400, {}},
    {"{\"scene\": \"\xff\"}", 400, {}},
    {"{\"scene\": \"\\ud800\"}", 400, {}},
    {"[[[[[[[[[[[[[[[[[[[[]]]]]]]]]]]]]]]]]]]]", 400, {}},
    // JSON, but no object.
    {"[]", 422, {""}},
    {"null", 422, {""}},
    {"17", 422, {""}},
    {"\"chapel\"", 422, {""}},
    // Doubled and unknown fields.
    {R"({"width": 64, "width": 64})", 422, {"/width"}},
    {R"({"camera": {"yfov": 1, "yfov": 1}})", 422, {"/camera/yfov"}},
    {R"({"widht": 64})", 422, {"/widht"}},
    {R"({"camera": {"positon": [0, 0, 0]}})", 422, {"/camera/positon"}},
    {R"({"a/b~c": 1})", 422, {"/a~1b~0c"}},
    {R"({"effects": {"bloom": true}})", 422, {"/effects/bloom"}},
    {R"({"accuracy": {"probeDepths": 64}})", 422, {"/accuracy/probeDepths"}},
    {R"({"environment": {"name": "sky"}})", 422, {"/environment/name"}},
    {R"({"output": {"type": "jpeg"}})", 422, {"/output/type"}},
    // Wrong types.
    {R"({"width": "64"})", 422, {"/width"}},
    {R"({"width": null})", 422, {"/width"}},
    {R"({"width": true})", 422, {"/width"}},
    {R"({"width": [64]})", 422, {"/width"}},
    {R"({"scene": 1})", 422, {"/scene"}},
    {R"({"camera": []})", 422, {"/camera"}},
    {R"({"camera": "main"})", 422, {"/camera"}},
    {R"({"camera": {"position": 1, "target": [0, 0, 0]}})", 422, {"/camera/position"}},
    {R"({"camera": {"position": {"x": 1}, "target": [0, 0, 0]}})", 422, {"/camera/position"}},
    {R"({"camera": {"position": [1, 2], "target": [0, 0, 0]}})", 422, {"/camera/position"}},
    {R"({"camera": {"position": [1, 2, 3, 4], "target": [0, 0, 0]}})", 422, {"/camera/position"}},
    {R"({"camera": {"position": [1, "2", 3], "target": [0, 0, 0]}})", 422, {"/camera/position/1"}},
    {R"({"camera": {"position": [1, null, 3], "target": [0, 0, 0]}})", 422, {"/camera/position/1"}},
    {R"({"camera": {"cameraToWorld": [1, 0, 0]}})", 422, {"/camera/cameraToWorld"}},
    {R"({"camera": {"intrinsics": 5}})", 422, {"/camera/intrinsics"}},
    {R"({"effects": {"emission": 1}})", 422, {"/effects/emission"}},
    {R"({"effects": {"emission": "true"}})", 422, {"/effects/emission"}},
    {R"({"effects": true})", 422, {"/effects"}},
    {R"({"accuracy": 3})", 422, {"/accuracy"}},
    {R"({"toneMap": 0})", 422, {"/toneMap"}},
    {R"({"output": "png"})", 422, {"/output"}},
    // Overrides.
    {R"({"overrides": {}})", 422, {"/overrides"}},
    {R"({"overrides": [3]})", 422, {"/overrides/0"}},
    {R"({"overrides": [{"node": "ball", "roughness": 1.5}]})", 422, {"/overrides/0/roughness"}},
    {R"({"overrides": [{"node": "ball", "roughnes": 1}]})", 422, {"/overrides/0/roughnes"}},
    {R"({"overrides": [{"node": "ball", "reflection": "some"}]})",
     422,
     {"/overrides/0/reflection"}},
    {R"({"overrides": [{"node": "ball", "baseColor": [1, 1, 1, 1]}]})",
     422,
     {"/overrides/0/baseColor"}},
    {R"({"overrides": [{"roughness": 0.5}]})", 422, {"/overrides/0"}},
    {R"({"overrides": [{"node": "ball"}, {"node": "bal", "roughness": 0.5},
                       {"material": "miror", "environmentMap": "duks", "probe": "x"}]})",
     422,
     {"/overrides/1/node", "/overrides/2/material", "/overrides/2/probe",
      "/overrides/2/environmentMap"}},
    {R"({"overrides": [{"node": "ball", "environmentRotation": [0, 0, 0, 2]}]})",
     422,
     {"/overrides/0/environmentRotation"}},
    // Filters.
    {R"({"filters": {}})", 422, {"/filters"}},
    {R"({"filters": ["glow"]})", 422, {"/filters/0"}},
    {R"({"filters": [{}]})", 422, {"/filters/0/type"}},
    {R"({"filters": [{"type": "bloom"}]})", 422, {"/filters/0/type"}},
    {R"({"filters": [{"type": "glow", "radius": -1}]})", 422, {"/filters/0/radius"}},
    {R"({"filters": [{"type": "glow", "strength": 1.01}]})", 422, {"/filters/0/strength"}},
    {R"({"filters": [{"type": "glow"}, {"type": "twirl"}]})", 422, {"/filters/1/amount"}},
    {R"({"filters": [{"type": "twirl", "amount": 1, "threshold": 1, "edge": "clamp"}]})",
     422,
     {"/filters/0/threshold", "/filters/0/edge"}},
    {R"({"filters": [{"type": "convolve"}]})", 422, {"/filters/0/kernel"}},
    {R"({"filters": [{"type": "convolve", "kernel": 3}]})", 422, {"/filters/0/kernel"}},
    {R"({"filters": [{"type": "convolve", "kernel": "sharp"}]})", 422, {"/filters/0/kernel"}},
    {R"({"filters": [{"type": "convolve", "kernel": [1, 2, 3, 4, 5, 6, 7, 8]}]})",
     422,
     {"/filters/0/kernel"}},
    {R"({"filters": [{"type": "convolve", "kernel": [1, 2, 3, 4, "5", 6, 7, 8, 1e4]}]})",
     422,
     {"/filters/0/kernel/4", "/filters/0/kernel/8"}},
    {R"({"filters": [{"type": "convolve", "kernel": "box", "edge": "mirror"}]})",
     422,
     {"/filters/0/edge"}},
    {R"({"filters": [{"type": "glow"}, {"type": "glow"}, {"type": "glow"}, {"type": "glow"},
                     {"type": "glow"}, {"type": "glow"}, {"type": "glow"}, {"type": "glow"},
                     {"type": "glow"}]})",
     422,
     {"/filters"}},
    // Out of range, too large for the number's type, not whole.
    {R"({"width": 0})", 422, {"/width"}},
    {R"({"width": -64})", 422, {"/width"}},
    {R"({"width": 4097})", 422, {"/width"}},
    {R"({"width": 64.5})", 422, {"/width"}},
    {R"({"width": 4294967360})", 422, {"/width"}},
    {R"({"width": 1e300})", 422, {"/width"}},
    {R"({"width": 1e999})", 422, {"/width"}},
    {R"({"width": 99999999999999999999})", 422, {"/width"}},
    {R"({"height": 4096, "width": 4096})", 422, {"/width"}},
    {R"({"time": -1})", 422, {"/time"}},
    {R"({"exposure": 33})", 422, {"/exposure"}},
    {R"({"camera": {"yfov": 0}})", 422, {"/camera/yfov"}},
    {R"({"camera": {"yfov": 3.1415926}})", 422, {"/camera/yfov"}},
    {R"({"camera": {"znear": 0}})", 422, {"/camera/znear"}},
    {R"({"camera": {"position": [1e300, 0, 0], "target": [0, 0, 0]}})",
     422,
     {"/camera/position/0"}},
    {R"({"camera": {"intrinsics": {"fx": 0}}})", 422, {"/camera/intrinsics/fx"}},
    {R"({"output": {"quality": 0}})", 422, {"/output/quality"}},
    {R"({"output": {"quality": 101}})", 422, {"/output/quality"}},
    {R"({"accuracy": {"samples": 65}})", 422, {"/accuracy/samples"}},
    {R"({"accuracy": {"sampleShare": 0}})", 422, {"/accuracy/sampleShare"}},
    {R"({"environment": {"intensity": -1}})", 422, {"/environment/intensity"}},
    // Words that do not exist.
    {R"({"toneMap": "filmic"})", 422, {"/toneMap"}},
    {R"({"accuracy": "best"})", 422, {"/accuracy"}},
    {R"({"accuracy": {"preset": "best"}})", 422, {"/accuracy/preset"}},
    {R"({"output": {"format": "gif"}})", 422, {"/output/format"}},
    {R"({"output": {"subsampling": "4:1:1"}})", 422, {"/output/subsampling"}},
    {R"({"camera": {"name": "no such camera"}})", 422, {"/camera/name"}},
    {R"({"environment": {"map": "no such map"}})", 422, {"/environment/map"}},
    {R"({"scene": "no such scene"})", 404, {"/scene"}},
    {R"({"scene": "../../etc/passwd"})", 404, {"/scene"}},
    {R"x({"scene": "(canary)"})x", 404, {"/scene"}},
    // Fields that do not go together.
    {R"({"camera": {"position": [0, 0, 0]}})", 422, {"/camera/position"}},
    {R"({"camera": {"target": [0, 0, 0]}})", 422, {"/camera/target"}},
    {R"({"camera": {"position": [1, 1, 1], "target": [1, 1, 1]}})", 422, {"/camera/target"}},
    {R"({"camera": {"position": [1, 1, 1], "target": [0, 0, 0], "up": [0, 0, 0]}})",
     422,
     {"/camera/up"}},
    {R"({"camera": {"position": [1, 1, 1], "orientation": [0, 0, 0, 0]}})",
     422,
     {"/camera/orientation"}},
    {R"({"camera": {"name": "a", "position": [1, 1, 1], "target": [0, 0, 0]}})",
     422,
     {"/camera/name"}},
    {R"({"camera": {"znear": 5, "zfar": 1}})", 422, {"/camera/zfar"}},
    {R"({"camera": {"yfov": 1, "intrinsics": {}}})", 422, {"/camera/intrinsics"}},
    {R"({"output": {"format": "jpeg", "channel": "depth"}})", 422, {"/output/format"}},
    // Several at once: each is named.
    {R"({"widht": 1, "height": 0, "camera": {"yfov": 9, "up": "y"}, "toneMap": "x"})",
     422,
     {"/widht", "/height", "/camera/yfov", "/camera/up", "/toneMap"}},
};

TEST(Refusals, EveryInvalidBodyGetsAPointerToTheError) {
    ASSERT_GE(kWrongBodies.size(), 60u);
    auto client = sharedServer().client();
    for (const char* path : {"/v1/frames", "/v1/plans"}) {
        for (const WrongBody& wrong : kWrongBodies) {
            SCOPED_TRACE(std::string(path) + " " + wrong.body);
            const json problem = problemOf(postJson(client, path, wrong.body), wrong.status);
            if (problem.is_null()) continue;
            std::vector<std::string> named;
            for (const json& error : problem.value("errors", json::array())) {
                named.push_back(error.at("pointer"));
                EXPECT_FALSE(error.at("detail").get<std::string>().empty());
                EXPECT_FALSE(error.at("allowed").get<std::string>().empty());
            }
            EXPECT_EQ(named.size(), wrong.pointers.size()) << problem.dump();
            for (const char* pointer : wrong.pointers) EXPECT_THAT(named, Contains(pointer));
        }
    }
}

TEST(Refusals, MistypedNamesGetASuggestion) {
    auto client = sharedServer().client();
    const auto detail = [&](const char* body) {
        return problemOf(postJson(client, "/v1/frames", body), 422)
            .at("errors")[0]
            .at("detail")
            .get<std::string>();
    };
    EXPECT_THAT(detail(R"({"widht": 64})"), HasSubstr("did you mean \"width\"?"));
    EXPECT_THAT(detail(R"({"camera": {"positon": []}})"), HasSubstr("did you mean \"position\"?"));
    EXPECT_THAT(detail(R"({"camera": {"fov": 1}})"), HasSubstr("did you mean \"yfov\"?"));
    EXPECT_THAT(detail(R"({"toneMap": "ACES"})"), HasSubstr("did you mean \"aces\"?"));
    EXPECT_THAT(detail(R"({"somethingElse": 1})"), testing::Not(HasSubstr("did you mean")));
}

TEST(Refusals, LinksAreCheckedAsStrictlyAsBodies) {
    auto client = sharedServer().client();
    struct Link {
        const char* query;
        const char* pointer;
    };
    for (const Link& link : {Link{"widht=64", "/widht"},
                             {"width=64px", "/width"},
                             {"eye=1,2&target=0,0,0", "/camera/position"},
                             {"eye=1,2,x&target=0,0,0", "/camera/position/2"},
                             {"eye=1,2,3,4&target=0,0,0", "/camera/position"},
                             {"emission=maybe", "/effects/emission"},
                             {"width=64&width=65", "/width"},
                             {"eye=1,2,3&camera.position=1,2,3&target=0,0,0", "/camera/position"},
                             {"accuracy=best", "/accuracy/preset"},
                             {"format=gif", "/output/format"},
                             {"width=", "/width"},
                             {"explain=2", "/explain"}}) {
        SCOPED_TRACE(link.query);
        const json problem = problemOf(client.Get("/v1/frames?" + std::string(link.query)), 422);
        ASSERT_FALSE(problem.is_null());
        EXPECT_EQ(problem.at("errors")[0].at("pointer"), link.pointer);
    }
}

TEST(Refusals, ALinkListsAllItsErrorsAtOnce) {
    auto client = sharedServer().client();
    const json problem = problemOf(
        client.Get("/v1/frames?widht=64&width=64px&emission=maybe&explain=2&format=gif"), 422);
    ASSERT_FALSE(problem.is_null());
    std::vector<std::string> pointers;
    for (const json& error : problem.at("errors")) {
        pointers.push_back(error.at("pointer"));
        EXPECT_FALSE(error.at("allowed").get<std::string>().empty()) << error;
    }
    EXPECT_THAT(pointers, testing::UnorderedElementsAre("/widht", "/width", "/effects/emission",
                                                        "/explain", "/output/format"));
}

TEST(Refusals, PathsThatDoNotExist) {
    auto client = sharedServer().client();
    for (const char* path :
         {"/nothing", "/v1", "/v1/", "/v1/frames/", "/v1/scenes/nothing", "/v1/scenes/",
          "/v1/scenes/../../etc/passwd", "/v1/scenes/%2e%2e%2fx", "/..%2f..%2fetc/passwd",
          "/index.html%00.js", "//", "/\\..\\x", "/v1/scenes/six-walls/x"}) {
        SCOPED_TRACE(path);
        problemOf(client.Get(path), 404);
    }
}

TEST(Refusals, MethodsThatAreNotAllowedListTheAllowedOnes) {
    auto client = sharedServer().client();
    const auto allowOf = [](const httplib::Result& result) {
        problemOf(result, 405);
        return result ? result->get_header_value("Allow") : "";
    };
    EXPECT_EQ(allowOf(client.Delete("/v1/frames")), "POST, GET, HEAD");
    EXPECT_EQ(allowOf(client.Put("/v1/frames", "{}", "application/json")), "POST, GET, HEAD");
    EXPECT_EQ(allowOf(client.Get("/v1/plans")), "POST");
    EXPECT_EQ(allowOf(client.Put("/v1/scenes", "{}", "application/json")), "GET, HEAD, POST");
    EXPECT_EQ(allowOf(postJson(client, "/healthz", "{}")), "GET, HEAD");
    EXPECT_EQ(allowOf(client.Patch("/v1/renderer", "{}", "application/json")), "GET, HEAD");
    const auto options = client.Options("/v1/frames");
    ASSERT_TRUE(options);
    EXPECT_EQ(options->get_header_value("Allow"), "POST, GET, HEAD");
    const auto head = client.Head("/v1/renderer");
    ASSERT_TRUE(head);
    EXPECT_EQ(head->status, 200);
    EXPECT_TRUE(head->body.empty());
}

// As in the files of scenes (SideFile).
TEST(Refusals, AByteOrderMarkIsNotContent) {
    auto client = sharedServer().client();
    const std::string mark = "\xEF\xBB\xBF";
    const auto marked = postJson(client, "/v1/frames", mark + smallFrame());
    ASSERT_TRUE(marked);
    EXPECT_EQ(marked->status, 200);
    EXPECT_EQ(marked->body, postJson(client, "/v1/frames", smallFrame())->body);
    problemOf(postJson(client, "/v1/frames", mark + mark + smallFrame()), 400);
}

TEST(Refusals, OversizedAndMistypedBodies) {
    auto client = sharedServer().client();
    const std::string large = "{\"scene\": \"" + std::string(80 * 1024, 'x') + "\"}";
    problemOf(postJson(client, "/v1/frames", large), 413);
    problemOf(client.Post("/v1/frames", "{}", "text/plain"), 415);
    problemOf(client.Post("/v1/frames", "a=1", "application/x-www-form-urlencoded"), 415);
    problemOf(client.Post("/v1/frames", httplib::Headers{{"Content-Encoding", "gzip"}}, "{}",
                          "application/json"),
              415);
    const auto plain = client.Post("/v1/frames", smallFrame(), "Application/JSON; charset=utf-8");
    ASSERT_TRUE(plain);
    EXPECT_EQ(plain->status, 200);
    problemOf(client.Get("/" + std::string(2000, 'x')), 414);
}

// Requests that no client library sends.
std::string rawAnswer(int port, const std::string& request) {
    const int fd = ::socket(AF_INET, SOCK_STREAM, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(port));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    if (::connect(fd, reinterpret_cast<sockaddr*>(&address), sizeof address) != 0) return "";
    (void)!::send(fd, request.data(), request.size(), MSG_NOSIGNAL);
    ::shutdown(fd, SHUT_WR);
    std::string answer;
    char buffer[4096];
    for (ssize_t n; (n = ::recv(fd, buffer, sizeof buffer, 0)) > 0;) {
        answer.append(buffer, static_cast<std::size_t>(n));
    }
    ::close(fd);
    return answer;
}

TEST(Refusals, NonHttpRequestsGetOneResponseAndAreClosed) {
    const int port = sharedServer().server().port();
    const auto status = [&](const std::string& request) {
        const std::string answer = rawAnswer(port, request);
        EXPECT_EQ(answer.find("HTTP/1.1 ", 1), std::string::npos) << "one answer only: " << answer;
        return answer.substr(0, 12);
    };
    const std::string head =
        "POST /v1/frames HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n";
    EXPECT_EQ(status("nonsense\r\n\r\n"), "HTTP/1.1 400");
    EXPECT_EQ(status("\x16\x03\x01\x02\r\n\r\n"), "HTTP/1.1 400");
    EXPECT_EQ(status(head + "Transfer-Encoding: chunked\r\n\r\n2\r\n{}\r\n0\r\n\r\n"),
              "HTTP/1.1 411");
    EXPECT_EQ(status("DELETE /v1/frames HTTP/1.1\r\nHost: localhost\r\n"
                     "Transfer-Encoding: chunked\r\n\r\n0\r\n\r\n"),
              "HTTP/1.1 405");
    EXPECT_EQ(status("PUT /v1/frames HTTP/1.1\r\nHost: localhost\r\n\r\n"), "HTTP/1.1 405");
    EXPECT_EQ(status("POST /v1/jobs/0 HTTP/1.1\r\nHost: localhost\r\n\r\n"), "HTTP/1.1 405");
    EXPECT_EQ(status("POST /v1/frames HTTP/1.1\r\nHost: localhost\r\n\r\n"), "HTTP/1.1 411");
    EXPECT_EQ(status(head + "Content-Length: abc\r\n\r\n{}"), "HTTP/1.1 400");
    EXPECT_EQ(status(head + "Content-Length: -1\r\n\r\n{}"), "HTTP/1.1 400");
    EXPECT_EQ(status(head + "Content-Length: 2\r\nContent-Length: 3\r\n\r\n{}"), "HTTP/1.1 400");
    EXPECT_EQ(status(head + "Content-Length: 99999999999999999999\r\n\r\n{}"), "HTTP/1.1 413");
    EXPECT_EQ(status("GET /healthz HTTP/1.1\r\nHost: localhost\r\nContent-Length: 5\r\n\r\nGET /"),
              "HTTP/1.1 400");
    std::string many = "GET /healthz HTTP/1.1\r\n";
    for (int i = 0; i < 200; ++i) many += "X-" + std::to_string(i) + ": 1\r\n";
    EXPECT_EQ(status(many + "\r\n"), "HTTP/1.1 431");
    // A line that never ends is given up, and the server still answers.
    rawAnswer(port, "GET /" + std::string(300'000, 'a'));
    EXPECT_EQ(status("GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n"), "HTTP/1.1 200");
}

TEST(Refusals, ResponsesDoNotLeakInternals) {
    auto client = sharedServer().client();
    for (const WrongBody& wrong : kWrongBodies) {
        const auto result = postJson(client, "/v1/frames", wrong.body);
        ASSERT_TRUE(result);
        EXPECT_THAT(result->body, testing::Not(HasSubstr("json.exception")));
        EXPECT_FALSE(result->has_header("EXCEPTION_WHAT"));
    }
    const auto health = client.Get("/healthz");
    EXPECT_EQ(health->get_header_value("X-Content-Type-Options"), "nosniff");
    EXPECT_THAT(health->get_header_value("Content-Security-Policy"),
                HasSubstr("frame-ancestors 'none'"));
    EXPECT_FALSE(health->has_header("Access-Control-Allow-Origin"));
}

}  // namespace
}  // namespace clerestory::test
