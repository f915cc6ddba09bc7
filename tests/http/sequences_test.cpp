// Sequences: each file equals a single response, in order, with the matrices used.
#include "server/live/archive.h"
#include "tests/http/sequences_support.h"

#include <gmock/gmock.h>
#include <malloc.h>

#include <numbers>
#include <thread>

namespace clerestory::test {
namespace {

using nlohmann::json;

// Found by the leak sanitizer: some bytes for every client that left.
TEST(UploadedArchives, AreDiscardedWhenTheClientDisconnects) {
    const auto abandoned = [](std::size_t after, bool ended) {
        std::size_t taken = 0;
        int refused = 0;
        const Sink leaves = [&](std::string_view bytes) {
            taken += bytes.size();
            refused += taken > after;
            return taken <= after;
        };
        {
            const auto tar = tarArchive(leaves);
            EXPECT_FALSE(tar->add("a", "", "b") && tar->add("b", "", "c"));
            EXPECT_FALSE(ended && tar->end());
        }
        EXPECT_EQ(refused, 1) << "nothing is sent after the disconnect";
    };
    // In the head of the first file, in its content, and so in the second.
    for (const std::size_t after : {0, 512, 1024, 1536}) {
        for (const bool ended : {false, true}) {
            abandoned(after, ended);
            const std::size_t before = mallinfo2().uordblks;
            for (int i = 0; i < 2000; ++i) abandoned(after, ended);
            EXPECT_LT(mallinfo2().uordblks, before + 50'000) << after;
        }
    }
}

TEST(Sequences, FramesHaveCompleteLight) {
    TestServer server;  // whose light is not computed
    auto client = server.client();
    json body = orbit(1);
    body["common"]["scene"] = "orbiting-cubes";
    body["common"].erase("effects");
    body["common"]["output"] = {{"format", "png"}};
    auto result = postJson(client, "/v1/sequences", body.dump());
    while (result->status == 409) {  // it loads
        result = postJson(client, "/v1/sequences", body.dump());
    }
    ASSERT_EQ(result->status, 200) << result->body;
    json single = body["common"];
    single.update(body["frames"][0]);
    const auto frame = postJson(client, "/v1/frames", single.dump());
    EXPECT_THAT(frame->get_header_value("Clerestory-Light"), testing::HasSubstr("share=1.00"));
    EXPECT_EQ(fileOf(filesOfTar(result->body), "000000.png"), frame->body);
}

TEST(Sequences, EachFileEqualsASingleResponse) {
    auto client = sharedServer().client();
    const json body = orbit(3, {{"channels", {{"depth", true}}}});
    const auto result = postJson(client, "/v1/sequences", body.dump());
    ASSERT_EQ(result->status, 200) << result->body;
    EXPECT_EQ(result->get_header_value("Content-Type"), "application/x-tar");
    const Files files = filesOfTar(result->body);
    std::vector<std::string> names;
    for (const auto& [name, content] : files) names.push_back(name);
    EXPECT_THAT(names,
                testing::ElementsAre("000000.jpg", "000000.depth.npy", "000000.json", "000001.jpg",
                                     "000001.depth.npy", "000001.json", "000002.jpg",
                                     "000002.depth.npy", "000002.json", "manifest.json"));
    for (int i = 0; i < 3; ++i) {
        json single = body["common"];
        single.update(body["frames"][i]);
        const std::string stem = "00000" + std::to_string(i);
        EXPECT_EQ(fileOf(files, stem + ".jpg"),
                  postJson(client, "/v1/frames", single.dump())->body);
        single["output"] = {{"channel", "depth"}, {"format", "npy"}};
        EXPECT_EQ(fileOf(files, stem + ".depth.npy"),
                  postJson(client, "/v1/frames", single.dump())->body);
    }
    const json manifest = json::parse(fileOf(files, "manifest.json"));
    EXPECT_EQ(manifest["frames"].size(), 3u);
    EXPECT_EQ(manifest["failures"], 0);
}

TEST(Sequences, MatricesAreReported) {
    auto client = sharedServer().client();
    json body = orbit(1);
    // A rotation about y by atan(3/4), in the columns of a rigid matrix.
    body["frames"][0] = {
        {"camera",
         {{"cameraToWorld", {0.8, 0, -0.6, 0, 0, 1, 0, 0, 0.6, 0, 0.8, 0, 0.5, 1.25, 2, 1}},
          {"intrinsics",
           {{"fx", 60}, {"fy", 55}, {"cx", 30}, {"cy", 20}, {"pixelCenter", "integer"}}}}}};
    const auto result = postJson(client, "/v1/sequences", body.dump());
    ASSERT_EQ(result->status, 200) << result->body;
    const json about = json::parse(fileOf(filesOfTar(result->body), "000000.json"));
    const json camera = about["camera"];
    const json asked = body["frames"][0]["camera"]["cameraToWorld"];
    for (int i = 0; i < 16; ++i) {
        EXPECT_NEAR(camera["cameraToWorld"][i].get<double>(), asked[i].get<double>(), 1e-8);
    }
    EXPECT_EQ(camera["cameraToWorld"][13], 1.25) << "the eye is returned with the same bits";
    EXPECT_EQ(camera["intrinsics"]["pixelCenter"], "half");
    EXPECT_NEAR(camera["intrinsics"]["cx"].get<double>(), 30.5, 1e-9);
    EXPECT_NEAR(camera["intrinsics"]["cy"].get<double>(), 20.5, 1e-9);
    EXPECT_NEAR(camera["intrinsics"]["fx"].get<double>(), 60, 1e-9);
    EXPECT_NEAR(camera["intrinsics"]["fy"].get<double>(), 55, 1e-9);
    EXPECT_GT(about["plans"]["color"]["passes"].size(), 0u);
}

TEST(Sequences, APathGivesItsFramesAndFirstResumesIt) {
    auto client = sharedServer().client();
    json body = {
        {"common",
         {{"scene", "six-walls"},
          {"width", 32},
          {"height", 24},
          {"effects", {{"indirectLight", false}}}}},
        {"path",
         {{"frameRate", 4},
          {"keys",
           {{{"time", 0}, {"camera", {{"position", {0, 1, 2}}, {"target", {0, 1, 0}}}}},
            {{"time", 1}, {"camera", {{"position", {1, 1, 2}}, {"target", {0, 1, 0}}}}}}}}}};
    const Files whole = filesOfTar(postJson(client, "/v1/sequences", body.dump())->body);
    EXPECT_EQ(whole.size(), 5u * 2 + 1);
    EXPECT_EQ(json::parse(fileOf(whole, "000002.json"))["time"], 0.5);
    body["first"] = 3;
    const Files rest = filesOfTar(postJson(client, "/v1/sequences", body.dump())->body);
    ASSERT_EQ(rest.size(), 2u * 2 + 1);
    EXPECT_EQ(rest[0].first, "000003.jpg");
    EXPECT_EQ(rest[0].second, fileOf(whole, "000003.jpg"));
}

// The frames of a turntable are those of the fitted view from its azimuths.
// Slices put together have the files of the whole, and without plans the same bytes.
TEST(Sequences, SlicesHaveTheFilesOfTheWhole) {
    auto client = sharedServer().client();
    const auto filesWith = [&](const json& fields) {
        const auto result = postJson(client, "/v1/sequences", orbit(5, fields).dump());
        EXPECT_EQ(result->status, 200) << result->body;
        return filesOfTar(result->body);
    };
    const Files whole = filesWith({{"plans", false}});
    Files joined;
    for (const auto& [first, count] : {std::pair{0, 2}, std::pair{2, 2}, std::pair{4, 100}}) {
        Files slice = filesWith({{"plans", false}, {"first", first}, {"count", count}});
        EXPECT_EQ(slice.back().first, "manifest.json");
        slice.pop_back();
        joined.insert(joined.end(), slice.begin(), slice.end());
    }
    EXPECT_EQ(joined, Files(whole.begin(), whole.end() - 1));
    const json frame = json::parse(fileOf(whole, "000000.json"));
    EXPECT_FALSE(frame.contains("plans"));
    EXPECT_FALSE(frame.contains("milliseconds"));
    EXPECT_TRUE(json::parse(fileOf(filesWith(json::object()), "000000.json")).contains("plans"));
}

TEST(Sequences, ATurntableGoesRoundWhatIsFitted) {
    auto client = sharedServer().client();
    const json common = {{"scene", "teapots"},
                         {"width", 48},
                         {"height", 32},
                         {"effects", {{"indirectLight", false}}},
                         {"camera", {{"fit", {{"elevation", 0.2}, {"azimuth", 0.5}}}}}};
    const json body = {{"common", common},
                       {"turntable", {{"seconds", 1}, {"turns", -2}, {"frameRate", 8}}}};
    const Files files = filesOfTar(postJson(client, "/v1/sequences", body.dump())->body);
    ASSERT_EQ(files.size(), 8u * 2 + 1);
    EXPECT_EQ(fileOf(files, "000001.jpg"), fileOf(files, "000005.jpg"));
    EXPECT_NE(fileOf(files, "000001.jpg"), fileOf(files, "000003.jpg"));
    json frame = common;
    frame["camera"]["fit"]["allAround"] = true;
    frame["camera"]["fit"]["azimuth"] = 0.5 - std::numbers::pi / 2.0;
    EXPECT_EQ(fileOf(files, "000001.jpg"), postJson(client, "/v1/frames", frame.dump())->body);
}

TEST(Sequences, MultipartIsSentOnRequest) {
    auto client = sharedServer().client();
    const std::string body = orbit(2).dump();
    const auto result =
        client.Post("/v1/sequences", {{"Accept", "multipart/mixed"}}, body, "application/json");
    ASSERT_EQ(result->status, 200);
    const auto parts = partsOf(*result);
    ASSERT_EQ(parts.size(), 5u);
    EXPECT_EQ(parts[0].first, "image/jpeg");
    const Files tar = filesOfTar(postJson(client, "/v1/sequences", body)->body);
    EXPECT_EQ(parts[0].second, tar[0].second);
    EXPECT_EQ(parts[2].second, tar[2].second);
}

TEST(Sequences, AFailedFrameIsReportedAndTheOthersAreSent) {
    auto client = sharedServer().client();
    json body = orbit(3);
    body["frames"][1] = {{"camera", {{"name", "unknown"}}}};
    const auto result = postJson(client, "/v1/sequences", body.dump());
    ASSERT_EQ(result->status, 200);
    const Files files = filesOfTar(result->body);
    EXPECT_EQ(files.size(), 5u);
    const json manifest = json::parse(fileOf(files, "manifest.json"));
    EXPECT_EQ(manifest["failures"], 1);
    EXPECT_EQ(manifest["frames"][1]["failure"]["errors"][0]["pointer"], "/camera/name");
}

TEST(Sequences, EveryInvalidFieldIsNamed) {
    auto client = sharedServer().client();
    const auto pointers = [&](const json& body) {
        const json problem = problemOf(postJson(client, "/v1/sequences", body.dump()), 422);
        std::vector<std::string> list;
        for (const json& error : problem["errors"]) list.push_back(error["pointer"]);
        return list;
    };
    using testing::ElementsAre;
    EXPECT_THAT(pointers(json::object()), ElementsAre("/frames"));
    EXPECT_THAT(pointers(orbit(1, {{"first", 1}})), ElementsAre("/first"));
    EXPECT_THAT(pointers(orbit(1, {{"channels", {{"color", false}}}})), ElementsAre("/channels"));
    EXPECT_THAT(pointers(orbit(1, {{"channels", {{"classId", true}}}})),
                ElementsAre("/frames/0/output/classes"));
    EXPECT_THAT(
        pointers(orbit(
            1, {{"channels", {{"classId", true}}},
                {"common", {{"output", {{"classes", {{{"name", "a"}, {"pattern", "none*"}}}}}}}}})),
        ElementsAre("/output/classes/0/pattern"));
    json resized = orbit(2, {{"channels", {{"flow", true}}}});
    resized["frames"][1]["width"] = 32;
    EXPECT_THAT(pointers(resized), ElementsAre("/frames/1/width"));
    EXPECT_THAT(pointers(orbit(1, {{"path", {{"keys", json::array()}}}})),
                ElementsAre("/path", "/path/keys"));
    EXPECT_THAT(pointers(orbit(1, {{"turntable", json::object()}})), ElementsAre("/turntable"));
    EXPECT_THAT(pointers({{"common", {{"camera", {{"name", "eye"}}}}},
                          {"turntable", {{"seconds", 3600}, {"frameRate", 1000}}}}),
                ElementsAre("/turntable", "/common/camera"));
    EXPECT_THAT(pointers({{"turntable", {{"seconds", 0}, {"turns", 1e9}, {"lap", 1}}}}),
                ElementsAre("/turntable/seconds", "/turntable/turns", "/turntable/lap"));
    json wrong = orbit(3);
    wrong["frames"][0]["width"] = 0;
    wrong["frames"][2]["camera"]["yfov"] = 9;
    EXPECT_THAT(pointers(wrong), ElementsAre("/frames/0/width", "/frames/2/camera/yfov"));
    // Sound by themselves, wrong together with what is common.
    json together = orbit(2, {{"common", {{"width", 4096}}}});
    together["frames"][1]["height"] = 4096;
    EXPECT_THAT(pointers(together), ElementsAre("/frames/1/width"));
    json first = orbit(2);
    first["frames"][0] = {{"camera", {{"name", "unknown"}}}};
    EXPECT_THAT(pointers(first), ElementsAre("/camera/name"));
}

TEST(Sequences, ATrainingSetFitsIntoOneSequence) {
    auto client = sharedServer().client();
    constexpr int kFrames = 4000;
    json body = orbit(0);
    for (int i = 0; i < kFrames; ++i) {
        const double x = 0.0001 * i + 1.0 / 3.0;
        body["frames"].push_back(
            {{"camera",
              {{"cameraToWorld",
                {1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, x, 1.0, 2.0, 1.0}}}}});
    }
    body["first"] = kFrames - 1;
    const std::string text = body.dump();
    EXPECT_GT(text.size(), 300'000u);
    const auto result = postJson(client, "/v1/sequences", text);
    ASSERT_TRUE(result);
    ASSERT_EQ(result->status, 200) << result->body;
    EXPECT_EQ(filesOfTar(result->body).front().first, "003999.jpg");

    // Common fields apply to every frame.
    body["common"]["overrides"] = json::array();
    body["frames"] = json(25'000, json::object());
    for (int i = 0; i < 64; ++i) {
        body["common"]["overrides"].push_back({{"node", std::string(190, 'n')}, {"metallic", 0.5}});
    }
    const json problem = problemOf(postJson(client, "/v1/sequences", body.dump()), 422);
    EXPECT_EQ(problem["errors"][0]["pointer"], "/common") << problem.dump();
    const auto other =
        client.Post("/v1/sequences", std::string((4 << 20) + 1, ' '), "application/json");
    EXPECT_TRUE(!other || other->status == 413) << "or it ended before all was sent";
}

TEST(Sequences, OtherFramesAreServedMeanwhileAndDisconnectingEndsTheSequence) {
    TestServer server;
    std::size_t taken = 0;
    std::thread reader([&] {
        auto client = server.client();
        httplib::Request request;
        request.method = "POST";
        request.path = "/v1/sequences";
        request.headers = {{"Content-Type", "application/json"}};
        request.body = orbit(400, {{"common", {{"width", 400}, {"height", 300}}}}).dump();
        request.content_receiver = [&](const char*, std::size_t n, std::uint64_t, std::uint64_t) {
            taken += n;
            return taken < 100'000;  // then leaves
        };
        client.send(request);
    });
    auto client = server.client();
    EXPECT_EQ(postJson(client, "/v1/frames", smallFrame())->status, 200);
    reader.join();
    EXPECT_GE(taken, 100'000u);
    // Its frames stop: the renderer becomes idle.
    const auto drawn = [&] {
        return server.backend().queue().run(std::chrono::seconds(10), [](Renderer& renderer) {
            return renderer.counters().frames;
        });
    };
    std::uint64_t before = drawn(), now = 0;
    for (int i = 0; i < 100; ++i) {
        std::this_thread::sleep_for(std::chrono::milliseconds(200));
        now = drawn();
        if (now == before) break;
        before = now;
    }
    EXPECT_EQ(now, before);
    EXPECT_LT(now, 400u);
}

TEST(Sequences, StoppingTruncatesResponsesDetectably) {
    auto server = std::make_unique<TestServer>();
    bool whole = true;
    std::promise<void> begun;
    std::thread reader([&] {
        auto client = server->client();
        httplib::Request request;
        request.method = "POST";
        request.path = "/v1/sequences";
        request.headers = {{"Content-Type", "application/json"}};
        request.body = orbit(400, {{"common", {{"width", 400}, {"height", 300}}}}).dump();
        bool first = true;
        request.content_receiver = [&](const char*, std::size_t, std::uint64_t, std::uint64_t) {
            if (std::exchange(first, false)) begun.set_value();
            return true;
        };
        whole = static_cast<bool>(client.send(request));
    });
    begun.get_future().wait();
    server->stop();
    reader.join();
    EXPECT_FALSE(whole);
}

}  // namespace
}  // namespace clerestory::test
