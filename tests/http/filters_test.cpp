// Filters over HTTP: equal to the CPU's, and part of the plan and the ETag.
#include "tests/support/filter_truth.h"
#include "tests/support/test_server.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>

namespace clerestory::test {
namespace {

using nlohmann::json;

constexpr int kWidth = 64, kHeight = 48;  // of smallFrame()

httplib::Result frameWith(const std::string& filters, const char* format) {
    auto client = sharedServer().client();
    auto result = postJson(client, "/v1/frames",
                           smallFrame(R"("output": {"format": ")" + std::string(format) +
                                      R"("}, "filters": )" + filters));
    EXPECT_TRUE(result && result->status == 200) << (result ? result->body : "no answer");
    return result;
}

// The last bytes of an .npy file are its numbers.
Picture lightWith(const std::string& filters) {
    const std::string body = frameWith(filters, "npy")->body;
    Picture picture(kWidth, kHeight);
    std::vector<float> numbers(3 * picture.pixels.size());
    const std::size_t bytes = numbers.size() * sizeof(float);
    EXPECT_GT(body.size(), bytes);
    if (body.size() <= bytes) return picture;
    std::memcpy(numbers.data(), body.data() + body.size() - bytes, bytes);
    for (std::size_t i = 0; i < picture.pixels.size(); ++i) {
        picture.pixels[i] = {numbers[3 * i], numbers[3 * i + 1], numbers[3 * i + 2]};
    }
    return picture;
}

TEST(FiltersOverHttp, MatchTheCpuInTheRequestedOrder) {
    const Picture plain = lightWith("[]");
    const auto expectNear = [&](const std::string& filters, const Picture& expected) {
        EXPECT_LT(greatestDifference(lightWith(filters), expected), 1e-4) << filters;
    };
    expectNear(R"([{"type": "twirl", "amount": 2.5, "radius": 20}])", twirled(plain, 2.5, 20));
    expectNear(R"([{"type": "convolve", "kernel": "sharpen", "edge": "repeat"}])",
               convolved(plain, {0, -1, 0, -1, 5, -1, 0, -1, 0}, true));
    expectNear(R"([{"type": "glow", "threshold": 0.3, "strength": 0.75, "radius": 6}])",
               glowing(plain, 0.3, 0.75, 6));
    expectNear(
        R"([{"type": "glow"}, {"type": "convolve", "kernel": [1, 0, 0, 0, 0, 0, 0, 0, 1]},
            {"type": "twirl", "amount": -1}])",
        twirled(convolved(glowing(plain, 1, 0.5, 32), {1, 0, 0, 0, 0, 0, 0, 0, 1}, false), -1));
}

TEST(FiltersOverHttp, WithoutEffectGiveTheBytesOfNoFilter) {
    for (const char* format : {"jpeg", "png", "npy", "exr"}) {
        const std::string plain = frameWith("[]", format)->body;
        for (const char* filters :
             {R"([{"type": "twirl", "amount": 0}])",
              R"([{"type": "convolve", "kernel": [0, 0, 0, 0, 1, 0, 0, 0, 0]}])",
              R"([{"type": "glow", "strength": 0}])"}) {
            EXPECT_EQ(frameWith(filters, format)->body, plain) << format << " " << filters;
        }
        EXPECT_NE(frameWith(R"([{"type": "twirl", "amount": 1}])", format)->body, plain);
    }
}

// Each type has its own members: a missing one, a foreign one and an unknown type name the field.
TEST(FiltersOverHttp, OfTheWrongShapeNameTheField) {
    auto client = sharedServer().client();
    for (const auto& [filters, pointer] : {
             std::pair(R"([{"amount": 1}])", "/filters/0/type"),
             std::pair(R"([{"type": "blur"}])", "/filters/0/type"),
             std::pair(R"([{"type": "twirl"}])", "/filters/0/amount"),
             std::pair(R"([{"type": "glow"}, {"type": "convolve"}])", "/filters/1/kernel"),
             std::pair(R"([{"type": "glow", "amount": 1}])", "/filters/0/amount"),
         }) {
        const auto result =
            postJson(client, "/v1/frames", smallFrame(R"("filters": )" + std::string(filters)));
        const json problem = problemOf(result, 422);
        ASSERT_EQ(problem.at("errors").size(), 1u) << problem;
        EXPECT_EQ(problem.at("errors")[0].at("pointer"), pointer) << problem;
    }
}

TEST(FiltersOverHttp, AppearInPlanHeadersAndETag) {
    const std::string glow = R"([{"type": "twirl", "amount": 0}, {"type": "glow", "radius": 4}])";
    const auto frame = frameWith(glow, "png");
    EXPECT_THAT(
        frame->get_header_value("Clerestory-Passes"),
        testing::HasSubstr("filter1:glow, filter1:glow, filter1:glow, filter1:glow, toneMap"));
    EXPECT_THAT(frame->get_header_value("Server-Timing"), testing::HasSubstr("glowBright;dur="));
    EXPECT_NE(frame->get_header_value("ETag"), frameWith("[]", "png")->get_header_value("ETag"));

    auto client = sharedServer().client();
    const auto answer = postJson(client, "/v1/plans", smallFrame(R"("filters": )" + glow));
    ASSERT_EQ(answer->status, 200) << answer->body;
    const json plan = json::parse(answer->body);
    std::size_t passes = 0;
    for (const json& pass : plan["passes"]) passes += pass["effect"] == "filters";
    EXPECT_EQ(passes, 4u);
    const auto about = std::find_if(plan["skipped"].begin(), plan["skipped"].end(), [](auto& s) {
        return s["name"] == "filter0:twirl" && s["effect"] == "filters";
    });
    ASSERT_NE(about, plan["skipped"].end());
    EXPECT_EQ((*about)["reason"], "an amount of 0 changes nothing");
}

}  // namespace
}  // namespace clerestory::test
