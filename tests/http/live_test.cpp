// Live views: every viewer receives what was put, and the last frame again once the view is at
// rest.
#include "tests/support/drawing_gate.h"
#include "tests/support/soon.h"
#include "tests/support/test_server.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <future>
#include <thread>

namespace clerestory::test {
namespace {

using nlohmann::json;
using namespace std::chrono_literals;

std::string viewFrom(double x) {
    return smallFrame(R"("camera": {"position": [)" + std::to_string(x) +
                      R"(, 1, 2], "target": [0, 1, 0]})");
}

// A viewer that reads a stream until a condition holds.
class StreamViewer {
public:
    StreamViewer(TestServer& server, const std::string& link) : client_(server.client()) {
        thread_ = std::thread([this, link] {
            client_.Get(
                link,
                [&](const httplib::Response& response) {
                    type = response.get_header_value("Content-Type");
                    return response.status == 200;
                },
                [&](const char* data, std::size_t n) {
                    const std::lock_guard lock(mutex_);
                    text_.append(data, n);
                    return !leaving_;
                });
        });
    }
    ~StreamViewer() { leave(); }
    void leave() {
        leaving_ = true;
        client_.stop();
        if (thread_.joinable()) thread_.join();
    }

    // Waits for that many pictures; those whole so far.
    std::vector<std::string> pictures(std::size_t wanted) {
        std::vector<std::string> seen;
        const bool all = within(15s, [&] {
            seen = parsed().pictures;
            return seen.size() >= wanted;
        });
        if (all) return seen;
        ADD_FAILURE() << "only " << seen.size() << " of " << wanted << " pictures came";
        return std::vector<std::string>(wanted);
    }
    // The same: the headers of their parts.
    std::vector<std::string> heads(std::size_t wanted) {
        pictures(wanted);
        auto list = parsed().heads;
        list.resize(wanted);
        return list;
    }

    std::string type;

private:
    struct Parts {
        std::vector<std::string> heads, pictures;
    };
    Parts parsed() {
        const std::lock_guard lock(mutex_);
        Parts parts;
        const std::string mark = "Content-Length: ";
        for (std::size_t at = 0; (at = text_.find("--frame\r\n", at)) != std::string::npos;) {
            const std::size_t length = text_.find(mark, at), head = text_.find("\r\n\r\n", at);
            if (length == std::string::npos || head == std::string::npos) break;
            const std::size_t n = std::stoull(text_.substr(length + mark.size()));
            if (head + 4 + n > text_.size()) break;
            parts.heads.push_back(text_.substr(at, head + 2 - at));
            parts.pictures.push_back(text_.substr(head + 4, n));
            at = head + 4 + n;
        }
        return parts;
    }

    httplib::Client client_;
    std::thread thread_;
    std::mutex mutex_;
    std::string text_;
    std::atomic<bool> leaving_{false};
};

std::string frameOf(httplib::Client& client, const std::string& body) {
    return postJson(client, "/v1/frames", body)->body;
}

int put(httplib::Client& client, const std::string& name, const std::string& body) {
    return client.Put("/v1/views/" + name, body, "application/json")->status;
}

TEST(Live, AStreamFollowsItsViewAndRepeatsTheLastFrame) {
    TestServer server;
    auto client = server.client();
    ASSERT_EQ(put(client, "desk", viewFrom(0)), 204);
    EXPECT_EQ(json::parse(client.Get("/v1/views/desk")->body), json::parse(viewFrom(0)));
    StreamViewer watcher(server, "/v1/stream?view=desk&fps=60");
    const auto still = watcher.pictures(2);
    EXPECT_EQ(watcher.type, "multipart/x-mixed-replace; boundary=frame");
    EXPECT_EQ(still[0], frameOf(client, viewFrom(0)));
    EXPECT_EQ(still[1], still[0]);
    ASSERT_EQ(put(client, "desk", viewFrom(0.5)), 204);
    const auto moved = watcher.pictures(4);
    EXPECT_EQ(moved[2], frameOf(client, viewFrom(0.5)));
    EXPECT_EQ(moved[3], moved[2]);
    watcher.leave();
}

TEST(Live, ManyViewersShareOneFrame) {
    TestServer server;
    auto client = server.client();
    const auto drawn = [&] {
        return server.backend().queue().run(10s, [](Renderer& r) { return r.counters().frames; });
    };
    ASSERT_EQ(put(client, "stage", viewFrom(0)), 204);
    const auto before = drawn();
    std::vector<std::unique_ptr<StreamViewer>> watchers;
    for (int i = 0; i < 5; ++i) {
        watchers.push_back(std::make_unique<StreamViewer>(server, "/v1/stream?view=stage"));
    }
    for (auto& watcher : watchers) watcher->pictures(2);
    EXPECT_EQ(drawn(), before + 1);
}

TEST(Live, EachLinkIsASeparateStream) {
    auto client = sharedServer().client();
    StreamViewer watcher(sharedServer(),
                         "/v1/stream?scene=six-walls&width=64&height=48&eye=0,1,2&target=0,1,0");
    EXPECT_EQ(watcher.pictures(1)[0], frameOf(client, viewFrom(0)));
}

// The headers of each picture are read, and the last one is the request itself.
TEST(Live, APacedStreamBeginsSmallAndEndsWithTheRequest) {
    TestServer server;
    auto client = server.client();
    const std::string body = R"({"scene": "six-walls", "width": 640, "height": 360})";
    ASSERT_EQ(put(client, "paced", body), 204);
    StreamViewer watcher(server, "/v1/stream?view=paced&targetMs=100");
    const std::string whole = frameOf(client, body);
    std::size_t n = 1;
    while (watcher.pictures(n).back() != whole && n < 20 && !HasFailure()) ++n;
    const auto heads = watcher.heads(n);
    EXPECT_THAT(heads.front(), testing::HasSubstr("Clerestory-Preset: draft"));
    EXPECT_THAT(heads.front(), testing::Not(testing::HasSubstr("Clerestory-Size: 640x360")));
    EXPECT_THAT(heads.back(), testing::HasSubstr("Clerestory-Level: 0\r\n"));
    EXPECT_THAT(heads.back(), testing::HasSubstr("Clerestory-Size: 640x360\r\n"));
    EXPECT_THAT(heads.back(), testing::HasSubstr("Clerestory-Preset: requested\r\n"));
    EXPECT_THAT(heads.back(), testing::HasSubstr("Server-Timing: frame;dur="));
}

TEST(Live, EachPictureNamesTheVersionOfItsView) {
    TestServer server;
    auto client = server.client();
    const auto version = [&](double x) {
        return client.Put("/v1/views/numbered", viewFrom(x), "application/json")
            ->get_header_value("Clerestory-View-Version");
    };
    EXPECT_EQ(version(0), "1");
    EXPECT_EQ(version(0.25), "2");
    StreamViewer watcher(server, "/v1/stream?view=numbered");
    watcher.pictures(1);
    EXPECT_EQ(version(0.5), "3");
    const auto heads = watcher.heads(4);
    EXPECT_THAT(heads.front(), testing::HasSubstr("Clerestory-View-Version: 2\r\n"));
    EXPECT_THAT(heads.back(), testing::HasSubstr("Clerestory-View-Version: 3\r\n"));
    EXPECT_THAT(heads.back(), testing::Not(testing::HasSubstr("Clerestory-Level")));
}

// While a frame of the view waits in the queue, poses replace it.
TEST(Live, OfThePosesThatWaitOnlyTheNewestIsDrawn) {
    for (const char* more : {"", "&targetMs=100"}) {
        TestServer server;
        auto client = server.client();
        const auto drawn = [&] {
            return server.backend().queue().run(10s,
                                                [](Renderer& r) { return r.counters().frames; });
        };
        ASSERT_EQ(put(client, "held", viewFrom(0)), 204);
        StreamViewer watcher(server, std::string("/v1/stream?view=held&fps=60") + more);
        watcher.pictures(1);
        const std::uint64_t before = drawn();
        auto hold = server.holdRenderer();
        ASSERT_EQ(put(client, "held", viewFrom(0.1)), 204);
        EXPECT_TRUE(within(kPatience, [&] { return server.backend().queue().depth() != 0; }));
        for (int i = 2; i <= 9; ++i) ASSERT_EQ(put(client, "held", viewFrom(0.1 * i)), 204);
        hold.reset();
        const std::string last = frameOf(client, viewFrom(0.9));
        std::size_t n = 2;
        while (watcher.pictures(n).back() != last && n < 20 && !HasFailure()) ++n;
        EXPECT_EQ(drawn(), before + 2) << "of the view, and of the request";
    }
}

// A frame that is being drawn for the server itself ends before its next pass when it is cancelled.
TEST(Live, ACancelledRefinementEndsBeforeItsNextPass) {
    DrawingGate gate;
    Config config = testConfig();
    config.renderer.beforeDrawing = gate.whenPlanned();
    TestServer server(config);
    server.awaitReady();
    const std::uint64_t before = server.framesDrawn();
    FrameOrder order{.arrived = Clock::now(),
                     .cancellation = std::make_shared<CancellationToken>()};
    order.request.scene = "six-walls";
    gate.close();
    auto answer = std::async(std::launch::async, [&] { return server.backend().draw(order); });
    gate.awaitFrame();
    order.cancellation->cancel();
    gate.open();
    try {
        answer.get();
        ADD_FAILURE() << "it was drawn";
    } catch (const RequestError& error) {
        EXPECT_EQ(error.problem().code, ProblemCode::clientLeft);
    }
    EXPECT_EQ(server.framesDrawn(), before);
}

TEST(Live, InvalidViewsAreRejected) {
    auto client = sharedServer().client();
    problemOf(client.Get("/v1/stream?view=unknown"), 404);
    problemOf(client.Get("/v1/views/unknown"), 404);
    EXPECT_EQ(problemOf(client.Get("/v1/stream?fps=0"), 422)["errors"][0]["pointer"], "/fps");
    EXPECT_EQ(problemOf(client.Get("/v1/stream?play=2"), 422)["errors"][0]["pointer"], "/play");
    EXPECT_EQ(problemOf(client.Get("/v1/stream?view=a&width=3"), 422)["errors"][0]["pointer"],
              "/view");
    EXPECT_EQ(problemOf(client.Get("/v1/stream?output.format=png"), 422)["errors"][0]["pointer"],
              "/output");
    EXPECT_EQ(problemOf(client.Get("/v1/stream?camera=unknown"), 422)["errors"][0]["pointer"],
              "/camera/name");
    const auto refused = client.Put("/v1/views/a%20b", "{}", "application/json");
    EXPECT_EQ(problemOf(refused, 422)["errors"][0]["pointer"], "/name");
    EXPECT_EQ(put(client, "x", R"({"widht": 3})"), 422);
}

TEST(Live, AViewThatCannotBeDrawnKeepsTheStreamOpen) {
    TestServer server;
    auto client = server.client();
    ASSERT_EQ(put(client, "v", viewFrom(0)), 204);
    StreamViewer watcher(server, "/v1/stream?view=v&fps=60");
    const auto first = watcher.pictures(1);
    ASSERT_EQ(put(client, "v", smallFrame(R"("camera": {"name": "unknown"})")), 204);
    std::this_thread::sleep_for(300ms);
    ASSERT_EQ(put(client, "v", viewFrom(0.25)), 204);
    const std::string last = frameOf(client, viewFrom(0.25));
    bool seen = false;
    for (std::size_t n = 2; n < 12 && !seen; ++n) seen = watcher.pictures(n).back() == last;
    EXPECT_TRUE(seen);
}

// A client that names ever more views loses its own oldest ones, never those of others.
TEST(LiveViews, AClientLosesItsOwnOldestView) {
    Holdings holdings({{Pool::views, {.most = 8}}});
    LiveViews views(holdings);
    const auto first = views.make("moderate", "a");
    for (int i = 0; i < 64; ++i) views.make("x" + std::to_string(i), "b");
    EXPECT_EQ(views.find("moderate"), first);
    EXPECT_EQ(holdings.of(Pool::views, "b"), 4u) << "not more than are free";
    EXPECT_EQ(views.find("x59"), nullptr);
    EXPECT_NE(views.find("x60"), nullptr);
    // A view that is changed is not the oldest one any more.
    views.make("x60", "b");
    views.make("x64", "b");
    EXPECT_NE(views.find("x60"), nullptr);
    EXPECT_EQ(views.find("x61"), nullptr);
    for (const char* client : {"c", "d", "e"}) EXPECT_NE(views.make(client, client), nullptr);
    EXPECT_EQ(views.find("moderate"), first);
}

TEST(Live, StreamsAreBoundedAndEndWithTheServer) {
    Config config = testConfig();
    // Stopping waits for none of these.
    config.http.limits.write = config.http.limits.idle = 1h;
    config.queueSeconds = config.deadlineSeconds = 3600.0;
    auto server = std::make_unique<TestServer>(config);
    std::vector<std::unique_ptr<StreamViewer>> watchers;
    for (int i = 0; i < 16; ++i) {
        watchers.push_back(
            std::make_unique<StreamViewer>(*server, "/v1/stream?width=32&height=24"));
    }
    for (auto& watcher : watchers) watcher->pictures(1);
    auto client = server->client();
    const auto refused = client.Get("/v1/stream?width=32&height=24");
    EXPECT_EQ(problemOf(refused, 503)["title"], "Too many streams");
    EXPECT_EQ(postJson(client, "/v1/frames", smallFrame())->status, 200);
    server->stop();
}

}  // namespace
}  // namespace clerestory::test
