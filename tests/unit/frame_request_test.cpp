// Rules that involve several fields of a request.
#include "plan/request/frame_request.h"

#include <gmock/gmock.h>

#include <functional>

namespace clerestory::test {
namespace {

using testing::ElementsAre;
using testing::Field;
using testing::IsEmpty;

TEST(FrameRequest, TheDefaultIsValid) {
    EXPECT_THAT(problems(FrameRequest{}), IsEmpty());
}

struct Wrong {
    const char* name;
    const char* pointer;
    std::function<void(FrameRequest&)> spoil;
};

class InvalidFrameRequest : public testing::TestWithParam<Wrong> {};

TEST_P(InvalidFrameRequest, NamesTheField) {
    FrameRequest request;
    GetParam().spoil(request);
    EXPECT_THAT(problems(request), ElementsAre(Field(&FieldError::pointer, GetParam().pointer)));
}

const glm::dvec3 kOrigin(0.0), kOne(1.0);

INSTANTIATE_TEST_SUITE_P(
    Rules, InvalidFrameRequest,
    testing::Values(
        Wrong{"targetIsPosition", "/camera/target",
              [](auto& r) { r.camera.position = r.camera.target = kOne; }},
        Wrong{"positionAlone", "/camera/position", [](auto& r) { r.camera.position = kOne; }},
        Wrong{"targetAlone", "/camera/target", [](auto& r) { r.camera.target = kOne; }},
        Wrong{"orientationAlone", "/camera/orientation",
              [](auto& r) {
                  r.camera.orientation = {0, 0, 0, 1};
              }},
        Wrong{"twoDirections", "/camera/orientation",
              [](auto& r) {
                  r.camera.position = kOrigin;
                  r.camera.target = kOne;
                  r.camera.orientation = {0, 0, 0, 1};
              }},
        Wrong{"zeroUp", "/camera/up",
              [](auto& r) {
                  r.camera.position = kOrigin;
                  r.camera.target = kOne;
                  r.camera.up = kOrigin;
              }},
        Wrong{"upAlone", "/camera/up", [](auto& r) { r.camera.up = kOne; }},
        Wrong{"longQuaternion", "/camera/orientation",
              [](auto& r) {
                  r.camera.position = kOrigin;
                  r.camera.orientation = {0, 0, 0, 2};
              }},
        Wrong{"zeroQuaternion", "/camera/orientation",
              [](auto& r) {
                  r.camera.position = kOrigin;
                  r.camera.orientation = {0, 0, 0, 0};
              }},
        Wrong{"scaledMatrix", "/camera/cameraToWorld",
              [](auto& r) {
                  r.camera.cameraToWorld = {2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 1};
              }},
        Wrong{"mirroredMatrix", "/camera/cameraToWorld",
              [](auto& r) {
                  r.camera.cameraToWorld = {-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
              }},
        Wrong{"matrixAndName", "/camera/cameraToWorld",
              [](auto& r) {
                  r.camera.cameraToWorld = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
                  r.camera.name = "a";
              }},
        Wrong{"conventionAlone", "/camera/convention",
              [](auto& r) { r.camera.convention = Convention::opencv; }},
        Wrong{"twoLenses", "/camera/intrinsics",
              [](auto& r) {
                  r.camera.yfov = 1.0;
                  r.camera.intrinsics = Intrinsics{};
              }},
        Wrong{"farBeforeNear", "/camera/zfar",
              [](auto& r) {
                  r.camera.znear = 2.0;
                  r.camera.zfar = 1.0;
              }},
        Wrong{"tooManyPixels", "/width", [](auto& r) { r.width = r.height = kMaxEdge; }},
        Wrong{"turnedMap", "/environment/rotation",
              [](auto& r) {
                  r.environment.rotation = {0, 0, 0, 3};
              }},
        Wrong{"depthInJpeg", "/output/format", [](auto& r) { r.output.channel = Channel::depth; }},
        Wrong{"classesMissing", "/output/classes",
              [](auto& r) {
                  r.output = {.format = OutputFormat::npy, .channel = Channel::classId};
              }}),
    [](const auto& row) { return row.param.name; });

TEST(Accuracy, APresetIsItsOwnName) {
    for (const Preset preset : {Preset::draft, Preset::standard, Preset::fine}) {
        EXPECT_EQ(accuracyOf(preset).preset, preset);
    }
}

}  // namespace
}  // namespace clerestory::test
