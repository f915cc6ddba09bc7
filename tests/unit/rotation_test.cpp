// One rotation in each of its forms.
#include "scene/geometry.h"

#include <gtest/gtest.h>
#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>

#include <cmath>
#include <vector>

namespace clerestory::test {
namespace {

glm::dmat3 matrixOf(const std::vector<double>& numbers) {
    const auto q = rotationFrom(numbers);
    if (!q) {
        ADD_FAILURE() << "is no rotation";
        return glm::dmat3(0.0);
    }
    EXPECT_TRUE(isUnit(*q));
    return glm::mat3_cast(glm::dquat((*q)[3], (*q)[0], (*q)[1], (*q)[2]));
}

void expectTurns(const std::vector<double>& numbers, const glm::dvec3& from, const glm::dvec3& to) {
    EXPECT_LT(glm::distance(matrixOf(numbers) * from, to), 1e-9);
}

TEST(Rotation, QuarterTurnInEachForm) {
    const double h = std::sqrt(0.5), q = 0.5 * 3.14159265358979323846;
    const glm::dvec3 x(1, 0, 0), y(0, 1, 0), z(0, 0, 1);
    for (const std::vector<double>& aboutY :
         std::vector<std::vector<double>>{{0, h, 0, h}, {0, q, 0}, {0, 0, -1, 0, 1, 0, 1, 0, 0}}) {
        expectTurns(aboutY, x, -z);
        expectTurns(aboutY, z, x);
        expectTurns(aboutY, y, y);
    }
    expectTurns({q, 0, 0}, y, z);
    expectTurns({0, 0, q}, x, y);
    // About X first, then about Y, then about Z.
    expectTurns({q, q, 0}, y, x);
    expectTurns({q, 0, q}, y, z);
    expectTurns({0, q, q}, z, y);
}

TEST(Rotation, InvalidRotationsAreRejected) {
    for (const std::vector<double>& wrong :
         std::vector<std::vector<double>>{{},
                                          {1},
                                          {0, 0, 0, 0},
                                          {0, 0, 0, 2},
                                          {1, 0, 0, 0, 1},
                                          {2, 0, 0, 0, 2, 0, 0, 0, 2},
                                          {-1, 0, 0, 0, 1, 0, 0, 0, 1},  // a mirror image
                                          {1, 0.1, 0, 0, 1, 0, 0, 0, 1},
                                          {0, 0, 0, 0, 0, 0, 0, 0, 0}}) {
        EXPECT_FALSE(rotationFrom(wrong)) << wrong.size();
    }
    EXPECT_TRUE(rotationFrom(std::vector<double>{0, 0, 0, 1.0005})) << "a client's rounding";
}

}  // namespace
}  // namespace clerestory::test
