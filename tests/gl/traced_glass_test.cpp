// Traced glass: panes from both sides, no light from the sky in a closed room, and textures of
// sheets where rays hit them.
#include "../support/compare_images.h"
#include "glass_truth.h"
#include "scene/texture_images.h"
#include "trace_support.h"

using namespace clerestory;
using namespace clerestory::test;

namespace {

FrameRequest glassShot(const glm::dvec3& eye, const glm::dvec3& target, double yfov) {
    FrameRequest r;
    r.effects.shadows = r.effects.indirectLight = false;
    r.width = r.height = 96;
    r.camera.position = eye;
    r.camera.target = target;
    r.camera.yfov = yfov;
    r.output.format = OutputFormat::npy;
    r.accuracy.glass = GlassMethod::traced;
    r.accuracy.planar = PlanarMethod::environment;
    return r;
}

Image picture(Scene scene, const FrameRequest& r) {
    PlanRunner& bench = workbench();
    bench.show(std::move(scene));
    return bench.run(bench.plan(r));
}

}  // namespace

// A ball of zero thickness is two panes, one behind the other, at any angle: from inside too,
// nothing is totally reflected.
TEST(TracedGlass, ThinShellsAreTwoPanesUpToTheRim) {
    for (const float ior : {1.1f, 1.5f, 2.0f}) {
        Scene scene;
        scene.environment = "black";
        place(scene, quad(40.0f, addMaterial(scene, glowing({1, 1, 1}))), moved(0, 0, -30));
        Material thin = clearGlass(ior);
        thin.doubleSided = true;
        place(scene, sphere(1.0f, 96, addMaterial(scene, thin)));
        const FrameRequest r = glassShot({0, 0, 10}, {0, 0, 0}, 0.21);
        const Image image = picture(std::move(scene), r);
        int compared = 0, beyondCritical = 0;
        for (std::uint32_t y = 0; y < r.height; ++y) {
            for (std::uint32_t x = 0; x < r.width; ++x) {
                const Ray ray = sightOfPixel(r, x, y);
                const auto t = meetsBall(ray, {0, 0, 0}, 1.0);
                if (!t) continue;
                const glm::dvec3 normal = ray.origin + *t * ray.direction;
                const double cosine = -glm::dot(ray.direction, normal);
                // At the silhouette flat triangles are visible, and some reflected rays hit the
                // lamp.
                const bool dark = glm::reflect(ray.direction, normal).z > 0.05;
                if (cosine < 0.25 || !dark) continue;
                const double once = paneTransmits(cosine, double{ior});
                ++compared;
                beyondCritical += std::sqrt(1.0 - cosine * cosine) > 1.0 / double{ior};
                ASSERT_NEAR(color(image, x, y).g, once * once, 4e-3)
                    << x << " " << y << ", index " << ior;
            }
        }
        EXPECT_GT(compared, 2000);
        if (ior > 1.45f) {
            EXPECT_GT(beyondCritical, 100);
        }
    }
}

// A glowing mirror behind a pane: light goes back and forth between them, and each time a part of it
// leaves. The sum is a geometric series, of which paths follow the terms that count.
TEST(TracedGlass, APaneInFrontOfAMirrorShowsReflectionsBetweenThem) {
    constexpr float kIor = 2.4f, kMirrored = 0.8f;
    Scene scene;
    scene.environment = "black";
    Material silver = mirrorMetal(kMirrored);
    silver.emissive = glm::vec3(1.0f);
    place(scene, quad(40.0f, addMaterial(scene, silver)), moved(0, 0, -1));
    Material thin = clearGlass(kIor);
    thin.doubleSided = true;
    place(scene, quad(40.0f, addMaterial(scene, thin)));
    const Image image = picture(std::move(scene), glassShot({0, 0, 5}, {0, 0, 0}, 0.05));
    const double through = paneTransmits(1.0, double{kIor});
    const double turned = double{kMirrored} * (1.0 - through);
    EXPECT_GT(color(image, 48, 48).g, through * (1.0 + turned) - 2e-3);
    EXPECT_LT(color(image, 48, 48).g, through / (1.0 - turned) + 2e-3);
}

// Between dark walls, under a sky that is ten times as bright: what turns back within a body leaves
// it into the room, and nothing of the sky is seen.
TEST(TracedGlass, InAClosedRoomShowsNoSky) {
    constexpr float kDark = 0.1f;
    for (const bool ball : {true, false}) {
        Scene scene;
        scene.environment = "white";
        const Index wall = addMaterial(scene, glowing(glm::vec3(kDark)));
        for (int axis = 0; axis < 3; ++axis) {
            for (const double side : {-5.0, 5.0}) {
                glm::dmat4 m(0.0);
                m[0][(axis + 1) % 3] = m[1][(axis + 2) % 3] = m[2][axis] = m[3][3] = 1.0;
                m[3][axis] = side;
                place(scene, quad(5.0f, wall), m);
            }
        }
        Material glass = clearGlass(1.5f);
        glass.thickness = 2.0f;
        const Index m = addMaterial(scene, glass);
        if (ball) place(scene, sphere(1.0f, 48, m));
        if (!ball) place(scene, cube(0.9f, m), glm::rotate(tilted(0, 30), 0.5, {1, 0, 0}));
        FrameRequest r = glassShot({0.3, 0.4, 4}, {0, 0, 0}, 0.6);
        r.accuracy.bounces = 16;
        const Image image = picture(std::move(scene), r);
        for (std::uint32_t y = 0; y < r.height; ++y) {
            for (std::uint32_t x = 0; x < r.width; ++x) {
                const Ray ray = sightOfPixel(r, x, y);
                // At the silhouette flat triangles are visible.
                const bool rim =
                    ball && meetsBall(ray, {0, 0, 0}, 1.0) && !meetsBall(ray, {0, 0, 0}, 0.97);
                if (rim) continue;
                ASSERT_NEAR(color(image, x, y).g, kDark, 1e-3f) << x << " " << y;
            }
        }
    }
}

// Light crosses bodies one behind the other, as the walls of a vessel and what it holds, with the
// fewest turns. It loses no more than what their faces reflect.
TEST(TracedGlass, BodiesOneBehindTheOtherAreClear) {
    constexpr float kIor = 1.3f;
    constexpr int kBodies = 3;
    Scene scene;
    scene.environment = "black";
    place(scene, quad(40.0f, addMaterial(scene, glowing({1, 1, 1}))), moved(0, 0, -30));
    Material glass = clearGlass(kIor);
    glass.thickness = 0.2f;
    const Index material = addMaterial(scene, glass);
    for (int i = 0; i < kBodies; ++i) place(scene, cube(0.2f, material), moved(0, 0, -i));
    FrameRequest r = glassShot({0, 0, 4}, {0, 0, 0}, 0.02);
    r.accuracy.bounces = 2;
    const float root = (kIor - 1.0f) / (kIor + 1.0f);
    const float through = centerColor(picture(std::move(scene), r)).g;
    EXPECT_GT(through, std::pow(1.0f - root * root, 2.0f * kBodies) - 1e-3f);
    EXPECT_LT(through, 1.0f);
}

// Root mean square of a picture's differences from its mean, where the ball of radius 1 at the
// origin is seen away from its rim.
double contrastInBall(const Image& image, const FrameRequest& r) {
    double sum = 0.0, squares = 0.0;
    int count = 0;
    for (std::uint32_t y = 0; y < r.height; ++y) {
        for (std::uint32_t x = 0; x < r.width; ++x) {
            if (!meetsBall(sightOfPixel(r, x, y), {0, 0, 0}, 0.6)) continue;
            const double value = color(image, x, y).g;
            sum += value, squares += value * value, ++count;
        }
    }
    EXPECT_GT(count, 500);
    const double mean = sum / count;
    return std::sqrt(squares / count - mean * mean);
}

// The wall of a bottle bends light forth and back: what is behind it stays as sharp as without it.
TEST(TracedGlass, TexturesBehindThinCurvedWallsAreSharp) {
    const auto drawn = [](bool bottle, const FrameRequest& r) {
        Scene scene;
        scene.environment = "black";
        constexpr std::uint32_t kTexels = 128;
        TextureImage squares{.name = "squares", .width = kTexels, .height = kTexels};
        for (std::uint32_t i = 0; i < kTexels * kTexels; ++i) {
            const bool white = (i % kTexels / 4 + i / kTexels / 4) % 2 == 0;
            const std::uint8_t code = white ? 255 : 0;
            squares.texels.insert(squares.texels.end(), {code, code, code, 255});
        }
        buildLevels(squares);
        scene.images.push_back(std::move(squares));
        scene.textures.push_back({.image = 0});
        Material wall = glowing({1, 1, 1});
        wall.emissiveTexture.texture = 0;
        place(scene, quad(4.0f, addMaterial(scene, wall)), moved(0, 0, -6));
        if (bottle) {
            Material glass = clearGlass(1.5f);
            glass.thickness = 0.02f;
            MeshDraft walls = sphere(1.0f, 96, addMaterial(scene, glass));
            const MeshDraft inside = sphere(0.98f, 96, 0);
            const auto first = static_cast<Index>(walls.vertices.size());
            for (Vertex v : inside.vertices) {
                v.normal = -v.normal;
                walls.vertices.push_back(v);
            }
            for (std::size_t i = 0; i < inside.indices.size(); i += 3) {  // turned inwards
                for (const std::size_t k : {0u, 2u, 1u}) {
                    walls.indices.push_back(first + inside.indices[i + k]);
                }
            }
            place(scene, std::move(walls));
        }
        return picture(std::move(scene), r);
    };
    const FrameRequest r = glassShot({0, 0, 10}, {0, 0, 0}, 0.21);
    const double without = contrastInBall(drawn(false, r), r);
    const double behind = contrastInBall(drawn(true, r), r);
    EXPECT_GT(without, 0.3);
    EXPECT_GT(behind, 0.7 * without);
}

// Green of a thickness texture is how thick a sheet is there: seen directly against its backdrop,
// in a mirror that was drawn, and in one that was traced.
TEST(TracedGlass, ThicknessTexturesApplyInReflections) {
    Material sheet = clearGlass(1.5f);
    sheet.doubleSided = true;
    sheet.thickness = 0.1f;
    sheet.attenuationColor = {0.5f, 0.9f, 0.2f};
    sheet.attenuationDistance = 0.1f;
    Scene scene;
    scene.environment = "black";
    place(scene, quad(6.0f, addMaterial(scene, glowing({1, 1, 1}))), moved(0, 0, -2));
    sheet.thicknessTexture.texture = addTexture2x2(
        scene, {glm::u8vec4(0, 0, 0, 255), {0, 85, 0, 255}, {0, 170, 0, 255}, {0, 255, 0, 255}},
        Wrap::repeat);
    scene.images.back().colorSpace = ColorSpace::linear;
    place(scene, quad(0.9f, addMaterial(scene, sheet)), moved(0, 0, -0.5));
    Scene withMirror = scene;
    glm::dmat4 turned = moved(0.2, 0.1, 3.2);
    turned[0][0] = turned[2][2] = -1.0;
    place(withMirror, quad(0.9f, addMaterial(withMirror, mirrorMetal())), turned);

    FrameRequest direct = glassShot({0, 0, 2}, {0, 0, -0.5}, 0.9);
    PlanRunner& bench = workbench();
    bench.show(std::move(scene));
    for (const GlassMethod method : {GlassMethod::backdrop, GlassMethod::traced}) {
        direct.accuracy.glass = method;
        const Image image = bench.run(bench.plan(direct));
        for (int square = 0; square < 4; ++square) {
            const std::uint32_t x = square % 2 ? 60 : 35, y = square / 2 ? 60 : 35;
            const double cosine = -sightOfPixel(direct, x, y).direction.z;
            const double path = 0.1 * square / 3.0 / cosineInside(cosine, 1.5);
            for (int c = 0; c < 3; ++c) {
                const double clear = std::pow(double{sheet.attenuationColor[c]}, path / 0.1);
                EXPECT_NEAR(color(image, x, y)[c], paneTransmits(cosine, 1.5, clear), 3e-3)
                    << square << " " << int(method);
            }
        }
    }
    bench.show(std::move(withMirror));
    FrameRequest mirrored = glassShot({0, 0, 2}, {0.1, 0.05, 3.2}, 0.9);
    mirrored.output.format = OutputFormat::png;
    mirrored.accuracy.glass = GlassMethod::backdrop;
    mirrored.accuracy.generations = 1;
    mirrored.accuracy.planar = PlanarMethod::mirror;
    const Image drawn = bench.run(bench.plan(mirrored));
    mirrored.accuracy.planar = PlanarMethod::traced;
    EXPECT_TRUE(imagesMatch(bench.run(bench.plan(mirrored)), drawn, kEdges));
}
