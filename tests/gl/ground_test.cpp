// The ground of a request: where shadows and reflections lie by arithmetic, as a surface and as a
// shadow catcher.
#include "../support/compare_images.h"
#include "alpha_support.h"
#include "support.h"

#include <gmock/gmock.h>

#include <cmath>
#include <numbers>

namespace clerestory::test {
namespace {

using Radiance = std::array<double, 3>;
constexpr double kPi = std::numbers::pi;

class GroundTest : public GlTest {};

glm::dmat4 lying(double x, double y, double z) {
    return moved(x, y, z) *
           glm::dmat4(glm::mat3_cast(glm::angleAxis(-0.5 * kPi, glm::dvec3(1, 0, 0))));
}

// A square of one metre that hovers at a height of 1, seen from above by parallel rays: 64 pixels
// are 4 metres. The sun comes from -x, 45 degrees high: the shadow is the square, 1 metre along x.
FrameRequest hoveringSquare(const std::string& id) {
    Scene s;
    Material card = unlit({0.9f, 0.2f, 0.1f, 1.0f});
    card.doubleSided = true;
    place(s, quad(0.5f, addMaterial(s, card)), lying(0, 1, 0));
    FrameRequest r = request(std::move(s), id);
    r.camera = {};
    r.camera.position = glm::dvec3(0, 5, 0);
    r.camera.target = glm::dvec3(0, 0, 0);
    r.camera.up = glm::dvec3(0, 0, -1);
    r.camera.orthographicHeight = 4.0;
    r.effects.shadows = true;
    r.ground = GroundPlane{.height = 0.0};
    r.lights = {{.light = "sun",
                 .type = LightKind::directional,
                 .intensity = std::sqrt(2.0) * kPi,  // irradiance over pi of the ground: 1
                 .direction = glm::dvec3(1, -1, 0)}};
    return r;
}

// Of the middle of a pixel, metres along x and z.
double metres(std::uint32_t pixel) {
    return (pixel + 0.5) / 16.0 - 2.0;
}
// Negative within a square about (x, 0), positive outside, metres from its edge.
double fromSquare(std::uint32_t px, std::uint32_t py, double x) {
    return std::max(std::abs(metres(px) - x), std::abs(metres(py))) - 0.5;
}

template <class Check>
void forGroundPixels(const Image& image, Check check) {
    int shadow = 0, open = 0;
    for (std::uint32_t y = 0; y < image.height; ++y) {
        for (std::uint32_t x = 0; x < image.width; ++x) {
            if (fromSquare(x, y, 0.0) < 0.05) continue;  // the square itself
            const double from = fromSquare(x, y, 1.0);
            if (std::abs(from) < 0.05) continue;  // less than a pixel
            (from < 0.0 ? shadow : open) += 1;
            check(image.floats() + (std::size_t{y} * image.width + x) * image.channels, from < 0.0);
        }
    }
    EXPECT_GT(shadow, 180);
    EXPECT_GT(open, 2000);
}

TEST_F(GroundTest, ShadowsLieWhereTheSunThrowsThem) {
    FrameRequest r = hoveringSquare("square over ground");
    r.ground->reflectance = 0.0;
    forGroundPixels(renderer().render(r).image, [](const float* p, bool shadow) {
        EXPECT_NEAR(p[0], shadow ? 0.0 : 0.5, 2e-3);  // the albedo
    });
}

TEST_F(GroundTest, ACatcherIsAsOpaqueAsTheShadowIsDark) {
    for (const char* map : {"black", "white"}) {
        FrameRequest r = hoveringSquare("square over catcher");
        r.environment.map = map;
        r.background = Background::transparent;
        // The sun is all of the light, or half.
        const double dark = r.environment.map == "black" ? 1.0 : 0.5;
        const Frame frame = renderer().render(r);
        ASSERT_EQ(frame.image.channels, 4u);
        forGroundPixels(frame.image, [&](const float* p, bool shadow) {
            EXPECT_EQ(p[0], 0.0f);
            if (shadow)
                EXPECT_NEAR(p[3], dark, 2e-3);
            else
                EXPECT_EQ(p[3], 0.0f) << "exactly the background";
        });
    }
}

// A clay ball, a metal ball and a pane of glass on the ground.
Scene product(bool glass) {
    Scene s;
    Material clay{.baseColor = {0.8f, 0.3f, 0.2f, 1.0f}, .metallic = 0.0f, .roughness = 0.7f};
    place(s, sphere(0.4f, 24, addMaterial(s, clay)), moved(-0.5, 0.4, 0));
    place(s, sphere(0.3f, 24, addMaterial(s, mirrorMetal(0.8f, 0.1f))), moved(0.4, 0.3, 0.3));
    if (glass) {
        Material pane = clearGlass();
        pane.doubleSided = true;
        place(s, quad(0.3f, addMaterial(s, pane)), moved(0.1, 0.31, 0.7));
    }
    return s;
}

FrameRequest productRequest(bool glass, const std::string& id) {
    FrameRequest r = request(product(glass), id);
    r.camera.position = glm::dvec3(0.3, 1.0, 2.2);
    r.camera.target = glm::dvec3(0, 0.2, 0);
    r.camera.yfov = 0.8;
    r.width = 160;
    r.height = 120;
    r.environment.map = "studio";
    r.effects.shadows = true;
    r.ground = GroundPlane{.roughness = 0.1, .reflectance = 0.3};
    r.lights = {{.light = "key",
                 .type = LightKind::spot,
                 .intensity = 60.0,
                 .position = glm::dvec3(-2, 3, 2),
                 .direction = glm::dvec3(2, -3, -2),
                 .outerConeAngle = 0.6}};
    return r;
}

// Two ways to one picture: the catcher over a colour, and the transparent picture laid over it.
TEST_F(GroundTest, ACatcherOverAColourIsTheTransparentPictureOverIt) {
    FrameRequest r = productRequest(false, "product");
    for (const bool lit : {false, true}) {
        r.effects.indirectLight = lit;
        r.background = Background::transparent;
        renderer().completeLight(r);
        renderer().render(r);  // maps are resident from now on
        const Image transparent = renderer().render(r).image;
        r.ground->shadowCatcher = true;
        const Radiance sand{0.7, 0.55, 0.2};
        r.background = sand;
        renderer().completeLight(r);
        const Image direct = renderer().render(r).image;
        EXPECT_TRUE(
            imagesMatch(over(transparent, sand), direct, Tolerance{"sum in floats", 1e-5, 0.0}));
        r.ground->shadowCatcher.reset();
    }
}

// Where nothing is darkened or reflected the picture is that without a ground.
TEST_F(GroundTest, OutsideOfShadowsTheBackgroundIsUntouched) {
    FrameRequest r = productRequest(false, "product without light between surfaces");
    r.background = Background::transparent;
    const Image with = renderer().render(r).image;
    r.ground.reset();
    const Image without = renderer().render(r).image;
    int untouched = 0, darkened = 0, reflecting = 0, objects = 0;
    for (std::size_t i = 0; i < std::size_t{with.width} * with.height; ++i) {
        const float *a = with.floats() + 4 * i, *b = without.floats() + 4 * i;
        if (b[3] > 0.999f) {
            ++objects;
            continue;
        }
        untouched += a[3] == 0.0f;
        darkened += a[3] > 0.05f;
        reflecting += a[0] > 0.01f;
    }
    EXPECT_GT(objects, 2000);
    EXPECT_GT(untouched, 4000);
    EXPECT_GT(darkened, 1000);
    EXPECT_GT(reflecting, 300);
}

// A picture with glass is drawn before black and before white, and alpha is the difference.
TEST_F(GroundTest, GlassShowsTheShadowBehindIt) {
    FrameRequest r = productRequest(true, "product with glass");
    r.background = Background::transparent;
    const Image transparent = renderer().render(r).image;
    r.ground->shadowCatcher = true;
    const Radiance grey{0.5, 0.5, 0.5};
    r.background = grey;
    const Image direct = renderer().render(r).image;
    EXPECT_TRUE(imagesMatch(over(transparent, grey), direct,
                            Tolerance{"half floats, and refraction of them", 4e-3, 0.002}));
}

// A mirror of white metal, and a square that glows: its image is as far below the ground as it is
// above.
TEST_F(GroundTest, ACatcherReflectsTheSceneAndNothingElse) {
    Scene s;
    place(s, quad(0.25f, addMaterial(s, glowing({0.5f, 0.25f, 1.0f}))), moved(0, 0.75, 0));
    FrameRequest r = request(std::move(s), "glowing square");
    r.environment.map = "white";
    r.camera.position = glm::dvec3(0, 1, 4);
    r.camera.target = glm::dvec3(0, 0, 0);
    r.background = Background::transparent;
    r.ground =
        GroundPlane{.height = 0.0, .color = glm::dvec3(1), .metallic = 1.0, .roughness = 0.0};
    const Image image = renderer().render(r).image;
    const auto at = [&](const glm::dvec3& p) {  // the pixel of a point in the world
        const glm::dvec3 back = glm::normalize(glm::dvec3(0, 1, 4)), d = p - glm::dvec3(0, 1, 4);
        const glm::dvec3 up = glm::normalize(glm::cross(back, glm::dvec3(1, 0, 0)));
        const double depth = -glm::dot(d, back);
        const auto x = static_cast<std::uint32_t>(32.0 * (1.0 + d.x / depth));
        const auto y = static_cast<std::uint32_t>(32.0 * (1.0 - glm::dot(d, up) / depth));
        return image.floats() + 4 * (std::size_t{y} * image.width + x);
    };
    const float* mirrored = at({0, -0.75, 0});
    EXPECT_NEAR(mirrored[0], 0.5, 5e-3);
    EXPECT_NEAR(mirrored[1], 0.25, 5e-3);
    EXPECT_NEAR(mirrored[2], 1.0, 5e-3);
    EXPECT_NEAR(mirrored[3], 1.0, 5e-3);
    for (const glm::dvec3& next : {glm::dvec3(0.6, -0.75, 0), glm::dvec3(0, -1.4, 0)}) {
        EXPECT_EQ(at(next)[3], 0.0f);
        EXPECT_EQ(at(next)[0], 0.0f);
    }
}

// A black ball at a height of twice its radius hides a quarter of the sky from the point below:
// (radius / height)^2 of a hemisphere weighted by the cosine.
TEST_F(GroundTest, ACatcherShowsTheSkyThatTheSceneHides) {
    Scene s;
    place(s, sphere(0.25f, 24, addMaterial(s, unlit({0, 0, 0, 1}))), moved(0, 0.5, 0));
    place(s, sphere(0.02f, 8, addMaterial(s, Material{.metallic = 0.0f})), moved(2, 0.5, 0));
    FrameRequest r = request(std::move(s), "ball over catcher");
    r.environment.map = "white";
    r.camera.position = glm::dvec3(0, 0.4, 1.5);
    r.camera.target = glm::dvec3(0, 0, 0);
    r.camera.yfov = 0.6;
    r.effects.indirectLight = true;
    r.background = Background::transparent;
    r.ground = GroundPlane{.height = 0.0};
    EXPECT_TRUE(renderer().completeLight(r).complete);
    const Image image = renderer().render(r).image;
    EXPECT_NEAR(image.floats()[4 * (32u * 64u + 32u) + 3], 0.25, 0.04);
    EXPECT_LE(image.floats()[4 * (62u * 64u + 2u) + 3], 0.06);
}

// Two ways to one picture: the ground, and a floor that the scene has.
TEST_F(GroundTest, IsTheFloorOfAScene) {
    const Material floor{
        .baseColor = {0.3f, 0.4f, 0.5f, 1.0f}, .metallic = 0.0f, .roughness = 0.1f};
    Scene made = product(false);
    place(made, quad(5.0f, addMaterial(made, floor)), lying(0, 0, 0));
    FrameRequest a = productRequest(false, "product to stand"), b = a;
    a.ground = GroundPlane{
        .height = 0.0, .color = glm::dvec3(0.3, 0.4, 0.5), .roughness = 0.1, .size = 10.0};
    b.scene = request(std::move(made), "product on its floor").scene;
    b.ground.reset();
    for (const PlanarMethod planar : {PlanarMethod::mirror, PlanarMethod::traced}) {
        a.accuracy.planar = b.accuracy.planar = planar;
        EXPECT_TRUE(imagesMatch(renderer().render(a).image, renderer().render(b).image,
                                Tolerance{"other texels of the shadow map", 0.02, 0.02}));
    }
}

TEST_F(GroundTest, StandsBelowTheLowestPointAndIsNotFitted) {
    FrameRequest r = productRequest(false, "product to fit");
    r.camera = {};
    r.camera.fit = FitRequest{};
    r.ground.reset();
    const FramePlan without = renderer().plan(r);
    r.ground = GroundPlane{};
    const FramePlan with = renderer().plan(r);
    const auto eyeOf = [](const FramePlan& plan) {  // of the requested view, which is drawn last
        glm::dvec3 eye(NAN);
        for (const Pass& pass : plan.passes) {
            if (pass.kind() == "surface") eye = pass.view()->eye;
        }
        return eye;
    };
    EXPECT_EQ(eyeOf(with), eyeOf(without));
    const char* line = "ground: added, at the lowest point of the scene";
    EXPECT_THAT(with.composition, testing::Contains(line));
    EXPECT_THAT(without.composition, testing::Not(testing::Contains(line)));
}

}  // namespace
}  // namespace clerestory::test
