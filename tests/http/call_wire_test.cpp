// Messages between the server and its workers: nothing is lost, and damaged bytes do no harm.
#include "server/worker/messages.h"

#include "server/api/frame_json.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace clerestory::test {
namespace {

TEST(CallWire, RoundTripPreservesEverything) {
    Call call{.method = "GET",
              .path = "/v1/frames",
              .query = {{"eye", "1,2,3"}, {"eye", ""}},
              .body = std::string("\0{}", 3),
              .requestId = "id-1",
              .arrived = Clock::now(),
              .header = [](const char* name) { return std::string("h:") + name; },
              .client = "10.0.0.1"};
    const Call back = unpackedCall(packed(call));
    EXPECT_EQ(back.method, call.method);
    EXPECT_EQ(back.path, call.path);
    EXPECT_EQ(back.query, call.query);
    EXPECT_EQ(back.body, call.body);
    EXPECT_EQ(back.requestId, call.requestId);
    EXPECT_EQ(back.arrived, call.arrived);
    EXPECT_EQ(back.client, call.client);
    EXPECT_EQ(back.header("Accept"), "h:Accept");
    EXPECT_EQ(back.header("Authorization"), "") << "no worker needs it";

    const Answer answer{.status = 422,
                        .type = "image/jpeg",
                        .body = std::string(100'000, 'x'),
                        .headers = {{"ETag", "\"1\""}},
                        .route = "/v1/frames",
                        .problem = Problem{.status = 422,
                                           .code = ProblemCode::quarantined,
                                           .errors = {{"/a", "b", "c"}},
                                           .retryAfterSeconds = 7},
                        .job = JobEvent{JobEvent::Kind::unknown, "id"}};
    const Answer again = unpackedAnswer(packed(answer));
    EXPECT_EQ(again.status, answer.status);
    EXPECT_EQ(again.type, answer.type);
    EXPECT_EQ(again.body, answer.body);
    EXPECT_EQ(again.headers, answer.headers);
    EXPECT_EQ(again.route, answer.route);
    ASSERT_TRUE(again.problem);
    EXPECT_EQ(again.problem->code, answer.problem->code);
    EXPECT_EQ(again.problem->errors, answer.problem->errors);
    EXPECT_EQ(again.problem->retryAfterSeconds, answer.problem->retryAfterSeconds);
    ASSERT_TRUE(again.job);
    EXPECT_EQ(again.job->kind, answer.job->kind);
    EXPECT_EQ(again.job->id, answer.job->id);
}

TEST(CallWire, AFrameComesBackWithItsCamera) {
    EncodedFrame frame{.type = "image/png",
                       .bytes = "x",
                       .lightShare = 0.3,
                       .passMilliseconds = 0.1,
                       .plan = "{}"};
    EXPECT_FALSE(unpackedFrame(packed(frame)).camera);
    FrameCamera& camera = frame.camera.emplace();
    camera.cameraToWorld[3] = {0.1, 1e-9, -3.0, 1.0};
    camera.clipFromView.emplace(1.0)[1][1] = 0.3;
    camera.width = 33;
    camera.znear = 0.7;
    camera.intrinsics = Intrinsics{.fx = 0.3};
    const EncodedFrame back = unpackedFrame(packed(frame));
    EXPECT_EQ(back.passMilliseconds, frame.passMilliseconds);
    EXPECT_EQ(back.plan, frame.plan);
    EXPECT_EQ(back.lightShare, frame.lightShare);
    ASSERT_TRUE(back.camera);
    EXPECT_EQ(cameraJson(*back.camera), cameraJson(camera));
}

TEST(CallWire, AFrameOrderComesBackWithEveryBit) {
    FrameOrder order{
        .withPlan = true, .requestId = "id-1", .arrived = Clock::now(), .wholeLight = true};
    FrameRequest& request = order.request;
    request = frameRequestFrom(nlohmann::json::parse(R"({
        "scene": "a", "width": 33, "time": 0.1, "clip": "",
        "camera": {"position": [0.1, 1e-9, -3], "orientation": [0.1, 0.1, 0.7, 0.7],
                   "intrinsics": {"fx": 0.3, "pixelCenter": "integer"}},
        "accuracy": {"preset": "fine", "planarScale": 0.3, "parallax": "depth"},
        "effects": {"refraction": false},
        "environment": {"map": "sky", "rotation": [0.1, 0.2, 0.3], "intensity": 0.7},
        "overrides": [{"material": "m", "baseColor": [0.1, 0.2, 0.3], "reflection": "mirror"}],
        "filters": [{"type": "convolve", "kernel": [1, 2, 3, 4, 5, 6, 7, 8, 0.1]},
                    {"type": "convolve", "kernel": "box"}, {"type": "glow", "radius": 3}],
        "toneMap": "aces", "output": {"format": "png"}})"));
    const FrameOrder back = unpackedFrameOrder(packed(order));
    EXPECT_EQ(canonicalText(back.request), canonicalText(request));
    EXPECT_EQ(back.withPlan, order.withPlan);
    EXPECT_EQ(back.wholeLight, order.wholeLight);
    EXPECT_EQ(back.requestId, order.requestId);
    EXPECT_EQ(back.arrived, order.arrived);
    EXPECT_EQ(packed(back), packed(order));
    const std::string bytes = packed(order);
    for (std::size_t n = 0; n < bytes.size(); ++n) {
        EXPECT_THROW(unpackedFrameOrder(bytes.substr(0, n)), std::runtime_error) << n;
    }
}

TEST(CallWire, IdsKeepTheirOrder) {
    const std::vector<std::string> ids = {"b", "", "a scene\n", "a"};
    EXPECT_EQ(unpackedTexts(packed(ids)), ids);
    EXPECT_EQ(unpackedTexts(""), std::vector<std::string>{});
    EXPECT_THROW(unpackedTexts(packed(ids).substr(1)), std::runtime_error);
}

TEST(CallWire, LoadedScenesComeBack) {
    const LoadedScenes scenes{
        .defaultScene = "a", .renderer = 7, .scenes = {{"b", 1}, {"a", ~0ull}}};
    EXPECT_EQ(unpackedScenes(packed(scenes)), scenes);
    EXPECT_THROW(unpackedScenes(packed(scenes).substr(1)), std::runtime_error);
}

TEST(CallWire, TruncatedAndCorruptedBytesAreRejectedOrRead) {
    const std::string bytes = packed(Call{.method = "POST",
                                          .path = "/v1/frames",
                                          .body = R"({"scene":"six-walls"})",
                                          .requestId = "test"});
    for (std::size_t n = 0; n < bytes.size(); ++n) {
        EXPECT_THROW(unpackedCall(bytes.substr(0, n)), std::runtime_error) << n;
        for (const int flip : {1, 0x80, 0xff}) {
            std::string other = bytes;
            other[n] = static_cast<char>(other[n] ^ flip);
            try {
                unpackedCall(other);
            } catch (const std::runtime_error&) {
            }
        }
    }
}

}  // namespace
}  // namespace clerestory::test
