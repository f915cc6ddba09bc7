// Scenes with reflectors and glass for tests of nested views, and queries on plans.
#pragma once

#include "plan_scenes.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <set>

namespace clerestory::test {

inline Material mirror(float roughness = 0.0f) {
    return {.name = "mirror", .metallic = 1.0f, .roughness = roughness};
}
inline Material clearGlass(float roughness = 0.0f) {
    return {.name = "glass", .metallic = 0.0f, .roughness = roughness, .transmission = 1.0f};
}
inline Material dullGrey() {
    return {.name = "grey", .metallic = 0.0f};
}

inline glm::dmat4 at(double x, double y, double z) {
    return glm::translate(glm::dmat4(1.0), glm::dvec3(x, y, z));
}
// Facing -Z.
inline glm::dmat4 turnedRound(double x, double y, double z) {
    return glm::rotate(at(x, y, z), glm::pi<double>(), glm::dvec3(0, 1, 0));
}

// A mirror of 2 x 2 metres in the plane z = 0 and two boxes in front of it.
inline Scene mirrorScene(Material material = mirror()) {
    Scene scene;
    placeAt(scene, addSquareMesh(scene, "mirror", addMaterial(scene, std::move(material))),
            at(0, 0, 0));
    const Index box = addBoxMesh(scene, "box", addMaterial(scene, dullGrey()));
    place(scene, box, {-0.8, 0, 1.5}, 0.2);
    place(scene, box, {0.8, 0, 2.5}, 0.2);
    updateContentHash(scene);
    return scene;
}

// Two mirror balls and a grey box, each in view of the other two.
inline Scene ballScene() {
    Scene scene;
    const Index ball = addBallMesh(scene, "ball", addMaterial(scene, mirror()));
    placeAt(scene, ball, at(-1.5, 0, 0), "left");
    placeAt(scene, ball, at(1.5, 0, 0), "right");
    placeAt(scene, addBoxMesh(scene, "box", addMaterial(scene, dullGrey())), at(0, 0, -3), "box");
    updateContentHash(scene);
    return scene;
}

inline FramePlan planWith(Rays rays, const Scene& scene, const FrameRequest& request) {
    const EnvironmentMap map = plainMap();
    const Pose pose = poseAt(scene, 0.0);
    return planFrame({.scene = scene,
                      .pose = pose,
                      .environment = map,
                      .maps = {},
                      .resident = {},
                      .limits = {.rays = rays}},
                     request);
}
inline FramePlan planOnProcessor(const Scene& scene, const FrameRequest& request) {
    return planWith(Rays::processor, scene, request);
}

inline FrameRequest forced(FrameRequest request) {
    request.accuracy.planar = PlanarMethod::mirror;
    request.accuracy.curved = CurvedMethod::probe;
    request.accuracy.glass = GlassMethod::backdrop;
    return request;
}

inline std::vector<Pass> passesOf(const FramePlan& plan, std::string_view kind) {
    std::vector<Pass> result;
    std::copy_if(plan.passes.begin(), plan.passes.end(), std::back_inserter(result),
                 [&](const Pass& pass) { return pass.kind() == kind; });
    return result;
}
inline std::size_t count(const FramePlan& plan, std::string_view kind) {
    return passesOf(plan, kind).size();
}
// The draws of the passes of one type, in the plan's order.
template <class Work>
std::vector<Work> worksOf(const FramePlan& plan) {
    std::vector<Work> works;
    for (const Pass& pass : plan.passes) {
        if (const auto* work = std::get_if<Work>(&pass.work)) works.push_back(*work);
    }
    return works;
}
inline DrawScene rootOf(const FramePlan& plan) {
    return std::get<DrawScene>(passesOf(plan, "surface").at(0).work);
}

// Keys of all maps that outlive the frame, but the environment's.
inline std::set<std::uint64_t> probeKeys(const FramePlan& plan) {
    std::set<std::uint64_t> keys;
    for (const TargetSpec& t : plan.targets) {
        if (t.residentKey != 0 && t.name.starts_with("probe:")) keys.insert(t.residentKey);
    }
    return keys;
}
inline ResidentMaps allOf(const FramePlan& plan) {
    ResidentMaps maps;
    for (const TargetSpec& t : plan.targets) {
        if (t.residentKey != 0) maps.keys.insert(t.residentKey);
    }
    return maps;
}

inline std::uint64_t effectPasses(const FramePlan& plan) {
    std::uint64_t sum = 0;
    for (const std::string_view kind :
         {"mirror", "capture", "prefilter", "levels", "backdrop", "glass"}) {
        sum += count(plan, kind);
    }
    return sum;
}

inline auto skippedAs(const std::string& name, const std::string& reason) {
    return testing::Contains(
        testing::AllOf(testing::Field(&Skipped::name, name),
                       testing::Field(&Skipped::reason, testing::HasSubstr(reason))));
}

}  // namespace clerestory::test
