// Lenses over HTTP: in bodies, links, plans, sequences, and what is wrong with them.
#include "tests/support/test_server.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace clerestory::test {
namespace {

using nlohmann::json;
using testing::HasSubstr;

json frameWith(const json& camera) {
    json body = json::parse(smallFrame(R"("output": {"format": "png"})"));
    body["camera"] = camera;
    return body;
}

std::string picture(const json& camera) {
    auto client = sharedServer().client();
    const auto result = postJson(client, "/v1/frames", frameWith(camera).dump());
    if (!result || result->status != 200) {
        ADD_FAILURE() << (result ? result->body : "no answer");
        return {};
    }
    return result->body;
}

json errorsOf(const json& camera, int status = 422) {
    auto client = sharedServer().client();
    return problemOf(postJson(client, "/v1/frames", frameWith(camera).dump()), status)["errors"];
}

const json kPose = {{"position", {0.4, 0.3, 1.2}}, {"target", {0, 0, 0}}};
json lensed(const json& lens, json more = json::object()) {
    json camera = kPose;
    camera["lens"] = lens;
    camera.update(more);
    return camera;
}

json planOf(const json& camera) {
    auto client = sharedServer().client();
    const auto result = postJson(client, "/v1/plans", frameWith(camera).dump());
    EXPECT_EQ(result->status, 200) << result->body;
    return json::parse(result->body);
}

int rootViews(const json& plan) {
    int count = 0;
    for (const json& pass : plan["passes"]) count += pass["kind"] == "surface";
    return count;
}

TEST(Lenses, EveryTypeIsDrawn) {
    std::vector<std::string> pictures = {picture(kPose)};
    for (const json& lens :
         {json{{"type", "perspective"}, {"k1", -0.1}},
          json{{"type", "orthographic"}, {"height", 3}}, json{{"type", "equirectangular"}},
          json{{"type", "cube"}, {"layout", "cross"}},
          json{{"type", "fisheye"}, {"fov", 3.3}, {"k1", 0.02}}}) {
        pictures.push_back(picture(lensed(lens)));
        for (std::size_t i = 0; i + 1 < pictures.size(); ++i) {
            EXPECT_NE(pictures[i], pictures.back()) << lens;
        }
    }
}

TEST(Lenses, WithoutDistortionTheBytesAreTheSame) {
    EXPECT_EQ(picture(lensed({{"type", "perspective"}})), picture(kPose));
    EXPECT_EQ(picture(lensed({{"type", "perspective"}, {"k1", 0.0}, {"p2", 0}})), picture(kPose));
    json parallel = kPose;
    parallel["orthographicHeight"] = 2.5;
    EXPECT_EQ(picture(lensed({{"type", "orthographic"}, {"height", 2.5}})), picture(parallel));
}

TEST(Lenses, LinksNameThemByDots) {
    auto client = sharedServer().client();
    const std::string pose =
        "/v1/frames?scene=six-walls&width=64&height=48&eye=0.4,0.3,1.2&target=0,0,0"
        "&indirectLight=0";
    const auto get = [&](const std::string& query) { return client.Get(pose + query); };
    const auto full = get("&camera.lens.type=fisheye&camera.lens.fov=2.5&camera.lens.k1=0.01");
    ASSERT_EQ(full->status, 200) << full->body;
    EXPECT_EQ(get("&lens.type=fisheye&lens.fov=2.5&lens.k1=0.01")->body, full->body);
    EXPECT_EQ(get("&lens.type=cube&lens.layout=row")->status, 200);
    EXPECT_EQ(get("&lens.type=equirectangular&yfov=1")->status, 422) << "yfov is the camera's";
    EXPECT_EQ(problemOf(get("&lens.type=square"), 422)["errors"][0]["pointer"],
              "/camera/lens/type");
    EXPECT_EQ(problemOf(get("&lens.k1=0.1"), 422)["errors"][0]["pointer"], "/camera/lens/type");
    EXPECT_EQ(problemOf(get("&lens.type=cube&lens.k1=0.1"), 422)["errors"][0]["pointer"],
              "/camera/lens/k1");
}

TEST(Lenses, ErrorsNameTheFieldAndTheRadius) {
    EXPECT_EQ(errorsOf(lensed("fisheye"))[0]["pointer"], "/camera/lens");
    EXPECT_EQ(errorsOf(lensed({{"k1", 1}}))[0]["pointer"], "/camera/lens/type");
    EXPECT_THAT(errorsOf(lensed({{"type", "fisheyes"}}))[0]["detail"].get<std::string>(),
                HasSubstr("fisheye"));
    EXPECT_EQ(errorsOf(lensed({{"type", "orthographic"}}))[0]["pointer"], "/camera/lens/height");
    EXPECT_EQ(errorsOf(lensed({{"type", "fisheye"}, {"fov", 7}}))[0]["pointer"],
              "/camera/lens/fov");
    EXPECT_EQ(errorsOf(lensed({{"type", "fisheye"}, {"k1", 1e7}}))[0]["pointer"],
              "/camera/lens/k1");
    EXPECT_EQ(errorsOf(lensed({{"type", "equirectangular"}, {"latitude", 4}}))[0]["pointer"],
              "/camera/lens/latitude");
    EXPECT_EQ(errorsOf(lensed({{"type", "cube"}}, {{"yfov", 1}}))[0]["pointer"], "/camera/yfov");
    const json intrinsics = {{"fx", 32}, {"fy", 32}, {"cx", 32}, {"cy", 24}};
    EXPECT_EQ(errorsOf(lensed({{"type", "cube"}}, {{"intrinsics", intrinsics}}))[0]["pointer"],
              "/camera/intrinsics");
    const json fold =
        errorsOf(lensed({{"type", "perspective"}, {"k1", -1.0 / 3}}, {{"intrinsics", intrinsics}}));
    EXPECT_EQ(fold[0]["pointer"], "/camera/lens/k1");
    EXPECT_THAT(fold[0]["detail"].get<std::string>(),
                HasSubstr("up to a radius of 21.3333 pixels"));
    EXPECT_THAT(fold[0]["detail"].get<std::string>(), HasSubstr("the frame reaches 40"));
    const json fitted = {{"fit", json::object()}, {"lens", {{"type", "fisheye"}}}};
    EXPECT_EQ(errorsOf(fitted)[0]["pointer"], "/camera/fit");
}

TEST(Lenses, PlansReportTheCameraAndTheViews) {
    const json plan = planOf(lensed({{"type", "fisheye"}, {"k2", 0.01}}));
    const json camera = plan["camera"];
    EXPECT_EQ(camera["lens"]["type"], "fisheye");
    EXPECT_EQ(camera["lens"]["k2"], 0.01);
    EXPECT_NEAR(camera["lens"]["fov"].get<double>(), 3.141592653589793, 1e-12);
    EXPECT_EQ(camera["intrinsics"]["cx"], 32.0);
    EXPECT_FALSE(camera.contains("clipFromView"));
    EXPECT_EQ(rootViews(plan), 5);
    const json direct = planOf(kPose);
    EXPECT_EQ(direct["camera"]["lens"]["type"], "perspective");
    EXPECT_TRUE(direct["camera"].contains("clipFromView"));
    EXPECT_EQ(rootViews(direct), 1);
    const json parallel = planOf(lensed({{"type", "orthographic"}, {"height", 3}}));
    EXPECT_EQ(parallel["camera"]["lens"], (json{{"type", "orthographic"}, {"height", 3.0}}));
}

// The reported camera, sent back, is the same camera.
TEST(Lenses, TheReportedCameraGivesTheSameFrame) {
    for (const json& lens :
         {json{{"type", "perspective"}, {"k1", -0.1}, {"p1", 0.002}}, json{{"type", "fisheye"}},
          json{{"type", "equirectangular"}, {"longitude", 5}}, json{{"type", "cube"}}}) {
        const json asked = lensed(lens);
        const json camera = planOf(asked)["camera"];
        json again = {{"cameraToWorld", camera["cameraToWorld"]}, {"lens", camera["lens"]}};
        if (camera.contains("intrinsics")) again["intrinsics"] = camera["intrinsics"];
        EXPECT_EQ(picture(again), picture(asked)) << lens;
    }
}

TEST(Lenses, ExplainedFramesListTheViewsOfTheLens) {
    auto client = sharedServer().client();
    const auto result = postJson(client, "/v1/frames?explain=1",
                                 frameWith(lensed({{"type", "equirectangular"}})).dump());
    ASSERT_EQ(result->status, 200) << result->body;
    const auto parts = partsOf(*result);
    ASSERT_FALSE(parts.empty());
    json plan;
    for (const auto& [type, content] : parts) {
        if (type.find("json") != std::string::npos) plan = json::parse(content);
    }
    int views = 0, lenses = 0;
    const json& passes = plan.contains("plan") ? plan["plan"]["passes"] : plan["passes"];
    for (const json& pass : passes) {
        views += pass["kind"] == "surface";
        lenses += pass["kind"] == "lens";
    }
    EXPECT_EQ(views, 6);
    EXPECT_EQ(lenses, 1);
}

}  // namespace
}  // namespace clerestory::test
