// Rows about light, in frames: furnaces, roughness, facing mirrors, invariances, and the order of
// techniques.
#include "measures/errors.h"
#include "scene/builtin/builtin_scenes.h"
#include "tests/stability/frames.h"

#include <glm/gtc/matrix_transform.hpp>

#include <functional>

namespace clerestory::test {
namespace {

// Built-in scenes, presets and forced ways, at the size of a stamp.
TEST_F(FrameRows, NonFiniteScanOfTheBuiltInScenes) {
    for (const BuiltinScene& builtin : builtinScenes()) {
        renderer().addScene(*makeBuiltinScene(builtin.id));
        FrameRequest r;
        r.scene = builtin.id;
        r.width = 48;
        r.height = 27;
        r.output.format = OutputFormat::npy;
        for (const Preset preset : {Preset::draft, Preset::standard, Preset::fine}) {
            r.accuracy = accuracyOf(preset);
            // Large cubes and many directions take long and say no more.
            r.accuracy.probeSize = std::min(r.accuracy.probeSize, 64u);
            r.accuracy.environmentSize = std::min(r.accuracy.environmentSize, 64u);
            // The chapel's many variants take seconds each to compile.
            if (!longForm() && builtin.id == "chapel" && preset != Preset::standard) continue;
            drawn(r);
            if (!longForm()) continue;
            for (const Parallax parallax : {Parallax::none, Parallax::box, Parallax::depth}) {
                r.accuracy.parallax = parallax;
                r.accuracy.curved = CurvedMethod::probe;
                drawn(r);
            }
        }
        renderer().removeScene(builtin.id);
    }
}

TEST_F(FrameRows, WhiteFurnace) {
    for (int m = 0; m <= steps(5, 50); ++m) {
        const float roughness = float(m) / float(steps(5, 50));
        for (const float f0 : {0.0f, 0.04f, 0.5f, 1.0f}) {
            for (const float diffuse : {0.0f, 1.0f}) {
                // A metal's F0 is its colour; a dielectric's 0.04 is scaled by `specular`.
                const bool metal = f0 >= 0.5f;
                if (metal && diffuse > 0.0f) continue;
                Material material{.name = "furnace",
                                  .baseColor = glm::vec4(glm::vec3(metal ? f0 : diffuse), 1.0f),
                                  .metallic = metal ? 1.0f : 0.0f,
                                  .roughness = roughness,
                                  .specular = f0 > 0.0f ? 1.0f : 0.0f};
                Scene scene;
                place(scene, sphere(1.0f, 24, addMaterial(scene, material)));
                FrameRequest r = request(std::move(scene), "furnace", {0, 0, 2.0});
                r.width = r.height = 24;
                r.environment.map = "white";
                r.accuracy.curved = CurvedMethod::environment;
                const Image image = drawn(r);
                for (std::uint32_t i = 0; i < 24 * 24; ++i) {
                    const double value = color(image, i % 24, i / 24).x;
                    EXPECT_TRUE(atMost("white furnace", "radiance, frames", value, 1.005));
                    if (f0 == 1.0f) {
                        EXPECT_TRUE(atMost("white furnace", "|radiance - 1|, F0 = 1, frames",
                                           std::abs(value - 1.0), 0.01))
                            << roughness;
                    }
                }
            }
        }
    }
}

TEST_F(FrameRows, GlassFurnace) {
    const auto eachPixel = [](const FrameRequest& r, const char* what) {
        const Image image = drawn(r);
        for (std::uint32_t i = 0; i < r.width * r.height; ++i) {
            EXPECT_TRUE(atMost("glass furnace", "|R + T - 1|, frames",
                               std::abs(color(image, i % r.width, i / r.width).x - 1.0), 2e-3))
                << what;
        }
    };
    for (const GlassMethod method : {GlassMethod::backdrop, GlassMethod::traced}) {
        for (const double ior : {1.0, 1.0003, 1.5, 3.0}) {
            for (const double tilt : {0.0, 60.0, 85.0, 89.9}) {
                Scene scene;
                Material m = clearGlass(float(ior));
                m.doubleSided = true;
                m.thickness = 0.05f;
                place(scene, quad(0.8f, addMaterial(scene, m)),
                      glm::rotate(moved(0, 0, 0.5), glm::radians(tilt), glm::dvec3(0, 1, 0)));
                FrameRequest r = byPictures(std::move(scene), "pane", {0, 0, 2});
                r.accuracy.planar = PlanarMethod::environment;
                r.accuracy.glass = method;
                r.width = r.height = 16;
                eachPixel(r, "pane");
            }
            // From outside, and from within, where the critical angle is in the picture.
            for (const double away : {2.0, 0.3}) {
                Scene scene;
                Material m = clearGlass(float(ior));
                m.thickness = 1.0f;
                m.doubleSided = true;
                place(scene, sphere(0.7f, 24, addMaterial(scene, m)));
                FrameRequest r = byPictures(std::move(scene), "solid", {0, 0, away});
                r.accuracy.curved = CurvedMethod::environment;
                r.accuracy.glass = method;
                r.accuracy.bounces = 16;
                r.width = r.height = 16;
                eachPixel(r, "solid");
            }
        }
    }
}

double lightOf(const Image& image) {
    double sum = 0.0;
    for (std::uint32_t i = 0; i < image.width * image.height; ++i) {
        sum += color(image, i % image.width, i / image.width).x;
    }
    return sum;
}

// Width of a lamp's image in a rough mirror or ball: its light's distance from its middle, pixels.
double widthOf(const Image& image) {
    double sum = 1e-30, squares = 0.0;
    glm::dvec2 mean(0.0);
    for (int turn = 0; turn < 2; ++turn) {
        for (std::uint32_t i = 0; i < image.width * image.height; ++i) {
            const glm::dvec2 at(i % image.width, i / image.width);
            const double light = color(image, i % image.width, i / image.width).x;
            if (turn == 0) {
                sum += light;
                mean += light * at;
            } else {
                squares += light * glm::dot(at - mean / sum, at - mean / sum) / sum;
            }
        }
    }
    return std::sqrt(squares);
}

TEST_F(FrameRows, Roughness) {
    const auto picture = [](float roughness) {
        Scene scene;
        place(scene, quad(3.0f, addMaterial(scene, mirrorMetal(1.0f, roughness))));
        place(scene, quad(0.2f, addMaterial(scene, glowing(glm::vec3(1.0f)))), moved(0, 0, 2));
        FrameRequest r = byPictures(std::move(scene), "rough", {0.0, 0.4, 1.0});
        r.environment.map = "black";
        r.camera.target = glm::dvec3(0.0, 0.0, 0.0);
        r.width = r.height = 96;
        return r;
    };
    double before = 0.0, sharp = 0.0;
    const int count = steps(20, 50);
    for (int i = 0; i <= count; ++i) {
        const Image image = drawn(picture(0.5f * float(i) / float(count)));
        const double width = widthOf(image);
        EXPECT_TRUE(atLeast("roughness", "growth of a mirrored lamp, frames", width / before,
                            i == 0 ? 0.0 : 0.999))
            << i;
        before = width;
        // Its levels leave out no texel. (At half size, which fine does not use, the lamp itself is
        // drawn by fewer pixels.) Not the same to a digit: each pixel's blur follows how far away
        // that is what it sees, so the lamp and the dark about it are read with different widths.
        // With texels left out it is wrong by a quarter, or by all of it.
        FrameRequest fine = picture(0.5f * float(i) / float(count));
        fine.accuracy.preset = Preset::fine;
        const double light = lightOf(drawn(fine));
        if (i == 0) sharp = light;
        EXPECT_TRUE(atMost("roughness", "|light - sharp| / sharp, to roughness 0.3, frames",
                           2 * i > 1.2 * count ? 0.0 : std::abs(light / sharp - 1.0), 0.15))
            << i;
    }
    // 0 is the sharp way: no level of the picture but the first is read.
    EXPECT_TRUE(atMost("roughness", "0 against just above, frames",
                       mostApart(drawn(picture(0.0f)), drawn(picture(1e-4f))), 0.0));
}

TEST_F(FrameRows, FacingMirrors) {
    for (const float rho : {0.0f, 0.5f, 0.9f, 1.0f}) {
        for (std::uint32_t generations = 1; generations <= 8; generations += steps(7, 1)) {
            Scene scene;
            const Index silver = addMaterial(scene, mirrorMetal(rho));
            place(scene, quad(4.0f, silver), moved(0, 0, -1));
            place(scene, quad(4.0f, silver),
                  glm::rotate(moved(0, 0, 1), glm::pi<double>(), glm::dvec3(0, 1, 0)));
            place(scene, quad(0.025f, addMaterial(scene, glowing(glm::vec3(1.0f)))),
                  moved(0.5, 0, 0));
            FrameRequest r = byPictures(std::move(scene), "facing", {0, 0, 0});
            r.environment.map = "black";
            r.width = 2048;
            r.height = 8;
            r.camera.yfov = 2.0 * std::atan(8.0 / 2048.0);  // 90 degrees across
            r.accuracy.generations = generations;
            const Image image = drawn(r);
            for (std::uint32_t k = 1; k <= generations; ++k) {
                // Images stand at z = -2k; the lamp is in the eye's plane, the mirrors 1 m away.
                const double middle = 1024.0 + 1024.0 * 0.5 / (2.0 * k);
                const double half = 1024.0 * 0.025 / (2.0 * k);
                const double expected = std::pow(double(rho), double(k));
                const double value = color(image, std::uint32_t(middle), 3).x;
                EXPECT_TRUE(atMost("facing mirrors", "|image k - rho^k| / rho^k",
                                   expected > 0.0 ? std::abs(value - expected) / expected : value,
                                   0.02))
                    << rho << ' ' << k << " of " << generations;
                if (expected <= 0.0) continue;
                // The image's light has its centre of gravity at the image; the next image stands
                // a pixel away at least.
                double light = 0.0, along = 0.0;
                for (auto x = std::uint32_t(middle - half - 0.5); x + 0.5 < middle + half + 0.5;
                     ++x) {
                    const double c = color(image, x, 3).x;
                    light += c;
                    along += c * (x + 0.5);
                }
                EXPECT_TRUE(atMost("facing mirrors", "image's place, pixels",
                                   std::abs(along / light - middle), 0.5))
                    << rho << ' ' << k;
            }
        }
    }
}

// ---- what must change nothing ------------------------------------------------------------------

TEST_F(FrameRows, MetamorphicTurningTheWorldWithItsCamera) {
    const auto picture = [](double degrees) {
        const glm::dmat4 turn =
            glm::rotate(glm::dmat4(1.0), glm::radians(degrees), glm::dvec3(0.3, 0.5, 0.8));
        FrameRequest r = byPictures(floorScene(turn, false, true), "turned", {});
        r.accuracy.parallax = Parallax::none;  // a box has the world's axes
        r.camera.position = glm::dvec3(turn * glm::dvec4(0.3, -1.6, 0.9, 1.0));
        r.camera.target = glm::dvec3(turn * glm::dvec4(0.0, 0.0, 0.2, 1.0));
        r.camera.up = glm::dvec3(turn * glm::dvec4(0, 0, 1, 0));
        r.accuracy.curved = CurvedMethod::traced;  // a cube's texels have the world's axes, too
        return drawn(r);
    };
    const Image straight = picture(0.0);
    for (const double degrees : {1.0, 90.0, 137.0, 180.0}) {
        const Image turned = picture(degrees);
        std::uint32_t off = 0;
        for (std::uint32_t i = 0; i < 64 * 64; ++i) {
            off += greatestDifference(color(straight, i % 64, i / 64),
                                      color(turned, i % 64, i / 64)) > 1.0f / 255.0f;
        }
        // On edges a pixel's centre may fall to the other side.
        EXPECT_TRUE(atMost("metamorphic", "turned world: pixels over 1 code", off, 12.0))
            << degrees;
    }
}

TEST_F(FrameRows, MetamorphicSymmetricScene) {
    Scene scene;
    for (const double side : {-1.0, 1.0}) {
        place(scene, quad(0.2f, addMaterial(scene, glowing({0.3f, 0.8f, 0.5f}))),
              moved(0.6 * side, 0.2, 0.3));
        place(scene, sphere(0.2f, 16, addMaterial(scene, mirrorMetal())),
              moved(0.3 * side, 0, 0.2));
    }
    place(scene, quad(1.0f, addMaterial(scene, mirrorMetal(0.8f))));
    FrameRequest r = byPictures(std::move(scene), "symmetric", {0, 0.1, 2});
    r.accuracy.curved = CurvedMethod::environment;
    const Image image = drawn(r);
    std::uint32_t off = 0;
    for (std::uint32_t y = 0; y < 64; ++y) {
        for (std::uint32_t x = 0; x < 32; ++x) {
            off += greatestDifference(color(image, x, y), color(image, 63 - x, y)) > 1.0f / 255.0f;
        }
    }
    EXPECT_TRUE(atMost("metamorphic", "symmetric scene: pixels over 1 code", off, 4.0));
}

TEST_F(FrameRows, MetamorphicInvisibleObjectsChangeNothing) {
    const auto view = [](Scene scene, const char* id) {
        FrameRequest r = byPictures(std::move(scene), id, {0.3, -1.6, 0.9});
        r.camera.target = glm::dvec3(0.0, 0.0, 0.2);
        r.camera.up = glm::dvec3(0, 0, 1);
        return r;
    };
    const glm::dmat4 here(1.0);
    const Image without = drawn(view(floorScene(here, false, false), "without"));
    for (const GlassMethod method : {GlassMethod::backdrop, GlassMethod::traced}) {
        Scene scene = floorScene(here, false, false);
        Material clear = clearGlass(1.0f);
        clear.thickness = 0.3f;
        place(scene, sphere(0.3f, 24, addMaterial(scene, clear)), moved(0, -0.4, 0.4));
        FrameRequest r = view(std::move(scene), "index 1");
        r.accuracy.glass = method;
        EXPECT_TRUE(atMost("metamorphic", "glass of index 1, codes",
                           255.0 * mostApart(drawn(r), without), 1.0));
    }
    // A mirror of reflectance 0 is black with every technique.
    for (const PlanarMethod method :
         {PlanarMethod::environment, PlanarMethod::mirror, PlanarMethod::traced}) {
        Scene scene;
        place(scene, quad(1.5f, addMaterial(scene, mirrorMetal(0.0f))));
        FrameRequest r = byPictures(std::move(scene), "black mirror", {0, 0, 1});
        r.accuracy.planar = method;
        // Schlick's term remains at grazing angles and vanishes at normal incidence.
        EXPECT_TRUE(atMost("metamorphic", "mirror of reflectance 0, codes",
                           255.0 * centerColor(drawn(r)).x, 1.0));
    }
}

// Off is byte for byte a scene whose materials do not have the effect.
TEST_F(FrameRows, MetamorphicOffIsASceneWithout) {
    enum { emission, refraction, planar, curved };
    for (const int effect : {emission, refraction, planar, curved}) {
        Scene with = floorScene(glm::dmat4(1.0), false, true), without = with;
        for (Material& m : without.materials) {
            if (effect == emission) m.emissive = glm::vec3(0.0f);
            if (effect == refraction) m.transmission = 0.0f;
            if (effect >= planar) m.reflection = Reflection::none;
        }
        FrameRequest r = byPictures(std::move(with), "with", {0.3, -1.6, 0.9});
        r.camera.target = glm::dvec3(0.0, 0.0, 0.2);
        r.camera.up = glm::dvec3(0, 0, 1);
        r.environment.map = "sky";
        FrameRequest plain = byPictures(std::move(without), "without", {});
        plain.camera = r.camera;
        plain.environment.map = "sky";
        // The two kinds of mirror share their material here: both go; so do the pane's mirrors.
        if (effect == emission) r.effects.emission = false;
        if (effect == refraction) r.effects.refraction = false;
        if (effect >= planar) r.effects.planarReflection = r.effects.environmentReflection = false;
        if (effect == refraction) plain.effects.refraction = false;
        EXPECT_TRUE(atMost("metamorphic", "effect off against none, bytes that differ",
                           drawn(r).data != drawn(plain).data, 0.0))
            << effect;
    }
}

// ---- a higher tier is never worse
// ----------------------------------------------------------------

// The truth here is the traced tier, which follows single rays exactly; random scenes are compared
// against the path tracer (random_ladder_test.cpp).
struct Ladder {
    const char* name;
    Effect effect;
    FrameRequest truth;
    std::vector<std::function<void(Accuracy&)>> tiers;  // cheapest first
};

void climb(Ladder ladder) {
    constexpr std::uint32_t kSquare = 4;
    ladder.truth.width = ladder.truth.height = 192;
    const Image reference = averaged(drawn(ladder.truth), kSquare);
    const Image through = renderer().render(maskRequest(ladder.truth)).image;
    const Mask mask = whole(maskOf(through, ladder.effect), kSquare);
    ASSERT_GT(mask.pixels(), 20u) << ladder.name;
    double before = HUGE_VAL;
    for (const auto& tier : ladder.tiers) {
        FrameRequest at = ladder.truth;
        tier(at.accuracy);
        const double error = linearErrors(averaged(drawn(at), kSquare), reference, &mask).rmse;
        EXPECT_TRUE(atMost("monotone ladder", std::string(ladder.name) + ": error / tier below",
                           std::isinf(before) ? 0.0 : error / std::max(before, 1e-6), 1.05))
            << error << " after " << before;
        before = error;
    }
}

FrameRequest ladderView(Scene scene) {
    FrameRequest r = byPictures(std::move(scene), "ladder", {0.3, -1.6, 0.9});
    r.camera.target = glm::dvec3(0.0, 0.0, 0.2);
    r.camera.up = glm::dvec3(0, 0, 1);
    r.camera.yfov = 0.9;
    r.environment.map = "grey";
    return r;
}

TEST_F(FrameRows, MonotoneLadderOfFlatMirrors) {
    FrameRequest truth = ladderView(floorScene(glm::dmat4(1.0), false, false));
    truth.accuracy.planar = PlanarMethod::traced;
    const auto mirror = [](double scale) {
        return [scale](Accuracy& a) {
            a.planar = PlanarMethod::mirror;
            a.planarScale = scale;
        };
    };
    climb({"flat",
           Effect::planarReflection,
           truth,
           {[](Accuracy& a) { a.planar = PlanarMethod::environment; }, mirror(0.125), mirror(0.25),
            mirror(0.5), mirror(1.0)}});
}

TEST_F(FrameRows, MonotoneLadderOfCurvedMirrors) {
    renderer().addScene(*makeBuiltinScene("six-walls"));
    FrameRequest truth;
    truth.effects.shadows = truth.effects.indirectLight = false;
    truth.scene = "six-walls";
    truth.output.format = OutputFormat::npy;
    truth.accuracy.curved = CurvedMethod::traced;
    const auto probe = [](std::uint32_t size, Parallax parallax) {
        return [=](Accuracy& a) {
            a.curved = CurvedMethod::probe;
            a.probeSize = size;
            a.parallax = parallax;
        };
    };
    climb({"curved",
           Effect::environmentReflection,
           truth,
           {[](Accuracy& a) { a.curved = CurvedMethod::environment; }, probe(64, Parallax::none),
            probe(64, Parallax::box), probe(256, Parallax::box)}});
}

TEST_F(FrameRows, MonotoneLadderOfGlass) {
    Scene scene = floorScene(glm::dmat4(1.0), false, false);
    scene.instances.pop_back();  // the floor
    Material pane = clearGlass();
    pane.doubleSided = true;
    pane.reflection = Reflection::none;
    place(scene, quad(0.8f, addMaterial(scene, pane)),
          glm::rotate(moved(0.0, -0.8, 0.5), 1.2, glm::dvec3(1, 0, 0)));
    FrameRequest truth = ladderView(std::move(scene));
    truth.accuracy.glass = GlassMethod::traced;
    climb({"glass",
           Effect::refraction,
           truth,
           {[](Accuracy& a) { a.glass = GlassMethod::environment; },
            [](Accuracy& a) { a.glass = GlassMethod::backdrop; }}});
}

}  // namespace
}  // namespace clerestory::test
