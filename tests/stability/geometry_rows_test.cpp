// Rows about positions, sizes and shapes, in frames: scale, distance, planes through the eye,
// degenerate meshes and transforms, cameras, depth, order.
#include "tests/stability/frames.h"

#include <glm/gtc/matrix_transform.hpp>

#include <functional>
#include <limits>

namespace clerestory::test {
namespace {

FrameRequest overTheFloor(const glm::dmat4& world, const char* id) {
    FrameRequest r = byPictures(floorScene(world, false, true), id, {});
    r.camera.position = glm::dvec3(world * glm::dvec4(0.3, -1.6, 0.9, 1.0));
    r.camera.target = glm::dvec3(world * glm::dvec4(0.0, 0.0, 0.2, 1.0));
    r.camera.up = glm::dvec3(0, 0, 1);
    return r;
}

TEST_F(FrameRows, Scale) {
    const auto picture = [](double scale) {
        FrameRequest r = overTheFloor(glm::scale(glm::dmat4(1.0), glm::dvec3(scale)), "scaled");
        r.camera.znear = 0.01 * scale;
        return drawn(r);
    };
    const Image one = picture(1.0);
    for (double scale = 1e-4; scale < 2e6; scale *= longForm() ? 3.7 : 10.0) {
        EXPECT_TRUE(atLeast("scale", "PSNR, decibels", decibelsApart(picture(scale), one), 60.0))
            << scale;
    }
}

TEST_F(FrameRows, FarFromTheOrigin) {
    const auto request = [](double far) {
        return overTheFloor(glm::translate(glm::dmat4(1.0), glm::dvec3(far, -far, 0.5 * far)),
                            "far");
    };
    const Image here = drawn(request(0.0));
    for (const double far : {0.0, 1e2, 1e4, 1e6}) {
        const Image there = drawn(request(far));
        double sum = 0.0;
        std::uint32_t off = 0;
        for (std::uint32_t y = 0; y < 64; ++y) {
            for (std::uint32_t x = 0; x < 64; ++x) {
                const double apart =
                    255.0 * greatestDifference(color(here, x, y), color(there, x, y));
                sum += apart;
                if (apart <= 4.0) continue;
                // A silhouette: some neighbour here looks like this pixel there.
                bool edge = false;
                for (int j = -1; j <= 1; ++j) {
                    for (int i = -1; i <= 1; ++i) {
                        const auto u = std::uint32_t(std::clamp(int(x) + i, 0, 63));
                        const auto v = std::uint32_t(std::clamp(int(y) + j, 0, 63));
                        edge |= 255.0 * greatestDifference(color(here, u, v), color(there, x, y)) <=
                                4.0;
                    }
                }
                off += !edge;
            }
        }
        EXPECT_TRUE(atMost("far from the origin", "mean difference, codes", sum / 4096.0, 0.5))
            << far;
        EXPECT_TRUE(atMost("far from the origin", "pixels over 4 codes off silhouettes", off, 0.0))
            << far;
    }
}

// The floor through the eye, and the eye on either side of it; above it, against the mirrored copy.
TEST_F(FrameRows, PlaneThroughTheEye) {
    FrameRequest seen = byPictures(floorScene(glm::dmat4(1.0), false, true), "through", {});
    FrameRequest mirrored = byPictures(floorScene(glm::dmat4(1.0), false, false), "floor", {});
    FrameRequest copy = byPictures(floorScene(glm::dmat4(1.0), true, false), "copy", {});
    // At the border of a mirror's picture small emitters have no neighbours.
    mirrored.accuracy.emitterCoverage = copy.accuracy.emitterCoverage = false;
    mirrored.environment.map = copy.environment.map = "black";
    std::vector<double> heights{0.0};
    for (double h = 1e-7; h < 2e3; h *= longForm() ? 3.1622776 : 100.0) {
        heights.insert(heights.end(), {h, -h});
    }
    for (const double height : heights) {
        for (const double degrees : {0.0, 10.0, 45.0, 90.0}) {
            const double tilt = glm::radians(degrees);
            for (FrameRequest* r : {&seen, &mirrored, &copy}) {
                r->camera.znear = 1e-3;
                r->camera.position = glm::dvec3(0.1, -1.2, height);
                r->camera.target =
                    *r->camera.position + glm::dvec3(0, std::cos(tilt), -std::sin(tilt));
                r->camera.up = glm::dvec3(0, std::sin(tilt), std::cos(tilt));
            }
            const Image image = drawn(seen);
            double most = 0.0;
            for (std::uint32_t i = 0; i < 64 * 64; ++i) {
                const glm::vec3 c = color(image, i % 64, i / 64);
                most = std::max({most, double(c.x), double(c.y), double(c.z)});
            }
            EXPECT_TRUE(atMost("plane through the eye", "brightest pixel under white", most, 1.02))
                << height << " tilt " << degrees;
            if (height < 1e-3 || height > 10.0) continue;
            const Image a = drawn(mirrored), b = drawn(copy);
            std::uint32_t off = 0;
            for (std::uint32_t i = 0; i < 64 * 64; ++i) {
                off +=
                    greatestDifference(color(a, i % 64, i / 64), color(b, i % 64, i / 64)) > 2e-3f;
            }
            // Beyond the floor's rim the copy is seen and the mirror is not.
            FrameRequest ids = mirrored;
            ids.output.channel = Channel::objectId;
            const Image numbers = renderer().render(ids).image;
            std::uint32_t wrong = 0;
            for (std::uint32_t i = 0; i < 64 * 64; ++i) {
                if (number(numbers, i % 64, i / 64) != 4.0f) continue;
                wrong +=
                    greatestDifference(color(a, i % 64, i / 64), color(b, i % 64, i / 64)) > 2e-3f;
            }
            EXPECT_TRUE(
                atMost("plane through the eye", "pixels unlike the mirrored scene", wrong, 0.0))
                << height << " tilt " << degrees << " of " << off;
        }
    }
}

TEST_F(FrameRows, StraightUpDownAndLevelAtAnyRoll) {
    struct Case {
        FrameRequest mirrored, copy;
    };
    for (const double pitch : {-90.0, 0.0, 90.0}) {
        // The floor turned to a ceiling or a wall: the eye looks straight at it.
        const glm::dmat4 world =
            glm::rotate(glm::dmat4(1.0), glm::radians(pitch + 90.0), glm::dvec3(1, 0, 0));
        Case c{byPictures(floorScene(world, false, false), "mirrored", {}),
               byPictures(floorScene(world, true, false), "copy", {})};
        const glm::dvec3 eye(world * glm::dvec4(0.05, 0.02, 1.3, 1));
        const glm::dvec3 at(world * glm::dvec4(0.05, 0.02, 0.0, 1));
        for (int degrees = 0; degrees < 360; degrees += steps(15, 1)) {
            const double a = glm::radians(double(degrees));
            for (FrameRequest* r : {&c.mirrored, &c.copy}) {
                r->environment.map = "black";
                r->camera.position = eye;
                r->camera.target = at;
                r->camera.up = glm::dvec3(world * glm::dvec4(std::cos(a), std::sin(a), 0, 0));
            }
            const Image mirrored = drawn(c.mirrored), copy = drawn(c.copy);
            std::uint32_t off = 0, lit = 0;
            for (std::uint32_t i = 0; i < 64 * 64; ++i) {
                lit += color(copy, i % 64, i / 64).y > 0.0f;
                off += greatestDifference(color(mirrored, i % 64, i / 64),
                                          color(copy, i % 64, i / 64)) > 2e-3f;
            }
            EXPECT_GT(lit, 100u);
            EXPECT_TRUE(
                atMost("straight up and down", "pixels unlike the mirrored scene", off, 0.0))
                << pitch << " roll " << degrees;
        }
    }
}

TEST_F(FrameRows, DegenerateGeometryIsTheCleanMesh) {
    const auto picture = [](const std::function<void(MeshDraft&)>& damage, bool damaged) {
        Scene scene = floorScene(glm::dmat4(1.0), false, false);
        MeshDraft draft =
            sphere(0.3f, 12, addMaterial(scene, {.name = "paper", .baseColor = {.8, .5, .3, 1}}));
        damage(draft);
        place(scene, std::move(draft), moved(0, 0, 0.5));
        EXPECT_EQ(!scene.warnings.empty(), damaged);
        FrameRequest r = byPictures(std::move(scene), "degenerate", {0.3, -1.6, 0.9});
        r.camera.target = glm::dvec3(0.0, 0.0, 0.2);
        r.camera.up = glm::dvec3(0, 0, 1);
        return drawn(r);
    };
    const Image clean = picture([](MeshDraft&) {}, false);
    const auto addTriangle = [](MeshDraft& d, const glm::vec3& a, const glm::vec3& b,
                                const glm::vec3& c) {
        for (const glm::vec3& p : {a, b, c}) {
            Vertex v;
            v.position = p;
            v.normal = {0, 0, 1};
            d.vertices.push_back(v);
            d.indices.push_back(std::uint32_t(d.vertices.size() - 1));
        }
    };
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const std::vector<std::pair<const char*, std::function<void(MeshDraft&)>>> rows{
        {"zero area",
         [&](MeshDraft& d) { addTriangle(d, glm::vec3(0.1f), glm::vec3(0.1f), glm::vec3(0.1f)); }},
        {"collinear",
         [&](MeshDraft& d) {
             addTriangle(d, {0, 0, 0}, {1, 1, 1}, {0.5f, 0.5f, 0.5f});
         }},
        {"NaN vertex",
         [&](MeshDraft& d) {
             addTriangle(d, {nan, 0, 0}, {1, 0, 0}, {0, 1, 0});
         }},
        {"infinite vertex",
         [&](MeshDraft& d) {
             addTriangle(d, {0, 0, 0}, {INFINITY, 0, 0}, {0, 1, 0});
         }},
        {"index out of range",
         [](MeshDraft& d) {
             d.indices.insert(d.indices.end(), {0, 1, 4000000000u});
         }},
        {"one vertex thrice",
         [](MeshDraft& d) {
             d.indices.insert(d.indices.end(), {5, 5, 6});
         }},
    };
    for (const auto& [name, damage] : rows) {
        EXPECT_TRUE(atMost("degenerate geometry", "difference from the clean mesh",
                           mostApart(picture(damage, true), clean), 0.0))
            << name;
    }
    // Sound, but tiny or drawn twice: seen as it is.
    EXPECT_TRUE(atMost("degenerate geometry", "doubled and 1e-30 small, difference",
                       mostApart(picture(
                                     [&](MeshDraft& d) {
                                         const auto once = d.indices;
                                         d.indices.insert(d.indices.end(), once.begin(),
                                                          once.end());
                                     },
                                     false),
                                 clean),
                       0.0));
}

TEST_F(FrameRows, Transforms) {
    const auto picture = [](const glm::dmat4& m) {
        Scene scene = floorScene(glm::dmat4(1.0), false, false);
        Material paper{.name = "paper", .baseColor = {.8, .5, .3, 1}};
        place(scene, sphere(0.3f, 12, addMaterial(scene, paper)), moved(0, 0, 0.5) * m);
        place(scene, quad(0.3f, addMaterial(scene, mirrorMetal())), moved(-0.4, 0, 0.5) * m);
        place(scene, sphere(0.2f, 12, addMaterial(scene, clearGlass())), moved(0.4, 0, 0.5) * m);
        FrameRequest r = byPictures(std::move(scene), "transforms", {0.3, -1.6, 0.9});
        r.camera.target = glm::dvec3(0.0, 0.0, 0.2);
        r.camera.up = glm::dvec3(0, 0, 1);
        return drawn(r);
    };
    // Whatever comes out, drawn() counts what is not finite; white light makes nothing above white.
    std::vector<glm::dmat4> all;
    for (int axis = 0; axis < 3; ++axis) {
        for (const double s : {0.0, -1.0, 1e-8, 1e8, -1e-8}) {
            glm::dvec3 scale(1.0);
            scale[axis] = s;
            all.push_back(glm::scale(glm::dmat4(1.0), scale));
        }
        glm::dmat4 shear(1.0);
        shear[axis][(axis + 1) % 3] = 3.0;
        all.push_back(shear);
    }
    all.push_back(glm::dmat4(0.0));
    all.back()[3][3] = 1.0;
    for (const double s : {1e-8, 1e8, -1.0}) {
        all.push_back(glm::scale(glm::dmat4(1.0), glm::dvec3(s)));
    }
    for (const glm::dmat4& m : all) {
        const Image image = picture(m);
        double most = 0.0;
        for (std::uint32_t i = 0; i < 64 * 64; ++i) {
            most = std::max(most, double(color(image, i % 64, i / 64).x));
        }
        EXPECT_TRUE(atMost("transforms", "brightest pixel under white", most, 1.02));
    }
    // Turned inside out, a lit ball is lit from the same side.
    const auto lit = [](const glm::dmat4& m) {
        Scene scene;
        place(scene, sphere(0.6f, 16, addMaterial(scene, {.name = "paper"})), m);
        addLight(scene, {.kind = LightKind::directional, .intensity = glm::vec3(1.0f)},
                 glm::rotate(glm::dmat4(1.0), 0.7, glm::dvec3(1, -1, 0)));
        return drawn(request(std::move(scene), "lit"));
    };
    const Image plain = lit(glm::dmat4(1.0));
    for (int axis = 0; axis < 3; ++axis) {
        glm::dvec3 flip(1.0);
        flip[axis] = -1.0;
        EXPECT_TRUE(atLeast("transforms", "ball of negative determinant, decibels",
                            decibelsApart(lit(glm::scale(glm::dmat4(1.0), flip)), plain), 40.0))
            << axis;
    }
}

// The rim of a half plane is a straight line through the picture.
TEST_F(FrameRows, FieldOfView) {
    for (int degrees = 1; degrees <= 179; degrees += steps(13, 1)) {
        const double slope = std::tan(0.5 * glm::radians(double(degrees)));
        Scene scene;
        // A quad from the middle of the picture to far beyond it, tilted by 0.3.
        place(scene, quad(1.0f, addMaterial(scene, glowing(glm::vec3(1.0f)))),
              glm::rotate(moved(0, 0, -1), 0.3, glm::dvec3(0, 0, 1)) *
                  glm::scale(glm::dmat4(1.0), glm::dvec3(8.0 * slope)) * moved(0, -1.0, 0));
        FrameRequest r = byPictures(std::move(scene), "line", {0, 0, 0});
        r.environment.map = "black";
        r.camera.yfov = glm::radians(double(degrees));
        const Image image = drawn(r);
        double most = 0.0;
        for (std::uint32_t x = 0; x < 64; ++x) {
            std::uint32_t dark = 0;
            while (dark < 64 && color(image, x, dark).x == 0.0f) ++dark;
            // Through the middle with slope tan 0.3, columns from the left, rows from the top.
            const double expected = 32.0 - (x + 0.5 - 32.0) * std::tan(0.3);
            most = std::max(most, std::abs(dark - expected));
        }
        // A row is lit when its centre is below the line: half a row at most.
        EXPECT_TRUE(atMost("field of view", "a line's distance from straight, pixels", most, 0.505))
            << degrees;
    }
}

TEST_F(FrameRows, Depth) {
    for (double ratio = 10.0; ratio < 2e12; ratio *= longForm() ? 10.0 : 100.0) {
        for (const double share : {0.999, 0.5, 0.03, 1e-3}) {  // of the way to the far plane
            const double zfar = 1e3, znear = zfar / ratio;
            const double z = std::max(share * zfar, 2.0 * znear);
            Scene scene;
            const Index front = addMaterial(scene, glowing({1, 0, 0}));
            const Index back = addMaterial(scene, glowing({0, 1, 0}));
            // The nearer one first on the left, last on the right: neither order may win.
            const auto add = [&](Index m, double at, double x) {
                place(scene, quad(1.0f, m),
                      moved(x * at, 0, -at) * glm::scale(glm::dmat4(1.0), glm::dvec3(at)));
            };
            add(front, z, -1.0);
            add(back, z * (1.0 + 1e-3), -1.0);
            add(back, z * (1.0 + 1e-3), 1.0);
            add(front, z, 1.0);
            FrameRequest r = request(std::move(scene), "depth", {0, 0, 0});
            r.camera.znear = znear;
            r.camera.zfar = 2.0 * zfar;
            const Image image = drawn(r);
            std::uint32_t wrong = 0;
            for (std::uint32_t i = 0; i < 64 * 64; ++i) {
                wrong += color(image, i % 64, i / 64).y > 0.0f;
            }
            // The farther quads are larger by 0.1 %: less than a pixel at the rim of the picture.
            EXPECT_TRUE(atMost("depth", "pixels of the farther one", wrong, 0.0))
                << ratio << " at " << z;
        }
    }
}

TEST_F(FrameRows, Order) {
    const auto scene = [](bool turned) {
        Scene s;
        std::vector<std::function<void()>> things;
        for (int i = 0; i < 3; ++i) {
            things.push_back([&s, i] {
                place(s, quad(0.2f, addMaterial(s, glowing({0.3f * float(i), 0.8f, 0.4f}))),
                      moved(0.5 * i - 0.5, 0.4, 0.3 + 0.1 * i));
            });
        }
        things.push_back([&s] { place(s, quad(1.5f, addMaterial(s, mirrorMetal(0.9f)))); });
        things.push_back([&s] {
            place(s, sphere(0.2f, 16, addMaterial(s, mirrorMetal())), moved(0.2, -0.2, 0.4));
        });
        things.push_back([&s] {
            place(s, sphere(0.2f, 16, addMaterial(s, mirrorMetal(0.8f))), moved(-0.4, -0.2, 0.4));
        });
        things.push_back(
            [&s] { place(s, quad(0.3f, addMaterial(s, clearGlass())), moved(0.3, 0.1, 0.6)); });
        if (turned) std::reverse(things.begin(), things.end());
        for (const auto& thing : things) thing();
        return s;
    };
    for (const std::uint32_t generations : {1u, 2u}) {
        const auto picture = [&](bool turned) {
            FrameRequest r = byPictures(scene(turned), "order", {0.1, 0.2, 2});
            r.environment.map = "sky";
            r.accuracy.generations = generations;
            return drawn(r).data;
        };
        const auto first = picture(false);
        EXPECT_TRUE(
            atMost("order", "file turned round: bytes differ", picture(true) != first, 0.0));
        EXPECT_TRUE(atMost("order", "frame repeated: bytes differ", picture(false) != first, 0.0));
    }
}

}  // namespace
}  // namespace clerestory::test
