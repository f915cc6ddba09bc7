// Frames over HTTP: images, data channels, headers.
#include "server/api/compact_passes.h"
#include "tests/support/test_server.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <set>

namespace clerestory::test {
namespace {

using nlohmann::json;
using testing::HasSubstr;

std::string frameBytes(const std::string& body) {
    auto client = sharedServer().client();
    const auto result = postJson(client, "/v1/frames", body);
    if (!result || result->status != 200) {
        ADD_FAILURE() << (result ? result->body : "no answer");
        return {};
    }
    return result->body;
}

std::string withCamera(const std::string& camera) {
    return smallFrame(R"("output": {"format": "png"}, "camera": )" + camera);
}

TEST(Frames, TheEmptyRequestIsAJpegOf1280x720) {
    auto client = sharedServer().client();
    const auto result = postJson(client, "/v1/frames", "{}");
    ASSERT_TRUE(result);
    ASSERT_EQ(result->status, 200) << result->body;
    EXPECT_EQ(result->get_header_value("Content-Type"), "image/jpeg");
    EXPECT_EQ(result->get_header_value("Content-Length"), std::to_string(result->body.size()));
    const Image image = decodeJpeg(result->body);
    EXPECT_EQ(image.width, 1280u);
    EXPECT_EQ(image.height, 720u);
    const auto [least, most] =
        std::minmax_element(image.bytes(), image.bytes() + image.data.size());
    EXPECT_GT(*most - *least, 50) << "the picture is one flat colour";
}

TEST(Frames, PosesInThreeFormsGiveEqualBytes) {
    // The eye at (1, 0.5, 0.25) looks along -X: a quarter turn about +Y.
    const std::string lookAt =
        frameBytes(withCamera(R"({"position": [1, 0.5, 0.25], "target": [0, 0.5, 0.25]})"));
    const std::string quaternion = frameBytes(withCamera(R"({"position": [1, 0.5, 0.25],
                       "orientation": [0, 0.7071067811865476, 0, 0.7071067811865476]})"));
    const std::string matrix = frameBytes(withCamera(
        R"({"cameraToWorld": [0, 0, -1, 0,  0, 1, 0, 0,  1, 0, 0, 0,  1, 0.5, 0.25, 1]})"));
    const std::string opencv = frameBytes(withCamera(
        R"({"convention": "opencv",
            "cameraToWorld": [0, 0, -1, 0,  0, -1, 0, 0,  -1, 0, 0, 0,  1, 0.5, 0.25, 1]})"));
    EXPECT_FALSE(lookAt.empty());
    EXPECT_EQ(lookAt, quaternion);
    EXPECT_EQ(lookAt, matrix);
    EXPECT_EQ(lookAt, opencv);
    EXPECT_NE(lookAt,
              frameBytes(withCamera(R"({"position": [1, 0.5, 0.25], "target": [0, 0.5, 0.3]})")));
}

TEST(Frames, ALinkGivesTheBytesOfItsPostRequest) {
    auto client = sharedServer().client();
    const auto link = client.Get(
        "/v1/frames?scene=six-walls&eye=0.5,0.6,0.7&target=0,0.1,0&yfov=0.8&width=64&height=48"
        "&emission=0&shadows=0&indirectLight=0&accuracy=draft&format=png&exposure=0.5&toneMap=aces&"
        "time=0");
    ASSERT_TRUE(link);
    ASSERT_EQ(link->status, 200) << link->body;
    EXPECT_EQ(link->get_header_value("Content-Type"), "image/png");
    const std::string posted = frameBytes(
        smallFrame(R"("camera": {"position": [0.5, 0.6, 0.7], "target": [0, 0.1, 0], "yfov": 0.8},
                      "effects": {"emission": false, "shadows": false, "indirectLight": false},
                      "accuracy": "draft", "exposure": 0.5,
                      "toneMap": "aces", "output": {"format": "png"})"));
    EXPECT_EQ(link->body, posted);

    const auto dotted = client.Get(
        "/v1/frames?scene=six-walls&camera.position=0.5,0.6,0.7&camera.target=0,0.1,0"
        "&camera.yfov=0.8&width=64&height=48&effects.emission=false"
        "&effects.shadows=false&effects.indirectLight=false&accuracy.preset=draft"
        "&output.format=png&exposure=0.5&toneMap=aces");
    ASSERT_TRUE(dotted);
    EXPECT_EQ(dotted->body, posted);
}

TEST(Frames, ALinkToAThumbnailNamesItsSizeAndWhatItShows) {
    auto client = sharedServer().client();
    const std::string body = R"({"scene": "teapots", "width": 64, "height": 48,
        "camera": {"fit": {"margin": 0.2}}, "output": {"format": "webp"}, )" +
                             kPlainEffects + "}";
    auto post = postJson(client, "/v1/frames", body);
    while (post->status == 409) post = postJson(client, "/v1/frames", body);  // it loads
    ASSERT_EQ(post->status, 200);
    const std::string link =
        "/v1/frames?scene=teapots&fit=all&margin=0.2&format=webp" + kPlainLink + "&size=";
    EXPECT_EQ(client.Get(link + "64x48")->body, post->body);
    EXPECT_NE(client.Get(link + "64")->body, post->body);
    const auto pointer = [&](const std::string& query) {
        return problemOf(client.Get("/v1/frames?" + query), 422)["errors"][0]["pointer"];
    };
    EXPECT_EQ(pointer("size=large"), "/width");
    EXPECT_EQ(pointer("size=64x"), "/height");
    EXPECT_EQ(pointer("size=64&width=32"), "/width");
    EXPECT_EQ(pointer("fit=some"), "/camera/fit");
}

TEST(Frames, AcceptSelectsTheFormatUnlessTheBodyDoes) {
    auto client = sharedServer().client();
    const auto typeFor = [&](const char* accept, const std::string& body) {
        const auto result = client.Post("/v1/frames", httplib::Headers{{"Accept", accept}}, body,
                                        "application/json");
        return result ? result->get_header_value("Content-Type") : "";
    };
    EXPECT_EQ(typeFor("image/png", smallFrame()), "image/png");
    EXPECT_EQ(typeFor("*/*", smallFrame()), "image/jpeg");
    EXPECT_EQ(typeFor("image/avif,image/png,image/*;q=0.5", smallFrame()), "image/jpeg");
    EXPECT_EQ(typeFor("image/png, image/jpeg;q=0", smallFrame()), "image/png");
    EXPECT_EQ(typeFor("application/x-npy", smallFrame()), "application/x-npy");
    EXPECT_EQ(typeFor("text/html", smallFrame()), "image/jpeg");
    EXPECT_EQ(typeFor("image/png", smallFrame(R"("output": {"format": "jpeg"})")), "image/jpeg");
}

TEST(Frames, EveryFormatHasTheRequestedSize) {
    const Image png = decodePng(frameBytes(smallFrame(R"("output": {"format": "png"})")));
    EXPECT_EQ(png.width, 64u);
    EXPECT_EQ(png.height, 48u);
    const Image npy = decodeNpy(frameBytes(smallFrame(R"("output": {"format": "npy"})")));
    EXPECT_EQ(npy.width, 64u);
    EXPECT_EQ(npy.height, 48u);
    EXPECT_GE(npy.channels, 3u);
    const Image depth =
        decodeNpy(frameBytes(smallFrame(R"("output": {"format": "npy", "channel": "depth"})")));
    EXPECT_EQ(depth.channels, 1u);
    EXPECT_EQ(depth.width, 64u);
    const Image normal =
        decodeNpy(frameBytes(smallFrame(R"("output": {"format": "npy", "channel": "normal"})")));
    EXPECT_EQ(normal.channels, 3u);
    for (std::size_t i = 0; i < npy.data.size() / 4; ++i)
        ASSERT_TRUE(std::isfinite(npy.floats()[i]));
    const std::string exr = frameBytes(smallFrame(R"("output": {"format": "exr"})"));
    EXPECT_EQ(exr.substr(0, 4), "\x76\x2f\x31\x01");
}

TEST(Frames, PngIsOpaqueAtEveryAccuracy) {
    for (const char* preset : {"draft", "standard", "fine"}) {
        const Image png = decodePng(frameBytes(smallFrame(
            R"("output": {"format": "png"}, "accuracy": ")" + std::string(preset) + '"')));
        for (std::size_t i = 3; i < png.data.size(); i += 4) {
            ASSERT_EQ(png.bytes()[i], 255) << preset;
        }
    }
}

TEST(Frames, JpegQualityAndSubsamplingReachTheEncoder) {
    const auto size = [](const char* output) {
        return frameBytes(R"({"width": 256, "height": 192, "output": )" + std::string(output) + "}")
            .size();
    };
    EXPECT_LT(size(R"({"quality": 20})"), size(R"({"quality": 95})"));
    EXPECT_LT(size(R"({"quality": 95})"), size(R"({"quality": 95, "subsampling": "4:4:4"})"));
}

TEST(Frames, AnUnchangedFrameIsNotRedrawn) {
    auto client = sharedServer().client();
    const std::string link =
        "/v1/frames?scene=six-walls&width=64&height=48&exposure=0.25" + kPlainLink;
    const auto first = client.Get(link);
    ASSERT_TRUE(first);
    const std::string etag = first->get_header_value("ETag");
    EXPECT_EQ(etag.front(), '"') << "a strong validator";
    const auto count = [&] {
        const auto metrics = client.Get("/metrics");
        return metrics->body.substr(metrics->body.find("clerestory_frame_seconds_count"), 60);
    };
    const std::string before = count();
    const auto second = client.Get(link, unless(etag));
    ASSERT_TRUE(second);
    EXPECT_EQ(second->status, 304);
    EXPECT_TRUE(second->body.empty());
    EXPECT_EQ(second->get_header_value("ETag"), etag);
    EXPECT_EQ(count().substr(0, 40), before.substr(0, 40));

    const auto weak = client.Get(link, unless("\"x\", W/" + etag));
    EXPECT_EQ(weak->status, 304);
    const auto other = client.Get(link, unless("\"x\""));
    EXPECT_EQ(other->status, 200);
}

// The same revision of the light has the same bytes and the same tag; other revisions have others.
TEST(Frames, LightBetweenSurfacesIsReportedAndWaitedFor) {
    auto client = sharedServer().client();
    client.set_read_timeout(120);
    const std::string link = "/v1/frames?scene=orbiting-cubes&width=96&height=64&format=png";
    const auto off = client.Get(link + kPlainLink);
    ASSERT_TRUE(off);
    EXPECT_FALSE(off->has_header("Clerestory-Light"));
    const auto first = client.Get(link);
    ASSERT_TRUE(first);
    ASSERT_EQ(first->status, 200) << first->body;
    EXPECT_THAT(first->get_header_value("Clerestory-Light"), HasSubstr("revision="));
    const auto waited = [&] { return client.Get(link, httplib::Headers{{"Prefer", "wait=30"}}); };
    auto complete = waited();
    // The light is computed while frames of other tests are drawn.
    while (complete && complete->status == 200 &&
           complete->get_header_value("Clerestory-Light").find("share=1.00") == std::string::npos) {
        complete = waited();
    }
    ASSERT_TRUE(complete);
    ASSERT_EQ(complete->status, 200) << complete->body;
    EXPECT_EQ(complete->get_header_value("Preference-Applied"), "wait=30");
    EXPECT_NE(complete->get_header_value("ETag"), off->get_header_value("ETag"));
    EXPECT_TRUE(complete->body != off->body);
    const auto again = client.Get(link);
    ASSERT_TRUE(again);
    EXPECT_TRUE(again->body == complete->body);
    EXPECT_EQ(again->get_header_value("ETag"), complete->get_header_value("ETag"));
    const auto framesDrawn = [&] {
        const std::string text = client.Get("/metrics")->body;
        const std::string name = "\nclerestory_frame_seconds_count";
        return text.substr(text.find(name) + 1,
                           text.find('\n', text.find(name) + 1) - text.find(name) - 1);
    };
    const std::string drawn = framesDrawn();
    const auto unchanged = client.Get(link, unless(complete->get_header_value("ETag")));
    ASSERT_TRUE(unchanged);
    EXPECT_EQ(unchanged->status, 304);
    EXPECT_EQ(framesDrawn(), drawn) << "its revision is known without drawing";
    const auto scene = client.Get("/v1/scenes/orbiting-cubes");
    ASSERT_TRUE(scene);
    const auto progress = json::parse(scene->body).at("light");
    EXPECT_EQ(progress.at("share"), 1.0);
    EXPECT_GE(progress.at("revision"), 1);
    const auto plan =
        postJson(client, "/v1/plans", R"({"scene": "orbiting-cubes", "width": 96, "height": 64})");
    ASSERT_TRUE(plan && plan->status == 200) << plan->body;
    EXPECT_EQ(json::parse(plan->body).at("light"), progress);
}

TEST(Frames, TheETagDependsOnEveryFieldAndNothingElse) {
    auto client = sharedServer().client();
    const auto etag = [&](const std::string& more) {
        return postJson(client, "/v1/frames", smallFrame(more))->get_header_value("ETag");
    };
    const std::string plain = etag("");
    EXPECT_EQ(plain, etag(""));
    EXPECT_EQ(plain, etag(R"("time": 0.0, "toneMap": "neutral")")) << "defaults written out";
    EXPECT_EQ(plain, etag(R"("accuracy": {"preset": "standard"})"));
    for (const char* change :
         {R"("exposure": 0.1)", R"("time": 1)", R"("toneMap": "aces")", R"("accuracy": "draft")",
          R"("effects": {"emission": false})", R"("output": {"quality": 84})",
          R"("environment": {"map": "studio"})", R"("environment": {"intensity": 2})",
          R"("camera": {"yfov": 0.5})", R"("overrides": [{"node": "ball", "roughness": 0.2}])",
          R"("overrides": [{"node": "ball", "roughness": 0.3}])"}) {
        EXPECT_NE(plain, etag(change)) << change;
    }
}

TEST(Frames, ServerTimingNamesEveryStep) {
    auto client = sharedServer().client();
    const auto result = postJson(client, "/v1/frames", smallFrame());
    ASSERT_TRUE(result);
    const std::string timing = result->get_header_value("Server-Timing");
    for (const char* name : {"queue;dur=", "plan;dur=", "surface;dur=", "toneMap;dur=",
                             "readback;dur=", "encode;dur=", "total;dur="}) {
        EXPECT_THAT(timing, HasSubstr(name));
    }
    EXPECT_THAT(result->get_header_value("Clerestory-Passes"), HasSubstr("surface"));
}

TEST(Frames, AnExplainedFrameCarriesThePlanThatRan) {
    auto client = sharedServer().client();
    ASSERT_TRUE(postJson(client, "/v1/frames", smallFrame()));  // maps become resident
    const auto plain = postJson(client, "/v1/frames", smallFrame());
    const auto planned = postJson(client, "/v1/plans", smallFrame());
    const auto explained = postJson(client, "/v1/frames?explain=1", smallFrame());
    ASSERT_TRUE(plain && planned && explained);
    ASSERT_EQ(explained->status, 200);
    const auto parts = partsOf(*explained);
    ASSERT_EQ(parts.size(), 2u);
    EXPECT_EQ(parts[0].first, "image/jpeg");
    EXPECT_EQ(parts[0].second, plain->body);
    EXPECT_EQ(parts[1].first, "application/json");

    json ran = json::parse(parts[1].second);
    for (json& pass : ran["passes"]) {
        EXPECT_GE(pass["milliseconds"].get<double>(), 0.0);
        pass.erase("milliseconds");
        pass.erase("paths");
        EXPECT_FALSE(pass["reason"].get<std::string>().empty());
    }
    EXPECT_EQ(ran, json::parse(planned->body));
    EXPECT_EQ(explained->get_header_value("Clerestory-Passes"),
              plain->get_header_value("Clerestory-Passes"));
}

TEST(Frames, HealthChecksEveryFloatTargetOnRequest) {
    auto client = sharedServer().client();
    const auto plain = postJson(client, "/v1/frames", smallFrame());
    const auto explained = postJson(client, "/v1/frames?explain=health", smallFrame());
    ASSERT_TRUE(plain && explained);
    ASSERT_EQ(explained->status, 200);
    const auto parts = partsOf(*explained);
    ASSERT_EQ(parts.size(), 2u);
    EXPECT_EQ(parts[0].second, plain->body);
    const json health = json::parse(parts[1].second)["health"];
    EXPECT_EQ(health["nonFinite"], 0);
    EXPECT_EQ(health["negative"], 0);
    ASSERT_FALSE(health["targets"].empty());
    for (const json& target : health["targets"]) {
        EXPECT_GT(target["texels"], 0) << target;
        EXPECT_EQ(target["nonFinite"], 0) << target;
    }
    const auto unasked = postJson(client, "/v1/frames?explain=1", smallFrame());
    ASSERT_TRUE(unasked);
    EXPECT_FALSE(json::parse(partsOf(*unasked)[1].second).contains("health"));
}

// The environment of a ball between six walls of one colour each consists of those six colours.
TEST(Frames, MapsShowTheEnvironmentOfTheMirrors) {
    auto client = sharedServer().client();
    const std::string request = smallFrame(
        R"("accuracy": {"curved": "probe", "probeSamples": 1}, "output": {"format": "png"})");
    const auto plain = postJson(client, "/v1/frames", request);
    const auto explained = postJson(client, "/v1/frames?explain=maps", request);
    ASSERT_TRUE(plain && explained);
    ASSERT_EQ(explained->status, 200) << explained->body;
    EXPECT_EQ(explained->get_header_value("ETag"), "");
    const auto parts = partsOf(*explained);
    ASSERT_GE(parts.size(), 3u);
    EXPECT_EQ(parts[0].second, plain->body);
    EXPECT_EQ(parts[1].first, "application/json");
    EXPECT_THAT(explained->body, HasSubstr("name=\"probe:"));
    const json plan = json::parse(parts[1].second);
    ASSERT_EQ(plan["maps"].size(), parts.size() - 2) << "one for each part";
    EXPECT_EQ(plan["maps"][0]["subject"], json({{"kind", "environment"}, {"name", "black"}}));
    EXPECT_EQ(plan["maps"][1]["subject"], json({{"kind", "probe"}, {"name", "ball"}}));
    std::size_t cubes = 0;
    for (std::size_t i = 2; i < parts.size(); ++i) {
        EXPECT_EQ(parts[i].first, "image/jpeg");
        const Image sheet = decodeJpeg(parts[i].second);
        if (sheet.width * 2 != sheet.height * 3) continue;
        std::set<std::array<int, 3>> colours;  // of the middles, coarse enough for JPEG
        for (std::uint32_t f = 0; f < 6; ++f) {
            const std::uint32_t edge = sheet.width / 3;
            const std::uint8_t* p =
                sheet.bytes() + 3 * (std::size_t{sheet.width} * (f / 3 * edge + edge / 2) +
                                     f % 3 * edge + edge / 2);
            colours.insert({p[0] / 40, p[1] / 40, p[2] / 40});
        }
        cubes += colours.size() == 6;
    }
    EXPECT_EQ(cubes, 1u);
    EXPECT_EQ(partsOf(*postJson(client, "/v1/frames?explain=1", request)).size(), 2u);
}

TEST(Frames, APlanListsTheTechniqueAndAlternativesOfEachReflector) {
    auto client = sharedServer().client();
    const auto decisionsOf = [&](const char* more) {
        const auto planned = postJson(client, "/v1/plans", smallFrame(more));
        EXPECT_TRUE(planned);
        return json::parse(planned->body)["decisions"];
    };
    const json free = decisionsOf("");
    ASSERT_EQ(free.size(), 1u) << "the ball";
    EXPECT_EQ(free[0]["effect"], "environmentReflection");
    EXPECT_THAT(free[0]["reason"].get<std::string>(), HasSubstr("% of the frame"));
    ASSERT_GE(free[0]["candidates"].size(), 2u);
    for (const json& candidate : free[0]["candidates"]) {
        EXPECT_GE(candidate["milliseconds"].get<double>(), 0.0);
        EXPECT_GT(candidate["error"].get<double>(), 0.0);
    }
    EXPECT_EQ(decisionsOf(R"("accuracy": {"curved": "environment"})")[0]["taken"], "environment");
    EXPECT_EQ(decisionsOf(R"("accuracy": {"curved": "probe"})")[0]["taken"], "probe");
    EXPECT_EQ(decisionsOf(R"("effects": {"environmentReflection": false})"), json::array());
}

TEST(Frames, PassesOfOneKindShareOneTimingEntry) {
    auto client = sharedServer().client();
    const auto result = postJson(
        client, "/v1/frames",
        smallFrame(R"("accuracy": {"curved": "probe", "probeSize": 17, "generations": 1})"));
    ASSERT_TRUE(result);
    ASSERT_EQ(result->status, 200) << result->body;
    EXPECT_THAT(result->get_header_value("Clerestory-Passes"), HasSubstr("capture*6"));
    const std::string timing = result->get_header_value("Server-Timing");
    const std::size_t first = timing.find("capture;dur=");
    ASSERT_NE(first, std::string::npos) << timing;
    EXPECT_EQ(timing.find("capture;dur=", first + 1), std::string::npos) << timing;
}

TEST(Frames, ServerTimingOfHundredsOfPassesFitsOneHeader) {
    FramePlan plan;
    const auto add = [&](const PassWork& work, const char* name, int times) {
        for (int i = 0; i < times; ++i) plan.passes.push_back({.name = name, .work = work});
    };
    add(PrefilterMap{}, "environment:a, b\n", 1);
    add(DrawScene{.purpose = DrawScene::Purpose::capture}, "probe:ball", 12);
    add(DrawScene{}, "surface", 1);
    EXPECT_EQ(compactPasses(plan), "environment:a__b_, capture*12, surface");
    plan.passes.clear();
    for (int i = 0; i < 200; ++i) {
        add(DrawScene{.purpose = DrawScene::Purpose::capture}, "probe:ball", 6);
        add(BuildLevels{}, "probe:ball:levels", 1);
    }
    add(DrawScene{}, "surface", 1);
    EXPECT_EQ(compactPasses(plan), "capture*1200, levels*200, surface*1");
    EXPECT_EQ(compactPasses({}), "");
}

TEST(Frames, TheExplanationContainsTheRequestedView) {
    auto client = sharedServer().client();
    const auto planned = postJson(
        client, "/v1/plans",
        smallFrame(R"("camera": {"position": [0, 0, 2], "target": [0, 0, 0], "yfov": 1.0})"));
    ASSERT_TRUE(planned);
    const json plan = json::parse(planned->body);
    int surfaces = 0;
    for (const json& pass : plan["passes"]) {
        if (pass["kind"] != "surface") continue;
        ++surfaces;
        const json& view = pass["viewMatrices"][0];
        EXPECT_EQ(view["eye"], json({0.0, 0.0, 2.0}));
        // Looking down -Z from (0, 0, 2): only a translation.
        EXPECT_EQ(view["viewFromWorld"], json({1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0,
                                               1.0, 0.0, 0.0, 0.0, -2.0, 1.0}));
        EXPECT_NEAR(view["clipFromView"][5].get<double>(), 1.0 / std::tan(0.5), 1e-12);
    }
    EXPECT_EQ(surfaces, 1);
}

TEST(Frames, TheRequestIdIsEchoedOrMade) {
    auto client = sharedServer().client();
    const auto idFor = [&](const char* given) {
        return client.Get("/healthz", httplib::Headers{{"X-Request-Id", given}})
            ->get_header_value("X-Request-Id");
    };
    EXPECT_EQ(idFor("pose-17.b_2"), "pose-17.b_2");
    const std::string made = idFor("bad id; rm");
    EXPECT_NE(made, "bad id; rm");
    EXPECT_FALSE(made.empty());
    EXPECT_NE(made, idFor(""));
}

TEST(Frames, MayBeWebp) {
    auto client = sharedServer().client();
    const auto named =
        postJson(client, "/v1/frames", smallFrame(R"("output": {"format": "webp"})"));
    ASSERT_EQ(named->status, 200) << named->body;
    EXPECT_EQ(named->get_header_value("Content-Type"), "image/webp");
    EXPECT_EQ(named->body.substr(0, 4) + named->body.substr(8, 4), "RIFFWEBP");
    const auto accepted =
        client.Post("/v1/frames", {{"Accept", "image/webp"}}, smallFrame(), "application/json");
    EXPECT_EQ(accepted->body, named->body);
    // What browsers send for a picture still gives a JPEG.
    const auto any = client.Post("/v1/frames", {{"Accept", "image/avif,image/webp,*/*;q=0.8"}},
                                 smallFrame(), "application/json");
    EXPECT_EQ(any->get_header_value("Content-Type"), "image/jpeg");
}

}  // namespace
}  // namespace clerestory::test
