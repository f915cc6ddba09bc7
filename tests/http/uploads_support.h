// Servers for upload tests, each with an empty folder, and frames of uploaded scenes.
#pragma once

#include "tests/support/scene_files.h"
#include "tests/support/soon.h"
#include "tests/support/test_server.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

namespace clerestory::test {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using nlohmann::json;

inline fs::path folderOfThisTest() {
    const auto* info = testing::UnitTest::GetInstance()->current_test_info();
    return fs::path(CLERESTORY_TEST_OUTPUT) / "uploads" / info->name();
}

inline fs::path freshFolder() {
    const fs::path folder = folderOfThisTest();
    fs::remove_all(folder);
    fs::create_directories(folder.parent_path());
    return folder;
}

inline Config uploadConfig() {
    Config config = testConfig();
    config.scenes.uploads.folder = freshFolder();
    config.scenes.uploads.import.cpu = 60s;  // sanitizers are slow
    config.scenes.uploads.import.wallClock = 60s;
    return config;
}

inline constexpr const char* kAny = "application/octet-stream";

inline httplib::Result send(httplib::Client& client, const std::string& content,
                            const char* type = kAny, const std::string& query = "") {
    return client.Post("/v1/scenes" + query, content, type);
}

// "" and a failure without an answer.
inline std::string idOf(const httplib::Result& answer) {
    if (!answer) {
        ADD_FAILURE() << "no answer: " << httplib::to_string(answer.error());
        return "";
    }
    const std::string place = answer->get_header_value("Location");
    EXPECT_THAT(place, testing::StartsWith("/v1/scenes/upload-"));
    return place.substr(place.rfind('/') + 1);
}

inline std::string frameOf(const std::string& id) {
    return R"({"width": 48, "height": 32, "scene": ")" + id + R"(", )" + kPlainEffects + "}";
}

inline json sceneAt(httplib::Client& client, const std::string& id) {
    const auto answer = client.Get("/v1/scenes/" + id);
    return answer && answer->status == 200 ? json::parse(answer->body) : json();
}

inline std::size_t kept(const fs::path& folder) {
    return static_cast<std::size_t>(
        std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
}

// The bytes of a frame, or "" and a failure.
inline std::string pictureOf(httplib::Client& client, const std::string& id) {
    httplib::Result answer(nullptr, httplib::Error::Unknown);
    soon([&] {  // it loads, or the next renderer starts
        answer = postJson(client, "/v1/frames", frameOf(id));
        return !answer || (answer->status != 409 && answer->status != 503);
    });
    if (answer && answer->status == 200) return answer->body;
    ADD_FAILURE() << id << ": " << (answer ? answer->body : "no answer");
    return "";
}

}  // namespace clerestory::test
