// Panes over a backdrop and traced, compared with their optics in double precision.
#include "glass_truth.h"

#include <numeric>

namespace clerestory::test {
namespace {

struct Mask {
    int both = 0, either = 0;
    void add(bool a, bool b) {
        both += a && b;
        either += a || b;
    }
    double overlap() const { return either == 0 ? 0.0 : double(both) / either; }
};

TEST_F(GlassPictures, OfThinPanesShowALampAttenuatedByTheirTransmittance) {
    const glm::vec3 radiance(8.0f, 0.5f, 0.25f);
    const auto scene = [&](int panes, double tilt) {
        Scene s;
        place(s, quad(0.5f, addMaterial(s, glowing(radiance))), moved(0.2, -0.1, -2));
        const Index m = addMaterial(s, clearGlass());
        for (int i = 0; i < panes; ++i) place(s, quad(4.0f, m), tilted(-0.4 * i, tilt));
        return s;
    };
    for (const double tilt : {0.0, 30.0, 60.0}) {
        const Image bare = renderer().render(through(scene(0, 0), "bare")).image;
        for (const int panes : {1, 2, 3}) {
            const FrameRequest r = through(scene(panes, tilt), "panes");
            const Image image = renderer().render(r).image;
            const glm::dvec3 normal(tilted(0, tilt)[2]);
            Mask mask;
            double worst = 0.0;
            for (std::uint32_t y = 0; y < r.height; ++y) {
                for (std::uint32_t x = 0; x < r.width; ++x) {
                    const glm::vec3 seen = color(image, x, y);
                    const bool here = color(bare, x, y).x > 1.0f;
                    mask.add(here, seen.x > 1.0f);
                    if (!here || seen.x <= 1.0f) continue;
                    const double cosine =
                        std::abs(glm::dot(sightOfPixel(r, x, y).direction, normal));
                    const double expected = std::pow(paneTransmits(cosine, 1.5), panes);
                    worst = std::max({worst, std::abs(seen.x / radiance.x - expected),
                                      std::abs(seen.z / radiance.z - expected)});
                }
            }
            EXPECT_GT(mask.both, 60);
            EXPECT_LE(worst, 3e-3 * panes) << panes << " panes at " << tilt << " degrees";
            EXPECT_GT(mask.overlap(), 0.98) << panes << " panes at " << tilt << " degrees";
        }
    }
}

// Pixels from the left edge to where a lamp ends that is seen through a thick pane: as it is drawn
// in the greatest error of all rows, against Snell's law.
double thickPaneError(GlassMethod method, double tilt, bool wall) {
    const double thickness = 0.3, ior = 1.5;
    Scene scene;
    place(scene, quad(4.0f, addMaterial(scene, glowing({1, 1, 1}))), moved(-4, 0, -2));  // x < 0
    if (wall) place(scene, quad(4.0f, addMaterial(scene, glowing({0, 0, 0}))), moved(4, 0, -2));
    Material m = clearGlass(float(ior));
    m.thickness = float(thickness);
    place(scene, quad(6.0f, addMaterial(scene, m)), tilted(0, tilt));
    FrameRequest r = through(std::move(scene), "thick", {0.05, 0, 2});
    r.accuracy.glass = method;
    r.width = r.height = 256;
    r.camera.yfov = 0.8;
    const Image image = renderer().render(r).image;
    const glm::dvec3 normal(tilted(0, tilt)[2]);

    // The intersection of the ray through (x, y) with the lamp's plane.
    const auto arrives = [&](double x, double y) {
        const Ray ray = sight(r, x, y);
        const double cosine = -glm::dot(ray.direction, normal);
        const double inside = cosineInside(cosine, ior);
        const glm::dvec3 entry =
            ray.origin + ray.direction * (glm::dot(ray.origin, normal) / cosine);
        const glm::dvec3 within = ray.direction / ior + normal * (cosine / ior - inside);  // unit
        const glm::dvec3 exit = entry + within * (thickness / inside);
        return exit.x + ray.direction.x * (-2.0 - exit.z) / ray.direction.z;
    };
    double worst = 0.0;
    for (std::uint32_t y = 8; y < r.height - 8; y += 8) {
        double low = 0.0, high = r.width;  // of the edge's place
        for (int i = 0; i < 50; ++i) {
            const double middle = 0.5 * (low + high);
            (arrives(middle, y + 0.5) < 0.0 ? low : high) = middle;
        }
        double lit = 0.0;  // pixels from the left edge on
        for (std::uint32_t x = 0; x < r.width; ++x) {
            const double cosine = -glm::dot(sightOfPixel(r, x, y).direction, normal);
            lit += std::min(1.0, color(image, x, y).x / paneTransmits(cosine, ior));
        }
        worst = std::max(worst, std::abs(lit - low));
    }
    return worst;
}

TEST_F(GlassPictures, OfAThickTiltedPaneShiftAStraightEdge) {
    for (const double tilt : {-50.0, -20.0, 0.0, 35.0, 60.0}) {
        // Backdrop and rays locate an edge to half a pixel.
        EXPECT_LE(thickPaneError(GlassMethod::backdrop, tilt, true), 0.5) << tilt;
        EXPECT_LE(thickPaneError(GlassMethod::traced, tilt, true), 0.5) << tilt;
    }
    // Coverage behind the glass adds half a pixel.
    for (const double tilt : {-50.0, 60.0}) {
        EXPECT_LE(thickPaneError(GlassMethod::backdrop, tilt, false), 1.0) << tilt;
    }
}

TEST_F(GlassPictures, AbsorbAlongTheirPath) {
    const glm::dvec3 tint(0.5, 0.8, 0.05);
    for (const double tilt : {0.0, 40.0, 70.0}) {
        Scene scene;
        place(scene, quad(300.0f, addMaterial(scene, glowing({1, 1, 1}))), moved(0, 0, -80));
        Material m = clearGlass();
        m.thickness = 0.2f;
        m.attenuationColor = glm::vec3(tint);
        m.attenuationDistance = 0.15f;
        place(scene, quad(20.0f, addMaterial(scene, m)), tilted(0, tilt));
        const FrameRequest r = through(std::move(scene), "absorbing");
        const Image image = renderer().render(r).image;
        const glm::dvec3 normal(tilted(0, tilt)[2]);
        for (std::uint32_t y = 24; y < 40; ++y) {
            for (std::uint32_t x = 24; x < 40; ++x) {
                const double cosine = -glm::dot(sightOfPixel(r, x, y).direction, normal);
                const double path = 0.2 / cosineInside(cosine, 1.5);
                for (int i = 0; i < 3; ++i) {
                    const double clear = std::pow(tint[i], path / 0.15);
                    EXPECT_NEAR(color(image, x, y)[i], paneTransmits(cosine, 1.5, clear), 2e-3)
                        << tilt;
                }
            }
        }
    }
}

TEST_F(GlassPictures, OfTintedPanesApplyBaseColorOnce) {
    Scene scene;
    place(scene, quad(30.0f, addMaterial(scene, glowing({1, 1, 1}))), moved(0, 0, -3));
    Material m = clearGlass();
    m.baseColor = {0.2f, 0.6f, 0.0f, 1.0f};
    place(scene, quad(2.0f, addMaterial(scene, m)));
    const glm::vec3 seen =
        centerColor(renderer().render(through(std::move(scene), "tinted")).image);
    for (int i = 0; i < 3; ++i) {
        EXPECT_NEAR(seen[i], m.baseColor[i] * paneTransmits(1.0, 1.5), 2e-3);
    }
}

// The far wall of a ball with thin walls is seen through its near one, and what is within through
// the near one alone.
TEST_F(GlassPictures, OfShellsShowBothWalls) {
    for (const float roughness : {0.0f, 0.4f}) {
        for (const bool within : {false, true}) {
            Scene scene;
            place(scene, quad(300.0f, addMaterial(scene, glowing({1, 1, 1}))), moved(0, 0, -80));
            Material wall = clearGlass(1.5f, roughness);
            wall.baseColor = {0.2f, 0.6f, 0.9f, 1.0f};
            wall.doubleSided = true;
            place(scene, sphere(1.0f, 64, addMaterial(scene, wall)));
            Material pane = clearGlass(1.0f);
            pane.baseColor = {0.9f, 0.1f, 0.5f, 1.0f};
            if (within) place(scene, quad(0.5f, addMaterial(scene, pane)));
            const glm::vec3 seen =
                centerColor(renderer().render(through(std::move(scene), "shell")).image);
            for (int i = 0; i < 3; ++i) {
                const double walls = std::pow(wall.baseColor[i] * paneTransmits(1.0, 1.5), 2.0);
                EXPECT_NEAR(seen[i], walls * (within ? pane.baseColor[i] : 1.0f), 4e-3)
                    << roughness << ' ' << within;
            }
        }
    }
}

// The blur of rough panes is that of the path tracer, whatever the unit of the scene is: a lamp of
// 1 m, 2 m behind a pane.
TEST_F(GlassPictures, OfRoughPanesAreThoseOfTheReference) {
    for (const double unit : {0.01, 1.0, 100.0}) {
        for (const float roughness : {0.3f, 0.5f}) {
            Scene scene;
            const auto half = [&](double metres) { return static_cast<float>(unit * metres); };
            place(scene, quad(half(0.5), addMaterial(scene, glowing({1, 1, 1}))),
                  moved(0, 0, -2 * unit));
            place(scene, quad(half(6.0), addMaterial(scene, clearGlass(1.5f, roughness))));
            FrameRequest r = through(Scene(scene), "rough", {0, 0, 2 * unit});
            r.camera.znear = 0.01 * unit;
            r.width = r.height = 64;
            const std::vector<double> truth = tracedPixels(scene, r);
            const Image image = renderer().render(r).image;
            double difference = 0.0, light = 0.0;
            for (std::uint32_t i = 0; i < r.width * r.height; ++i) {
                difference += std::abs(color(image, i % r.width, i / r.width).x - truth[i]);
                light += truth[i];
            }
            EXPECT_LT(difference / light, 0.35) << unit << ' ' << roughness;
        }
    }
}

// The same of both walls of a rough shell, with a pane within.
TEST_F(GlassPictures, OfRoughShellsAreThoseOfTheReference) {
    for (const bool within : {false, true}) {
        Scene scene;
        place(scene, quad(300.0f, addMaterial(scene, glowing({1, 1, 1}))), moved(0, 0, -80));
        Material wall = clearGlass(1.5f, 0.4f);
        wall.doubleSided = true;
        place(scene, sphere(1.0f, 64, addMaterial(scene, wall)));
        Material pane = clearGlass(1.0f);
        pane.baseColor = {0.1f, 0.1f, 0.1f, 1.0f};
        if (within) place(scene, quad(0.5f, addMaterial(scene, pane)));
        FrameRequest r = through(Scene(scene), "shell");
        r.camera.yfov = 0.02;
        r.width = r.height = 16;
        const std::vector<double> truth = tracedPixels(scene, r);
        const double expected =
            std::accumulate(truth.begin(), truth.end(), 0.0) / double(truth.size());
        // The pane's edge is in the tails of the lobe, which frames blur less.
        EXPECT_NEAR(centerColor(renderer().render(r).image).x, expected, within ? 0.03 : 0.003);
    }
}

TEST_F(GlassPictures, WithPartialCoverageBlendGlassAndBackground) {
    // alphaMode blend: coverage applies to the surface including its transmission.
    for (const GlassMethod method :
         {GlassMethod::environment, GlassMethod::backdrop, GlassMethod::traced}) {
        for (const float coverage : {0.0f, 0.25f, 0.75f, 1.0f}) {
            Scene scene;
            Material pane = clearGlass();
            pane.alphaMode = AlphaMode::blend;
            pane.baseColor = {0.5f, 0.8f, 1.0f, coverage};
            place(scene, quad(1.0f, addMaterial(scene, pane)), moved(0, 0, 1));
            place(scene, quad(3.0f, addMaterial(scene, glowing({2, 1, 0.5f}))));
            FrameRequest r = through(std::move(scene), "covered");
            r.accuracy.glass = method;
            const glm::dvec3 behind(2, 1, 0.5);
            const double let = method == GlassMethod::environment ? 0.0 : paneTransmits(1.0, 1.5);
            const glm::dvec3 expected =
                double{coverage} * let * glm::dvec3(pane.baseColor) * behind +
                (1.0 - double{coverage}) * behind;
            const glm::vec3 seen = centerColor(renderer().render(r).image);
            for (int c = 0; c < 3; ++c) {
                EXPECT_NEAR(seen[c], expected[c], 4e-3) << coverage << " " << int(method);
            }
        }
    }
}

TEST_F(GlassPictures, AtGrazingAnglesAreMirrors) {
    Scene scene;  // a pane on black cloth under a white sky
    Material cloth{.name = "cloth", .baseColor = {0, 0, 0, 1}, .unlit = true};
    place(scene, quad(400.0f, addMaterial(scene, cloth)), moved(0, 0, -0.001));
    place(scene, quad(50.0f, addMaterial(scene, clearGlass())));
    FrameRequest r = through(std::move(scene), "grazing", {0, -5, 0.2});
    r.camera.target = glm::dvec3(0, 0, 0);
    r.camera.up = glm::dvec3(0, 0, 1);
    r.camera.yfov = 0.2;
    r.environment.map = "white";
    const Image image = renderer().render(r).image;
    int compared = 0, at89 = 0;
    for (std::uint32_t y = 0; y < r.height; ++y) {
        const Ray ray = sightOfPixel(r, 32, y);
        const double cosine = -ray.direction.z;
        if (cosine < 0.005) continue;  // beyond the pane
        ++compared;
        const float seen = color(image, 32, y).x;
        EXPECT_NEAR(seen, paneReflects(cosine, 1.5), 5e-3) << glm::degrees(std::acos(cosine));
        if (cosine < std::cos(glm::radians(89.0))) {
            ++at89;
            EXPECT_GT(seen, 0.9f);
        }
    }
    EXPECT_GT(compared, 20);
    EXPECT_GT(at89, 1);
}

}  // namespace
}  // namespace clerestory::test
