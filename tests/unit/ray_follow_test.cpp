// Which pixels of a picture follow their rays, and what the others show.
#include "ray_room.h"
#include "rays/follow.h"

#include <gtest/gtest.h>
#include <glm/gtc/packing.hpp>

#include <algorithm>
#include <cmath>

using namespace clerestory;
using namespace clerestory::rays;

namespace {

constexpr std::uint32_t kEdge = 64;
constexpr float kPixel = 0.01f;  // slope

// Rays from one point, on a grid of slopes about +Z, towards bright stripes a pixel and a half
// wide.
class Picture {
public:
    Picture() : room_(0.2f) {
        room_.materialRow(0) = glm::vec4(glm::vec3(0.5f), 1.0f);
        room_.materialRow(5).w = float(TRACE_UNLIT | TRACE_DOUBLE_SIDED);
        for (std::uint32_t y = 0; y < kEdge; ++y) {
            for (std::uint32_t x = 0; x < kEdge; ++x) {
                starts_.push_back({.position = {}, .cone = glm::packHalf2x16({1e-3f, -10.0f})});
                ways_.push_back(wayAlong(slopeAt(x), slopeAt(y)));
            }
        }
    }
    // Stripes a pixel and a half wide.
    void addStripes() {
        for (int i = -12; i < 12; ++i) {
            const float x = 3.0f * kPixel * float(i), width = 1.5f * kPixel;
            room_.add({x, -9.0f, 1.0f}, {x + width, -9.0f, 1.0f}, {x, 9.0f, 1.0f});
            room_.add({x + width, -9.0f, 1.0f}, {x + width, 9.0f, 1.0f}, {x, 9.0f, 1.0f});
        }
    }
    // An inclined line a little more than a pixel wide.
    void addLine() {
        const float width = 1.2f * kPixel;
        const glm::vec3 low(-0.1f, -0.25f, 1.0f), high(0.03f, 0.25f, 1.0f), across(width, 0, 0);
        room_.add(low, low + across, high);
        room_.add(low + across, high + across, high);
    }
    // The red channel; sets `paths` to the number of those that were followed.
    std::vector<float> follow(const Density& density, std::uint64_t& paths) const {
        Scratch scratch;
        return follow(density, paths, scratch);
    }
    std::vector<float> follow(const Density& density, std::uint64_t& paths,
                              Scratch& scratch) const {
        std::vector<glm::vec4> radiance(starts_.size(), glm::vec4(0.0f));
        const Surroundings around = room_.surroundings(glm::vec3(0.0f));
        paths = rays::follow(around, density, {.width = kEdge, .starts = starts_, .ways = ways_},
                             radiance, scratch);
        std::vector<float> red;
        for (const glm::vec4& r : radiance) red.push_back(r.x);
        return red;
    }
    void removePixel(std::uint32_t x, std::uint32_t y) { starts_[y * kEdge + x].cone = 0; }
    void turnColumn(std::uint32_t x, float slope) {
        for (std::uint32_t y = 0; y < kEdge; ++y)
            ways_[y * kEdge + x] = wayAlong(slope, slopeAt(y));
    }
    void moveColumn(std::uint32_t x, float metres) {
        for (std::uint32_t y = 0; y < kEdge; ++y) starts_[y * kEdge + x].position[2] -= metres;
    }

    // A plate one metre away, between two slopes.
    void addPlate(float low, float high) {
        room_.add({low, -1.0f, 1.0f}, {high, -1.0f, 1.0f}, {low, 1.0f, 1.0f});
        room_.add({high, -1.0f, 1.0f}, {high, 1.0f, 1.0f}, {low, 1.0f, 1.0f});
    }
    // A wall in all of the picture that brightens to the right by about `change` a pixel.
    void addRamp(float change) {
        const float rise = 8.0f * change / kPixel;  // over the triangle's 8 metres
        room_.add({-4.0f, -4.0f, 1.0f}, {4.0f, -4.0f, 1.0f}, {-4.0f, 4.0f, 1.0f});
        room_.colorCorners(2.0f - 0.5f * rise, 2.0f + 0.5f * rise, 2.0f - 0.5f * rise);
    }

private:
    static float slopeAt(std::uint32_t pixel) { return kPixel * (float(pixel) - 32.0f); }
    static Way wayAlong(float x, float y) {
        const float sum = std::abs(x) + std::abs(y) + 1.0f;
        return {.octahedral = {x / sum, y / sum},
                .shareRedGreen = glm::packHalf2x16({1.0f, 1.0f}),
                .shareBlueLobe = glm::packHalf2x16({1.0f, 0.0f})};
    }

    RayRoom room_;
    std::vector<Start> starts_;
    std::vector<Way> ways_;
};

TEST(RayFollow, PixelsBetweenTheFinestTakeAMeanOfNeighbours) {
    Picture picture;
    picture.addStripes();
    std::uint64_t all = 0, quarter = 0;
    const std::vector<float> truth = picture.follow({}, all);
    const std::vector<float> found = picture.follow({.stride = 2,
                                                     .finest = 2,
                                                     .contrast = 0.1f,
                                                     .contrastNextTo = 0.1f,
                                                     .contrastBetween = 10.0f},
                                                    quarter);
    // One in four, and the pixels of two borders, which have no neighbours on one side.
    EXPECT_LE(quarter, (kEdge / 2) * (kEdge / 2) + 2 * kEdge);
    for (std::uint32_t y = 0; y < kEdge; y += 2) {
        for (std::uint32_t x = 0; x + 2 < kEdge; x += 2) {
            const std::size_t i = y * kEdge + x;
            EXPECT_EQ(found[i], truth[i]) << "followed";
            const auto [low, high] = std::minmax(truth[i], truth[i + 2]);
            EXPECT_GE(found[i + 1], low - 1e-6f);
            EXPECT_LE(found[i + 1], high + 1e-6f);
        }
    }
    // Without contrast those between neighbours that differ follow their rays.
    std::uint64_t strict = 0;
    const std::vector<float> sharp = picture.follow(
        {.stride = 2, .finest = 2, .contrast = 0.1f, .contrastNextTo = 0.1f}, strict);
    EXPECT_GT(strict, all / 2);
    for (std::size_t i = 0; i + 2 < kEdge; i += 2) {
        if (truth[i] != truth[i + 2]) {
            EXPECT_EQ(sharp[i + 1], truth[i + 1]) << i;
        }
    }
}

// Paths four pixels apart meet the line here and there only.
TEST(RayFollow, ThinLinesAreWhole) {
    Picture picture;
    picture.addLine();
    std::uint64_t all = 0, chosen = 0;
    const std::vector<float> truth = picture.follow({}, all);
    EXPECT_GT(std::count(truth.begin(), truth.end(), 0.5f), 40);
    EXPECT_EQ(picture.follow({.stride = 4, .contrast = 0.1f, .contrastNextTo = 0.1f}, chosen),
              truth);
    EXPECT_LT(chosen, all / 4);
}

TEST(RayFollow, PixelsOfAnotherSurfaceFollowTheirRays) {
    Picture picture;
    picture.addStripes();
    picture.moveColumn(33, 0.3f);  // an odd column: a post in front of the others
    std::uint64_t all = 0, chosen = 0;
    const std::vector<float> truth = picture.follow({}, all);
    const std::vector<float> found = picture.follow({.stride = 2,
                                                     .finest = 2,
                                                     .contrast = 0.1f,
                                                     .contrastNextTo = 0.1f,
                                                     .contrastBetween = 10.0f},
                                                    chosen);
    for (std::uint32_t y = 0; y < kEdge; y += 2) {
        EXPECT_EQ(found[y * kEdge + 33], truth[y * kEdge + 33]) << y;
    }
}

// A groove of one column shows what its neighbours do not.
TEST(RayFollow, PixelsWithOtherDirectionsFollowTheirRays) {
    for (const bool neighboursMeetIt : {true, false}) {
        Picture picture;
        picture.addPlate(neighboursMeetIt ? -0.5f : 0.6f, neighboursMeetIt ? 0.5f : 1.0f);
        picture.turnColumn(33, 0.8f);
        std::uint64_t all = 0, chosen = 0;
        const std::vector<float> truth = picture.follow({}, all);
        EXPECT_NE(truth[33], truth[32]);
        EXPECT_EQ(picture.follow({.stride = 4, .contrast = 10.0f, .contrastNextTo = 10.0f}, chosen),
                  truth);
        EXPECT_LT(chosen, all / 4);
    }
}

// A pixel next to its neighbours may take the mean of more different ones than one between others
// that are farther away.
TEST(RayFollow, ContrastDependsOnTheStep) {
    Picture picture;
    picture.addRamp(0.04f);
    std::uint64_t all = 0, few = 0, far = 0, near = 0;
    const std::vector<float> truth = picture.follow({}, all);
    const auto expectTruth = [&](const std::vector<float>& found) {
        for (std::size_t i = 0; i < found.size(); ++i) EXPECT_NEAR(found[i], truth[i], 1e-4f) << i;
    };
    expectTruth(picture.follow({.stride = 4, .contrast = 0.3f, .contrastNextTo = 0.3f}, few));
    expectTruth(picture.follow({.stride = 4, .contrast = 0.3f}, far));
    expectTruth(picture.follow({.stride = 4, .contrastNextTo = 0.3f}, near));
    EXPECT_LT(few, all / 4);
    EXPECT_GT(far, all / 2);
    EXPECT_GT(near, all / 4);
    EXPECT_LT(near, all / 2);
}

// Pixels without a ray do not keep the paths of an earlier picture.
TEST(RayFollow, MemoryOfAnEarlierPictureChangesNothing) {
    Picture picture;
    picture.addLine();
    const Density density{.stride = 4, .contrast = 0.1f, .contrastNextTo = 0.1f};
    std::uint64_t before = 0, fresh = 0, used = 0;
    Scratch scratch;
    picture.follow({}, before, scratch);
    picture.removePixel(45, 21);
    EXPECT_EQ(picture.follow(density, used, scratch), picture.follow(density, fresh));
    EXPECT_EQ(used, fresh);
}

}  // namespace
