// Nearer pictures of suns (plan/effects/near_shadows.h). A body 400 m away makes the texels of the
// picture of everything 10 to 40 cm wide; shadows of what is near the camera are as sharp as
// without it.
#include "plan/graph/frame_plan.h"
#include "shadow_support.h"

#include <algorithm>
#include <cstring>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

using namespace clerestory;
using namespace clerestory::test;

namespace {

class NearShadows : public GlTest {};

struct Place {
    double size = 1.0;          // factor on all lengths
    glm::dvec3 origin{0.0};     // in sizes
    std::size_t suns = 1;       // equal ones
    std::vector<double> walls;  // x of squares over further walls, in sizes
};

// As squareOverWall(), with another body 400 sizes away.
Scene largeScene(const Material& blocker, const Place& place) {
    Scene scene;
    scene.environment = "black";
    const auto s = static_cast<float>(place.size);
    const Index wall = addMaterial(scene, lambert(0.5f));
    const Index square = addMaterial(scene, blocker);
    const auto at = [&](double x, double y, double z) {
        return glm::translate(glm::dmat4(1.0), place.size * (place.origin + glm::dvec3(x, y, z)));
    };
    std::vector<double> walls = place.walls;
    walls.push_back(0.0);
    for (const double x : walls) {
        test::place(scene, quad(2.0f * s, wall), at(x, 0.0, 0.0));
        test::place(scene, quad(0.5f * s, square), at(x, 0.0, 1.0));
    }
    test::place(scene, sphere(s, 8, wall), at(400.0, 0.0, 0.0));
    for (std::size_t i = 0; i < place.suns; ++i) {
        Light sun = sunLight();
        sun.intensity /= float(place.suns);
        addLight(scene, sun, shiningAlong({0.0, 0.0, 0.0}, {0.0, 0.0, -1.0}));
    }
    return scene;
}

FrameRequest seen(Scene scene, const Place& place = {}, const std::string& id = "large scene") {
    FrameRequest r =
        request(std::move(scene), id, place.size * (place.origin + glm::dvec3(0.0, 0.0, 0.9)));
    r.camera.znear = 0.01 * place.size;
    r.width = r.height = 201;
    r.accuracy = accuracyOf(Preset::fine);
    r.accuracy.samples = 1;
    r.accuracy.edgeFilter = false;
    return r;
}

FrameRequest shadowed(FrameRequest r) {
    r.effects.shadows = true;
    return r;
}

FrameRequest movedBy(FrameRequest r, double x) {
    r.camera.position->x += x;
    if (r.camera.target) r.camera.target->x += x;
    return r;
}

// Passes whose names begin so.
std::ptrdiff_t passes(const FrameRequest& r, std::string_view start) {
    const FramePlan plan = renderer().plan(r);
    return std::count_if(plan.passes.begin(), plan.passes.end(), [&](const Pass& pass) {
        return std::string_view(pass.name).starts_with(start);
    });
}

bool equal(const Image& a, const Image& b) {
    return a.data.size() == b.data.size() &&
           std::memcmp(a.data.data(), b.data.data(), a.data.size()) == 0;
}

}  // namespace

TEST_F(NearShadows, AreSharpInLargeScenes) {
    const Material opaque = lambertBothSides(0.5f);
    for (const double size : {1e-2, 1.0, 1e3}) {
        for (const double away : {0.0, 100.0}) {
            for (const std::size_t suns : {1u, 2u}) {
                const Place place{.size = size, .origin = {away, -away, 0.0}, .suns = suns};
                expectShadow(
                    draw(seen(largeScene(opaque, place), place)), 0.5, 0.06,
                    std::to_string(size) + ' ' + std::to_string(away) + ' ' + std::to_string(suns));
            }
        }
    }
}

TEST_F(NearShadows, OfHolesAndOfSuns) {
    Material hole = lambertBothSides(0.5f);
    hole.alphaMode = AlphaMode::mask;
    hole.baseColor.a = 0.1f;
    const Pictures p = draw(seen(largeScene(hole, {})));
    EXPECT_TRUE(equal(p.with, p.without));
    Scene scene = largeScene(lambertBothSides(0.5f), {});
    for (Light& light : scene.lights) light.radius = 0.01f;  // half shadows of 1 cm
    expectShadow(draw(seen(std::move(scene))), 0.5, 0.08, "disc");
}

// Where the map of tints, which has no nearer pictures, is read.
TEST_F(NearShadows, GlassCastsItsTint) {
    const float pane = (1.0f - 0.04f) / (1.0f + 0.04f);
    Material coloured = clearGlass();
    coloured.baseColor = {0.9f, 0.4f, 0.1f, 1.0f};
    Scene scene = largeScene(coloured, {});
    // Something that casts a shadow, outside the picture.
    place(scene, quad(0.2f, addMaterial(scene, lambertBothSides(0.5f))), moved(3.0, 0.0, 1.0));
    const FrameRequest r = seen(std::move(scene));
    EXPECT_GT(passes(shadowed(r), "nearShadows:"), 0);
    const Pictures p = draw(r);
    const glm::vec3 left = glm::vec3(0.9f, 0.4f, 0.1f) * pane;
    for (const std::uint32_t x : {90u, 100u, 110u}) {
        const glm::vec3 with = color(p.with, x, 100), without = color(p.without, x, 100);
        for (int k = 0; k < 3; ++k) {
            EXPECT_NEAR(with[k], without[k] * left[k], 2e-3f * without[k]) << x << ' ' << k;
        }
    }
}

// The camera moves: within a step nothing is drawn, beyond it the nearer pictures are, and the
// others never. What was drawn before changes no picture.
TEST_F(NearShadows, FollowTheCameraInSteps) {
    const Place place{.walls = {8.0, 90.0}};
    const FrameRequest r = shadowed(seen(largeScene(lambertBothSides(0.5f), place), place));
    EXPECT_GT(passes(r, "nearShadows:"), 0);
    EXPECT_EQ(passes(r, "shadows:"), 1);
    const Image first = renderer().render(r).image;
    EXPECT_EQ(passes(r, "nearShadows:"), 0);
    EXPECT_EQ(passes(movedBy(r, 1e-3), "nearShadows:"), 0);
    for (const double way : {8.0, 90.0}) {
        const FrameRequest there = movedBy(r, way);
        EXPECT_GT(passes(there, "nearShadows:"), 0) << way;
        EXPECT_EQ(passes(there, "shadows:"), 0) << way;
        const Image second = renderer().render(there).image;
        EXPECT_EQ(passes(there, "nearShadows:"), 0) << way;
        expectShadow({second, renderer()
                                  .render([&] {
                                      FrameRequest without = there;
                                      without.effects.shadows = false;
                                      return without;
                                  }())
                                  .image},
                     0.5, 0.06, "there");
        EXPECT_TRUE(equal(renderer().render(r).image, first)) << way;
        EXPECT_TRUE(equal(renderer().render(there).image, second)) << way;
    }
}

// A captured cube outlives steps of the camera, and is that of a first frame there.
TEST_F(NearShadows, CapturedCubesShowNone) {
    Scene scene = largeScene(lambertBothSides(0.5f), {});
    place(scene, sphere(0.2f, 24, addMaterial(scene, mirrorMetal())), moved(1.2, 0.0, 0.3));
    FrameRequest r = movedBy(shadowed(seen(std::move(scene))), 1.0);
    r.effects.environmentReflection = true;
    r.accuracy.curved = CurvedMethod::probe;
    EXPECT_EQ(passes(r, "probe"), 8);
    renderer().render(r);
    FrameRequest there = r;
    there.camera.position->z = 2.0;  // coarser nearer pictures
    EXPECT_GT(passes(there, "nearShadows:"), 0);
    EXPECT_EQ(passes(there, "probe"), 0);
    const Image later = renderer().render(there).image;
    renderer().forgetMaps();
    EXPECT_EQ(passes(there, "probe"), 8);
    EXPECT_TRUE(equal(renderer().render(there).image, later));
}

// What moves has the shadow that it has at rest.
TEST_F(NearShadows, FollowWhatMoves) {
    const glm::vec3 from(-0.5f, 0.0f, 1.2f), to(0.5f, 0.0f, 1.2f);  // in 2 s
    const auto scene = [&](float x) {
        Scene s = largeScene(lambertBothSides(0.5f), {});
        place(s, quad(0.2f, addMaterial(s, lambertBothSides(0.5f))), moved(x, 0.7, 1.2));
        return s;
    };
    Scene moving = scene(from.x);
    moveLast(moving, from + glm::vec3(0.0f, 0.7f, 0.0f), to + glm::vec3(0.0f, 0.7f, 0.0f));
    FrameRequest r = shadowed(seen(std::move(moving), {}, "moving"));
    for (const double time : {0.5, 1.0, 0.5}) {
        r.time = time;
        EXPECT_GT(passes(r, "nearShadows:"), 0);
        const float x = from.x + static_cast<float>(0.5 * time);
        EXPECT_TRUE(
            equal(renderer().render(r).image, renderer().render(shadowed(seen(scene(x)))).image))
            << time;
    }
}
