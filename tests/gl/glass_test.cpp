// Glass over a backdrop: against the optics of panes and balls written out in double.
#include "sight.h"

#include <glm/gtc/matrix_transform.hpp>

#include <numeric>

namespace clerestory::test {
namespace {

class GlassPictures : public GlTest {};

glm::dmat4 tilted(double z, double degrees) {  // about the vertical
    return glm::rotate(moved(0, 0, z), glm::radians(degrees), glm::dvec3(0, 1, 0));
}

// One mesh, so that it is a body.
MeshDraft cube(float half, Index material) {
    MeshDraft draft{.name = "cube", .material = material, .hasNormals = true};
    for (int axis = 0; axis < 3; ++axis) {
        for (int side = -1; side <= 1; side += 2) {
            const auto first = static_cast<std::uint32_t>(draft.vertices.size());
            for (int i = 0; i < 4; ++i) {
                Vertex v;
                v.position[axis] = half * float(side);
                v.position[(axis + 1) % 3] = (i == 1 || i == 2) ? half : -half;
                v.position[(axis + 2) % 3] = i >= 2 ? half : -half;
                v.normal = glm::vec3(0.0f);
                v.normal[axis] = float(side);
                draft.vertices.push_back(v);
            }
            for (const std::uint32_t i : side > 0 ? std::array{0u, 1u, 2u, 0u, 2u, 3u}
                                                  : std::array{0u, 2u, 1u, 0u, 3u, 2u}) {
                draft.indices.push_back(first + i);
            }
        }
    }
    return draft;
}

FrameRequest through(Scene scene, const std::string& id, const glm::dvec3& eye = {0, 0, 2}) {
    FrameRequest r = request(std::move(scene), id, eye);
    r.accuracy.glass = GlassMethod::backdrop;
    r.accuracy.planar = PlanarMethod::environment;  // what it mirrors is the map
    return r;
}

// ---- the truth ---------------------------------------------------------------------------------

double cosineInside(double cosine, double ior) {
    return std::sqrt(1.0 - (1.0 - cosine * cosine) / (ior * ior));
}
// Unpolarised, from the amplitudes of both polarisations.
double fresnel(double cosine, double ior) {
    const double c = cosineInside(cosine, ior);
    const double s = (cosine - ior * c) / (cosine + ior * c);
    const double p = (ior * cosine - c) / (ior * cosine + c);
    return 0.5 * (s * s + p * p);
}
// All bounces between the faces summed; `clear`: what one crossing leaves.
double paneTransmits(double cosine, double ior, double clear = 1.0) {
    const double f = fresnel(cosine, ior);
    return (1 - f) * (1 - f) * clear / (1 - f * f * clear * clear);
}
double paneReflects(double cosine, double ior) {
    return 1.0 - paneTransmits(cosine, ior);
}

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

TEST_F(GlassPictures, OfIndexOneShowNoObjectAtAll) {
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

TEST_F(GlassPictures, LoseNoLightInAWhiteFurnace) {
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

// ---- panes -------------------------------------------------------------------------------------

struct Mask {
    int both = 0, either = 0;
    void add(bool a, bool b) {
        both += a && b;
        either += a || b;
    }
    double overlap() const { return either == 0 ? 0.0 : double(both) / either; }
};

TEST_F(GlassPictures, OfThinPanesShowALampAtItsPlaceDimmedByWhatThePanesLetThrough) {
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

TEST_F(GlassPictures, OfAThickTiltedPaneShiftAStraightEdgeAndDoNotBendIt) {
    const double thickness = 0.3, ior = 1.5;
    for (const auto& [tilt, wall] : {std::pair(-50.0, true),
                                     {-20.0, true},
                                     {0.0, true},
                                     {35.0, true},
                                     {60.0, true},
                                     {-50.0, false},
                                     {60.0, false}}) {
        Scene scene;
        place(scene, quad(4.0f, addMaterial(scene, glowing({1, 1, 1}))),
              moved(-4, 0, -2));  // x < 0
        if (wall) place(scene, quad(4.0f, addMaterial(scene, glowing({0, 0, 0}))), moved(4, 0, -2));
        Material m = clearGlass(float(ior));
        m.thickness = float(thickness);
        place(scene, quad(6.0f, addMaterial(scene, m)), tilted(0, tilt));
        FrameRequest r = through(std::move(scene), "thick", {0.05, 0, 2});
        r.width = r.height = 256;
        r.camera.yfov = 0.8;
        const Image image = renderer().render(r).image;
        const glm::dvec3 normal(tilted(0, tilt)[2]);

        // Where the ray through (x, y) crosses the lamp's plane.
        const auto arrives = [&](double x, double y) {
            const Ray ray = sight(r, x, y);
            const double cosine = -glm::dot(ray.direction, normal);
            const double inside = cosineInside(cosine, ior);
            const glm::dvec3 entry =
                ray.origin + ray.direction * (glm::dot(ray.origin, normal) / cosine);
            const glm::dvec3 within =
                ray.direction / ior + normal * (cosine / ior - inside);  // unit
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
        // The picture knows an edge to half a pixel, and whether something or nothing is behind the
        // glass to one more half.
        EXPECT_LE(worst, wall ? 0.5 : 1.0)
            << "pixels beside its place, pane at " << tilt << " degrees";
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

TEST_F(GlassPictures, OfTintedPanesTakeTheirBaseColorOnce) {
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

TEST_F(GlassPictures, CoveredInPartShowWhatIsBehindBesideTheGlass) {
    // alphaMode blend: coverage counts for the surface with all that it lets through.
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

// ---- bodies ------------------------------------------------------------------------------------

TEST_F(GlassPictures, OfABallShowTheWorldUpsideDown) {
    Scene scene;
    place(scene, quad(10.0f, addMaterial(scene, glowing({1, 0, 0}))), moved(0, 10, -4));
    place(scene, quad(10.0f, addMaterial(scene, glowing({0, 0, 1}))), moved(0, -10, -4));
    Material m = clearGlass();
    m.thickness = 1.0f;
    place(scene, sphere(0.5f, 48, addMaterial(scene, m)));
    FrameRequest r = through(std::move(scene), "upside down");
    r.camera.yfov = 0.7;
    const Image image = renderer().render(r).image;
    EXPECT_GT(color(image, 32, 2).x, 0.9f) << "beside the ball the world stands upright";
    for (std::uint32_t y = 20; y < 44; ++y) {
        if (y >= 31 && y <= 32) continue;
        const glm::vec3 seen = color(image, 32, y);
        EXPECT_GT(y < 32 ? seen.z : seen.x, 0.8f) << y;
        EXPECT_LT(y < 32 ? seen.x : seen.z, 0.1f) << y;
    }
}

// From within water or glass, all of the world outside lies in a cone.
// A ball with a cavity, so that light passes two walls.
MeshDraft bottle(float radius, float wall, Index material) {
    MeshDraft draft = sphere(radius, 48, material);
    MeshDraft inner = sphere(radius - wall, 48, material);
    const auto first = static_cast<std::uint32_t>(draft.vertices.size());
    for (Vertex& v : inner.vertices) v.normal = -v.normal;
    draft.vertices.insert(draft.vertices.end(), inner.vertices.begin(), inner.vertices.end());
    for (std::size_t i = 0; i < inner.indices.size(); i += 3) {
        for (const std::size_t k : {0, 2, 1}) draft.indices.push_back(first + inner.indices[i + k]);
    }
    return draft;
}

TEST_F(GlassPictures, OfAThinWallAreThoseOfAPaneAndNotOfABall) {
    const auto seen = [&](GlassMethod method, float wall) {
        Scene scene;
        Material clear = clearGlass();
        clear.thickness = wall;
        place(scene, bottle(0.6f, wall, addMaterial(scene, clear)));
        place(scene, quad(1.5f, addMaterial(scene, glowing({1, 0, 0}))), moved(-1.5, 0, -1.5));
        place(scene, quad(1.5f, addMaterial(scene, glowing({0, 1, 0}))), moved(1.5, 0, -1.5));
        FrameRequest r = through(std::move(scene), "bottle");
        r.accuracy.glass = method;
        r.accuracy.bounces = 8;
        return renderer().render(r).image;
    };
    // Left of the middle red is behind it: a ball would show green there.
    for (const GlassMethod method : {GlassMethod::backdrop, GlassMethod::traced}) {
        const Image image = seen(method, 0.01f);
        EXPECT_GT(color(image, 26, 32).x, 0.75f) << int(method);
        EXPECT_EQ(color(image, 26, 32).y, 0.0f) << int(method);
        EXPECT_GT(color(image, 38, 32).y, 0.75f) << int(method);
    }
    const Image backdrop = seen(GlassMethod::backdrop, 0.01f);
    const Image traced = seen(GlassMethod::traced, 0.01f);
    double squares = 0.0;
    for (std::uint32_t y = 0; y < 64; ++y) {
        for (std::uint32_t x = 0; x < 64; ++x) {
            const glm::dvec3 off = color(backdrop, x, y) - color(traced, x, y);
            squares += glm::dot(off, off) / 3.0;
        }
    }
    // The far wall's reflection, at most a tenth, and the rim, where rays see the wall's thickness.
    EXPECT_LT(std::sqrt(squares / 4096.0), 0.06);
}

TEST_F(GlassPictures, FromWithinShowTheWorldInSnellsWindow) {
    for (const double ior : {1.5, 1.8}) {
        Scene scene;
        place(scene, quad(300.0f, addMaterial(scene, glowing({1, 1, 1}))), moved(0, 0, -2));
        Material m = clearGlass(float(ior));
        m.thickness = 2.0f;
        place(scene, cube(1.0f, addMaterial(scene, m)));
        FrameRequest r = through(std::move(scene), "window", {0, 0, 0});
        // A slit that reaches 83 degrees to both sides: beyond it the picture knows nothing.
        r.width = 2048;
        r.height = 16;
        r.camera.yfov = 0.127;
        const Image image = renderer().render(r).image;
        const double critical = glm::degrees(std::asin(1.0 / ior));
        double widest = 0.0;
        for (std::uint32_t x = 1024; x < 2048; ++x) {
            const double angle = glm::degrees(std::acos(-sightOfPixel(r, x, 8).direction.z));
            if (angle > 44.5) continue;  // another side of the cube
            const double sine = ior * std::sin(glm::radians(angle));
            const double expected =
                sine < 1.0 ? 1.0 - fresnel(std::sqrt(1.0 - sine * sine), ior) : 0.0;
            const float seen = color(image, x, 8).x;
            if (seen > 0.0f) widest = angle;
            if (sine < 0.99) {
                EXPECT_NEAR(seen, expected, 3e-3) << angle;
            }
            if (angle > critical + 0.5) {
                EXPECT_EQ(seen, 0.0f) << angle;
            }
        }
        EXPECT_NEAR(widest, critical, 0.5) << "index " << ior;
    }
}

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

TEST_F(GlassPictures, SwitchedOffAreByteForByteThoseOfASceneWithoutTransmission) {
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

TEST_F(GlassPictures, AskOpenGLForWhatThePlanSaysAndNoMore) {
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
