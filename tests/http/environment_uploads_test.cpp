// Uploaded environment maps: the light of a frame, rejections and their reasons, deletion, memory.
#include "tests/http/uploads_support.h"
#include "tests/support/temporary_folder.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <future>

namespace clerestory::test {
namespace {

using testing::Contains;
using testing::HasSubstr;
using Rgbe = std::array<unsigned char, 4>;

std::string hdrHeader(int width) {
    return "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y " + std::to_string(width / 2) + " +X " +
           std::to_string(width) + "\n";
}

// A panorama of 16 x 8 with a bright upper half, so that directions matter.
std::string smallMap(unsigned char red) {
    std::string file = hdrHeader(16);
    for (int pixel = 0; pixel < 16 * 8; ++pixel) {
        const Rgbe color = pixel < 64 ? Rgbe{red, 200, 255, 130} : Rgbe{128, 64, 32, 126};
        file.append(color.begin(), color.end());
    }
    return file;
}

// One colour in lines of run lengths: 8 MB of texels in 0.5 MB.
std::string largeMap(unsigned char red) {
    constexpr int kWidth = 4096;
    std::string line = {2, 2, static_cast<char>(kWidth >> 8), static_cast<char>(kWidth & 255)};
    for (const unsigned char value : Rgbe{red, 128, 128, 129}) {
        for (int left = kWidth; left > 0; left -= 127) {
            line += static_cast<char>(128 + std::min(left, 127));
            line += static_cast<char>(value);
        }
    }
    std::string file = hdrHeader(kWidth);
    for (int y = 0; y < kWidth / 2; ++y) file += line;
    return file;
}

httplib::Result sendMap(httplib::Client& client, const std::string& content,
                        const char* type = kAny, const std::string& query = "") {
    return client.Post("/v1/environments" + query, content, type);
}

std::string nameIn(const httplib::Result& answer) {
    EXPECT_TRUE(answer && (answer->status == 200 || answer->status == 201)) << answer->body;
    const std::string name = json::parse(answer->body)["name"];
    EXPECT_EQ(answer->get_header_value("Location"), "/v1/environments/" + name);
    return name;
}

// From outside of the six walls, so that the map is behind them.
std::string frameIn(const std::string& map) {
    return smallFrame(R"("camera": {"position": [0, 1, 20], "target": [0, 1, 0]}, )"
                      R"("environment": {"map": ")" +
                      map + "\"}");
}

std::string pictureIn(httplib::Client& client, const std::string& map) {
    const auto answer = postUntilReady(client, "/v1/frames", frameIn(map));
    EXPECT_TRUE(answer && answer->status == 200) << (answer ? answer->body : "");
    return answer ? answer->body : "";
}

std::vector<std::string> listed(httplib::Client& client) {
    std::vector<std::string> names;
    const json list = json::parse(client.Get("/v1/environments")->body);
    for (const json& map : list["environments"]) names.push_back(map["name"]);
    return names;
}

TEST(EnvironmentUploads, LightAFrameAsTheSameFileOfTheOptions) {
    const TemporaryFolder folder;
    Config config = uploadConfig();
    config.scenes.environments = {folder.write("halves.hdr", smallMap(90))};
    TestServer server(config);
    auto client = server.client();
    const auto made = sendMap(client, smallMap(90), "image/vnd.radiance", "?title=Two%20halves");
    ASSERT_TRUE(made);
    ASSERT_EQ(made->status, 201) << made->body;
    const std::string name = nameIn(made);
    const json map = json::parse(made->body);
    EXPECT_EQ(map["title"], "Two halves");
    EXPECT_EQ(map["source"], "uploaded");
    EXPECT_EQ(map["sun"], false);
    EXPECT_GT(map["meanRadiance"], 0.5);

    const std::string picture = pictureIn(client, name);
    EXPECT_EQ(picture, pictureIn(client, "halves"));
    EXPECT_NE(picture, pictureIn(client, "studio"));
    const std::string other = nameIn(sendMap(client, smallMap(250)));
    EXPECT_NE(pictureIn(client, other), picture);
    EXPECT_EQ(pictureIn(client, name), picture);
    EXPECT_EQ(sendMap(client, smallMap(90))->status, 200) << "the same content again";
    EXPECT_THAT(listed(client),
                testing::IsSupersetOf({std::string("sky"), std::string("halves"), name, other}));
    EXPECT_EQ(json::parse(client.Get("/v1/environments/halves")->body)["source"], "file");

    // As a map that a surface reflects.
    const auto reflecting = [&](const std::string& reflected) {
        return postJson(
            client, "/v1/frames",
            smallFrame(R"("overrides": [{"material": "mirror", "metallic": 1, "roughness": 0, )"
                       R"("environmentMap": ")" +
                       reflected + "\"}]"));
    };
    const auto first = reflecting(name);
    ASSERT_EQ(first->status, 200) << first->body;
    EXPECT_EQ(first->body, reflecting("halves")->body);
    EXPECT_NE(first->body, reflecting(other)->body);
}

TEST(EnvironmentUploads, AreGoneWhenDeleted) {
    Config config = uploadConfig();
    config.frameCacheBytes = 64 << 20;
    TestServer server(config);
    auto client = server.client();
    const std::string name = nameIn(sendMap(client, smallMap(90)));
    const std::string other = nameIn(sendMap(client, smallMap(250)));
    const std::string picture = pictureIn(client, name);
    pictureIn(client, other);
    const auto isStored = [&](const std::string& map) {
        return postJson(client, "/v1/frames", frameIn(map))->has_header("Age");
    };
    EXPECT_TRUE(isStored(name) && isStored(other)) << "both frames are in the frame cache";
    EXPECT_EQ(client.Delete("/v1/environments/" + name)->status, 204);
    EXPECT_TRUE(isStored(other));
    const json problem = problemOf(postJson(client, "/v1/frames", frameIn(name)), 422);
    EXPECT_EQ(problem["errors"][0]["pointer"], "/environment/map");
    problemOf(client.Get("/v1/environments/" + name), 404);
    problemOf(client.Delete("/v1/environments/" + name), 404);
    EXPECT_THAT(listed(client), testing::Not(Contains(name)));
    EXPECT_EQ(kept(folderOfThisTest()), 1u);
    EXPECT_EQ(nameIn(sendMap(client, smallMap(90))), name);
    EXPECT_EQ(pictureIn(client, name), picture);
    problemOf(client.Delete("/v1/environments/sky"), 403);
    const json near = problemOf(client.Get("/v1/environments/stduio"), 404);
    EXPECT_THAT(near["detail"].get<std::string>(), HasSubstr("studio"));
}

TEST(EnvironmentUploads, WhatIsNoMapIsRefusedWithItsReason) {
    TestServer server(uploadConfig());
    auto client = server.client();
    for (const std::string& damaged : {smallMap(90).substr(0, 200), std::string("#?RADIANCE\n"),
                                       hdrHeader(2'000'000'000), std::string("DDS nothing")}) {
        const json problem = problemOf(sendMap(client, damaged), 422);
        EXPECT_EQ(problem["code"], "mapFailed") << problem;
        EXPECT_FALSE(problem["reason"].get<std::string>().empty());
    }
    EXPECT_EQ(kept(folderOfThisTest()), 0u) << "refused files are not kept";
    const json scene = problemOf(sendMap(client, triangleGlb()), 415);
    EXPECT_THAT(scene["detail"].get<std::string>(), HasSubstr(".exr"));
    problemOf(sendMap(client, smallMap(90), "image/x-exr"), 415);
    problemOf(sendMap(client, smallMap(90), kAny, "?tilte=x"), 422);
    const json map = problemOf(send(client, smallMap(90)), 415);
    EXPECT_THAT(map["detail"].get<std::string>(), HasSubstr("/v1/environments"));
    auto without = sharedServer().client();
    problemOf(sendMap(without, smallMap(90)), 403);
}

// An importer that does not begin before the gate is open.
class GatedImporter {
public:
    GatedImporter() {
        mkfifo(pipe_.c_str(), 0600);
        folder_.write("importer", "#!/bin/sh\n: < " + pipe_.string() +
                                      "\nexec " CLERESTORY_PROGRAM " \"$@\"\n");
        fs::permissions(program(), fs::perms::owner_all);
    }
    ~GatedImporter() {
        if (end_ >= 0) close(end_);
    }
    GatedImporter(const GatedImporter&) = delete;
    GatedImporter& operator=(const GatedImporter&) = delete;
    fs::path program() const { return folder_.path() / "importer"; }
    // A pipe with a writer can be opened for reading.
    void open() { end_ = ::open(pipe_.c_str(), O_RDWR | O_CLOEXEC); }

private:
    const TemporaryFolder folder_;
    const fs::path pipe_ = folder_.path() / "gate";
    int end_ = -1;
};

Config gatedConfig(const GatedImporter& importer) {
    Config config = uploadConfig();
    config.scenes.import.importer = importer.program();
    config.http.threads = 3 * kMaxWaitingForMaps;
    return config;
}

std::string storeMap(const std::string& content) {
    return UploadStore(folderOfThisTest(), {}).add("hdr", "map", content).id;
}

TEST(EnvironmentUploads, FewRequestsWaitForAMapThatLoads) {
    GatedImporter importer;
    TestServer server(gatedConfig(importer));
    server.awaitReady();
    const EnvironmentLibrary& library = server.backend().library().environments();
    const std::string map = storeMap(smallMap(90));
    constexpr std::size_t kRequests = 2 * kMaxWaitingForMaps;
    std::vector<std::future<int>> frames;
    for (std::size_t i = 0; i < kRequests; ++i) {
        frames.push_back(std::async(std::launch::async, [&] {
            auto client = server.client();
            const auto answer = postJson(client, "/v1/frames", frameIn(map));
            return answer ? answer->status : 0;
        }));
    }
    std::size_t refused = 0;
    EXPECT_TRUE(soon([&] {
        EXPECT_LE(library.waitingCalls(), kMaxWaitingForMaps);
        refused = 0;
        for (const auto& frame : frames) {
            refused += frame.wait_for(0s) == std::future_status::ready;
        }
        return refused >= kRequests - kMaxWaitingForMaps;
    })) << "more requests than that wait for the map";

    auto client = server.client();
    EXPECT_EQ(client.Get("/v1/scenes")->status, 200);
    EXPECT_EQ(postJson(client, "/v1/frames", smallFrame())->status, 200);
    EXPECT_FALSE(pictureIn(client, "studio").empty()) << "another map";
    const auto hurried = client.Post("/v1/frames", httplib::Headers{{"Clerestory-Deadline", "1"}},
                                     frameIn(map), "application/json");
    EXPECT_EQ(problemOf(hurried, 409)["code"], "stillLoading");
    EXPECT_EQ(hurried->get_header_value("Retry-After"), "1");

    importer.open();
    for (auto& frame : frames) EXPECT_THAT(frame.get(), testing::AnyOf(200, 409));
    EXPECT_EQ(postUntilReady(client, "/v1/frames", frameIn(map))->status, 200);
    EXPECT_EQ(library.waitingCalls(), 0u);
}

TEST(EnvironmentUploads, AFailureIsReportedAlsoAfterAConflict) {
    GatedImporter importer;
    TestServer server(gatedConfig(importer));
    auto client = server.client();
    const std::string map = storeMap(smallMap(90).substr(0, 200));
    const auto hurried = client.Post("/v1/frames", httplib::Headers{{"Clerestory-Deadline", "1"}},
                                     frameIn(map), "application/json");
    problemOf(hurried, 409);
    importer.open();
    const json problem = problemOf(postUntilReady(client, "/v1/frames", frameIn(map)), 422);
    EXPECT_EQ(problem["code"], "mapFailed");
    EXPECT_EQ(problem["errors"][0]["pointer"], "/environment/map");
}

TEST(EnvironmentUploads, AnUploadIsAnsweredWhenItsMapIsLoaded) {
    GatedImporter importer;
    TestServer server(gatedConfig(importer));
    auto posted = std::async(std::launch::async, [&] {
        auto client = server.client();
        return sendMap(client, smallMap(90));
    });
    EXPECT_TRUE(
        soon([&] { return server.backend().library().environments().waitingCalls() == 1; }));
    importer.open();
    const auto answer = posted.get();
    ASSERT_TRUE(answer);
    EXPECT_EQ(answer->status, 201) << answer->body;
}

TEST(EnvironmentUploads, OfAnyNumberTakeBoundedMemory) {
    TestServer server(uploadConfig());
    auto client = server.client();
    const EnvironmentLibrary& library = server.backend().library().environments();
    std::vector<std::string> names, pictures;
    for (const unsigned char red : {100, 150, 200}) {
        names.push_back(nameIn(sendMap(client, largeMap(red))));
        pictures.push_back(pictureIn(client, names.back()));
        EXPECT_LE(library.uploadedBytes(), kUploadedMapBytes);
    }
    EXPECT_GT(library.uploadedBytes(), kUploadedMapBytes / 2) << "the test is about large maps";
    EXPECT_NE(pictures[0], pictures[2]);
    EXPECT_EQ(pictureIn(client, names[0]), pictures[0]) << "evicted, and loaded again";
    EXPECT_LE(library.uploadedBytes(), kUploadedMapBytes);
}

}  // namespace
}  // namespace clerestory::test
