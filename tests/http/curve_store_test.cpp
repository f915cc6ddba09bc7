// Stored curves of budgets: found by another process and after a worker ended, and never used if a
// file or what it belongs to has changed.
#include "scene/import/sandbox/jail.h"
#include "server/jobs/budgets.h"
#include "tests/support/soon.h"
#include "tests/support/test_server.h"
#include "tests/unit/import_support.h"

#include <gtest/gtest.h>

#include <csignal>
#include <fstream>

namespace clerestory::test {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

Curve someCurve() {
    Curve curve{.relMseNoise = 1e-4};
    for (const Accuracy& accuracy : curveSettings()) {
        const double n = static_cast<double>(curve.points.size() + 1);
        curve.points.push_back(
            {.accuracy = accuracy, .milliseconds = 10.0 / 3.0 * n, .relMse = 0.1 / n});
    }
    return curve;
}

std::string contentOf(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

void put(const fs::path& file, const std::string& content) {
    std::ofstream(file, std::ios::binary | std::ios::trunc) << content;
}

class CurveStoreTest : public testing::Test {
protected:
    fs::path onlyFile() const {
        std::vector<fs::path> files;
        for (const auto& entry : fs::directory_iterator(place())) files.push_back(entry.path());
        EXPECT_EQ(files.size(), 1u);
        return files.empty() ? fs::path() : files.front();
    }
    fs::path place() const { return folder / "cache"; }
    TemporaryFolder folder;
    CurveStore store{place()};
};

TEST_F(CurveStoreTest, OtherProcessesReadStoredCurves) {
    EXPECT_FALSE(store.find("one"));
    store.keep("one\nkey", someCurve());
    const auto found = CurveStore(place()).find("one\nkey");
    ASSERT_TRUE(found);
    EXPECT_EQ(found->relMseNoise, someCurve().relMseNoise);
    ASSERT_EQ(found->points.size(), curveSettings().size());
    for (std::size_t i = 0; i < found->points.size(); ++i) {
        EXPECT_EQ(found->points[i].accuracy, curveSettings()[i]);
        EXPECT_EQ(found->points[i].milliseconds, someCurve().points[i].milliseconds);
        EXPECT_EQ(found->points[i].relMse, someCurve().points[i].relMse);
    }
    EXPECT_FALSE(store.find("one\nother"));
}

TEST_F(CurveStoreTest, DamagedFilesAreIgnoredAndReplaced) {
    store.keep("key", someCurve());
    const fs::path file = onlyFile();
    const std::string whole = contentOf(file);
    for (std::size_t size = 0; size < whole.size(); ++size) {
        put(file, whole.substr(0, size));
        EXPECT_FALSE(store.find("key")) << size << " bytes";
    }
    for (std::size_t at = 0; at < whole.size(); ++at) {
        std::string damaged = whole;
        damaged[at] = static_cast<char>(damaged[at] ^ 1);
        put(file, damaged);
        EXPECT_FALSE(store.find("key")) << "byte " << at;
    }
    put(file, whole + "x");
    EXPECT_FALSE(store.find("key"));
    store.keep("key", someCurve());
    EXPECT_EQ(contentOf(file), whole);
    EXPECT_TRUE(store.find("key"));
}

TEST_F(CurveStoreTest, KeysWithEqualHashesAreDistinguished) {
    store.keep("key", someCurve());
    const fs::path file = onlyFile();
    store.keep("other", someCurve());
    for (const auto& entry : fs::directory_iterator(place())) {
        if (entry.path() != file)
            fs::copy_file(entry.path(), file, fs::copy_options::overwrite_existing);
    }
    EXPECT_FALSE(store.find("key")) << "it holds the other's";
}

TEST_F(CurveStoreTest, AnUnwritableFolderStoresNothing) {
    put(folder / "file", "");
    const CurveStore nowhere(folder / "file" / "below");
    nowhere.keep("key", someCurve());
    EXPECT_FALSE(nowhere.find("key"));
}

// The worker that measured is killed: the standby, and another server, find the curve.
TEST_F(CurveStoreTest, CurvesOutliveTheirWorker) {
    if (kSanitized) GTEST_SKIP() << "measured in minutes there";
    Config config = testConfig();
    config.singleProcess = false;
    config.workers.program.file = CLERESTORY_PROGRAM;
    config.workers.program.arguments = {"--scene",       "six-walls",     "--log-level",
                                        "off",           "--deadline",    "60",
                                        "--scene-cache", place().string()};
    const std::string body = smallFrame(R"("accuracy": {"maxMilliseconds": 60000})");
    const auto ask = [&](Server& server) {
        httplib::Client client = clientOf(server);
        return postJson(client, "/v1/frames", body);
    };
    std::string picture;
    {
        Server server(config);
        server.start();
        ASSERT_EQ(ask(server)->status, 409);
        ASSERT_TRUE(within(120s, [&] {
            const auto answer = ask(server);
            if (answer->status == 200) picture = answer->body;
            return answer->status == 200;
        }));
        killWorker(server);
        const auto after = ask(server);
        ASSERT_EQ(after->status, 200) << after->body;
        EXPECT_EQ(after->body, picture);
    }
    Server another(config);
    another.start();
    EXPECT_EQ(ask(another)->status, 200) << "nothing is measured again";
    ASSERT_FALSE(fs::is_empty(place()));
}

}  // namespace
}  // namespace clerestory::test
