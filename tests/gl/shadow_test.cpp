// Shadows of punctual lights (Effects::shadows) with known edges, and hard cases.
#include "plan/graph/frame_plan.h"
#include "shadow_support.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

using namespace clerestory;
using namespace clerestory::test;

namespace {

class Shadows : public GlTest {};

// A rectangle of the box from low to high: the face where axis k is low or high, seen from outside
// the box, or from inside.
void addFace(MeshDraft& draft, const glm::vec3& low, const glm::vec3& high, int k, bool isHigh,
             bool inwards) {
    const auto first = static_cast<Index>(draft.vertices.size());
    for (const auto& [u, v] : {std::pair{0, 0}, {1, 0}, {1, 1}, {0, 1}}) {
        Vertex corner;
        corner.position[k] = isHigh ? high[k] : low[k];
        corner.position[(k + 1) % 3] = u ? high[(k + 1) % 3] : low[(k + 1) % 3];
        corner.position[(k + 2) % 3] = v ? high[(k + 2) % 3] : low[(k + 2) % 3];
        draft.vertices.push_back(corner);
    }
    for (const Index i : {0u, 1u, 2u, 0u, 2u, 3u}) draft.indices.push_back(first + i);
    if (isHigh == inwards) {
        std::reverse(draft.indices.end() - 6, draft.indices.end());
    }
}

}  // namespace

TEST_F(Shadows, ASquareCastsASquare) {
    {
        const Material blocker = lambertBothSides(0.5f);
        // From two edges away a shadow is twice as large, from far away as large as the square.
        expectShadow(draw(squareOverWall(pointLight(), {0.0, 0.0, 3.0}, blocker)), 0.75, 0.03,
                     "point");
        expectShadow(draw(squareOverWall(spotLight(), {0.0, 0.0, 3.0}, blocker)), 0.75, 0.03,
                     "spot");
        expectShadow(draw(squareOverWall(sunLight(), {0.0, 0.0, 3.0}, blocker)), 0.5, 0.02, "sun");
    }
}

// Lengths from a millimetre to ten kilometres, and far from the origin.
TEST_F(Shadows, ScaleAndPlaceDoNotMatter) {
    for (const double size : {1e-3, 1.0, 1e4}) {
        for (const double away : {0.0, 1e3}) {
            const glm::dvec3 origin(away * size, -away * size, 0.0);
            const std::string name = std::to_string(size) + " at " + std::to_string(away);
            expectShadow(draw(squareOverWall(pointLight(), {0.0, 0.0, 3.0}, lambertBothSides(0.5f),
                                             size, origin)),
                         0.75, 0.03, "point, " + name);
            expectShadow(draw(squareOverWall(sunLight(), {0.0, 0.0, 3.0}, lambertBothSides(0.5f),
                                             size, origin)),
                         0.5, 0.02, "sun, " + name);
        }
    }
}

TEST_F(Shadows, HolesLetLightThrough) {
    Material hole = lambertBothSides(0.5f);
    hole.alphaMode = AlphaMode::mask;
    hole.baseColor.a = 0.1f;
    const Pictures p = draw(squareOverWall(pointLight(), {0.0, 0.0, 3.0}, hole));
    EXPECT_EQ(std::memcmp(p.with.data.data(), p.without.data.data(), p.with.data.size()), 0);
}

// A body alone hides light from its own back only, where the cosine already leaves nothing.
TEST_F(Shadows, ABallAloneLooksAsWithout) {
    for (const bool doubleSided : {false, true}) {
        for (const Light& light : {pointLight(), sunLight()}) {
            Scene scene;
            place(scene,
                  sphere(0.8f, 64,
                         addMaterial(scene, doubleSided ? lambertBothSides(0.5f) : lambert(0.5f))));
            addLight(scene, light, shiningAlong({2.0, 2.0, 2.0}, {-1.0, -1.0, -1.0}));
            FrameRequest r = request(std::move(scene), "ball");
            r.width = r.height = 128;
            const Pictures p = draw(r);
            float greatest = 0.0f;
            for (std::uint32_t y = 0; y < 128; ++y) {
                for (std::uint32_t x = 0; x < 128; ++x) {
                    greatest = std::max(greatest, color(p.without, x, y).x);
                }
            }
            for (std::uint32_t y = 0; y < 128; ++y) {
                for (std::uint32_t x = 0; x < 128; ++x) {
                    // Towards the rim of the light facets of the mesh turn away before its normals.
                    const float without = color(p.without, x, y).x;
                    const float allowed = without > 0.1f * greatest ? 0.01f * greatest : without;
                    EXPECT_NEAR(color(p.with, x, y).x, without, allowed + 1e-6f)
                        << doubleSided << ' ' << x << ' ' << y;
                }
            }
        }
    }
}

// The samples of `fine` differ from the mean of 64 pixels of a finer picture by what they miss.
TEST_F(Shadows, SamplesAreShadedOnTheirTriangles) {
    Scene scene;
    scene.environment = "black";
    Material glossy = lambert(0.5f);
    glossy.roughness = 0.3f;
    const Index gloss = addMaterial(scene, glossy);
    for (int i = 0; i < 9; ++i) {
        place(scene, sphere(0.3f, 40, gloss), moved(0.7 * (i % 3 - 1), 0.7 * (i / 3 - 1), 0.0));
    }
    addLight(scene, sunLight(), shiningAlong({0.0, 0.0, 3.0}, {-1.0, -0.6, -0.5}));
    FrameRequest r = request(std::move(scene), "balls", {0.0, 0.0, 3.0});
    r.effects.shadows = true;
    r.accuracy.samples = accuracyOf(Preset::fine).samples;
    r.width = r.height = 48;
    const Image few = renderer().render(r).image;
    r.accuracy.samples = 1;
    r.width = r.height = 8 * 48;
    const Image finer = renderer().render(r).image;
    double largest = 0.0, sum = 0.0;
    for (std::uint32_t y = 0; y < 48; ++y) {
        for (std::uint32_t x = 0; x < 48; ++x) {
            glm::vec3 mean(0.0f);
            for (std::uint32_t i = 0; i < 64; ++i) {
                mean += color(finer, 8 * x + i % 8, 8 * y + i / 8) / 64.0f;
            }
            const double off = std::abs(std::sqrt(color(few, x, y).x) - std::sqrt(mean.x));
            largest = std::max(largest, off);
            sum += off * off;
        }
    }
    EXPECT_LT(largest, 0.28);  // 0.076 of a pixel, between the first samples
    EXPECT_LT(sum, 0.5);
}

// A ball on a floor, seen from within through the backs of its faces. A far body makes the texels
// of the map 6 cm wide. Half a texel above the floor is outside the ball up to 17 cm from the point
// of contact, and texels that show the ball there reach 6 cm further.
TEST_F(Shadows, ContactsAreClosedToAboutATexel) {
    constexpr float kRadius = 0.5f, kOpen = 0.24f;  // metres
    Scene scene;
    place(scene, quad(2.0f, addMaterial(scene, lambert(0.5f))));
    const Index body = addMaterial(scene, lambert(0.5f));
    for (const double x : {0.0, 60.0}) {
        place(scene, sphere(kRadius, 64, body),
              glm::translate(glm::dmat4(1.0), glm::dvec3(x, 0.0, kRadius)));
    }
    addLight(scene, sunLight(), shiningAlong({0.0, 0.0, 20.0}, {0.0, 0.0, -1.0}));
    FrameRequest r = request(std::move(scene), "ball on a floor", {0.0, 0.0, kRadius});
    r.width = r.height = 101;
    r.accuracy = accuracyOf(Preset::draft);
    const Pictures p = draw(r);
    std::size_t dark = 0;
    for (std::uint32_t y = 0; y < 101; ++y) {
        for (std::uint32_t x = 0; x < 101; ++x) {
            const double away = std::hypot(x - 50.0, y - 50.0) / 101.0;  // metres
            if (away < kOpen || away > 0.8 * kRadius) continue;
            ++dark;
            EXPECT_GT(color(p.without, x, y).x, 0.0f);
            EXPECT_EQ(color(p.with, x, y).x, 0.0f) << x << ' ' << y;
        }
    }
    EXPECT_GT(dark, 3000u);
}

// Light does not enter a closed room along the edges where two walls meet, or a wall and the middle
// of the ceiling. A far body makes the texels of the map 5 cm wide. Comparing a receiver with each
// of the four texels about it lets light onto 332 to 657 of the pixels; what is left is at edges
// where the four are of two planes.
TEST_F(Shadows, ClosedRoomsAreDarkUpToTheirEdges) {
    enum class Walls { slabs, oneSided, twoSided };
    for (const Walls walls : {Walls::slabs, Walls::oneSided, Walls::twoSided}) {
        for (const float radius : {0.0f, 0.005f}) {
            Scene scene;
            const Index wall = addMaterial(
                scene, walls == Walls::twoSided ? lambertBothSides(0.5f) : lambert(0.5f));
            for (int k = 0; k < 3; ++k) {
                for (const bool isHigh : {false, true}) {
                    MeshDraft draft{.material = wall};
                    glm::vec3 low(-2.0f), high(2.0f);
                    if (walls == Walls::slabs) {
                        // The ceiling and the floor reach over the walls, and two of these over
                        // the others.
                        low = glm::vec3(k == 2 ? -2.0f : -2.1f, k == 1 ? -2.1f : -2.0f, -2.1f);
                        high = -low;
                        (isHigh ? low : high)[k] = isHigh ? 2.0f : -2.0f;
                        if (k == 2) (isHigh ? high : low)[k] = isHigh ? 2.1f : -2.1f;
                        for (int face = 0; face < 6; ++face) {
                            addFace(draft, low, high, face / 2, face % 2 == 1, false);
                        }
                    } else {
                        addFace(draft, low, high, k, isHigh, true);
                    }
                    place(scene, std::move(draft));
                }
            }
            place(scene, sphere(0.1f, 8, wall), moved(40.0, 0.0, 0.0));
            Light sun = sunLight();
            sun.radius = radius;
            addLight(scene, sun, shiningAlong({0.0, 0.0, 0.0}, {-0.6, -0.55, -0.57}));
            FrameRequest r = request(std::move(scene), "closed room", {0.0, 0.0, 1.9});
            r.width = r.height = 400;
            const Pictures p = draw(r);
            std::size_t lit = 0, bright = 0;
            for (std::uint32_t y = 0; y < r.height; ++y) {
                for (std::uint32_t x = 0; x < r.width; ++x) {
                    lit += color(p.with, x, y).x > 0.0f;
                    bright += color(p.without, x, y).x > 0.1f;
                }
            }
            EXPECT_LE(lit, 160u) << int(walls) << ' ' << radius;  // of 160,000
            EXPECT_GT(bright, 50000u) << int(walls) << ' ' << radius;
        }
    }
}

// Light that grazes a wall: no acne, however flat.
TEST_F(Shadows, GrazingLightLeavesNoPattern) {
    for (const double height : {1.0, 0.3, 0.1}) {
        Scene scene;
        place(scene, quad(2.0f, addMaterial(scene, lambertBothSides(0.5f))));
        addLight(scene, sunLight(), shiningAlong({0.0, 0.0, 0.0}, {-1.0, -0.2, -height}));
        FrameRequest r = request(std::move(scene), "grazing", {0.0, 0.0, 1.0});
        const Pictures p = draw(r);
        EXPECT_EQ(std::memcmp(p.with.data.data(), p.without.data.data(), p.with.data.size()), 0)
            << height;
    }
}

// In the plane of a receiver and inside a closed body: finite, and dark outside.
TEST_F(Shadows, ALightInsideABodyIsHidden) {
    Scene scene;
    place(scene, quad(2.0f, addMaterial(scene, lambert(0.5f))), moved(0.0, 0.0, -0.5));
    place(scene, sphere(0.4f, 32, addMaterial(scene, lambertBothSides(0.5f))));
    addLight(scene, pointLight(), moved(0.0, 0.0, 0.0));
    FrameRequest r = request(std::move(scene), "inside");
    const Pictures p = draw(r);
    for (const std::uint32_t x : {8u, 12u, 51u, 55u}) {
        EXPECT_GT(color(p.without, x, 32).x, 0.0f) << x;
        EXPECT_EQ(color(p.with, x, 32).x, 0.0f) << x;
    }
    Scene flat;
    place(flat, quad(2.0f, addMaterial(flat, lambertBothSides(0.5f))));
    addLight(flat, pointLight(), moved(0.3, 0.0, 0.0));
    const Pictures inPlane = draw(request(std::move(flat), "in plane"));
    const float* values = inPlane.with.floats();
    EXPECT_TRUE(std::all_of(values, values + std::size_t{3} * 64 * 64,
                            [](float v) { return std::isfinite(v) && v >= 0.0f; }));
}

TEST_F(Shadows, TheMapIsDrawnOnceAndOnlyIfItIsNeeded) {
    const auto passes = [](const FrameRequest& r) {
        const FramePlan plan = renderer().plan(r);
        return std::count_if(plan.passes.begin(), plan.passes.end(),
                             [](const Pass& pass) { return pass.kind() == "shadow"; });
    };
    FrameRequest r = squareOverWall(pointLight(), {0.0, 0.0, 3.0}, lambertBothSides(0.5f));
    EXPECT_EQ(passes(r), 0);
    r.effects.shadows = true;
    EXPECT_EQ(passes(r), 6);
    renderer().render(r);
    EXPECT_EQ(passes(r), 0);
    r.camera.position = glm::dvec3(0.2, 0.1, 0.7);
    EXPECT_EQ(passes(r), 0);
    r = squareOverWall(sunLight(), {0.0, 0.0, 3.0}, lambertBothSides(0.5f));
    r.effects.shadows = true;
    EXPECT_EQ(passes(r), 1);

    Scene dark;
    place(dark, quad(1.0f, addMaterial(dark, lambert(0.5f))));
    FrameRequest none = request(std::move(dark), "no lights");
    none.effects.shadows = true;
    EXPECT_EQ(passes(none), 0);
}

// A lamp that gives 1 % of the light has a shadow at presets whose tolerance is smaller, and one
// that reaches nothing has none. What is left out changes the picture by less than the preset's
// tolerance.
TEST_F(Shadows, LightsHaveThemWhereTheyAreWorthIt) {
    Scene scene;
    const Index wall = addMaterial(scene, lambert(0.5f));
    place(scene, quad(2.0f, wall));
    place(scene, quad(0.15f, addMaterial(scene, lambertBothSides(0.5f))), moved(0.0, 0.0, 1.0));
    addLight(scene, pointLight(), moved(0.0, 0.0, 2.0));
    Light dim = pointLight();
    dim.intensity *= 0.008f;
    addLight(scene, dim, moved(0.5, 0.0, 2.0));
    Light far = pointLight();
    far.range = 0.5f;
    addLight(scene, far, moved(0.0, 0.0, 9.0));
    FrameRequest r = request(std::move(scene), "three lamps", {0.0, 0.0, 0.9});
    r.effects.shadows = true;
    const auto drawn = [&](Preset preset) {
        FrameRequest asked = r;
        asked.accuracy = accuracyOf(preset);
        asked.accuracy.edgeFilter = false;
        asked.accuracy.samples = 1;
        return renderer().render(asked);
    };
    const Frame draft = drawn(Preset::draft), fine = drawn(Preset::fine);
    const auto shadowed = [](const Frame& frame) {
        std::vector<bool> has;
        for (const PlacedLight& light : frame.plan.lights) has.push_back(light.shadow.has_value());
        return has;
    };
    EXPECT_EQ(shadowed(draft), (std::vector<bool>{true, false, false})) << toText(draft.plan);
    EXPECT_EQ(shadowed(fine), (std::vector<bool>{true, true, false})) << toText(fine.plan);
    EXPECT_TRUE(
        std::any_of(draft.plan.skipped.begin(), draft.plan.skipped.end(),
                    [](const auto& skipped) { return skipped.reason == "reaches no surface"; }));
    EXPECT_EQ(draft.plan.decisions.size(), 2u);
    EXPECT_EQ(draft.plan.decisions.at(1).taken, Method::unshadowed);

    double squares = 0.0, all = 0.0;
    for (std::uint32_t y = 0; y < r.height; ++y) {
        for (std::uint32_t x = 0; x < r.width; ++x) {
            const double a = color(draft.image, x, y).x, b = color(fine.image, x, y).x;
            // The edge of the strong lamp's shadow is finer in one of the pictures.
            if (std::abs(a - b) > 0.1) continue;
            squares += (a - b) * (a - b);
            all += b * b;
        }
    }
    EXPECT_GT(std::sqrt(squares / all), 1e-4);
    EXPECT_LT(std::sqrt(squares / all), 2.2e-2);
}
