// The part of a point's surroundings that is not sky.
#include "plan/visibility/enclosure.h"
#include "plan/cost/cost.h"
#include "plan/effects/method_choice.h"
#include "view_planner_support.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
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

double enclosed(std::vector<Bounds> boxes, const glm::dvec3& position) {
    return enclosure(BoxHierarchy(std::move(boxes)), position);
}

// 14 directions, as enclosure() tests.
std::vector<glm::dvec3> directions() {
    std::vector<glm::dvec3> list;
    for (int i = 0; i < 27; ++i) {
        const glm::ivec3 d(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
        const int along = d.x * d.x + d.y * d.y + d.z * d.z;
        if (along == 1 || along == 3) list.emplace_back(d);
    }
    return list;
}

// count^3 cubes with gaps between them.
std::vector<Bounds> lattice(int count) {
    std::vector<Bounds> cubes;
    for (int i = 0; i < count * count * count; ++i) {
        const glm::vec3 low(i % count, i / count % count, i / count / count);
        cubes.push_back(box(low, low + 0.3f));
    }
    return cubes;
}

std::uint32_t mostVisits(const BoxHierarchy& boxes, const std::vector<glm::dvec3>& positions) {
    std::uint32_t most = 0;
    for (const glm::dvec3& position : positions) {
        for (const glm::dvec3& direction : directions()) {
            most = std::max(most, boxes.trace(position, direction).visits);
        }
    }
    return most;
}

TEST(Enclosure, IsZeroOutdoorsAndOneInARoom) {
    EXPECT_EQ(enclosed({}, {1, 2, 3}), 0.0);
    EXPECT_EQ(enclosed(room(), {1, 2, 3}), 1.0);
    EXPECT_EQ(enclosed(room(), {1, 20, 3}), 1.0 / 14.0);  // straight down alone
}

TEST(Enclosure, ARoomWithoutCeilingIsOpenAbove) {
    std::vector<Bounds> court = room();
    court.erase(court.begin() + 3);  // y = 4
    EXPECT_EQ(enclosed(court, {0, -3, 0}), 13.0 / 14.0);
    EXPECT_EQ(enclosed(court, {0, 3.9, 0}), 9.0 / 14.0);  // diagonals upwards pass over the walls
}

TEST(Enclosure, TheOwnerOfThePointIsIgnored) {
    const std::vector<Bounds> own{box(glm::vec3(-1.0f), glm::vec3(1.0f))};
    EXPECT_EQ(enclosed(own, {0.2, 0.3, 0.4}), 0.0);
    EXPECT_GT(enclosed(own, {0.0, 3.0, 0.0}), 0.0);
}

TEST(Enclosure, TheHierarchyFindsWhatAListFinds) {
    std::mt19937 random(7);
    std::uniform_real_distribution<float> place(-10.0f, 10.0f), size(0.0f, 1.5f);
    const auto point = [&] { return glm::vec3(place(random), place(random), place(random)); };
    for (const std::size_t count : {1u, 4u, 5u, 60u, 500u}) {
        std::vector<Bounds> boxes;
        while (boxes.size() < count) {
            const glm::vec3 low = point();
            boxes.push_back(box(low, low + glm::vec3(size(random), size(random), size(random))));
        }
        const BoxHierarchy all(boxes);
        for (int i = 0; i < 50; ++i) {
            const glm::dvec3 origin(point());
            for (const glm::dvec3& direction : directions()) {
                const bool blocked = std::any_of(boxes.begin(), boxes.end(), [&](const Bounds& b) {
                    return BoxHierarchy({b}).trace(origin, direction).blocked;
                });
                EXPECT_EQ(all.trace(origin, direction).blocked, blocked) << count;
            }
        }
    }
}

// A list would visit all 27,000 boxes for each ray that none blocks.
TEST(Enclosure, ARayVisitsFewOfManyBoxes) {
    const BoxHierarchy cubes(lattice(30));
    const std::vector<glm::dvec3> between{
        {0.65, 0.65, 0.65}, {12.65, 12.15, 12.65}, {15.15, 60, 15.15}};
    EXPECT_LT(mostVisits(cubes, between), 400u);
}

TEST(Enclosure, VisitsOfOverlappingBoxesAreLimited) {
    const std::vector<Bounds> around(10'000, box(glm::vec3(-1.0f), glm::vec3(1.0f)));
    const BoxHierarchy boxes(around);
    EXPECT_EQ(mostVisits(boxes, {{0.2, 0.3, 0.4}}), BoxHierarchy::kMaxVisits);
    EXPECT_EQ(enclosure(boxes, {0.2, 0.3, 0.4}), 1.0);
}

// Surfaces that appear later in the stage show whether the boxes were collected again.
TEST(Enclosure, BoxesAreCollectedOnceAlsoWithoutOpaqueSurfaces) {
    using namespace test;
    Scene scene = boxScene(clearGlass());
    place(scene, addBoxMesh(scene, "grey", addMaterial(scene, dullGrey())), {0, 5, 0});
    const FrameRequest request = lookingFrom({0, 0, 5});
    const EnvironmentMap map = plainMap();
    const Pose pose = poseAt(scene, 0.0);
    const ViewSettings settings = viewSettings(request, scene, 1.0);
    const MaterialBindings materials;
    const std::vector<Surface> surfaces = surfacesOf(scene, materials);
    const FrameContext frame{
        .scene = scene, .pose = pose, .environment = map, .maps = {}, .resident = {}, .limits = {}};
    Stage stage{.scene = scene,
                .pose = pose,
                .settings = settings,
                .materials = materials,
                .surfaces = std::span(surfaces).first(1),
                .environment = map};
    FramePlan plan;
    PlanBuilder builder(plan);
    ViewContext views(frame, stage, builder);
    const Bounds center = box(glm::vec3(-1.0f), glm::vec3(1.0f));
    EXPECT_EQ(enclosureAt(views, {}, center), 0.0);
    stage.surfaces = surfaces;
    EXPECT_EQ(enclosureAt(views, {}, center), 0.0) << "the boxes were collected again";
    ViewContext others(frame, stage, builder);
    EXPECT_GT(enclosureAt(others, {}, center), 0.0);
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
