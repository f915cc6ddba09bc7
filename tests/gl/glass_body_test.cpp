// Solid glass over a backdrop and traced: inversion, thin shells, and the eye inside.
#include "glass_truth.h"

namespace clerestory::test {
namespace {

TEST_F(GlassPictures, OfABallShowTheSceneUpsideDown) {
    Scene scene;
    place(scene, quad(10.0f, addMaterial(scene, glowing({1, 0, 0}))), moved(0, 10, -4));
    place(scene, quad(10.0f, addMaterial(scene, glowing({0, 0, 1}))), moved(0, -10, -4));
    Material m = clearGlass();
    m.thickness = 1.0f;
    place(scene, sphere(0.5f, 48, addMaterial(scene, m)));
    FrameRequest r = through(std::move(scene), "upside down");
    r.camera.yfov = 0.7;
    const Image image = renderer().render(r).image;
    EXPECT_GT(color(image, 32, 2).x, 0.9f) << "next to the ball the scene is upright";
    for (std::uint32_t y = 20; y < 44; ++y) {
        if (y >= 31 && y <= 32) continue;
        const glm::vec3 seen = color(image, 32, y);
        EXPECT_GT(y < 32 ? seen.z : seen.x, 0.8f) << y;
        EXPECT_LT(y < 32 ? seen.x : seen.z, 0.1f) << y;
    }
}

// Without a change of index light does not turn: small balls before a wall are invisible.
TEST_F(GlassPictures, OfSmallBodiesShowWhatIsBehindThem) {
    for (const float radius : {0.06f, 0.09f, 0.12f}) {
        Scene scene;
        place(scene, quad(10.0f, addMaterial(scene, glowing({1, 1, 1}))), moved(0, 0, -2));
        Material m = clearGlass(1.0f);
        m.thickness = 1.0f;
        place(scene, sphere(radius, 24, addMaterial(scene, m)));
        FrameRequest r = request(std::move(scene), "small");
        r.width = 320;
        r.height = 180;
        const Image image = renderer().render(r).image;
        for (std::uint32_t y = 80; y < 100; ++y) {
            for (std::uint32_t x = 150; x < 170; ++x) {
                EXPECT_NEAR(color(image, x, y).x, 1.0f, 0.01f) << radius << ' ' << x << ' ' << y;
            }
        }
    }
}

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

TEST_F(GlassPictures, OfAThinShellAreThoseOfAPane) {
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

// From within water or glass, all of the world outside lies in a cone.
TEST_F(GlassPictures, FromInsideShowTheSceneInSnellsWindow) {
    for (const double ior : {1.5, 1.8}) {
        Scene scene;
        place(scene, quad(300.0f, addMaterial(scene, glowing({1, 1, 1}))), moved(0, 0, -2));
        Material m = clearGlass(float(ior));
        m.thickness = 2.0f;
        place(scene, cube(1.0f, addMaterial(scene, m)));
        FrameRequest r = through(std::move(scene), "window", {0, 0, 0});
        // A slit of 83 degrees to both sides, which bounds the backdrop.
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

}  // namespace
}  // namespace clerestory::test
