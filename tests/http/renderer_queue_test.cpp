// The queue before several renderers: who draws what, and when. The renderers are values here.
#include "server/worker/renderer_queue.h"
#include "server/api/metrics.h"
#include "tests/support/soon.h"

#include <gtest/gtest.h>

#include <future>

namespace clerestory::test {
namespace {

using namespace std::chrono_literals;

RendererState holding(const std::vector<std::pair<std::string, std::uint64_t>>& scenes,
                      std::uint64_t renderer = 7) {
    return {
        .isPresent = true,
        .loaded = std::make_shared<const LoadedScenes>(LoadedScenes{"first", renderer, scenes})};
}

const RendererState kAbsent;
const RendererState kCold{.isPresent = true};

TEST(RendererChoice, AFrameGoesToRenderersThatHoldItsScene) {
    const std::vector<RendererState> both = {holding({{"first", 1}}),
                                             holding({{"first", 1}, {"other", 2}})};
    for (const char* scene : {"", "first"}) {
        EXPECT_TRUE(mayDraw(both, {.scene = scene}, 0));
        EXPECT_TRUE(mayDraw(both, {.scene = scene}, 1));
    }
    EXPECT_FALSE(mayDraw(both, {.scene = "other"}, 0));
    EXPECT_TRUE(mayDraw(both, {.scene = "other"}, 1));
    EXPECT_TRUE(mayDraw(both, {.scene = "unknown"}, 0)) << "the first one loads it";
    EXPECT_FALSE(mayDraw(both, {.scene = "unknown"}, 1));
    EXPECT_TRUE(mayDraw(both, {.scene = "", .onlyFirst = true}, 0));
    EXPECT_FALSE(mayDraw(both, {.scene = "", .onlyFirst = true}, 1));
}

TEST(RendererChoice, TheFirstIsTheFirstThatRuns) {
    EXPECT_EQ(firstRenderer({kAbsent, kCold}), 1u);
    EXPECT_EQ(firstRenderer({kAbsent, kAbsent}), 0u);
    EXPECT_TRUE(mayDraw({kAbsent, kCold}, {}, 1));
    EXPECT_FALSE(mayDraw({kCold, kCold}, {}, 1)) << "not before it is warm";
    EXPECT_TRUE(mayDraw({kAbsent, holding({{"a", 1}})}, {.scene = "a", .onlyFirst = true}, 1));
}

TEST(RendererChoice, ScenesOfAllAreThoseWithEqualContents) {
    EXPECT_EQ(loadedInAll({kAbsent, kCold}), nullptr);
    const RendererState one = holding({{"a", 1}, {"b", 2}});
    EXPECT_EQ(*loadedInAll({one, kCold}), *one.loaded);
    const auto all = loadedInAll({one, holding({{"b", 3}, {"c", 4}}), holding({{"b", 2}})});
    using Scenes = std::vector<std::pair<std::string, std::uint64_t>>;
    EXPECT_EQ(all->scenes, (Scenes{{"a", 1}, {"c", 4}}));
    EXPECT_TRUE(loadedInAll({one, holding({{"a", 1}}, 8)})->scenes.empty())
        << "other programs or drivers";
}

// Two warm renderers with the scene "a"; the second also holds "b".
class TwoRenderers : public testing::Test {
protected:
    std::vector<RendererState> states{holding({{"a", 1}}), holding({{"a", 1}, {"b", 2}})};
    std::mutex mutex;
    RendererQueue queue{{.count = 3, .seconds = 60.0, .servers = 2}, [this] {
                            const std::lock_guard lock(mutex);
                            return states;
                        }};
    static Turn turnOf(const std::string& client, std::chrono::milliseconds patience = 60s) {
        return {.client = client, .patience = patience, .compilePatience = 60s};
    }
    // The renderer's number; the place is left when `released` is set.
    std::future<std::size_t> taken(const std::string& client, const RendererNeed& need,
                                   std::shared_future<void> released) {
        return std::async(std::launch::async, [this, client, need, released] {
            const RendererQueue::Place place = queue.take(turnOf(client), need);
            released.wait();
            return place.renderer();
        });
    }
    std::unique_ptr<RendererQueue::Place> held(const std::string& client, const char* scene = "a") {
        return std::unique_ptr<RendererQueue::Place>(
            new RendererQueue::Place(queue.take(turnOf(client), {.scene = scene})));
    }
    void awaitWaiting(std::size_t count) {
        EXPECT_TRUE(within(kPatience, [&] { return queue.usage().entries.total == count; }));
    }
    template <class Work>
    static ProblemCode codeOf(Work work) {
        try {
            work();
        } catch (const RequestError& error) {
            return error.problem().code;
        }
        ADD_FAILURE() << "nothing was thrown";
        return ProblemCode::internalError;
    }
};

TEST_F(TwoRenderers, BothDrawAtOnceAndTheNextWaits) {
    EXPECT_EQ(queue.take(turnOf("x"), {.scene = "a"}).renderer(), 0u) << "and left again";
    const RendererQueue::Place first = queue.take(turnOf("x"), {.scene = "a"});
    const RendererQueue::Place second = queue.take(turnOf("x"), {.scene = "a"});
    EXPECT_EQ(first.renderer(), 0u);
    EXPECT_EQ(second.renderer(), 1u);
    EXPECT_EQ(codeOf([&] { queue.take(turnOf("x", 20ms), {.scene = "a"}); }),
              ProblemCode::overDeadline);
    EXPECT_EQ(queue.usage().entries.total, 0u);
}

TEST_F(TwoRenderers, AnEntryThatMustWaitForOneDoesNotHoldUpTheOther) {
    std::promise<void> release;
    release.set_value();
    const auto released = release.get_future().share();
    auto drawsB = held("x", "b");
    EXPECT_EQ(drawsB->renderer(), 1u);
    auto waitsForB = taken("y", {.scene = "b"}, released);
    awaitWaiting(1);
    EXPECT_EQ(taken("z", {.scene = "a"}, released).get(), 0u) << "the free renderer";
    EXPECT_EQ(queue.usage().entries.total, 1u);
    drawsB.reset();
    EXPECT_EQ(waitsForB.get(), 1u);
}

TEST_F(TwoRenderers, ASceneThatIsLoadedLaterIsNoticed) {
    const RendererQueue::Place second = queue.take(turnOf("x"), {.scene = "b"});
    EXPECT_EQ(second.renderer(), 1u);
    std::promise<void> release;
    release.set_value();
    auto waits = taken("y", {.scene = "b"}, release.get_future().share());
    awaitWaiting(1);
    {
        const std::lock_guard lock(mutex);
        states[0] = states[1];
    }
    EXPECT_EQ(waits.get(), 0u);
}

TEST_F(TwoRenderers, FullQueuesRefuseAndHeavyClientsMakeRoom) {
    std::promise<void> release;
    const auto released = release.get_future().share();
    auto first = held("x");
    auto second = held("x");
    std::vector<std::future<std::size_t>> waiting;
    for (std::size_t i = 0; i < 3; ++i) {
        waiting.push_back(taken("heavy", {.scene = "a"}, released));
        awaitWaiting(i + 1);
    }
    EXPECT_EQ(queue.refusalFor("heavy")->code, ProblemCode::queueFull);
    EXPECT_FALSE(queue.refusalFor("light"));
    EXPECT_EQ(codeOf([&] { queue.take(turnOf("heavy"), {.scene = "a"}); }), ProblemCode::queueFull);
    auto light = taken("light", {.scene = "a"}, released);
    EXPECT_EQ(codeOf([&] { waiting[2].get(); }), ProblemCode::queueFull) << "it lost its place";
    release.set_value();
    first.reset();
    second.reset();
    light.get();
    waiting[0].get();
    waiting[1].get();
    EXPECT_TRUE(queue.hasRoom());
}

TEST_F(TwoRenderers, ClientsThatLeaveLoseTheirPlace) {
    const RendererQueue::Place first = queue.take(turnOf("x"), {.scene = "a"});
    const RendererQueue::Place second = queue.take(turnOf("x"), {.scene = "a"});
    Turn turn = turnOf("y");
    turn.cancellation = std::make_shared<CancellationToken>();
    auto left = std::async(std::launch::async,
                           [&] { return codeOf([&] { queue.take(turn, {.scene = "a"}); }); });
    awaitWaiting(1);
    turn.cancellation->cancel();
    EXPECT_EQ(left.get(), ProblemCode::clientLeft);
    EXPECT_EQ(queue.usage().entries.total, 0u);
}

TEST_F(TwoRenderers, DeadlinesStandStillWhileShadersAreCompiled) {
    const RendererQueue::Place second = queue.take(turnOf("x"), {.scene = "b"});
    const auto setCompiling = [&](bool compiling) {
        const std::lock_guard lock(mutex);
        states[1].isCompiling = compiling;
    };
    setCompiling(true);
    auto waits = std::async(std::launch::async, [&] {
        return codeOf([&] { queue.take(turnOf("y", 100ms), {.scene = "b"}); });
    });
    EXPECT_EQ(waits.wait_for(500ms), std::future_status::timeout) << "longer than its patience";
    setCompiling(false);
    EXPECT_EQ(waits.get(), ProblemCode::overDeadline);
}

TEST_F(TwoRenderers, RefuseNewWaitsForTheAcceptedOnes) {
    auto first = held("x");
    auto stopped = std::async(std::launch::async, [&] { queue.refuseNew(); });
    EXPECT_TRUE(within(kPatience, [&] { return queue.refusalFor("y").has_value(); }));
    EXPECT_EQ(codeOf([&] { queue.take(turnOf("y"), {.scene = "a"}); }), ProblemCode::shuttingDown);
    EXPECT_EQ(stopped.wait_for(20ms), std::future_status::timeout);
    first.reset();
    stopped.get();
}

TEST(JoinedMetrics, EachSampleNamesItsRendererAndEachFamilyAppearsOnce) {
    const std::string text =
        "# HELP b Bytes of all\n# TYPE b gauge\nb 1\n"
        "# HELP t Times\n# TYPE t histogram\nt_bucket{le=\"1\"} 2\nt_sum 3\n";
    EXPECT_EQ(joinedMetrics({{1, text}, {2, text}}),
              "# HELP b Bytes of all\n# TYPE b gauge\n"
              "b{renderer=\"1\"} 1\nb{renderer=\"2\"} 1\n"
              "# HELP t Times\n# TYPE t histogram\n"
              "t_bucket{renderer=\"1\",le=\"1\"} 2\nt_sum{renderer=\"1\"} 3\n"
              "t_bucket{renderer=\"2\",le=\"1\"} 2\nt_sum{renderer=\"2\"} 3\n");
    EXPECT_EQ(joinedMetrics({}), "");
}

}  // namespace
}  // namespace clerestory::test
