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

std::string percentEncoded(const std::string& text) {
    std::string out;
    for (const unsigned char c : text) {
        char code[4];
        std::snprintf(code, sizeof code, "%%%02X", c);
        out += code;
    }
    return out;
}

TEST(Compose, LinksHaveListsAsJson) {
    auto client = sharedServer().client();
    const auto linked = [&](const std::string& scene, const std::string& name = "",
                            const std::string& list = "") {
        return client.Get(
            "/v1/frames?width=96&height=64&accuracy=draft&shadows=1&indirectLight=0"
            "&format=png&scene=" +
            percentEncoded(scene) + (name.empty() ? "" : "&" + name + "=" + percentEncoded(list)));
    };
    const json nodes = {{{"node", "teapot copper"}, {"hidden", true}}};
    const auto hidden = linked("teapots", "nodes", nodes.dump());
    ASSERT_TRUE(hidden);
    EXPECT_EQ(hidden->body, bytesOf(teapots({{"nodes", nodes}})));
    const json glow = {{{"type", "glow"}}};
    EXPECT_EQ(linked("teapots", "filters", glow.dump())->body,
              bytesOf(teapots({{"filters", glow}})));
    const json pair = {{{"scene", "teapots"}},
                       {{"scene", "teapots"}, {"name", "other"}, {"translation", {0, 1, 0}}}};
    EXPECT_EQ(linked(pair.dump())->body, bytesOf(teapots({{"scene", pair}})));

    struct Wrong {
        const char *name, *list, *pointer;
    };
    for (const auto& [name, list, pointer] :
         {Wrong{"nodes", "hidden", "/nodes"}, Wrong{"nodes", "[{", "/nodes"},
          Wrong{"nodes", R"([{"node": 1}])", "/nodes/0/node"},
          Wrong{"nodes", R"([{"node": "a", "node": "b"}])", "/nodes"},
          Wrong{"lights", "7", "/lights"}}) {
        const auto wrong = linked("teapots", name, list);
        EXPECT_EQ(problemOf(wrong, 422)["errors"][0]["pointer"], pointer) << list;
    }
    problemOf(linked("[{"), 404);  // the id of a scene
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

std::vector<std::string> pointersOf(const json& problem) {
    std::vector<std::string> pointers;
    for (const json& e : problem["errors"]) pointers.push_back(e["pointer"]);
    return pointers;
}

TEST(Compose, PatternsSelectNodes) {
    const json hidden = {{"nodes", {{{"node", "teapot *"}, {"hidden", true}}}}};
    const json plan = json::parse(post(teapots(hidden), "/v1/plans")->body);
    EXPECT_THAT(plan["composition"][0].get<std::string>(), HasSubstr("nodes): hidden"));
    EXPECT_NE(bytesOf(teapots(hidden)), bytesOf(teapots()));
    const json none =
        problemOf(post(teapots({{"nodes", {{{"node", "kettle *"}, {"hidden", true}}}}})), 422);
    EXPECT_EQ(none["errors"][0]["pointer"], "/nodes/0/node");
    EXPECT_THAT(none["errors"][0]["detail"].get<std::string>(), HasSubstr("kettle *"));
}

TEST(Compose, AGroundIsASurfaceOrCatchesShadows) {
    const json ground = {{"ground", {{"roughness", 0.2}}}};
    const json plan = json::parse(post(teapots(ground), "/v1/plans")->body);
    EXPECT_EQ(plan["composition"], json({"ground: added, at the lowest point of the scene"}));
    EXPECT_NE(bytesOf(teapots(ground)), bytesOf(teapots()));

    json catcher = teapots(ground);
    catcher["background"] = "transparent";
    catcher["nodes"] = {{{"node", "table"}, {"hidden", true}}};
    const auto before = alphas(decodePng(bytesOf(catcher)));
    catcher.erase("ground");
    const auto without = alphas(decodePng(bytesOf(catcher)));
    int soft = 0, softWithout = 0;
    for (int a = 10; a < 245; ++a) {
        soft += before[a];
        softWithout += without[a];
    }
    EXPECT_GT(soft, softWithout + 300) << "shadows and reflections on the catcher";

    auto client = sharedServer().client();
    const auto link = client.Get(
        "/v1/frames?scene=teapots&width=96&height=64&accuracy=draft&shadows=1&indirectLight=0"
        "&format=png&ground.roughness=0.2");
    ASSERT_TRUE(link);
    EXPECT_EQ(link->body, bytesOf(teapots(ground)));
    const json wrong = teapots({{"ground", {{"roughness", 2}, {"reflectance", 1}, {"hight", 0}}}});
    EXPECT_THAT(
        pointersOf(problemOf(post(wrong), 422)),
        testing::UnorderedElementsAre("/ground/roughness", "/ground/reflectance", "/ground/hight"));
}

TEST(Compose, ScenesInAListAreOneScene) {
    const json list = {{{"scene", "teapots"}},
                       {{"scene", "orbiting-cubes"}, {"name", "box"}, {"translation", {2, 0, 0}}}};
    json body = teapots({{"scene", list}});
    const std::string both = bytesOf(body);
    EXPECT_EQ(bytesOf(body), both);
    const std::string tag = post(body)->get_header_value("ETag");
    EXPECT_NE(tag, post(teapots())->get_header_value("ETag"));
    EXPECT_FALSE(post(body)->has_header("Age")) << "the frame cache has entries of one scene";
    const json plan = json::parse(post(body, "/v1/plans")->body);
    EXPECT_EQ(plan["composition"],
              json({"scene teapots: not transformed", "scene orbiting-cubes as box: transformed"}));

    body["nodes"] = {{{"node", "box"}, {"hidden", true}}};
    body["camera"] = {{"position", {0, 2, 6}}, {"target", {0, 0.5, 0}}};
    body["output"] = {{"format", "npy"}, {"channel", "objectId"}};
    const json alone = teapots({{"camera", body["camera"]}, {"output", body["output"]}});
    EXPECT_EQ(bytesOf(body), bytesOf(alone)) << "a hidden part is not there";

    const json sequence = {{"common", teapots({{"scene", list}, {"output", {{"format", "png"}}}})},
                           {"frames", {json::object(), {{"exposure", 1}}}}};
    auto client = sharedServer().client();
    const auto tar = postJson(client, "/v1/sequences", sequence.dump());
    ASSERT_TRUE(tar);
    EXPECT_EQ(tar->status, 200);
    EXPECT_THAT(tar->body, HasSubstr(both)) << "the file of a sequence is that of one request";
}

TEST(Compose, ListsOfScenesNameEveryWrongField) {
    const json flat = {1, 0, 0, 0, 2, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    EXPECT_THAT(pointersOf(problemOf(post(teapots({{"scene",
                                                    {{{"scene", "teapots"}, {"scale", {1, 0, 1}}},
                                                     {{"scene", "teapots"}, {"matrix", flat}},
                                                     {{"scene", "teapots"}, {"name", ""}}}}})),
                                     422)),
                testing::ElementsAre("/scene/0/scale", "/scene/1/matrix", "/scene/2/name"));
    const json unknown = problemOf(
        post(teapots(
            {{"scene", {{{"scene", "teapots"}}, {{"scene", "teapot"}}, {{"scene", "kettles"}}}}})),
        422);
    EXPECT_THAT(pointersOf(unknown), testing::ElementsAre("/scene/1/scene", "/scene/2/scene"));
    EXPECT_THAT(unknown["errors"][0]["detail"].get<std::string>(), HasSubstr("teapots"));
    json many = json::array();
    for (int i = 0; i < 17; ++i) many.push_back({{"scene", "orbiting-cubes"}});
    for (const json& scene : {many, json::array(), json(3), json::object()}) {
        EXPECT_EQ(problemOf(post(teapots({{"scene", scene}})), 422)["errors"][0]["pointer"],
                  "/scene");
    }
    json compared = teapots({{"scene", {{{"scene", "teapots"}}, {{"scene", "kettles"}}}}});
    EXPECT_EQ(problemOf(post(compared, "/v1/comparisons"), 422)["errors"][0]["pointer"],
              "/scene/1/scene");
}

}  // namespace
}  // namespace clerestory::test
