// Glass of any shape: invisible at index 1, energy conservation, blur, and cost.
#include "glass_truth.h"

namespace clerestory::test {
namespace {

// ---- no glass, and no light lost ---------------------------------------------------------------

Scene colorfulWall() {
    Scene scene;
    for (int i = 0; i < 16; ++i) {
        const glm::vec3 radiance(0.2f + 0.05f * float(i), i % 3 * 0.4f, 0.3f + 0.2f * float(i % 4));
        place(scene, quad(0.5f, addMaterial(scene, glowing(radiance))),
              moved(i % 4 - 1.5, i / 4 - 1.5, -1.0 - 0.1 * (i % 5)));
    }
    return scene;
}

TEST_F(GlassPictures, OfIndexOneAreInvisible) {
    const Image without = renderer().render(through(colorfulWall(), "no glass")).image;
    for (const char* body : {"pane", "ball", "cube"}) {
        Scene scene = colorfulWall();
        Material clear = clearGlass(1.0f);
        clear.thickness = body == std::string("pane") ? 0.1f : 1.0f;
        const Index m = addMaterial(scene, clear);
        if (body == std::string("pane")) place(scene, quad(0.7f, m), tilted(0.2, 35));
        if (body == std::string("ball")) place(scene, sphere(0.5f, 48, m), moved(0.1, 0.1, 0));
        if (body == std::string("cube")) place(scene, cube(0.4f, m), tilted(0, 20));
        const Image with = renderer().render(through(std::move(scene), body)).image;
        double greatest = 0.0;
        for (std::uint32_t y = 0; y < with.height; ++y) {
            for (std::uint32_t x = 0; x < with.width; ++x) {
                greatest =
                    std::max(greatest, greatestDifference(color(with, x, y), color(without, x, y)));
            }
        }
        EXPECT_LE(greatest, 1.0 / 255.0) << body;
    }
}

TEST_F(GlassPictures, ConserveEnergyInAWhiteFurnace) {
    for (const double ior : {1.0, 1.1, 1.33, 1.5, 2.0, 3.0}) {
        for (const double tilt : {0.0, 20.0, 45.0, 60.0, 75.0, 85.0}) {
            for (const float roughness : {0.0f, 0.4f}) {
                Scene scene;
                Material m = clearGlass(float(ior), roughness);
                m.doubleSided = true;
                m.thickness = 0.05f;
                place(scene, quad(0.8f, addMaterial(scene, m)), tilted(0.5, tilt));
                FrameRequest r = through(std::move(scene), "furnace");
                r.environment.map = "white";
                r.width = r.height = 32;
                const Image image = renderer().render(r).image;
                for (std::uint32_t i = 0; i < 32 * 32; ++i) {
                    ASSERT_NEAR(color(image, i % 32, i / 32).x, 1.0f, 2e-3f)
                        << "pane of index " << ior << " at " << tilt << " degrees, roughness "
                        << roughness;
                }
            }
        }
        Scene scene;
        Material m = clearGlass(float(ior));
        m.thickness = 1.0f;
        place(scene, sphere(0.5f, 48, addMaterial(scene, m)));
        FrameRequest r = through(std::move(scene), "furnace", {0, 0, 1.2});
        r.environment.map = "white";
        const Image image = renderer().render(r).image;
        for (std::uint32_t i = 0; i < 64 * 64; ++i) {
            ASSERT_NEAR(color(image, i % 64, i / 64).x, 1.0f, 2e-3f) << "ball of index " << ior;
        }
    }
}

// ---- rough -------------------------------------------------------------------------------------

TEST_F(GlassPictures, BlurMoreTheRougherTheGlass) {
    double before = 1e9;
    for (int step = 0; step <= 10; ++step) {
        Scene scene;
        place(scene, quad(0.12f, addMaterial(scene, glowing({1, 1, 1}))), moved(0, 0, -1));
        place(scene, quad(6.0f, addMaterial(scene, clearGlass(1.5f, 0.1f * float(step)))));
        FrameRequest r = through(std::move(scene), "rough");
        r.width = r.height = 128;
        const Image image = renderer().render(r).image;
        float brightest = 0.0f;
        for (std::uint32_t i = 0; i < 128 * 128; ++i) {
            brightest = std::max(brightest, color(image, i % 128, i / 128).x);
        }
        if (step == 0) {
            EXPECT_NEAR(brightest, paneTransmits(1.0, 1.5), 3e-3);
        }
        EXPECT_LE(brightest, before * 1.001) << step;
        before = brightest;
    }
    EXPECT_LT(before, 0.2);
}

// ---- what it costs -----------------------------------------------------------------------------

TEST_F(GlassPictures, SwitchedOffEqualASceneWithoutTransmission) {
    const auto scene = [](float transmission) {
        Scene s = colorfulWall();
        Material pane = clearGlass(1.5f, 0.2f), ball = clearGlass(1.4f);
        ball.thickness = 0.6f;
        pane.transmission = ball.transmission = transmission;
        place(s, quad(0.5f, addMaterial(s, pane)), tilted(0.5, 30));
        place(s, sphere(0.3f, 24, addMaterial(s, ball)), moved(0.3, 0.3, 0.2));
        return s;
    };
    FrameRequest off = through(scene(0.8f), "off");
    off.effects.refraction = false;
    off.environment.map = "sky";
    FrameRequest without = through(scene(0.0f), "without");
    without.environment.map = "sky";
    EXPECT_EQ(renderer().render(off).image.data, renderer().render(without).image.data);
}

TEST_F(GlassPictures, IssueExactlyTheDrawsOfThePlan) {
    Scene scene = colorfulWall();
    Material ball = clearGlass(1.4f, 0.2f);
    ball.thickness = 0.6f;
    for (int i = 0; i < 6; ++i) {
        place(scene, quad(0.5f, addMaterial(scene, clearGlass())), tilted(0.1 * i, 10.0 * i));
    }
    place(scene, sphere(0.3f, 24, addMaterial(scene, ball)), moved(0.3, 0.3, 0.8));
    FrameRequest r = through(std::move(scene), "counted");
    r.accuracy.planar = PlanarMethod::mirror;
    for (int frame = 0; frame < 3; ++frame) {
        const RendererCounters before = renderer().counters();
        const Frame drawn = renderer().render(r);
        const RendererCounters after = renderer().counters();
        const PlanTotals planned = totals(drawn.plan);
        EXPECT_EQ(after.drawCalls - before.drawCalls, planned.draws);
        EXPECT_EQ(after.triangles - before.triangles, planned.triangles);
        EXPECT_EQ(badSamples(drawn.image), 0u);
        if (frame == 2) {
            EXPECT_EQ(after.texturesMade, before.texturesMade);
        }
    }
}

}  // namespace
}  // namespace clerestory::test
