// Planes under transforms: errata P1 and P2.
#include "scene/geometry.h"

#include <gtest/gtest.h>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/quaternion.hpp>

#include <cmath>
#include <random>

namespace clerestory::test {
namespace {

class RandomSource {
public:
    double number(double low, double high) {
        return std::uniform_real_distribution<double>(low, high)(engine_);
    }
    glm::dvec3 direction() {
        std::normal_distribution<double> normal;
        return glm::normalize(glm::dvec3(normal(engine_), normal(engine_), normal(engine_)));
    }
    glm::dmat4 rotation() { return glm::rotate(glm::dmat4(1.0), number(0.0, 6.3), direction()); }

private:
    std::mt19937 engine_{7};
};

glm::dvec3 someTangent(const glm::dvec3& n) {
    const glm::dvec3 axis = std::abs(n.x) < 0.5 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
    return glm::normalize(glm::cross(n, axis));
}

TEST(Plane, TransformsWithItsPoints) {  // P1
    RandomSource dice;
    int mirrored = 0;
    for (int i = 0; i < 5000; ++i) {
        glm::dmat4 m = glm::translate(glm::dmat4(1.0), dice.number(0, 1e3) * dice.direction());
        glm::dvec3 scale;
        for (int k = 0; k < 3; ++k) {
            scale[k] = std::pow(10.0, dice.number(-4, 4)) * (dice.number(-1, 1) < 0 ? -1 : 1);
        }
        m = m * dice.rotation() * glm::scale(glm::dmat4(1.0), scale);
        const bool flips = glm::determinant(glm::dmat3(m)) < 0;
        mirrored += flips;
        const Plane plane{dice.direction(), dice.number(-10, 10)};
        const auto world = transformed(plane, m);
        ASSERT_TRUE(world);
        EXPECT_NEAR(glm::length(world->normal), 1.0, 1e-12);
        const glm::dvec3 u = someTangent(plane.normal), v = glm::cross(plane.normal, u);
        const glm::dvec3 foot = -plane.offset * plane.normal;  // P2
        EXPECT_NEAR(plane.distance(foot), 0.0, 1e-12);
        for (int k = 0; k < 4; ++k) {
            const glm::dvec3 on = foot + dice.number(-10, 10) * u + dice.number(-10, 10) * v;
            const glm::dvec3 p(m * glm::dvec4(on, 1.0));
            EXPECT_LE(std::abs(world->distance(p)),
                      4e-6 * (glm::length(p) + std::abs(world->offset)));
        }
        // Points in front stay in front, also after a mirroring transform.
        const glm::dvec3 before(m * glm::dvec4(foot + plane.normal, 1.0));
        EXPECT_GT(world->distance(before), 0.0);
    }
    EXPECT_GT(mirrored, 1000);
}

TEST(Plane, FlattenedMirrorsStayMirrors) {
    RandomSource dice;
    for (int i = 0; i < 100; ++i) {
        const glm::dmat4 turn = dice.rotation();
        const glm::dmat4 flat = turn * glm::scale(glm::dmat4(1.0), glm::dvec3(1, 1, 0));
        const auto world = transformed({{0, 0, 1}, -5.0}, flat);
        ASSERT_TRUE(world);
        EXPECT_NEAR(glm::dot(world->normal, glm::dvec3(turn[2])), 1.0, 1e-12);
        EXPECT_NEAR(world->offset, 0.0, 1e-12) << "the scale moved the plane to the origin";
    }
}

TEST(Plane, DegenerateTransformsAreRejected) {
    RandomSource dice;
    const auto through = [](const glm::dvec3& normal, const glm::dmat4& m) {
        return transformed({normal, 0.0}, m);
    };
    for (int i = 0; i < 100; ++i) {
        const glm::dmat4 turn = dice.rotation();
        const glm::dmat4 line = turn * glm::scale(glm::dmat4(1.0), glm::dvec3(1, 0, 0));
        EXPECT_FALSE(through(dice.direction(), line));
        EXPECT_FALSE(through(dice.direction(), line * dice.rotation()));
        EXPECT_FALSE(through({1, 0, 0}, turn * glm::scale(glm::dmat4(1.0), glm::dvec3(1, 1, 0))))
            << "a plane at right angles to what it is flattened into";
    }
    EXPECT_FALSE(through({0, 0, 1}, glm::scale(glm::dmat4(1.0), glm::dvec3(0.0))));
    EXPECT_FALSE(through({0, 0, 1}, glm::dmat4(std::nan(""))));
    EXPECT_FALSE(through({0, 0, 1}, glm::dmat4(HUGE_VAL)));
    EXPECT_TRUE(through({0, 0, 1}, glm::scale(glm::dmat4(1.0), glm::dvec3(1e-30))));
}

TEST(Plane, ModelOriginDoesNotMatter) {  // P2
    RandomSource dice;
    for (int i = 0; i < 100; ++i) {
        const glm::dvec3 moved = dice.number(0, 10) * dice.direction();
        const Plane here{dice.direction(), dice.number(-3, 3)};
        const Plane there{here.normal, here.offset - glm::dot(here.normal, moved)};
        const glm::dmat4 m = dice.rotation();
        const auto a = transformed(here, m);
        const auto b = transformed(there, m * glm::translate(glm::dmat4(1.0), -moved));
        ASSERT_TRUE(a && b);
        EXPECT_NEAR(a->offset, b->offset, 1e-12);
        EXPECT_NEAR(glm::distance(a->normal, b->normal), 0.0, 1e-12);
    }
}

}  // namespace
}  // namespace clerestory::test
