// The routes of uploads alone: which calls wait for their scenes. The renderer is a stand-in.
#include "server/api/uploads.h"

#include <gtest/gtest.h>

#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <string>

namespace clerestory::test {
namespace {

// Its scenes are loaded when their report was read that many times.
class SlowBackend final : public RenderBackend {
public:
    explicit SlowBackend(int reportsUntilLoaded) : left_(reportsUntilLoaded) {}
    SceneReport sceneReport(const std::string&) override {
        ++reports;
        if (left_ > 0) --left_;
        return {.state = left_ == 0 ? SceneState::ready : SceneState::loading, .description = "{}"};
    }
    Answer answer(const Call&) override { return {}; }
    std::optional<Problem> refusalFor(const std::string&) const override { return std::nullopt; }
    EncodedFrame draw(const FrameOrder&) override { return {}; }
    std::shared_ptr<const LoadedScenes> loadedScenes() const override { return nullptr; }
    std::optional<WorkerStatus> workerStatus() const override { return std::nullopt; }
    bool importing() const override { return false; }
    void stop() override {}

    int reports = 0;

private:
    int left_;
};

class UploadWaits : public testing::Test {
protected:
    UploadWaits() {
        std::string pattern =
            (std::filesystem::temp_directory_path() / "clerestory-waits-XXXXXX").string();
        folder_ = mkdtemp(pattern.data());
    }
    ~UploadWaits() override { std::filesystem::remove_all(folder_); }

    // POST of a scene by that client.
    Answer upload(SlowBackend& backend, const std::string& client, const char* prefer = "") {
        UploadStore store(folder_, {});
        Routes routes;
        addRoutes(routes,
                  UploadRoutes{backend, &store, std::chrono::seconds(60), stopping_, holdings});
        Call call{.method = "POST", .path = "/v1/scenes", .client = client};
        call.body = std::string("glTF\2\0\0\0\14\0\0\0", 12);
        call.arrived = Clock::now();
        call.header = [prefer](const char* name) -> std::string {
            const std::string_view wanted = name;
            if (wanted == "Prefer") return prefer;
            return wanted == "Content-Type" ? "application/octet-stream" : "";
        };
        std::string route;
        return *routes.answer(call, route);
    }

    Holdings holdings{{{Pool::waits, {.most = 8}}}};

private:
    std::filesystem::path folder_;
    std::atomic<bool> stopping_{false};
};

TEST_F(UploadWaits, AnUploadWaitsForItsScene) {
    SlowBackend backend(3);
    EXPECT_EQ(upload(backend, "ann").status, 201);
    EXPECT_EQ(backend.reports, 3);
    EXPECT_EQ(holdings.usage(Pool::waits).total, 0u) << "the share ends with the call";
}

TEST_F(UploadWaits, AClientWithFourWaitingCallsIsAnsweredAtOnce) {
    const auto waiting = holdings.take(Pool::waits, "ann", 4);
    ASSERT_TRUE(waiting);
    SlowBackend backend(3);
    const Answer answer = upload(backend, "ann");
    EXPECT_EQ(answer.status, 202);
    EXPECT_EQ(backend.reports, 1) << "it does not wait";
    ASSERT_FALSE(answer.headers.empty());
    EXPECT_EQ(answer.headers[0].first, "Location");
    EXPECT_EQ(upload(backend, "ben").status, 200) << "another client waits; the file is known";
    EXPECT_EQ(backend.reports, 3);
}

TEST_F(UploadWaits, AnAsynchronousUploadTakesNoShare) {
    SlowBackend backend(3);
    EXPECT_EQ(upload(backend, "ann", "respond-async").status, 202);
    EXPECT_EQ(backend.reports, 1);
}

}  // namespace
}  // namespace clerestory::test
