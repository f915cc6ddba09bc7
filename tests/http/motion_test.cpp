// Animated scenes over HTTP: animations in a scene's description, time and clip in a request,
// unknown clips.
#include "tests/support/test_server.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace clerestory::test {
namespace {

using nlohmann::json;

httplib::Result frame(httplib::Client& client, json more) {
    json body = {{"scene", "meadow"},
                 {"width", 96},
                 {"height", 54},
                 {"output", {{"format", "png"}}},
                 {"effects", {{"shadows", false}, {"indirectLight", false}}}};
    body.update(more);
    return postUntilReady(client, "/v1/frames", body.dump());
}

TEST(MovingScenes, AreDescribedAndDependOnTimeAndClip) {
    auto client = sharedServer().client();
    client.set_read_timeout(60);
    const auto first = frame(client, {{"time", 0.25}});
    ASSERT_TRUE(first);
    ASSERT_EQ(first->status, 200) << first->body;
    const json scene = json::parse(client.Get("/v1/scenes/meadow")->body);
    ASSERT_EQ(scene["animations"].size(), 4u);
    EXPECT_EQ(scene["animations"][0],
              (json{{"name", "flag"}, {"duration", 2.0}, {"default", true}}));
    std::vector<std::string> names;
    for (const json& clip : scene["animations"]) names.push_back(clip["name"]);
    EXPECT_THAT(names, testing::ElementsAre("flag", "walk", "round", "lanterns"));

    const auto later = frame(client, {{"time", 1.25}});
    EXPECT_NE(first->body, later->body);
    EXPECT_NE(first->get_header_value("ETag"), later->get_header_value("ETag"));
    EXPECT_EQ(frame(client, {{"time", 0.25}})->body, first->body);
    EXPECT_EQ(frame(client, {{"time", 2.25}, {"clip", "flag"}})->body,
              frame(client, {{"time", 0.25}, {"clip", "flag"}})->body)
        << "the clip repeats";
    const auto link =
        client.Get("/v1/frames?scene=meadow&width=96&height=54&format=png&time=0.25" + kPlainLink);
    ASSERT_EQ(link->status, 200);
    EXPECT_EQ(link->body, first->body);
}

TEST(MovingScenes, AnUnknownClipIsRejectedWithTheExistingNames) {
    auto client = sharedServer().client();
    client.set_read_timeout(60);
    for (const char* path : {"/v1/frames", "/v1/plans"}) {
        const auto result = postJson(client, path, R"({"scene": "meadow", "clip": "gallop"})");
        const json problem = problemOf(result, 422);
        ASSERT_FALSE(problem.is_null()) << path;
        ASSERT_EQ(problem["errors"].size(), 1u);
        EXPECT_EQ(problem["errors"][0]["pointer"], "/clip");
        EXPECT_EQ(problem["errors"][0]["allowed"], "one of: flag, walk, round, lanterns");
    }
    const json problem =
        problemOf(postJson(client, "/v1/frames", smallFrame(R"("clip": "x")")), 422);
    EXPECT_EQ(problem["errors"][0]["allowed"], "none: the scene has no animations");
}

}  // namespace
}  // namespace clerestory::test
