// `clerestory sequence`: a folder of frames, and resuming it.
#include "tests/support/program.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace clerestory::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::HasSubstr;

class SequenceCommand : public testing::Test {
protected:
    void SetUp() override {
        fs::remove_all(folder);
        fs::create_directories(folder.parent_path());
        ask(0.0);
    }
    void ask(double shift) const {
        json frames = json::array();
        for (int i = 0; i < 4; ++i) {
            frames.push_back(
                {{"camera", {{"position", {shift + 0.3 * i, 1, 2}}, {"target", {0, 1, 0}}}}});
        }
        const json body = {{"common", {{"width", 32}, {"height", 24}}},
                           {"frames", frames},
                           {"channels", {{"objectId", true}}}};
        std::ofstream(request) << body;
    }
    Outcome sequence() const {
        return run("sequence six-walls --request '" + request.string() + "' -o '" +
                   folder.string() + "'");
    }

    const fs::path folder = fs::path(CLERESTORY_TEST_OUTPUT) / "sequence" / "frames";
    const fs::path request = fs::path(CLERESTORY_TEST_OUTPUT) / "sequence" / "request.json";
};

TEST_F(SequenceCommand, AnInterruptedSequenceResumes) {
    const Outcome first = sequence();
    ASSERT_EQ(first.exitCode, 0) << first.output;
    const std::string second = contentOf(folder / "000001.jpg");
    const std::string manifest = contentOf(folder / "manifest.json");
    EXPECT_THAT(first.output, HasSubstr("drawing  25 %"));
    EXPECT_THAT(first.output, HasSubstr("drawing 100 %"));
    EXPECT_GT(second.size(), 100u);
    EXPECT_EQ(json::parse(manifest)["frames"].size(), 4u);
    EXPECT_TRUE(fs::exists(folder / "000003.objectId.npy"));

    // The state after a run that ended in frame 1: two frames lack their last file.
    fs::remove(folder / "000001.json");
    fs::remove(folder / "000001.objectId.npy");
    fs::remove(folder / "000002.json");
    fs::remove(folder / "manifest.json");
    const auto untouched = fs::last_write_time(folder / "000000.jpg");
    const Outcome again = sequence();
    ASSERT_EQ(again.exitCode, 0) << again.output;
    EXPECT_THAT(again.output, HasSubstr("4 frames"));
    EXPECT_THAT(again.output, HasSubstr("2 of them from an earlier run"));
    EXPECT_EQ(fs::last_write_time(folder / "000000.jpg"), untouched);
    EXPECT_EQ(contentOf(folder / "000001.jpg"), second);
    EXPECT_TRUE(fs::exists(folder / "000001.objectId.npy"));
    EXPECT_EQ(json::parse(contentOf(folder / "manifest.json"))["frames"].size(), 4u);
    for (const auto& entry : fs::directory_iterator(folder)) {
        EXPECT_NE(entry.path().extension(), ".part") << entry.path();
    }
}

// The same request gives the same film, and names what a film cannot have.
TEST_F(SequenceCommand, AFilmIsOneFile) {
    const auto film = [&](const char* name, const char* more) {
        std::ofstream(request) << R"({"common": {"width": 32, "height": 24}, "turntable": )"
                                  R"({"seconds": 1, "frameRate": 4})" +
                                      std::string(more) + "}";
        return run("sequence six-walls --request '" + request.string() + "' -o '" +
                   (folder.parent_path() / name).string() + "'");
    };
    for (const char* name : {"film.mp4", "film.webp"}) {
        const fs::path file = folder.parent_path() / name;
        fs::remove(file);
        const Outcome outcome = film(name, "");
        ASSERT_EQ(outcome.exitCode, 0) << outcome.output;
        EXPECT_THAT(outcome.output, HasSubstr("4 frames in"));
        const std::string once = contentOf(file);
        EXPECT_FALSE(fs::exists(file.string() + ".part"));
        ASSERT_EQ(film(name, "").exitCode, 0);
        EXPECT_EQ(contentOf(file), once);
    }
    EXPECT_EQ(contentOf(folder.parent_path() / "film.mp4").substr(4, 4), "ftyp");
    EXPECT_EQ(contentOf(folder.parent_path() / "film.webp").substr(0, 4), "RIFF");
    const Outcome refused = film("other.mp4", R"(, "channels": {"depth": true})");
    EXPECT_EQ(refused.exitCode, 2);
    EXPECT_THAT(refused.output, HasSubstr("channels/depth"));
    EXPECT_FALSE(fs::exists(folder.parent_path() / "other.mp4"));
}

TEST_F(SequenceCommand, ForeignFoldersAreNotChanged) {
    ASSERT_EQ(sequence().exitCode, 0);
    const std::string before = contentOf(folder / "000000.jpg");
    ask(0.5);
    const Outcome other = sequence();
    EXPECT_EQ(other.exitCode, 2);
    EXPECT_THAT(other.output, HasSubstr("another sequence"));
    EXPECT_EQ(contentOf(folder / "000000.jpg"), before);
}

TEST_F(SequenceCommand, ErrorsAreExplained) {
    std::ofstream(request) << R"({"frames": [{"widht": 3}]})";
    const Outcome outcome = sequence();
    EXPECT_EQ(outcome.exitCode, 2);
    EXPECT_THAT(outcome.output, HasSubstr("/frames/0/widht"));
    EXPECT_FALSE(fs::exists(folder));
}

}  // namespace
}  // namespace clerestory::test
