// The hierarchy in difficult cases: malformed scenes, extreme transforms, rays along faces and from
// far away.
#include "bvh_support.h"

#include <cstring>

namespace clerestory::test {
namespace {

TEST(BvhStress, MatchesALinearSearch) {
    std::mt19937 random(7);
    for (const double scale : {1e-4, 1.0, 1e6}) {
        const Scene scene =
            sceneOf(soup(random, 3000, 0.08), {glm::scale(glm::dmat4(1.0), glm::dvec3(scale))});
        const Bvh bvh = bvhOf(scene);
        EXPECT_EQ(bvh.triangles.size() + bvh.dropped, triangleCount(scene));
        EXPECT_LE(bvh.dropped, 1u);
        expectSound(bvh);
        const int hits = expectSame(bvh, trianglesOf(scene, bvh.origin),
                                    raysThrough(random, bvh, scale, 2000), scale);
        EXPECT_TRUE(hits > 600 && hits < 2000) << hits << " at scale " << scale;
    }
}

TEST(BvhStress, FollowsThePose) {
    std::mt19937 random(8);
    glm::dmat4 sheared(1.0);
    sheared[1] = glm::dvec4(0.7, 0.4, -0.2, 0.0);
    for (const glm::dvec3 middle : {glm::dvec3(0.0), glm::dvec3(1e6, -1e6, 1e6)}) {
        const glm::dmat4 there = glm::translate(glm::dmat4(1.0), middle);
        const Scene scene = sceneOf(
            soup(random, 700, 0.1),
            {there, there * sheared, there * glm::scale(glm::dmat4(1.0), glm::dvec3(-1, 1, 1)),
             there * glm::scale(glm::dmat4(1.0), glm::dvec3(1, 0, 1))});
        const Bvh bvh = bvhOf(scene);
        expectSound(bvh);
        EXPECT_LT(glm::distance(bvh.origin, middle), 1.0);
        EXPECT_EQ(bvh.triangles.size() + bvh.dropped, triangleCount(scene));
        expectSame(bvh, trianglesOf(scene, bvh.origin), raysThrough(random, bvh, 1.0, 1500), 1.0);
        // Distant corners are stored in double and lose no precision.
        const auto triangles = trianglesOf(scene, bvh.origin);
        for (const BvhTriangle& t : bvh.triangles) {
            const bool known =
                std::any_of(triangles.begin(), triangles.end(), [&](const Triangle& other) {
                    return glm::distance(other.a, glm::dvec3(t.a)) < 1e-6;
                });
            ASSERT_TRUE(known);
        }
    }
}

TEST(BvhStress, ZeroScaledAndNonFiniteTrianglesAreDropped) {
    std::mt19937 random(9);
    glm::dmat4 nan(1.0), huge(1.0);
    nan[3].x = std::numeric_limits<double>::quiet_NaN();
    huge[0] *= 1e300;
    const MeshDraft draft = soup(random, 100, 0.2);
    for (const glm::dmat4& bad :
         {glm::dmat4(0.0), nan, huge, glm::scale(glm::dmat4(1.0), glm::dvec3(1.0, 0.0, 0.0))}) {
        const Scene scene = sceneOf(draft, {glm::dmat4(1.0), bad});
        const Bvh bvh = bvhOf(scene);
        EXPECT_EQ(bvh.triangles.size(), 100u);
        EXPECT_EQ(bvh.dropped, 100u);
        expectSound(bvh);
        const Scene onlyBad = sceneOf(draft, {bad});
        const Bvh none = bvhOf(onlyBad);
        EXPECT_EQ(none.dropped, 100u);
        EXPECT_TRUE(none.nodes.empty());
        EXPECT_TRUE(glm::all(glm::lessThan(glm::abs(none.origin), glm::dvec3(10.0))));
    }
}

TEST(BvhStress, NoRayLeavesAClosedBall) {
    std::mt19937 random(10);
    for (const double scale : {1e-4, 1.0, 1e6}) {
        const Scene scene = sceneOf(ball(40, 63), {glm::scale(glm::dmat4(1.0), glm::dvec3(scale))});
        const Bvh bvh = bvhOf(scene);
        EXPECT_EQ(bvh.dropped, 0u);
        std::vector<glm::vec3> targets;
        for (const BvhTriangle& t : bvh.triangles) {
            targets.push_back(t.a);
            targets.push_back(0.5f * (t.a + t.b));
            targets.push_back(0.5f * (t.b + t.c));
            targets.push_back(0.63f * t.a + 0.37f * t.c);
        }
        for (const glm::vec3& target : targets) {
            const glm::vec3 inside(0.6 * scale * unit(random));
            for (const glm::vec3& from : {inside, glm::vec3(0.0f)}) {
                const auto hit = nearestHit(bvh, from, target - from, 0.0f, kFar);
                ASSERT_TRUE(hit) << "missed at scale " << scale;
                EXPECT_NEAR(hit->distance, 1.0, 2e-4);
            }
        }
        // From far outside, where float steps are a good part of a triangle's tolerance.
        for (int i = 0; i < 3000; ++i) {
            const glm::vec3 from(300.0 * scale * unit(random));
            const glm::vec3 target = targets[static_cast<std::size_t>(i) * 3 % targets.size()];
            const auto hit = nearestHit(bvh, from, 0.9f * target - from, 0.0f, kFar);
            ASSERT_TRUE(hit) << "missed from far away at scale " << scale;
            EXPECT_LT(hit->distance, 1.0);
        }
    }
}

TEST(BvhStress, CoordinatesNearTheEndOfFloatAreSafe) {
    std::mt19937 random(15);
    for (const double far : {1e18, 1e19, 1e30, 1e37, 1e38, 2e38, 3e38}) {
        std::vector<glm::dmat4> places;
        for (const double sign : {1.0, -1.0})
            for (const double size : {1.0, 0.2 * far})
                places.push_back(glm::scale(
                    glm::translate(glm::dmat4(1.0), glm::dvec3(sign * far, 0.5 * far, far)),
                    glm::dvec3(size)));
        const Scene scene = sceneOf(soup(random, 50, 0.5), places);
        const Bvh bvh = bvhOf(scene);
        EXPECT_EQ(bvh.triangles.size() + bvh.dropped, triangleCount(scene));
        expectSound(bvh);
        for (int i = 0; i < 100; ++i)
            nearestHit(bvh, glm::vec3(far * unit(random)), glm::vec3(unit(random)), 0.0f, kFar);
    }
}

// Many copies of one triangle in one place: nothing splits them but counting.
TEST(BvhStress, IdenticalTrianglesStayShallow) {
    std::mt19937 random(11);
    const Scene scene =
        sceneOf(soup(random, 10, 0.5), std::vector<glm::dmat4>(10'000, glm::dmat4(1.0)));
    const Bvh bvh = bvhOf(scene);
    EXPECT_EQ(bvh.triangles.size(), 100'000u);
    expectSound(bvh);
}

// Over eighteen powers of ten: bins that divide evenly find few at a time.
TEST(BvhStress, TrianglesOfAllSizesStayShallow) {
    std::mt19937 random(12);
    std::vector<glm::dmat4> places;
    for (int i = 0; i < 2000; ++i) {
        const double size = std::pow(10.0, 0.009 * i - 9.0);
        for (const double sign : {1.0, -1.0})  // about the origin, where float is fine enough
            places.push_back(glm::scale(glm::dmat4(1.0), glm::dvec3(sign * size)));
    }
    const Bvh bvh = bvhOf(sceneOf(soup(random, 3, 0.5), places));
    expectSound(bvh);
    EXPECT_EQ(bvh.triangles.size(), 12'000u);
}

TEST(BvhStress, ExcessTrianglesAreDropped) {
    std::mt19937 random(13);
    const Scene scene =
        sceneOf(soup(random, 2000, 0.5), std::vector<glm::dmat4>(1001, glm::dmat4(1.0)));
    const Bvh bvh = bvhOf(scene);
    EXPECT_EQ(bvh.triangles.size(), kMaxBvhTriangles);
    EXPECT_EQ(bvh.dropped, 2000u);
    EXPECT_TRUE(std::none_of(bvh.triangles.begin(), bvh.triangles.end(),
                             [](const BvhTriangle& t) { return t.instance == 1000.0f; }));
    EXPECT_EQ(bvh.nodes[0].skip, static_cast<float>(bvh.nodes.size()));
}

TEST(BvhStress, EqualScenesGiveEqualBytes) {
    const auto build = [] {
        std::mt19937 random(16);
        return bvhOf(sceneOf(soup(random, 3000, 0.1)));
    };
    const Bvh one = build(), two = build();
    ASSERT_EQ(one.nodes.size(), two.nodes.size());
    ASSERT_EQ(one.triangles.size(), two.triangles.size());
    EXPECT_EQ(std::memcmp(one.nodes.data(), two.nodes.data(), one.nodes.size() * sizeof(BvhNode)),
              0);
    EXPECT_EQ(std::memcmp(one.triangles.data(), two.triangles.data(),
                          one.triangles.size() * sizeof(BvhTriangle)),
              0);
}

TEST(BvhStress, OutOfRangeInstancesDoNotAffectOthers) {
    std::mt19937 random(17);
    const MeshDraft draft = soup(random, 200, 0.2);
    const Bvh alone = bvhOf(sceneOf(draft));
    const Bvh both = bvhOf(sceneOf(
        draft, {glm::dmat4(1.0), glm::translate(glm::dmat4(1.0), glm::dvec3(1e30, 0.0, 0.0))}));
    EXPECT_EQ(both.origin, alone.origin);
    EXPECT_EQ(both.triangles.size(), alone.triangles.size());
    EXPECT_EQ(both.dropped, 200u);
}

}  // namespace
}  // namespace clerestory::test
