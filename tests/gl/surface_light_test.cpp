// Light between surfaces (Effects::indirectLight) with known results: furnaces, closed rooms, form
// factors.
#include "lit_room.h"
#include "scene/builtin/modelling.h"

#include <cmath>
#include <numbers>

using namespace clerestory;
using namespace clerestory::test;

namespace {

class LightBetweenSurfaces : public GlTest {};

}  // namespace

TEST_F(LightBetweenSurfaces, AClosedRoomIsDarkUnderAnySky) {
    Scene scene;
    placeRoom(scene, addMaterial(scene, lambert(0.5f)));
    FrameRequest r = request(std::move(scene), "closed", {0.0, 0.0, 0.5});
    r.environment.map = "white";
    EXPECT_NEAR(centerColor(renderer().render(r).image).x, 0.5f, 1e-2f);
    const Image dark = renderer().render(lit(r)).image;
    for (std::uint32_t y = 0; y < dark.height; y += 7) {
        for (std::uint32_t x = 0; x < dark.width; x += 7) EXPECT_LT(color(dark, x, y).x, 1e-3f);
    }
}

// Each bounce brings `albedo` times the one before: the sum is 1 / (1 - albedo) times the first.
TEST_F(LightBetweenSurfaces, ARoomOfGlowingWallsHasTheSumOfAllBounces) {
    for (const float albedo : {0.5f, 0.8f, 0.9f}) {
        Scene scene;
        placeRoom(scene, addMaterial(scene, lambert(albedo, 0.25f)));
        const FrameRequest r = lit(request(std::move(scene), "glowing", {0.0, 0.0, 0.5}));
        const Image image = renderer().render(r).image;
        const float expected = 0.25f / (1.0f - albedo);
        for (std::uint32_t y = 0; y < image.height; y += 7) {
            for (std::uint32_t x = 0; x < image.width; x += 7) {
                EXPECT_NEAR(color(image, x, y).x, expected, 0.03f * expected)
                    << albedo << ' ' << x << ' ' << y;
            }
        }
    }
}

// Between two large plates at a small distance each sees the other only. With albedo a and one
// plate that emits e, the plates have e / (1 - a^2) and a e / (1 - a^2).
TEST_F(LightBetweenSurfaces, ACorridorOfTwoGreyWallsHasItsSeries) {
    Scene scene;
    place(scene, quad(20.0f, addMaterial(scene, lambert(0.5f))));
    Material bright = lambert(0.5f, 0.3f);
    bright.doubleSided = true;
    place(scene, quad(20.0f, addMaterial(scene, bright)), moved(0.0, 0.0, 1));
    FrameRequest r = request(std::move(scene), "corridor");
    r = lit(lookingAt(r, {0.0, 0.0, 0.5}, {0.01, 0.0, 0.0}));
    EXPECT_NEAR(centerColor(renderer().render(r).image).x, 0.2f, 0.006f);
    r.camera.target = {0.01, 0.0, 1};
    EXPECT_NEAR(centerColor(renderer().render(r).image).x, 0.4f, 0.012f);
}

// Walls that transmit all light diffusely have the radiance of a uniform sky on the inside, and
// what is in the room is lit as if it were outside.
TEST_F(LightBetweenSurfaces, DiffuselyTransmittingWallsLightARoom) {
    Scene scene;
    Material sheet = lambert(1.0f);
    sheet.doubleSided = true;
    sheet.diffuseTransmission = 1.0f;
    placeRoom(scene, addMaterial(scene, sheet));
    place(scene, quad(0.2f, addMaterial(scene, lambert(0.5f))));
    FrameRequest r =
        lookingAt(request(std::move(scene), "sheets"), {0.0, 0.0, 0.5}, {0.0, 0.0, 0.0});
    r.environment.map = "white";
    const Image image = renderer().render(lit(r)).image;
    EXPECT_NEAR(centerColor(image).x, 0.5f, 0.015f) << "a square in the room";
    EXPECT_NEAR(color(image, 2, 2).x, 1.0f, 0.03f) << "a wall";
}

// Howell, A Catalog of Radiation Heat Transfer Configuration Factors, B-3: a rectangle over a
// parallel element below its corner, four times. Glass that does not bend light changes nothing.
TEST_F(LightBetweenSurfaces, ARectangularLampLightsTheFloorAsItsFormFactor) {
    const struct {
        double height;
        bool glass;
    } cases[] = {{0.5, false}, {1.0, false}, {2.0, false}, {0.2, true}, {1.0, true}};
    for (const auto& [height, glass] : cases) {
        Scene scene;
        if (glass) {
            Material clear = clearGlass(1.0f);
            clear.doubleSided = true;
            place(scene, quad(0.6f, addMaterial(scene, clear)), facingDown(0.9 * height));
        }
        place(scene, quad(3.0f, addMaterial(scene, lambert(0.5f))), facingUp());
        Material lamp = lambert(0.0f, 4.0f);
        lamp.doubleSided = false;
        place(scene, quad(0.5f, addMaterial(scene, lamp)), facingDown(height));
        // From next to the lamp to the point below its centre.
        const FrameRequest r =
            lit(lookingAt(request(std::move(scene), "lamp"), {2.0, 0.3, 0.0}, {0.0, 0.0, 0.0}));
        const double a = 0.5 / height, root = std::sqrt(1.0 + a * a);
        const double factor = 4.0 / (2.0 * std::numbers::pi) * 2.0 * a / root * std::atan(a / root);
        const double expected = 0.5 * 4.0 * factor;
        EXPECT_NEAR(centerColor(renderer().render(r).image).x, expected, 0.04 * expected)
            << height << (glass ? ", glass" : "");
    }
}

// At its foot, half of the sky is behind a high wall.
TEST_F(LightBetweenSurfaces, AWallHidesHalfOfTheSky) {
    Scene scene;
    place(scene, quad(4.0f, addMaterial(scene, lambert(0.5f))), facingUp());
    glm::dmat4 wall(1.0);
    wall[3] = {0.0, 4.0, -0.25, 1.0};
    place(scene, quad(4.0f, addMaterial(scene, lambert(0.0f))), wall);
    FrameRequest r = lookingAt(request(std::move(scene), "wall"), {0.0, 0.5, 2.0}, {0.0, 0.0, 0.0});
    r.environment.map = "white";
    const double open = centerColor(renderer().render(r).image).x;
    // A rectangle of half width 4 and height 8 that stands upright at 0.25 (Howell, B-4, twice).
    const double x = 8.0 / 4.0, y = 0.25 / 4.0;
    const double hidden = 2.0 / (2.0 * std::numbers::pi) *
                          (std::atan(1.0 / y) - y / std::sqrt(x * x + y * y) *
                                                    std::atan(1.0 / std::sqrt(x * x + y * y)));
    EXPECT_NEAR(centerColor(renderer().render(lit(r)).image).x / open, 1.0 - hidden, 0.03);
}

TEST_F(LightBetweenSurfaces, AConvexBodyHasAllOfTheSky) {
    for (const float metallic : {0.0f, 1.0f}) {
        Scene scene;
        place(scene,
              sphere(1.0f, 48, addMaterial(scene, {.metallic = metallic, .roughness = 0.8f})));
        FrameRequest r = request(std::move(scene), "ball");
        r.environment.map = "white";
        const Frame frame = renderer().render(lit(r));
        EXPECT_EQ(frame.light.revision, 1u) << "one round shows that nothing is hidden";
        const Image& image = frame.image;
        for (std::uint32_t y = 0; y < image.height; y += 5) {
            for (std::uint32_t x = 0; x < image.width; x += 5) {
                EXPECT_NEAR(color(image, x, y).x, 1.0f, 0.02f) << metallic << ' ' << x << ' ' << y;
            }
        }
    }
}

TEST_F(LightBetweenSurfaces, RoughMetalInAClosedRoomDoesNotShowTheSky) {
    Scene scene;
    placeRoom(scene, addMaterial(scene, lambert(0.5f)));
    place(scene, sphere(0.3f, 32, addMaterial(scene, {.metallic = 1.0f, .roughness = 0.9f})));
    FrameRequest r = request(std::move(scene), "metal", {0.0, 0.0, 0.9});
    r.environment.map = "white";
    EXPECT_GT(centerColor(renderer().render(r).image).x, 0.9f);
    EXPECT_LT(centerColor(renderer().render(lit(r)).image).x, 2e-2f);
}

// Two balls between walls that glow alike show these walls, however they are drawn, and nothing of
// the sky, which is ten times as bright. With one bounce paths end at a ball. Where the balls are
// close to each other the picture is too dark, because light between surfaces loses what glass
// reflects.
TEST_F(LightBetweenSurfaces, BallsOfGlassAndMetalInAClosedRoomDoNotShowTheSky) {
    struct {
        const char* name;
        Material ball;
        GlassMethod glass;
        CurvedMethod curved;
    } cases[] = {
        {"glass", clearGlass(1.5f), GlassMethod::environment, CurvedMethod::environment},
        {"rays of glass", clearGlass(1.5f), GlassMethod::traced, CurvedMethod::environment},
        {"rays of metal", mirrorMetal(), GlassMethod::automatic, CurvedMethod::traced}};
    for (auto& [name, ball, glass, curved] : cases) {
        constexpr float kGlow = 0.1f;
        Scene scene;
        placeRoom(scene, addMaterial(scene, lambert(0.0f, kGlow)));
        ball.thickness = ball.transmission > 0.0f ? 0.6f : 0.0f;
        const Index m = addMaterial(scene, ball);
        place(scene, sphere(0.3f, 48, m), moved(-0.32, 0.0, 0.0));
        place(scene, sphere(0.3f, 48, m), moved(0.32, 0.0, 0.0));
        FrameRequest r = request(std::move(scene), name, {0.0, 0.0, 0.9});
        r.environment.map = "white";
        r.accuracy.glass = glass;
        r.accuracy.curved = curved;
        r.accuracy.bounces = 1;
        r = lit(r);
        const Image image = renderer().render(r).image;
        for (std::uint32_t y = 0; y < image.height; ++y) {
            for (std::uint32_t x = 0; x < image.width; ++x) {
                const float shown = color(image, x, y).x;
                ASSERT_LT(shown, 1.15f * kGlow) << name << ' ' << x << ' ' << y;
                ASSERT_GT(shown, 0.5f * kGlow) << name << ' ' << x << ' ' << y;
            }
        }
    }
}

// Seen from inside, along the walls: all of the sky arrives on their other side.
TEST_F(LightBetweenSurfaces, ThinWallsDoNotShowTheSkyOfTheirOtherSide) {
    for (const float roughness : {0.3f, 0.9f}) {
        Scene scene;
        placeRoom(scene, addMaterial(scene, {.baseColor = {0.5f, 0.5f, 0.5f, 1.0f},
                                             .metallic = 1.0f,
                                             .roughness = roughness,
                                             .doubleSided = true}));
        FrameRequest r = request(std::move(scene), "thin", {0.9, 0.0, 0.9});
        r.camera.target = {0.99, 0.0, -1.0};
        r.effects.planarReflection = false;
        r.environment.map = "white";
        const Image inside = renderer().render(lit(r)).image;
        for (std::uint32_t y = 0; y < inside.height; y += 3) {
            for (std::uint32_t x = 0; x < inside.width; x += 3) {
                EXPECT_LT(color(inside, x, y).x, 2e-2f) << roughness << ' ' << x << ' ' << y;
            }
        }
        r.camera.position = {3.0, 0.0, 0.0};
        r.camera.target = {0.0, 0.0, 0.0};
        const float open = centerColor(renderer().render(r).image).x;
        EXPECT_GT(open, 0.3f);
        EXPECT_NEAR(centerColor(renderer().render(lit(r)).image).x, open, 0.02f * open);
    }
}

// A wall between a red light and a blue one.
TEST_F(LightBetweenSurfaces, EachSideOfAWallHasItsOwnColour) {
    Scene scene;
    Material wall = lambert(0.5f);
    wall.doubleSided = true;
    place(scene, quad(1.0f, addMaterial(scene, wall)));
    Material red = lambert(0.0f), blue = lambert(0.0f);
    red.emissive = {1.0f, 0.0f, 0.0f};
    blue.emissive = {0.0f, 0.0f, 1.0f};
    red.doubleSided = blue.doubleSided = true;
    place(scene, quad(2.0f, addMaterial(scene, red)), moved(0.0, 0.0, 1.0));
    place(scene, quad(2.0f, addMaterial(scene, blue)), moved(0.0, 0.0, -1.0));
    FrameRequest r = request(std::move(scene), "colours", {0.0, 0.0, 0.9});
    r.environment.intensity = 0.0;
    const glm::vec3 front = centerColor(renderer().render(lit(r)).image);
    r.camera.position = {0.0, 0.0, -0.9};
    const glm::vec3 back = centerColor(renderer().render(lit(r)).image);
    EXPECT_GT(front.x, 0.25f);
    EXPECT_LT(front.z, 1e-2f * front.x);
    EXPECT_NEAR(back.z, front.x, 1e-2f * front.x);
    EXPECT_LT(back.x, 1e-2f * back.z);
}

// A sheet of rough metal between a bright wall and one with a thousandth of its light, as the
// inside and the outside of a lampshade.
TEST_F(LightBetweenSurfaces, EachSideOfRoughMetalReflectsWhatItFaces) {
    Scene scene;
    Material metal{.baseColor = {0.5f, 0.5f, 0.5f, 1.0f},
                   .metallic = 1.0f,
                   .roughness = 0.8f,
                   .doubleSided = true};
    place(scene, quad(1.0f, addMaterial(scene, metal)));
    const auto wall = [&](double z, float radiance) {
        Material glow = lambert(0.0f, radiance);
        glow.doubleSided = true;
        place(scene, quad(20.0f, addMaterial(scene, glow)), moved(0.0, 0.0, z));
    };
    wall(1.0, 100.0f);
    wall(-1.0, 0.1f);
    FrameRequest r = request(std::move(scene), "shade", {0.0, 0.0, 0.9});
    r.environment.intensity = 0.0;
    const float front = centerColor(renderer().render(lit(r)).image).x;
    r.camera.position = {0.0, 0.0, -0.9};
    const float back = centerColor(renderer().render(lit(r)).image).x;
    EXPECT_GT(front, 10.0f);
    EXPECT_GT(back, 3e-4f * front);
    EXPECT_LT(back, 2e-3f * front);
}

// A pane has no inside: surfaces behind its back are not inside a body.
TEST_F(LightBetweenSurfaces, ARoomUnderOneSidedGlassIsLit) {
    const auto floor = [](bool bothSides) {
        Scene scene;
        placeRoom(scene, addMaterial(scene, lambert(0.5f)));
        scene.instances.erase(scene.instances.begin() + 3);  // the ceiling
        Material glass = clearGlass();
        glass.doubleSided = bothSides;
        place(scene, quad(1.0f, addMaterial(scene, glass)), moved(0.0, -0.8, 0.0) * facingUp());
        FrameRequest r = request(std::move(scene), "under glass", {0.0, 0.5, 0.5});
        r.camera.target = {0.0, -1.0, 0.0};
        r.environment.map = "white";
        return centerColor(renderer().render(lit(r)).image).x;
    };
    const float expected = floor(true);
    EXPECT_GT(expected, 0.05f);
    EXPECT_NEAR(floor(false), expected,
                0.15f * expected);  // a back that is not drawn reflects nothing
}

// A box of thin walls that is open towards +z. The same point of a rough metal wall shows the
// inside to who looks in, and the sky to who looks out.
TEST_F(LightBetweenSurfaces, ThinWallsMirrorWhatTheyFace) {
    Scene scene;
    const auto metal = [](float reflectance) {
        return Material{.baseColor = glm::vec4(glm::vec3(reflectance), 1.0f),
                        .metallic = 1.0f,
                        .roughness = 0.3f,
                        .doubleSided = true};
    };
    placeRoom(scene, addMaterial(scene, metal(0.1f)));
    scene.instances.pop_back();  // the wall at z = 1
    const Index wall = addMaterial(scene, metal(1.0f));
    scene.instances[1].material = wall;  // at x = 1
    FrameRequest r = request(std::move(scene), "box", {0.0, 0.0, 0.9});
    r.effects.planarReflection = false;
    r.environment.map = "white";
    r.camera.target = {1.0, 0.0, 0.0};
    const float inwards = centerColor(renderer().render(lit(r)).image).x;
    r.camera.position = {0.0, 0.0, -0.9};
    const float outwards = centerColor(renderer().render(lit(r)).image).x;
    EXPECT_LT(inwards, 0.1f);
    EXPECT_GT(outwards, 0.5f);  // linear in the direction
}

// A lamp that fills a hundredth of the directions is in few lobes.
TEST_F(LightBetweenSurfaces, ASmallLampIsNotInEveryLobe) {
    Scene scene;
    placeRoom(scene, addMaterial(scene, lambert(0.0f)));
    Material metal{.metallic = 1.0f, .roughness = 0.3f};
    place(scene, quad(0.5f, addMaterial(scene, metal)), moved(0.0, 0.0, -0.99));
    place(scene, quad(0.1f, addMaterial(scene, lambert(0.0f, 100.0f))),
          moved(0.0, 0.9, 0.0) * facingDown(0.0));
    FrameRequest r = request(std::move(scene), "lamp", {0.0, -0.5, 0.0});
    r.camera.target = {0.0, -0.4, -0.99};
    EXPECT_LT(centerColor(renderer().render(lit(r)).image).x, 0.1f);
}

// Rays from the edge of a wall begin in the plane of the next one.
TEST_F(LightBetweenSurfaces, EdgesOfThinWallsDoNotShowTheSkyOfTheirOtherSide) {
    Scene scene;
    Material thin = lambert(0.5f);
    thin.doubleSided = true;
    placeRoom(scene, addMaterial(scene, thin));
    FrameRequest r = request(std::move(scene), "edges", {0.0, 0.0, 0.9});
    r.camera.target = {-0.9, -0.9, -0.9};
    r.environment.map = "white";
    r = lit(r);
    const Image inside = renderer().render(r).image;
    for (std::uint32_t y = 0; y < inside.height; ++y) {
        for (std::uint32_t x = 0; x < inside.width; ++x) {
            EXPECT_LT(color(inside, x, y).x, 2e-2f) << x << ' ' << y;
        }
    }
}

// What lies on a floor does not take the light of the floor below it, which is dark.
TEST_F(LightBetweenSurfaces, ASlabOnTheFloorIsAsBrightAsTheRoom) {
    for (const double thickness : {0.002, 0.01}) {
        Scene scene;
        placeRoom(scene, addMaterial(scene, lambert(0.5f, 0.25f)));
        const Index stone = addMaterial(scene, lambert(0.5f));
        place(scene, quad(0.95f, stone), moved(0.0, thickness - 0.999, 0.0) * facingUp());
        place(scene, quad(0.95f, stone), facingDown(-0.999));
        FrameRequest r = request(std::move(scene), "slab");
        r = lit(lookingAt(r, {0.0, 0.8, 0.4}, {0.0, -1.0, 0.0}));
        const Image image = renderer().render(r).image;
        for (std::uint32_t y = 24; y <= 40; ++y) {
            for (std::uint32_t x = 24; x <= 40; ++x) {
                // The other five walls have a little less than 0.5 each, because the slab reflects
                // only.
                EXPECT_NEAR(color(image, x, y).x, 0.22f, 0.04f)
                    << thickness << ' ' << x << ' ' << y;
            }
        }
    }
}

// The floor below a box is dark, and no part of the floor around it takes light from there; whether
// the box's material has one side or two, its inside is not seen.
TEST_F(LightBetweenSurfaces, ClosedBodiesOfTwoSidedMaterialsStandOnFloorsWithoutASeam) {
    Image images[2];
    for (const bool twoSided : {false, true}) {
        Scene scene;
        place(scene, quad(2.0f, addMaterial(scene, lambert(0.5f))), facingUp());
        Material grey = lambert(0.5f);
        grey.doubleSided = twoSided;
        MeshDraft box{.material = addMaterial(scene, grey)};
        shapes::addBox(box, glm::vec3(-0.4f, 0.0f, -0.4f), glm::vec3(0.4f, 0.8f, 0.4f));
        place(scene, box);
        FrameRequest r = request(std::move(scene), "box");
        r.environment.map = "white";
        r = lit(lookingAt(r, {1.2, 1.2, 1.6}, {0.0, 0.0, 0.0}));
        images[twoSided] = renderer().render(r).image;
    }
    for (std::uint32_t y = 0; y < images[0].height; ++y) {
        for (std::uint32_t x = 0; x < images[0].width; ++x) {
            EXPECT_NEAR(color(images[1], x, y).x, color(images[0], x, y).x, 0.02f) << x << ' ' << y;
        }
    }
}

// A room may be one closed mesh whose faces are drawn from both sides and wound outwards. Its
// inside is seen, also if what stands in it reaches through the floor.
TEST_F(LightBetweenSurfaces, ClosedRoomsOfTwoSidedMaterialsAreLitInside) {
    for (const float emitted : {0.0f, 0.25f}) {
        Scene scene;
        Material wall = lambert(0.5f, emitted);
        wall.doubleSided = true;
        MeshDraft room{.material = addMaterial(scene, wall)};
        shapes::addBox(room, glm::vec3(-1.0f), glm::vec3(1.0f));
        place(scene, room);
        if (emitted == 0.0f) {
            MeshDraft lamp{.material = addMaterial(scene, glowing(glm::vec3(2.0f)))};
            shapes::addBox(lamp, glm::vec3(-0.4f, -1.1f, -0.4f), glm::vec3(0.4f, -0.6f, 0.4f));
            place(scene, lamp);
        }
        const FrameRequest r = lit(request(std::move(scene), "room", {0.0, 0.0, 0.5}));
        const Image image = renderer().render(r).image;
        // Of glowing walls the sum of all bounces, 0.25 / (1 - 0.5); of the lamp's light a part.
        const float seen = centerColor(image).x;
        if (emitted > 0.0f) {
            EXPECT_NEAR(seen, 0.5f, 0.02f);
        } else {
            EXPECT_GT(seen, 0.05f);
        }
    }
}

// Rays begin on the faces, and not within the body below normals that lean out of them.
TEST_F(LightBetweenSurfaces, ACoarseBodyWithSmoothNormalsIsNotDark) {
    Scene scene;
    Material grey = lambert(0.5f);
    grey.doubleSided = true;
    MeshDraft body{.material = addMaterial(scene, grey)};
    body.hasNormals = true;
    for (int i = 0; i < 8; ++i) {
        const glm::vec3 corner(i & 1 ? 0.5f : -0.5f, i & 2 ? 0.5f : -0.5f, i & 4 ? 0.5f : -0.5f);
        body.vertices.push_back({.position = corner, .normal = glm::normalize(corner)});
    }
    const int faces[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                             {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
    for (const auto& f : faces) {
        for (const int corner : {f[0], f[1], f[2], f[0], f[2], f[3]}) {
            body.indices.push_back(static_cast<std::uint32_t>(corner));
        }
    }
    place(scene, body);
    FrameRequest r = request(std::move(scene), "coarse", {1.5, 1.2, 2.0});
    r.environment.map = "white";
    const Image image = renderer().render(lit(r)).image;
    int seen = 0;
    for (std::uint32_t y = 0; y < image.height; ++y) {
        for (std::uint32_t x = 0; x < image.width; ++x) {
            const float light = color(image, x, y).x;
            if (light > 0.9f) continue;  // the environment
            ++seen;
            // Rays below the face meet the face itself; at least half of the others are free.
            EXPECT_GT(light, 0.3f) << x << ' ' << y;
        }
    }
    EXPECT_GT(seen, 200);
}

// In uniform radiance L a matte ball of albedo 0.5 shows 0.5 L and white metal L, wherever it is.
TEST_F(LightBetweenSurfaces, WhatMovesHasTheLightOfItsPlace) {
    for (const bool metal : {false, true}) {
        for (const float emitted : {0.0f, 0.25f}) {
            Scene scene;
            placeRoom(scene, addMaterial(scene, lambert(0.5f, emitted)));
            const Index ball = addMaterial(
                scene, metal ? Material{.metallic = 1.0f, .roughness = 0.9f} : lambert(0.5f));
            place(scene, sphere(0.2f, 24, ball));
            moveLast(scene, {-0.3f, 0.0f, -0.5f}, {0.3f, 0.0f, -0.5f});
            FrameRequest r = request(std::move(scene), "moving", {0.0, 0.0, 0.8});
            r.environment.map = "white";
            r.clip = "move";
            r = lit(r);
            const float expected = 2.0f * emitted * (metal ? 1.0f : 0.5f);
            std::vector<Image> images;
            for (const double time : {0.0, 0.5, 1.0, 1.5, 0.0}) {
                r.time = time;
                images.push_back(renderer().render(lit(r)).image);
                // The room is 2 wide at a distance of 1.3, where the picture is 2.6 wide.
                const double x = (-0.3 + 0.3 * time) / 2.6 + 0.5;
                const auto column = static_cast<std::uint32_t>(x * 64.0);
                const float seen = color(images.back(), column, 32).x;
                EXPECT_NEAR(seen, expected, 0.02f) << metal << ' ' << emitted << ' ' << time;
            }
            EXPECT_TRUE(sameBytes(images.front(), images.back()));
        }
    }
}
