// Backgrounds, nodes and lights of a request over HTTP.
#include "tests/support/test_server.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace clerestory::test {
namespace {

using nlohmann::json;
using testing::HasSubstr;

json teapots(const json& more = json::object()) {
    json body = {{"scene", "teapots"},
                 {"width", 96},
                 {"height", 64},
                 {"accuracy", "draft"},
                 {"effects", {{"shadows", true}, {"indirectLight", false}}},
                 {"output", {{"format", "png"}}}};
    body.update(more);
    return body;
}

httplib::Result post(const json& body, const char* path = "/v1/frames") {
    auto client = sharedServer().client();
    auto result = postJson(client, path, body.dump());
    // The scene may be loading; each answer waits for it for a while.
    for (int i = 0; i < 60 && result && result->status == 409; ++i) {
        result = postJson(client, path, body.dump());
    }
    return result;
}

std::string bytesOf(const json& body) {
    const auto result = post(body);
    if (!result || result->status != 200) {
        ADD_FAILURE() << (result ? result->body : "no answer");
        return {};
    }
    return result->body;
}

std::array<int, 256> alphas(const Image& image) {
    std::array<int, 256> count{};
    for (std::size_t i = 3; i < image.data.size(); i += 4) ++count[image.bytes()[i]];
    return count;
}

TEST(Compose, ATransparentBackgroundIsAlphaInEveryFormatThatHasIt) {
    const json transparent = {{"background", "transparent"}};
    const Image png = decodePng(bytesOf(teapots(transparent)));
    EXPECT_GT(alphas(png)[0], 500);
    EXPECT_GT(alphas(png)[255], 500);
    EXPECT_EQ(alphas(decodePng(bytesOf(teapots())))[255], 96 * 64);

    json floats = teapots(transparent);
    floats["output"]["format"] = "npy";
    EXPECT_EQ(decodeNpy(bytesOf(floats)).channels, 4u);
    floats["output"]["format"] = "exr";
    EXPECT_THAT(bytesOf(floats).substr(0, 200), HasSubstr(std::string("A\0\2", 3)));
    json webp = teapots(transparent);
    webp["output"]["format"] = "webp";
    EXPECT_THAT(bytesOf(webp).substr(0, 100), HasSubstr("ALPH"));
    webp.erase("background");
    EXPECT_THAT(bytesOf(webp).substr(0, 100), testing::Not(HasSubstr("ALPH")));

    json jpeg = teapots(transparent);
    jpeg["output"]["format"] = "jpeg";
    const json problem = problemOf(post(jpeg), 422);
    EXPECT_EQ(problem["errors"][0]["pointer"], "/output/format");
    EXPECT_EQ(problem["errors"][0]["allowed"], "png, webp, exr or npy");
}

TEST(Compose, LinksNameABackground) {
    auto client = sharedServer().client();
    const std::string link =
        "/v1/frames?scene=teapots&width=96&height=64&accuracy=draft&shadows=1&indirectLight=0"
        "&format=png&background=";
    const auto transparent = client.Get(link + "transparent");
    ASSERT_TRUE(transparent);
    EXPECT_EQ(transparent->body, bytesOf(teapots({{"background", "transparent"}})));
    const auto blue = client.Get(link + "0.1,0.2,0.4");
    ASSERT_TRUE(blue);
    EXPECT_EQ(blue->body, bytesOf(teapots({{"background", {0.1, 0.2, 0.4}}})));
    const auto wrong = client.Get(link + "glass");
    EXPECT_EQ(problemOf(wrong, 422)["errors"][0]["pointer"], "/background");
    const auto negative = client.Get(link + "0,-1,0");
    EXPECT_EQ(problemOf(negative, 422)["errors"][0]["pointer"], "/background/1");
}

TEST(Compose, NodesAndLightsChangeTheFrameAndNotTheScene) {
    const std::string before = bytesOf(teapots());
    const json nodes = {{"nodes",
                         {{{"node", "teapot copper"}, {"hidden", true}},
                          {{"node", "teapot clay"}, {"material", "gold"}}}}};
    const json lights = {{"lights",
                          {{{"light", "lamp"}, {"enabled", false}},
                           {{"type", "spot"},
                            {"position", {0, 4, 0}},
                            {"direction", {0, -1, 0}},
                            {"intensity", 90}}}}};
    const std::string composed = bytesOf(teapots(nodes)), lit = bytesOf(teapots(lights));
    EXPECT_NE(composed, before);
    EXPECT_NE(lit, before);
    EXPECT_EQ(bytesOf(teapots(nodes)), composed);
    EXPECT_EQ(bytesOf(teapots()), before);
    EXPECT_NE(post(teapots(nodes))->get_header_value("ETag"),
              post(teapots())->get_header_value("ETag"));

    const json plan = json::parse(post(teapots(nodes), "/v1/plans")->body);
    EXPECT_EQ(plan["composition"],
              json({"node teapot copper: hidden", "node teapot clay: material gold"}));
    EXPECT_FALSE(json::parse(post(teapots(), "/v1/plans")->body).contains("composition"));
}

TEST(Compose, NamesEveryWrongField) {
    const json flat = {1, 0, 0, 0, 2, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    const json body =
        teapots({{"nodes",
                  {{{"node", "teapot cooper"}, {"hidden", true}},
                   {{"node", "table"}, {"material", "silver"}},
                   {{"node", "table"}, {"matrix", flat}},
                   {{"node", "table"}, {"scale", {1, 0, 1}}}}},
                 {"lights", {{{"light", "lmap"}, {"enabled", false}}, {{"type", "point"}}}}});
    const json problem = problemOf(post(body), 422);
    std::vector<std::string> pointers;
    for (const json& e : problem["errors"]) pointers.push_back(e["pointer"]);
    EXPECT_THAT(pointers, testing::UnorderedElementsAre("/nodes/0/node", "/nodes/1/material",
                                                        "/nodes/2/matrix", "/nodes/3/scale",
                                                        "/lights/0/light", "/lights/1/position"));
    EXPECT_THAT(problem["errors"].dump(), HasSubstr("teapot copper"));

    json many = json::array();
    for (int i = 0; i < 65; ++i) many.push_back({{"node", "table"}, {"hidden", true}});
    EXPECT_EQ(problemOf(post(teapots({{"nodes", many}})), 422)["errors"][0]["pointer"], "/nodes");
    const json missing = problemOf(post(teapots({{"nodes", {{{"hidden", true}}}}})), 422);
    EXPECT_EQ(missing["errors"][0]["pointer"], "/nodes/0/node");
}

}  // namespace
}  // namespace clerestory::test
