// Sequences as films: the pictures of single responses, in one file.
#include "measures/errors.h"
#include "tests/support/decoded_film.h"
#include "tests/support/test_server.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <thread>

namespace clerestory::test {
namespace {

using nlohmann::json;

// Without light between surfaces, which is computed meanwhile.
const json kCommon = {
    {"scene", "six-walls"}, {"width", 96}, {"height", 64}, {"effects", {{"indirectLight", false}}}};

json turntable(const json& more = json::object()) {
    json body = {{"common", kCommon}, {"turntable", {{"seconds", 1}, {"frameRate", 6}}}};
    body.merge_patch(more);
    return body;
}

json listed(int frames, const json& more = json::object()) {
    json body = {{"common", kCommon}, {"frameRate", 5}, {"frames", json::array()}};
    for (int i = 0; i < frames; ++i) {
        body["frames"].push_back(
            {{"camera", {{"position", {0.1 * i, 1.0, 2.0}}, {"target", {0, 1, 0}}}}});
    }
    body.merge_patch(more);
    return body;
}

httplib::Result film(httplib::Client& client, const json& body, const char* type) {
    return client.Post("/v1/sequences", {{"Accept", type}}, body.dump(), "application/json");
}

TEST(Films, Mp4HasThePicturesOfSingleResponses) {
    auto client = sharedServer().client();
    const json body = listed(7);
    const auto result = film(client, body, "video/mp4");
    ASSERT_EQ(result->status, 200) << result->body;
    EXPECT_EQ(result->get_header_value("Content-Type"), "video/mp4");
    const DecodedFilm decoded = decodedMp4(result->body);
    ASSERT_EQ(decoded.pictures.size(), 7u);
    EXPECT_NEAR(decoded.frameRate, 5.0, 1e-9);
    EXPECT_NEAR(decoded.seconds, 1.4, 1e-3);
    EXPECT_TRUE(decoded.isTagged709);
    for (std::size_t i = 0; i < 7; ++i) {
        json single = body["common"];
        single.update(body["frames"][i]);
        single["output"] = {{"format", "png"}};
        const Image picture = decodePng(postJson(client, "/v1/frames", single.dump())->body);
        ASSERT_EQ(decoded.pictures[i].width, 96u);
        ASSERT_EQ(decoded.pictures[i].height, 64u);
        // As good as the default JPEG, which has colour of half resolution too. The edges of these
        // walls of pure colours are the worst case for both: 28 and 26 to 28 decibels.
        single["output"] = {{"format", "jpeg"}};
        const Image jpeg = decodeJpeg(postJson(client, "/v1/frames", single.dump())->body);
        EXPECT_GT(psnr(decoded.pictures[i], picture),
                  psnr(decodePng(encodePng(jpeg)), picture) - 0.5)
            << i;
    }
}

TEST(Films, OfATurntableAndSlicesHaveTheirFrameRate) {
    auto client = sharedServer().client();
    EXPECT_EQ(decodedMp4(film(client, turntable(), "video/mp4")->body).pictures.size(), 6u);
    const auto slice =
        film(client, turntable({{"first", 2}, {"count", 3}, {"plans", true}}), "image/webp");
    ASSERT_EQ(slice->status, 200) << slice->body;
    EXPECT_EQ(slice->get_header_value("Content-Type"), "image/webp");
    const DecodedFilm decoded = decodedWebp(slice->body);
    EXPECT_EQ(decoded.pictures.size(), 3u);
    EXPECT_NEAR(decoded.seconds, 0.5, 1e-9);
}

// Each picture of an animated WebP is the answer to a single request, byte for byte.
TEST(Films, WebpConsistsOfSingleResponses) {
    auto client = sharedServer().client();
    const json body = listed(3, {{"common", {{"width", 95}, {"output", {{"quality", 70}}}}}});
    const std::string whole = film(client, body, "image/webp")->body;
    EXPECT_EQ(decodedWebp(whole).pictures.size(), 3u);
    for (std::size_t i = 0; i < 3; ++i) {
        json single = body["common"];
        single.update(body["frames"][i]);
        single["output"]["format"] = "webp";
        const std::string picture = postJson(client, "/v1/frames", single.dump())->body;
        ASSERT_GT(picture.size(), 100u);
        // Without the head of its file, "RIFF", size and "WEBP".
        EXPECT_NE(whole.find(picture.substr(12)), std::string::npos) << i;
    }
}

TEST(Films, AreTheSameBytesEachTime) {
    auto client = sharedServer().client();
    for (const char* type : {"video/mp4", "image/webp"}) {
        const auto once = film(client, turntable(), type), again = film(client, turntable(), type);
        ASSERT_EQ(once->status, 200);
        EXPECT_GT(once->body.size(), 500u);
        EXPECT_EQ(once->body, again->body) << type;
    }
}

TEST(Films, EveryInvalidFieldIsNamed) {
    auto client = sharedServer().client();
    const auto pointers = [&](const json& body, const char* type = "video/mp4") {
        const json problem = problemOf(film(client, body, type), 422);
        std::vector<std::string> list;
        for (const json& error : problem["errors"]) list.push_back(error["pointer"]);
        return list;
    };
    using testing::ElementsAre;
    EXPECT_THAT(pointers(listed(2, {{"frameRate", nullptr}})), ElementsAre("/frameRate"));
    EXPECT_THAT(pointers(turntable({{"frameRate", 3}})), ElementsAre("/frameRate"));
    EXPECT_THAT(pointers(listed(2, {{"channels", {{"depth", true}, {"normal", true}}}})),
                ElementsAre("/channels/depth", "/channels/normal"));
    EXPECT_THAT(pointers(listed(2, {{"channels", {{"color", false}, {"through", true}}}})),
                ElementsAre("/channels/color", "/channels/through"));
    EXPECT_THAT(pointers(turntable({{"common", {{"width", 97}, {"height", 63}}}})),
                ElementsAre("/common/width", "/common/height"));
    json sizes = listed(3);
    sizes["frames"][1]["width"] = 64;
    sizes["frames"][2]["output"] = {{"quality", 20}};
    EXPECT_THAT(pointers(sizes), ElementsAre("/frames/1/width", "/frames/2/output"));
    EXPECT_THAT(
        pointers(listed(3000, {{"common", {{"width", 640}, {"height", 480}}}}), "image/webp"),
        ElementsAre("/count"));
}

// A film has no place for an error: the answer ends early, and the client's HTTP library says so.
TEST(Films, AFrameThatCannotBeDrawnTruncatesTheAnswer) {
    auto client = sharedServer().client();
    json body = listed(3);
    body["frames"][1] = {{"camera", {{"name", "unknown"}}}};
    for (const char* type : {"video/mp4", "image/webp"}) {
        EXPECT_FALSE(film(client, body, type)) << type;
    }
    // Of the first frame it still has a status.
    body["frames"][0] = body["frames"][1];
    EXPECT_EQ(film(client, body, "video/mp4")->status, 422);
    EXPECT_EQ(film(client, listed(1), "video/mp4")->status, 200) << "the server works on";
}

// An animated WebP is sent at the end: the client leaves while there is nothing to send.
TEST(Films, EndWhenTheClientDisconnects) {
    TestServer server;
    server.awaitReady();
    const auto drawn = [&] {
        return server.backend().queue().run(std::chrono::seconds(10), [](Renderer& renderer) {
            return renderer.counters().frames;
        });
    };
    const std::uint64_t start = drawn();
    {
        auto client = server.client();
        client.set_read_timeout(std::chrono::milliseconds(500));
        const json body = listed(600, {{"common", {{"width", 640}, {"height", 480}}}});
        EXPECT_FALSE(film(client, body, "image/webp")) << "it leaves";
    }
    std::uint64_t before = drawn(), now = 0;
    for (int i = 0; i < 100; ++i) {
        std::this_thread::sleep_for(std::chrono::milliseconds(300));
        now = drawn();
        if (now == before) break;
        before = now;
    }
    EXPECT_EQ(now, before) << "the renderer becomes idle";
    EXPECT_LT(now - start, 600u);
}

}  // namespace
}  // namespace clerestory::test
