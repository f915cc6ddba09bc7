// The part of a point's surroundings that is not sky.
#include "plan/visibility/enclosure.h"
#include "plan/cost/cost.h"

#include <gtest/gtest.h>

#include <vector>

namespace clerestory {
namespace {

Bounds box(const glm::vec3& low, const glm::vec3& high) {
    Bounds b;
    b.add(low);
    b.add(high);
    return b;
}

// Walls, floor and ceiling of a room from -4 to 4.
std::vector<Bounds> room() {
    std::vector<Bounds> walls;
    for (int axis = 0; axis < 3; ++axis) {
        for (const float side : {-4.0f, 4.0f}) {
            glm::vec3 low(-4.0f), high(4.0f);
            low[axis] = high[axis] = side;
            walls.push_back(box(low, high));
        }
    }
    return walls;
}

TEST(Enclosure, IsZeroOutdoorsAndOneInARoom) {
    EXPECT_EQ(enclosure({}, {1, 2, 3}), 0.0);
    EXPECT_EQ(enclosure(room(), {1, 2, 3}), 1.0);
    EXPECT_EQ(enclosure(room(), {1, 20, 3}), 1.0 / 14.0);  // straight down alone
}

TEST(Enclosure, ARoomWithoutCeilingIsOpenAbove) {
    std::vector<Bounds> court = room();
    court.erase(court.begin() + 3);  // y = 4
    EXPECT_EQ(enclosure(court, {0, -3, 0}), 13.0 / 14.0);
    EXPECT_EQ(enclosure(court, {0, 3.9, 0}), 9.0 / 14.0);  // diagonals upwards pass over the walls
}

TEST(Enclosure, TheOwnerOfThePointIsIgnored) {
    const std::vector<Bounds> own{box(glm::vec3(-1.0f), glm::vec3(1.0f))};
    EXPECT_EQ(enclosure(own, {0.2, 0.3, 0.4}), 0.0);
    EXPECT_GT(enclosure(own, {0.0, 3.0, 0.0}), 0.0);
}

TEST(Enclosure, MakesAnEnvironmentMapWorse) {
    double before = 0.0;
    for (const double enclosed : {0.0, 0.25, 0.5, 0.75, 1.0}) {
        const double error = environmentError(0.1, enclosed);
        EXPECT_GT(error, before);
        before = error;
        EXPECT_GT(error, probeError(0.1));
        EXPECT_GT(probeError(0.1), tracedError(0.1));
    }
}

}  // namespace
}  // namespace clerestory
