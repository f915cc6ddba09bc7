// Earlier frames do not change a bit of a frame, for any difference between the two requests: every
// accuracy knob, every switch, the environment, the materials, the camera.
#include "room.h"
#include "scene/import/sandbox/jail.h"

#include <malloc.h>
#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_transform.hpp>

namespace clerestory::test {
namespace {

class History : public GlTest {};

struct Other {
    std::string what;
    FrameRequest request;
};

void change(std::uint32_t& value, const Range& range) {
    const auto least = static_cast<std::uint32_t>(range.min);
    value = value > least ? least : value + 1;
}
void change(double& value, const Range& range) {
    value = value > range.min ? std::max(range.min, 0.5 * value) : range.max;
}
void change(bool& value, const Flag&) {
    value = !value;
}
// The next word after the present one.
template <class E>
void change(E& value, const Choice<E>& choice) {
    std::size_t i = 0;
    while (choice.words[i].second != value) ++i;
    value = choice.words[(i + 1) % choice.words.size()].second;
}
void change(std::optional<double>&, const Range&) {}  // a budget is no knob

// A request for each field of the part of `base` that `part` picks, with that field changed.
template <class Part>
void addChanged(std::vector<Other>& others, const FrameRequest& base, Part FrameRequest::*part) {
    std::size_t count = 0;
    FrameRequest copy = base;
    fields(copy.*part, [&](auto&&...) { ++count; });
    for (std::size_t i = 0; i < count; ++i) {
        Other other{"", base};
        std::size_t at = 0;
        fields(other.request.*part,
               [&](const char* name, auto& value, const auto& kind, auto&&...) {
                   if (at++ != i) return;
                   other.what = name;
                   change(value, kind);
               });
        others.push_back(std::move(other));
    }
}

std::vector<Other> othersOf(const FrameRequest& base) {
    std::vector<Other> others;
    addChanged(others, base, &FrameRequest::accuracy);
    addChanged(others, base, &FrameRequest::effects);
    const auto add = [&](const char* what, auto&& change) {
        others.push_back({what, base});
        change(others.back().request);
    };
    add("environment map", [](FrameRequest& r) { r.environment.map = "studio"; });
    add("environment intensity", [](FrameRequest& r) { r.environment.intensity = 0.5; });
    add("environment rotation", [](FrameRequest& r) {
        r.environment.rotation = Quaternion{0.0, 0.6, 0.0, 0.8};
    });
    add("environment visible", [](FrameRequest& r) { r.environment.visible = false; });
    add("material", [](FrameRequest& r) {
        MaterialOverride gold{.material = "ball", .baseColor = glm::dvec3(1.0, 0.6, 0.2)};
        r.overrides.push_back(gold);
    });
    add("rougher material",
        [](FrameRequest& r) { r.overrides.push_back({.material = "ball", .roughness = 0.3}); });
    add("camera", [](FrameRequest& r) { r.camera.position = glm::dvec3(0.4, 0.3, 2.6); });
    add("size", [](FrameRequest& r) { r.width = 33; });
    add("exposure", [](FrameRequest& r) { r.exposure = 1.0; });
    add("eight-bit output", [](FrameRequest& r) { r.output.format = OutputFormat::png; });
    return others;
}

// Two mirror balls, a glass one, two flat mirrors that face each other, a lamp that glows and one
// that shines.
Scene scene() {
    Scene s;
    s.environment = "sky";
    Material ball = mirrorMetal(0.9f, 0.05f);
    ball.name = "ball";
    ball.reflection = Reflection::mirror;
    const Index metal = addMaterial(s, ball);
    place(s, sphere(0.5f, 24, metal), moved(-0.7, 0.0, -0.5));
    place(s, sphere(0.4f, 24, metal), moved(0.7, -0.3, -0.8));
    Material glass = clearGlass();
    glass.thickness = 0.6f;
    place(s, sphere(0.3f, 24, addMaterial(s, glass)), moved(0.1, 0.1, 0.4));
    place(s, quad(2.0f, addMaterial(s, mirrorMetal(0.8f))), moved(0.0, 0.0, -2.0));
    place(s, quad(3.0f, addMaterial(s, mirrorMetal(0.9f))),
          glm::rotate(moved(0.0, 0.0, 4.0), glm::pi<double>(), glm::dvec3(0, 1, 0)));
    place(s, quad(0.3f, addMaterial(s, glowing(glm::vec3(3.0f, 2.0f, 1.0f)))), moved(0, 1, -1));
    addLight(s, {.kind = LightKind::point, .intensity = glm::vec3(4.0f)}, moved(1, 2, 2));
    return s;
}

void expectNoHistory(const FrameRequest& base) {
    const auto fresh = [](const FrameRequest& r) {
        renderer().forgetMaps();
        renderer().completeLight(r);  // frames show what is computed so far
        return renderer().render(r).image;
    };
    const Image expected = fresh(base);
    int different = 0;
    for (const Other& other : othersOf(base)) {
        const Image first = fresh(other.request);
        EXPECT_TRUE(sameBytes(renderer().render(base).image, expected)) << "after " << other.what;
        EXPECT_TRUE(sameBytes(renderer().render(other.request).image, first)) << other.what;
        different += !sameBytes(first, expected);
    }
    EXPECT_GT(different, 20) << "the change must be visible";
}

FrameRequest small(const char* id) {
    FrameRequest r = request(scene(), id, {0.0, 0.2, 2.8});
    r.environment.map = "sky";
    r.width = r.height = 48;
    r.accuracy.probeSize = 32;
    r.accuracy.environmentSize = 32;
    r.accuracy.curved = CurvedMethod::probe;
    r.accuracy.glass = GlassMethod::backdrop;
    r.accuracy.planarSamples = 4;
    r.accuracy.curvedSamples = 4;
    return r;
}

TEST_F(History, DoesNotChangeFramesWithMirroredViewsAndCubes) {
    FrameRequest r = small("history of pictures");
    r.accuracy.planar = PlanarMethod::mirror;
    expectNoHistory(r);
}

// Captured cubes hold flat mirrors that follow rays.
TEST_F(History, DoesNotChangeFramesWithRaysInCubes) {
    FrameRequest r = small("history of rays");
    r.accuracy.planar = PlanarMethod::traced;
    expectNoHistory(r);
}

// An idle renderer gives back what frames keep for the next one, but not resident maps.
TEST_F(History, ReleasedScratchIsMadeAgain) {
    FrameRequest r = small("history of released scratch");
    r.accuracy.planar = PlanarMethod::traced;
    renderer().forgetMaps();
    renderer().render(r);
    const Frame before = renderer().render(r);
    const std::uint64_t kept = renderer().counters().texturesMade;
    renderer().render(r);
    EXPECT_EQ(renderer().counters().texturesMade, kept) << "frames reuse targets";
    renderer().releaseScratch();
    const Frame after = renderer().render(r);
    EXPECT_GT(renderer().counters().texturesMade, kept + 1);
    EXPECT_EQ(after.plan.passes.size(), before.plan.passes.size()) << "maps are resident";
    EXPECT_TRUE(sameBytes(after.image, before.image));
    EXPECT_EQ(after.mapBytes, before.mapBytes);
}

// Mesa keeps textures after their deletion until its queue of pictures and its slots for textures
// hold others.
TEST_F(History, ReleasedScratchTakesNoMemory) {
    if (!renderer().identity().software) GTEST_SKIP() << "textures are in the card's memory";
    if (kSanitized) GTEST_SKIP() << "the allocator of a sanitizer has no such counts";
    const auto allocated = [] {
        const struct mallinfo2 info = mallinfo2();
        return static_cast<double>(info.uordblks + info.hblkhd) / (1 << 20);
    };
    FrameRequest r = small("history of memory");
    r.accuracy.planar = PlanarMethod::traced;
    r.accuracy.glass = GlassMethod::backdrop;
    renderer().render(r);
    renderer().releaseScratch();
    const double before = allocated();
    r.width = 1024;
    r.height = 768;
    renderer().render(r);
    const double kept = allocated();
    renderer().releaseScratch();
    const double after = allocated();
    const double color = r.width * r.height * 8.0 / (1 << 20);  // half floats, MB
    EXPECT_GT(kept - before, 4 * color) << "frames keep their targets";
    EXPECT_LT(after - before, color) << "of " << kept - before << " MB";
}

// A standby holds no programs while it rests.
TEST_F(History, ReleasedProgramsAreMadeAgain) {
    const FrameRequest r = small("history of released programs");
    const Frame before = renderer().render(r);
    const std::uint64_t made = renderer().counters().programsMade;
    renderer().render(r);
    EXPECT_EQ(renderer().counters().programsMade, made) << "frames reuse programs";
    renderer().releasePrograms();
    const Frame after = renderer().render(r);
    EXPECT_GT(after.compiled, 0u) << "also when a program has the name of a deleted one";
    EXPECT_GT(renderer().counters().programsMade, made);
    EXPECT_TRUE(sameBytes(after.image, before.image));
}

// The vertex array that was bound last belonged to that scene.
TEST_F(History, ScratchIsReleasedAfterTheLastScene) {
    FrameRequest r = small("history of a scene that is removed");
    renderer().render(r);
    renderer().removeScene(r.scene);
    renderer().releaseScratch();
    EXPECT_NO_THROW(renderer().render(small("history of the next scene")));
}

// A frame that ends before one of its passes leaves complete maps or none.
TEST_F(History, AnAbandonedFrameLeavesNoTrace) {
    FrameRequest r = small("history of abandoned frames");
    r.accuracy.planar = PlanarMethod::mirror;
    renderer().forgetMaps();
    const Frame whole = renderer().render(r);
    const std::size_t passes = whole.plan.passes.size();
    ASSERT_GT(passes, 20u);
    FrameRequest next = r;  // reads the same cubes
    next.exposure = 1.0;
    const Image expected = renderer().render(next).image;
    for (std::size_t last = 0; last < passes; ++last) {
        renderer().forgetMaps();
        const std::uint64_t frames = renderer().counters().frames;
        std::size_t begun = 0;
        EXPECT_THROW(renderer().render(r, Readback::picture, [&] { return begun++ == last; }),
                     FrameAbandoned);
        EXPECT_EQ(begun, last + 1) << "no pass begins after it";
        EXPECT_EQ(renderer().counters().frames, frames);
        ASSERT_TRUE(sameBytes(renderer().render(next).image, expected)) << "before pass " << last;
    }
    std::size_t asked = 0;
    const auto wanted = [&] {
        ++asked;
        return false;
    };
    EXPECT_TRUE(sameBytes(renderer().render(r, Readback::picture, wanted).image, whole.image));
    EXPECT_GT(asked, 0u);
}

// A single draw may fill the picture many times.
TEST_F(History, AFrameEndsWithinALongPass) {
    if (!renderer().identity().software) GTEST_SKIP() << "hardware drivers draw it quickly";
    Scene scene;
    MeshDraft draft{.name = "layers", .hasNormals = true};
    draft.material =
        addMaterial(scene, {.baseColor = {0.5f, 0.2f, 0.1f, 0.1f}, .alphaMode = AlphaMode::blend});
    constexpr int kLayers = 300;
    for (int i = 0; i < kLayers; ++i) {
        const auto first = static_cast<std::uint32_t>(draft.vertices.size());
        for (const glm::vec2 at : {glm::vec2(-4, -4), glm::vec2(4, -4), glm::vec2(0, 8)}) {
            draft.vertices.push_back(
                {.position = glm::vec3(at, -0.001f * static_cast<float>(i)), .normal = {0, 0, 1}});
        }
        for (std::uint32_t k = 0; k < 3; ++k) draft.indices.push_back(first + k);
    }
    place(scene, draft, glm::dmat4(1.0));
    FrameRequest r = request(std::move(scene), "history of a long pass", {0, 0, 2});
    r.width = r.height = 512;
    const Frame whole = renderer().render(r);  // also makes maps
    std::size_t asked = 0;
    const Frame inParts = renderer().render(r, Readback::picture, [&] {
        ++asked;
        return false;
    });
    EXPECT_GT(asked, inParts.plan.passes.size()) << "also within a pass";
    EXPECT_TRUE(sameBytes(inParts.image, whole.image));
    for (std::size_t last = 0; last < asked; ++last) {
        std::size_t begun = 0;
        EXPECT_THROW(renderer().render(r, Readback::picture, [&] { return begun++ == last; }),
                     FrameAbandoned);
        EXPECT_EQ(begun, last + 1);
    }
    EXPECT_TRUE(sameBytes(renderer().render(r).image, whole.image));
}

}  // namespace
}  // namespace clerestory::test
