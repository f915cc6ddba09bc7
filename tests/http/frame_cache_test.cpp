// Equal requests of frames are answered from memory: the same bytes, without the renderer, for as
// long as they would be drawn the same.
#include "server/base/process.h"
#include "tests/support/soon.h"
#include "tests/support/test_server.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <thread>

namespace clerestory::test {
namespace {

using nlohmann::json;
using testing::HasSubstr;

Config cacheConfig(std::size_t bytes = 64 << 20) {
    Config config = testConfig();
    config.frameCacheBytes = bytes;
    return config;
}

httplib::Result postWith(httplib::Client& client, const httplib::Headers& headers,
                         const std::string& body) {
    return client.Post("/v1/frames", headers, body, "application/json");
}

bool isHit(const httplib::Result& result) {
    EXPECT_TRUE(result);
    EXPECT_EQ(result->status, 200) << result->body;
    return result->has_header("Age");
}

// The value of a metric, such as "clerestory_frame_cache_bytes".
double metric(httplib::Client& client, const std::string& name) {
    const std::string text = "\n" + client.Get("/metrics")->body;
    const std::size_t at = text.find("\n" + name + " ");
    if (at == std::string::npos) {
        ADD_FAILURE() << "no metric " << name;
        return -1.0;
    }
    return std::stod(text.substr(at + name.size() + 2));
}

double events(httplib::Client& client, const std::string& event) {
    return metric(client, "clerestory_frame_cache_events{event=\"" + event + "\"}");
}

std::string tinyFrame(int number) {
    return smallFrame(R"("output": {"format": "npy"}, "exposure": 0.)" +
                      std::to_string(100 + number));
}

TEST(FrameCache, AnEqualRequestGetsTheSameAnswerWithoutDrawing) {
    TestServer server(cacheConfig());
    auto client = server.client();
    const auto drawn = postJson(client, "/v1/frames", smallFrame());
    EXPECT_FALSE(isHit(drawn));
    const auto again = postJson(client, "/v1/frames", smallFrame());
    EXPECT_TRUE(isHit(again));
    EXPECT_GE(std::stoi(again->get_header_value("Age")), 0);
    EXPECT_EQ(again->body, drawn->body);
    for (const char* name : {"Content-Type", "Cache-Control", "Vary", "ETag", "Server-Timing",
                             "Clerestory-Passes", "Clerestory-Scene-Generation"}) {
        EXPECT_FALSE(drawn->get_header_value(name).empty()) << name;
        EXPECT_EQ(again->get_header_value(name), drawn->get_header_value(name)) << name;
    }
    EXPECT_NE(again->get_header_value("X-Request-Id"), drawn->get_header_value("X-Request-Id"));
    EXPECT_EQ(server.framesDrawn(), 1u);
    EXPECT_EQ(events(client, "hit"), 1.0);
    EXPECT_EQ(events(client, "miss"), 1.0);
    EXPECT_EQ(metric(client, "clerestory_frame_cache_entries"), 1.0);
    EXPECT_GT(metric(client, "clerestory_frame_cache_bytes"),
              static_cast<double>(drawn->body.size()));
    const json limits = json::parse(client.Get("/v1/renderer")->body)["limits"];
    EXPECT_EQ(limits["frameCacheBytes"], 64 << 20);
    const auto head = client.Head("/v1/frames?scene=six-walls&width=64&height=48" + kPlainLink);
    EXPECT_EQ(head->get_header_value("Content-Length"), std::to_string(drawn->body.size()));
    EXPECT_TRUE(head->has_header("Age"));
}

TEST(FrameCache, EqualFormsOfARequestShareAnEntry) {
    TestServer server(cacheConfig());
    auto client = server.client();
    const auto drawn = postJson(client, "/v1/frames", smallFrame());
    EXPECT_FALSE(isHit(drawn));
    for (const char* form :
         {R"("width": 64, "height": 48)", R"("height": 48.0, "scene": "", "width": 64)",
          R"("scene": "six-walls", "width": 64, "height": 48, "time": 0, "toneMap": "neutral",
              "accuracy": {"preset": "standard"}, "output": {"format": "jpeg"})"}) {
        const auto result = postJson(client, "/v1/frames", "{" + kPlainEffects + ", " + form + "}");
        EXPECT_TRUE(isHit(result)) << form;
        EXPECT_EQ(result->body, drawn->body) << form;
    }
    EXPECT_TRUE(isHit(client.Get("/v1/frames?scene=six-walls&width=64&height=48" + kPlainLink)));
    EXPECT_TRUE(isHit(client.Get("/v1/frames?height=48&width=64&explain=0" + kPlainLink)));
    EXPECT_TRUE(isHit(postWith(client, {{"Accept", "image/jpeg"}}, smallFrame())));
    EXPECT_EQ(server.framesDrawn(), 1u);
}

TEST(FrameCache, EveryFieldBelongsToTheKey) {
    TestServer server(cacheConfig());
    auto client = server.client();
    EXPECT_FALSE(isHit(postJson(client, "/v1/frames", smallFrame())));
    for (const char* change :
         {R"("exposure": 0.1)", R"("time": 1)", R"("toneMap": "aces")", R"("accuracy": "draft")",
          R"("effects": {"emission": false})", R"("output": {"quality": 84})",
          R"("output": {"format": "png"})", R"("environment": {"map": "studio"})",
          R"("camera": {"yfov": 0.5})", R"("overrides": [{"node": "ball", "roughness": 0.2}])",
          R"("overrides": [{"node": "ball", "roughness": 0.3}])",
          R"("filters": [{"type": "twirl", "amount": 1}])"}) {
        EXPECT_FALSE(isHit(postJson(client, "/v1/frames", smallFrame(change)))) << change;
        EXPECT_TRUE(isHit(postJson(client, "/v1/frames", smallFrame(change)))) << change;
    }
    const auto png = postWith(client, {{"Accept", "image/png"}}, smallFrame());
    EXPECT_TRUE(isHit(png)) << "as output.format";
    EXPECT_EQ(png->get_header_value("Content-Type"), "image/png");
    EXPECT_FALSE(isHit(postJson(client, "/v1/frames", R"({"width": 65, "height": 48})")));
}

// A hit takes no place in the queue, so that it is answered where others are refused.
TEST(FrameCache, AHitNeedsNoPlaceInTheQueue) {
    Config config = cacheConfig();
    config.queue = 1;
    TestServer server(config);
    server.awaitReady();
    auto client = server.client();
    EXPECT_FALSE(isHit(postJson(client, "/v1/frames", smallFrame())));
    auto hold = server.holdRenderer();
    std::thread waiting([&] {
        auto own = server.client();
        EXPECT_FALSE(isHit(postJson(own, "/v1/frames", smallFrame(R"("time": 1)"))));
    });
    EXPECT_TRUE(within(kPatience, [&] { return server.backend().queue().depth() != 0; }));
    problemOf(postJson(client, "/v1/frames", smallFrame(R"("time": 2)")), 503);
    problemOf(postJson(client, "/v1/plans", smallFrame()), 503);
    EXPECT_TRUE(isHit(postJson(client, "/v1/frames", smallFrame())));
    EXPECT_EQ(server.backend().queue().depth(), 1u);
    hold.reset();
    waiting.join();
}

TEST(FrameCache, ZeroBytesSwitchItOff) {
    TestServer server(cacheConfig(0));
    auto client = server.client();
    EXPECT_FALSE(isHit(postJson(client, "/v1/frames", smallFrame())));
    EXPECT_FALSE(isHit(postJson(client, "/v1/frames", smallFrame())));
    EXPECT_EQ(server.framesDrawn(), 2u);
    EXPECT_EQ(metric(client, "clerestory_frame_cache_entries"), 0.0);
    EXPECT_EQ(events(client, "miss"), 0.0);
    const json limits = json::parse(client.Get("/v1/renderer")->body)["limits"];
    EXPECT_EQ(limits["frameCacheBytes"], 0);
}

TEST(FrameCache, TheLeastRecentlyUsedFrameMakesRoom) {
    double bytes = 0.0;  // of one entry
    {
        TestServer server(cacheConfig());
        auto client = server.client();
        EXPECT_FALSE(isHit(postJson(client, "/v1/frames", tinyFrame(0))));
        bytes = metric(client, "clerestory_frame_cache_bytes");
    }
    const double bound = 2.5 * bytes;
    TestServer server(cacheConfig(static_cast<std::size_t>(bound)));
    auto client = server.client();
    for (int frame : {0, 1}) {
        EXPECT_FALSE(isHit(postJson(client, "/v1/frames", tinyFrame(frame))));
    }
    EXPECT_TRUE(isHit(postJson(client, "/v1/frames", tinyFrame(0))));
    EXPECT_FALSE(isHit(postJson(client, "/v1/frames", tinyFrame(2)))) << "replaces frame 1";
    EXPECT_TRUE(isHit(postJson(client, "/v1/frames", tinyFrame(0))));
    EXPECT_EQ(events(client, "evicted"), 1.0);
    EXPECT_EQ(metric(client, "clerestory_frame_cache_entries"), 2.0);
    EXPECT_LE(metric(client, "clerestory_frame_cache_bytes"), bound);
    EXPECT_FALSE(isHit(postJson(client, "/v1/frames", tinyFrame(1))));

    // An answer that is larger than the cache removes nothing.
    const std::string large =
        R"({"width": 256, "height": 256, "output": {"format": "npy"}, )" + kPlainEffects + "}";
    EXPECT_FALSE(isHit(postJson(client, "/v1/frames", large)));
    EXPECT_FALSE(isHit(postJson(client, "/v1/frames", large)));
    EXPECT_EQ(metric(client, "clerestory_frame_cache_entries"), 2.0);
    EXPECT_TRUE(isHit(postJson(client, "/v1/frames", tinyFrame(1))));
}

TEST(FrameCache, NoCacheDrawsAgainAndNoStoreKeepsNothing) {
    TestServer server(cacheConfig());
    auto client = server.client();
    EXPECT_FALSE(isHit(postWith(client, {{"Cache-Control", "no-store"}}, smallFrame())));
    EXPECT_EQ(metric(client, "clerestory_frame_cache_entries"), 0.0);
    EXPECT_FALSE(isHit(postJson(client, "/v1/frames", smallFrame())));
    const auto renewed =
        postWith(client, {{"Cache-Control", "max-age=0,  No-Cache"}}, smallFrame());
    EXPECT_FALSE(isHit(renewed));
    EXPECT_EQ(server.framesDrawn(), 3u);
    const auto hit = postJson(client, "/v1/frames", smallFrame());
    EXPECT_TRUE(isHit(hit));
    EXPECT_EQ(hit->get_header_value("Server-Timing"), renewed->get_header_value("Server-Timing"))
        << "of the frame that was drawn last";
    EXPECT_EQ(metric(client, "clerestory_frame_cache_entries"), 1.0);
}

// Their answers contain measured times, or depend on them.
TEST(FrameCache, ExplainedFramesAndBudgetsAreDrawnEachTime) {
    TestServer server(cacheConfig());
    auto client = server.client();
    EXPECT_FALSE(isHit(postJson(client, "/v1/frames", smallFrame())));
    for (const char* words : {"1", "health", "maps"}) {
        for (int i = 0; i < 2; ++i) {
            const std::string path = "/v1/frames?explain=" + std::string(words);
            EXPECT_FALSE(isHit(postJson(client, path, smallFrame()))) << words;
        }
    }
    EXPECT_EQ(server.framesDrawn(), 7u);
    const std::string budget = smallFrame(R"("accuracy": {"maxMilliseconds": 1000})");
    EXPECT_FALSE(isHit(postUntilReady(client, "/v1/frames", budget)));
    EXPECT_FALSE(isHit(postJson(client, "/v1/frames", budget)));
    EXPECT_EQ(metric(client, "clerestory_frame_cache_entries"), 1.0);
}

// Until its light is complete a frame changes: it is drawn each time, and its entity tag with it.
TEST(FrameCache, OnlyFramesWithCompleteLightAreKept) {
    Config config = cacheConfig();
    config.scenes.scenes = {"orbiting-cubes"};
    TestServer server(config);
    auto client = server.client();
    const std::string link = "/v1/frames?width=64&height=48&format=png";
    const auto first = client.Get(link);
    EXPECT_FALSE(isHit(first));
    EXPECT_EQ(first->get_header_value("Clerestory-Light"), "revision=0, share=0.00");
    EXPECT_EQ(metric(client, "clerestory_frame_cache_entries"), 0.0);
    const auto waited = [&] { return client.Get(link, httplib::Headers{{"Prefer", "wait=60"}}); };
    auto complete = waited();
    while (complete->get_header_value("Clerestory-Light") != "revision=6, share=1.00") {
        ASSERT_EQ(complete->status, 200) << complete->body;
        complete = waited();
    }
    EXPECT_NE(complete->body, first->body);
    EXPECT_NE(complete->get_header_value("ETag"), first->get_header_value("ETag"));
    EXPECT_EQ(metric(client, "clerestory_frame_cache_entries"), 1.0);
    const auto hit = client.Get(link);
    EXPECT_TRUE(isHit(hit));
    EXPECT_EQ(hit->body, complete->body);
    // Where no frame shows it, there is nothing to wait for.
    const std::string depth = "/v1/frames?width=64&height=48&format=npy&channel=depth";
    EXPECT_FALSE(isHit(client.Get(depth)));
    EXPECT_TRUE(isHit(client.Get(depth)));
}

TEST(FrameCache, AnUnchangedFrameIsStillAnswered304) {
    TestServer server(cacheConfig());
    auto client = server.client();
    const std::string link = "/v1/frames?scene=six-walls&width=64&height=48" + kPlainLink;
    const auto drawn = client.Get(link);
    EXPECT_FALSE(isHit(drawn));
    const std::string etag = drawn->get_header_value("ETag");
    const auto unchanged = client.Get(link, unless(etag));
    EXPECT_EQ(unchanged->status, 304);
    EXPECT_TRUE(unchanged->body.empty());
    EXPECT_EQ(metric(client, "clerestory_not_modified_total"), 1.0);
    EXPECT_TRUE(isHit(client.Get(link, unless("\"x\""))));
    EXPECT_TRUE(isHit(postWith(client, {{"If-None-Match", etag}}, smallFrame()))) << "no GET";
}

TEST(FrameCache, RequestsAreCheckedAsBefore) {
    const auto token = std::filesystem::path(CLERESTORY_TEST_OUTPUT) / "frame-cache.token";
    std::filesystem::create_directories(token.parent_path());
    std::ofstream(token) << "a-token-of-some-length\n";
    std::filesystem::permissions(
        token, std::filesystem::perms::owner_read | std::filesystem::perms::owner_write);
    Config config = cacheConfig();
    config.http.access.tokenFile = token.string();
    TestServer server(config);
    auto untrusted = server.client();
    auto client = server.client();
    client.set_default_headers({{"Authorization", "Bearer a-token-of-some-length"}});
    EXPECT_FALSE(isHit(postJson(client, "/v1/frames", smallFrame())));
    EXPECT_TRUE(isHit(postJson(client, "/v1/frames", smallFrame())));
    problemOf(postJson(untrusted, "/v1/frames", smallFrame()), 401);
    problemOf(postJson(client, "/v1/frames?explian=1", smallFrame()), 422);
    problemOf(postJson(client, "/v1/frames?explain=no", smallFrame()), 422);
    problemOf(postWith(client, {{"Clerestory-Deadline", "soon"}}, smallFrame()), 400);
    problemOf(client.Post("/v1/frames", smallFrame(), "text/plain"), 415);
    problemOf(client.Put("/v1/frames", smallFrame(), "application/json"), 405);
    for (int i = 0; i < 2; ++i) {
        problemOf(postJson(client, "/v1/frames", R"({"scene": "unknown"})"), 404);
    }
    EXPECT_EQ(metric(client, "clerestory_frame_cache_entries"), 1.0);
}

// Sequences ask the renderer itself.
TEST(FrameCache, SequencesDrawTheirFrames) {
    TestServer server(cacheConfig());
    auto client = server.client();
    const auto drawn = postJson(client, "/v1/frames", smallFrame());
    EXPECT_FALSE(isHit(drawn));
    const json frames = {{"frames", {json::parse(smallFrame()), json::parse(smallFrame())}}};
    const auto sequence = client.Post("/v1/sequences", {{"Accept", "multipart/mixed"}},
                                      frames.dump(), "application/json");
    ASSERT_EQ(sequence->status, 200);
    EXPECT_THAT(sequence->body, HasSubstr(drawn->body));
    EXPECT_EQ(server.framesDrawn(), 3u);
}

TEST(FrameCache, ConcurrentRequestsGetEqualBytes) {
    TestServer server(cacheConfig());
    constexpr int kClients = 24;
    std::vector<std::string> bodies(kClients);
    std::vector<std::thread> threads;
    for (std::string& body : bodies) {
        threads.emplace_back([&] {
            auto own = server.client();
            for (int i = 0; i < 4; ++i) {
                const auto result = postJson(own, "/v1/frames", smallFrame());
                body = result && result->status == 200 ? result->body : "no frame";
            }
        });
    }
    for (std::thread& thread : threads) thread.join();
    EXPECT_NE(bodies[0], "no frame");
    EXPECT_EQ(std::count(bodies.begin(), bodies.end(), bodies[0]), kClients);
    auto client = server.client();
    EXPECT_EQ(metric(client, "clerestory_frame_cache_entries"), 1.0);
    EXPECT_EQ(events(client, "hit") + events(client, "miss"), 4.0 * kClients);
}

// The process that clients reach prints how long a hit takes over HTTP.
TEST(FrameCache, PrintsTheTimeOfAHit) {
    TestServer server(cacheConfig());
    auto client = server.client();
    const std::string body = R"({"width": 640, "height": 360, )" + kPlainEffects + "}";
    EXPECT_FALSE(isHit(postJson(client, "/v1/frames", body)));
    std::vector<double> milliseconds;
    for (int i = 0; i < 500; ++i) {
        const auto start = Clock::now();
        const auto result = postJson(client, "/v1/frames", body);
        milliseconds.push_back(millisecondsSince(start));
        ASSERT_TRUE(isHit(result));
    }
    std::sort(milliseconds.begin(), milliseconds.end());
    std::printf("a hit takes %.3f ms (p50), %.3f ms (p99)\n", milliseconds[250], milliseconds[495]);
}

}  // namespace
}  // namespace clerestory::test
