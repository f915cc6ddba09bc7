// Any failure during a frame is reported, ends nothing, and does not change the next frame (as
// SQLite tests: fail the first call, then the second, and so on).
#include "faults.h"
#include "../gl/support.h"

#include <gtest/gtest.h>
#include <glm/gtc/matrix_transform.hpp>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <set>
#include <string_view>

namespace clerestory::test {
namespace {

// Everything that makes a frame's passes: glass before a wall, a flat mirror, a curved one with its
// captured cube, a lamp, a texture, and filters.
Scene everything() {
    Scene scene;
    Material wall;
    wall.roughness = 1.0f;
    wall.metallic = 0.0f;
    wall.baseColorTexture.texture = addTexture2x2(
        scene, {{{255, 0, 0, 255}, {0, 255, 0, 255}, {0, 0, 255, 255}, {9, 9, 9, 255}}},
        Wrap::repeat, Filter::linear);
    place(scene, quad(4.0f, addMaterial(scene, wall)), moved(0.0, 0.0, -3.0));
    place(scene, sphere(0.6f, 12, addMaterial(scene, clearGlass())), moved(-0.8, 0.0, 0.0));
    place(scene, sphere(0.5f, 12, addMaterial(scene, mirrorMetal())), moved(0.9, 0.3, 0.0));
    const glm::dmat4 floor =
        glm::rotate(moved(0.0, -1.0, 0.0), -1.5707963267948966, glm::dvec3(1, 0, 0));
    place(scene, quad(3.0f, addMaterial(scene, mirrorMetal(0.8f))), floor);
    place(scene, quad(0.3f, addMaterial(scene, glowing({4.0f, 3.0f, 2.0f}))),
          moved(0.0, 1.0, -1.0));
    addLight(scene, {.kind = LightKind::point, .intensity = glm::vec3(8.0f)}, moved(1.0, 2.0, 2.0));
    return scene;
}

FrameRequest everythingRequest() {
    FrameRequest r = request(everything(), "everything", {0.0, 0.3, 3.0});
    r.width = 48;
    r.height = 32;
    r.environment.map = "sky";
    r.output.format = OutputFormat::png;
    r.accuracy.edgeFilter = true;
    r.accuracy.curved = CurvedMethod::probe;
    // The same passes with little to do in each, for there are thousands of points.
    r.accuracy.environmentSize = r.accuracy.probeSize = 16;
    r.accuracy.environmentSamples = r.accuracy.probeSamples = 1;
    r.filters = {GlowFilter{}};
    return r;
}

// All of them with CLERESTORY_FAULTS=all, one in N with CLERESTORY_FAULTS=N, else one in N by
// default.
std::uint64_t stride(std::uint64_t usually) {
    const char* wanted = std::getenv("CLERESTORY_FAULTS");
    if (!wanted) return usually;
    return std::string_view(wanted) == "all" ? 1 : std::max(1ul, std::strtoul(wanted, nullptr, 10));
}

std::vector<std::byte> drawn(const FrameRequest& r) {
    return renderer().render(r).image.data;
}

void failEach(Fault fault, std::uint64_t step) {
    const FrameRequest r = everythingRequest();
    renderer().forgetMaps();
    std::set<std::string_view> kinds;
    for (const Pass& pass : renderer().plan(r).passes) kinds.insert(pass.kind());
    for (const std::string_view kind : {"environment", "capture", "prefilter", "mirror", "surface",
                                        "backdrop", "glass", "glow", "toneMap", "edgeFilter"}) {
        ASSERT_TRUE(kinds.contains(kind)) << kind;
    }
    const std::vector<std::byte> right = drawn(r);
    std::uint64_t failures = 0, unneeded = 0, of = 0;
    for (std::uint64_t n = 1;; n += step) {
        renderer().forgetMaps();  // so that every pass runs
        failAt(fault, n);
        bool failed = false;
        std::vector<std::byte> bytes;
        try {
            bytes = drawn(r);
        } catch (const RenderFailed&) {
            failed = true;
        } catch (const std::bad_alloc&) {  // before anything was drawn
            failed = true;
        }
        if (!endFault()) {
            EXPECT_EQ(bytes, right);
            of = counted(fault);
            break;
        }
        // Some code works without the memory, as a stable sort does; its result is then correct.
        if (!failed && fault == Fault::allocation) {
            ASSERT_EQ(bytes, right) << "number " << n << " failed and the picture is wrong";
            ++unneeded;
        } else {
            ASSERT_TRUE(failed) << "number " << n << " failed without a report";
        }
        ASSERT_EQ(drawn(r), right) << "after number " << n;
        ++failures;
    }
    EXPECT_GT(failures, 10u);
    std::printf(
        "%llu of %llu failed in turn, each noticed or not needed (%llu), each next frame "
        "right\n",
        static_cast<unsigned long long>(failures), static_cast<unsigned long long>(of),
        static_cast<unsigned long long>(unneeded));
}

TEST(Faults, EveryDriverCallInAFrame) {
    failEach(Fault::driverCall, stride(61));
}

TEST(Faults, EveryAllocationInAFrame) {
    failEach(Fault::allocation, stride(53));
}

// A scene that did not get to the GPU whole is not there; given again, it is.
TEST(Faults, EveryDriverCallDuringUpload) {
    const FrameRequest r = everythingRequest();
    const std::vector<std::byte> right = drawn(r);
    for (std::uint64_t n = 1;; n += stride(5)) {
        failAt(Fault::driverCall, n);
        bool failed = false;
        try {
            everythingRequest();
        } catch (const std::exception&) {
            failed = true;
        }
        const bool happened = endFault();
        ASSERT_EQ(failed, happened) << n;
        if (!happened) break;
        EXPECT_FALSE(renderer().hasScene("everything"));
        everythingRequest();
        ASSERT_EQ(drawn(r), right) << n;
    }
}

// G5. What ends the process in a worker is counted here.
TEST(Faults, AResetOfTheGpuIsReportedAndNothingIsDrawnAfterIt) {
    int resets = 0;
    Renderer own({.onReset = [&] { ++resets; }});
    if (!own.identity().tellsOfResets) GTEST_SKIP() << "this driver does not report resets";
    Scene scene = everything();
    scene.id = "everything";
    own.addScene(std::move(scene));
    FrameRequest r = everythingRequest();
    const std::vector<std::byte> right = own.render(r).image.data;
    EXPECT_EQ(resets, 0);
    resetGpu(true);
    EXPECT_THROW(own.render(r), RenderFailed);
    EXPECT_EQ(resets, 1);
    EXPECT_THROW(own.render(r), RenderFailed);
    resetGpu(false);
    EXPECT_EQ(own.render(r).image.data, right) << "it was reported differently";
}

}  // namespace
}  // namespace clerestory::test
