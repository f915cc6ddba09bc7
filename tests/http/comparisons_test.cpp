// POST /v1/comparisons on a real server: the job, its figures, images, and rejections.
#include "tests/support/compare_images.h"
#include "tests/support/soon.h"
#include "tests/support/test_server.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace clerestory::test {
namespace {

using nlohmann::json;
using testing::StartsWith;

// Three quarters of a second of tracing at most; six-walls has a mirror and nothing else.
std::string comparison(const std::string& more) {
    return smallFrame(R"("frames": 2, "samples": 16, "settings": ["draft", "fine"])" + more);
}

json jobAt(httplib::Client& client, const std::string& place) {
    const auto result = client.Get(place);
    if (!result || result->status != 200) {
        ADD_FAILURE() << place;
        return nullptr;
    }
    return json::parse(result->body);
}

json ended(httplib::Client& client, const std::string& place) {
    json job;
    EXPECT_TRUE(within(kPatience, [&] {
        job = jobAt(client, place);
        return job.is_null() || (job["state"] != "queued" && job["state"] != "running");
    }));
    return job;
}

TEST(Comparisons, AJobReportsTimeAndErrorOfEachSetting) {
    auto client = sharedServer().client();
    const auto started =
        postJson(client, "/v1/comparisons", comparison(R"(, "errorPictures": true)"));
    ASSERT_TRUE(started);
    ASSERT_EQ(started->status, 202) << started->body;
    const std::string place = started->get_header_value("Location");
    EXPECT_THAT(place, StartsWith("/v1/jobs/"));
    // Clients get their frames meanwhile.
    EXPECT_EQ(postJson(client, "/v1/frames", smallFrame())->status, 200);
    const json job = ended(client, place);
    ASSERT_EQ(job["state"], "done") << job;
    EXPECT_EQ(job["progress"], 1.0);
    const json& result = job["result"];
    EXPECT_EQ(result["reference"]["mode"], "full");
    EXPECT_EQ(result["reference"]["samples"], 16);
    EXPECT_EQ(result["reference"]["nonFinite"], 0);
    ASSERT_EQ(result["settings"].size(), 2u);
    const json &draft = result["settings"][0], &fine = result["settings"][1];
    EXPECT_EQ(draft["name"], "draft");
    EXPECT_EQ(fine["accuracy"]["preset"], "fine");
    EXPECT_GT(draft["milliseconds"]["median"], 0.0);
    EXPECT_GE(draft["milliseconds"]["p95"], draft["milliseconds"]["median"]);
    EXPECT_EQ(draft["error"]["frame"]["pixels"], 64 * 48);
    EXPECT_LT(fine["error"]["frame"]["relMse"], draft["error"]["frame"]["relMse"]);
    EXPECT_LT(fine["error"]["frame"]["relMse"], result["effectsOff"]["relMse"]);
    EXPECT_GT(fine["error"]["frame"]["psnr"], draft["error"]["frame"]["psnr"]);
    EXPECT_LE(fine["closedGap"], 1.0);
    for (const json* setting : {&draft, &fine}) {
        const auto picture = client.Get((*setting)["errorPicture"].get<std::string>());
        ASSERT_TRUE(picture && picture->status == 200);
        EXPECT_EQ(picture->get_header_value("Content-Type"), "image/png");
        EXPECT_EQ(decodePng(picture->body).width, 64u);
    }
    const auto truth = client.Get(result["reference"]["picture"].get<std::string>());
    ASSERT_TRUE(truth && truth->status == 200);
    const auto fineFrame = postJson(
        client, "/v1/frames", smallFrame(R"("accuracy": "fine", "output": {"format": "png"})"));
    EXPECT_LT(difference(decodePng(truth->body), decodePng(fineFrame->body), 0.0).mean, 0.06);
    EXPECT_EQ(client.Get(place + "/pictures/3")->status, 404);
    EXPECT_EQ(client.Get(place + "/pictures/-1")->status, 404);
    EXPECT_EQ(client.Get(place + "/pictures/")->status, 404);
}

TEST(Comparisons, ResultsAreReproducible) {
    auto client = sharedServer().client();
    json errors[2];
    for (json& e : errors) {
        const auto started = postJson(client, "/v1/comparisons", comparison(""));
        ASSERT_EQ(started->status, 202);
        const json job = ended(client, started->get_header_value("Location"));
        for (const json& setting : job["result"]["settings"]) e.push_back(setting["error"]);
        EXPECT_FALSE(job["result"]["settings"][0].contains("errorPicture"));
    }
    EXPECT_EQ(errors[0], errors[1]);
}

json comparedSettings(httplib::Client& client, const std::string& scene) {
    const std::string body = R"({"width": 64, "height": 48, "frames": 1, "samples": 8,
        "settings": ["draft"], "errorPictures": true,
        "camera": {"position": [3, 2, 5], "target": [0, 0.5, 0]}, "scene": )" +
                             scene + "}";
    const auto started = postUntilReady(client, "/v1/comparisons", body);
    EXPECT_EQ(started->status, 202) << started->body;
    const json job = ended(client, started->get_header_value("Location"));
    EXPECT_EQ(job["state"], "done") << job;
    return job["result"];
}

TEST(Comparisons, AListOfScenesIsOneScene) {
    auto client = sharedServer().client();
    const json alone = comparedSettings(client, R"("teapots")");
    const json listed = comparedSettings(client, R"([{"scene": "teapots"}])");
    EXPECT_EQ(listed["settings"][0]["error"], alone["settings"][0]["error"]);
    const auto picture = [&](const json& result) {
        return client.Get(result["reference"]["picture"].get<std::string>())->body;
    };
    EXPECT_EQ(picture(listed), picture(alone));

    // Another place of a part is another reference.
    const auto both = [](const char* y) {
        return std::string(R"([{"scene": "teapots"}, {"scene": "orbiting-cubes",
            "scale": [0.3, 0.3, 0.3], "translation": [0, )") +
               y + ", 0]}]";
    };
    const json low = comparedSettings(client, both("1")),
               high = comparedSettings(client, both("2"));
    EXPECT_NE(picture(low), picture(alone));
    EXPECT_NE(picture(low), picture(high));
    const double error = alone["settings"][0]["error"]["frame"]["relMse"];
    for (const json* result : {&low, &high}) {
        EXPECT_LT((*result)["settings"][0]["error"]["frame"]["relMse"], 3.0 * error);
    }
}

TEST(Comparisons, AJobCanBeCancelled) {
    auto client = sharedServer().client();
    const auto started = postJson(client, "/v1/comparisons",
                                  R"({"scene": "six-walls", "width": 640, "samples": 4096})");
    ASSERT_EQ(started->status, 202) << started->body;
    const std::string place = started->get_header_value("Location");
    EXPECT_EQ(client.Delete(place)->status, 200);
    const json job = ended(client, place);
    EXPECT_EQ(job["state"], "cancelled");
    EXPECT_FALSE(job.contains("result"));
}

// A budget is measured on first use; then it is kept, said, and the same bytes as what it picked.
TEST(Budgets, AFrameReportsTheSettingThatItsBudgetChose) {
    auto client = sharedServer().client();
    const auto within = [](const std::string& budget) {
        return smallFrame(R"("output": {"format": "png"}, "accuracy": )" + budget);
    };
    httplib::Result frame = postJson(client, "/v1/frames", within(R"({"maxMilliseconds": 60000})"));
    ASSERT_EQ(frame->status, 409) << "nothing has been measured yet";
    EXPECT_EQ(frame->get_header_value("Retry-After"), "2");
    problemOf(frame, 409);
    frame = postUntilReady(client, "/v1/frames", within(R"({"maxMilliseconds": 60000})"));
    ASSERT_EQ(frame->status, 200) << frame->body;
    EXPECT_THAT(frame->get_header_value("Clerestory-Accuracy"), testing::HasSubstr("predicted"));
    const auto plan = postJson(client, "/v1/plans", within(R"({"maxMilliseconds": 60000})"));
    const json chosen = json::parse(plan->body)["accuracy"]["chosen"];
    const auto again = postJson(client, "/v1/frames", within(chosen.dump()));
    ASSERT_EQ(again->status, 200) << again->body;
    EXPECT_EQ(again->body, frame->body);
    EXPECT_EQ(again->get_header_value("ETag"), frame->get_header_value("ETag"));
    EXPECT_FALSE(again->has_header("Clerestory-Accuracy"));

    // A budget is for the frame before its filters: they cause no new measurement.
    const std::string glow = R"(, "filters": [{"type": "glow"}])";
    const auto glowing =
        postJson(client, "/v1/frames", within(R"({"maxMilliseconds": 60000})" + glow));
    ASSERT_EQ(glowing->status, 200) << glowing->body;
    EXPECT_EQ(glowing->body, postJson(client, "/v1/frames", within(chosen.dump() + glow))->body);

    const auto missed = postJson(client, "/v1/frames", within(R"({"maxError": 1e-6})"));
    ASSERT_EQ(missed->status, 200);
    EXPECT_THAT(missed->get_header_value("Clerestory-Accuracy"),
                testing::HasSubstr("no setting meets the budget"));
    problemOf(postJson(client, "/v1/frames", within(R"({"maxError": 1, "probeSize": 64})")), 422);
    problemOf(postJson(client, "/v1/frames", within(R"({"maxMilliseconds": 0})")), 422);
    problemOf(postJson(client, "/v1/comparisons", within(R"({"maxError": 1})")), 422);
}

TEST(Budgets, AListOfScenesHasACurveOfItsOwn) {
    auto client = sharedServer().client();
    const auto frame = [](const char* x, const std::string& accuracy) {
        return std::string(R"({"width": 32, "height": 24, "output": {"format": "png"},
            "scene": [{"scene": "six-walls"}, {"scene": "orbiting-cubes", "translation": [)") +
               x + R"(, 0, 0]}], "accuracy": )" + accuracy + "}";
    };
    const std::string budget = R"({"maxMilliseconds": 60000})";
    const auto drawn = postUntilReady(client, "/v1/frames", frame("1", budget));
    ASSERT_EQ(drawn->status, 200) << drawn->body;
    const auto plan = postJson(client, "/v1/plans", frame("1", budget));
    const json chosen = json::parse(plan->body)["accuracy"]["chosen"];
    EXPECT_EQ(postJson(client, "/v1/frames", frame("1", chosen.dump()))->body, drawn->body);
    problemOf(postJson(client, "/v1/frames", frame("2", budget)), 409);
}

// A picture on a page of another site would otherwise start minutes of work (Fetch Metadata).
TEST(Budgets, APageOfAnotherSiteStartsNoMeasurement) {
    TestServer server;
    server.awaitReady();
    auto client = server.client();
    const std::string link =
        "/v1/frames?scene=six-walls&width=24&height=24&accuracy.maxError=1" + kPlainLink;
    const auto from = [&](const char* site) {
        return client.Get(link, {{"Sec-Fetch-Site", site}});
    };
    const auto open = [&] {
        const std::string text = client.Get("/metrics")->body;
        const std::string name = "clerestory_renderer_held{pool=\"jobs\"} ";
        const std::size_t at = text.find(name);
        return at == std::string::npos ? -1 : std::stoi(text.substr(at + name.size()));
    };
    for (const char* site : {"cross-site", "same-site"}) {
        problemOf(from(site), 403);
        EXPECT_EQ(open(), 0) << site;
    }
    const json problem = problemOf(from("same-origin"), 409);
    EXPECT_EQ(open(), 1) << problem;
    problemOf(from("cross-site"), 409);
    EXPECT_EQ(open(), 1) << "one measurement";
}

TEST(Comparisons, EveryWrongFieldIsNamed) {
    auto client = sharedServer().client();
    const auto refused = postJson(client, "/v1/comparisons",
                                  R"({"scene": "six-walls", "samples": 1, "modes": "full",
                                      "settings": ["standart", {"probeSize": 1}], "width": 0})");
    const json problem = problemOf(refused, 422);
    std::vector<std::string> pointers;
    for (const json& error : problem["errors"]) pointers.push_back(error["pointer"]);
    EXPECT_THAT(pointers, testing::UnorderedElementsAre("/samples", "/modes", "/settings/0",
                                                        "/settings/1/probeSize", "/width"));
    problemOf(
        postJson(client, "/v1/comparisons", R"({"width": 4096, "height": 2160, "samples": 16384})"),
        422);
    problemOf(postJson(client, "/v1/comparisons", R"({"scene": "nowhere"})"), 404);
    problemOf(postJson(client, "/v1/comparisons",
                       R"({"scene": "six-walls", "camera": {"name": "none"}})"),
              422);
    const json filtered =
        problemOf(postJson(client, "/v1/comparisons", R"({"filters": [{"type": "glow"}]})"), 422);
    EXPECT_EQ(filtered["errors"][0]["pointer"], "/filters");
    problemOf(client.Get("/v1/comparisons"), 405);
    problemOf(client.Get("/v1/jobs/0"), 404);
    problemOf(client.Get("/v1/jobs/"), 404);
    problemOf(client.Delete("/v1/jobs/0"), 404);
    problemOf(client.Post("/v1/jobs/0"), 405);
}

}  // namespace
}  // namespace clerestory::test
