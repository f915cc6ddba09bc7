// Flat mirrors inside captured cubes (S6). A mirror ball shows along each direction what a camera
// of 90 degrees at its centre sees, and that camera's flat mirrors have mirrored views.
#include "room.h"
#include "six_pictures.h"

#include <glm/gtc/matrix_transform.hpp>

namespace clerestory::test {
namespace {

class MirrorsInProbes : public GlTest {};

const glm::dvec3 kCenter(0.2, 0.1, -0.3);
constexpr double kBall = 0.02;     // radius: small, so that its own image covers a few pixels
constexpr double kMirrorAt = 1.0;  // metres below or next to the ball
constexpr double kHalf = 1.6;      // of the mirror's edge

struct Wall {
    int axis;  // the mirror faces along it
    glm::dmat4 worldFromMirror;
};
// Below the ball, facing up; or next to it, facing +X.
Wall wallOf(bool floor) {
    glm::dmat4 m(0.0);
    const int axis = floor ? 1 : 0;
    m[0][(axis + 1) % 3] = m[1][(axis + 2) % 3] = m[2][axis] = 1.0;
    m[3] = glm::dvec4(kCenter, 1.0);
    m[3][axis] -= kMirrorAt;
    return {axis, m};
}

Scene surroundings(const Wall& wall, const Material& mirror) {
    Scene scene;
    Room{}.build(scene);
    Material paint{.baseColor = {0.7f, 0.5f, 0.2f, 1}, .metallic = 0.0f, .specular = 0.0f};
    const Index painted = addMaterial(scene, paint);
    place(scene, sphere(0.4f, 16, painted), moved(1.5, 0.8, -1.2));
    place(scene, quad(0.5f, painted), moved(-0.4, 0.9, -2));
    place(scene, quad(float(kHalf), addMaterial(scene, mirror)), wall.worldFromMirror);
    return scene;
}

Material flatSilver() {
    Material m = mirrorMetal();
    m.reflection = Reflection::mirror;
    return m;
}

// Whether a ray from the middle along d meets the mirror, well within its edge.
bool meetsMirror(const Wall& wall, const glm::dvec3& d) {
    if (d[wall.axis] >= -0.1) return false;
    const glm::dvec3 met = d * (-kMirrorAt / d[wall.axis]);
    const double u = std::abs(met[(wall.axis + 1) % 3]), v = std::abs(met[(wall.axis + 2) % 3]);
    // The centre shows the image of the ball, which the camera does not see.
    return std::max(u, v) < 0.97 * kHalf && std::max(u, v) > 4.0 * kBall;
}

struct Compared {
    int pixels = 0, off = 0;
};
// Pixels of the ball that show the mirror, against `around`.
Compared compareBall(FrameRequest r, const Wall& wall, const SixPictures& around) {
    Compared result;
    for (const glm::dvec3& from : {glm::dvec3(0.1, 0.2, 3), glm::dvec3(3, 0.2, -0.3),
                                   glm::dvec3(0.3, 3, 0.1), glm::dvec3(-0.2, 0.1, -3)}) {
        r.camera.position = kCenter + 0.03 * from;
        const Image image = renderer().render(r).image;
        for (std::uint32_t y = 0; y < r.height; ++y) {
            for (std::uint32_t x = 0; x < r.width; ++x) {
                const Ray ray = sightOfPixel(r, x, y);
                const auto t = meetsBall(ray, kCenter, kBall);
                if (!t || !meetsBall(ray, kCenter, 0.95 * kBall)) continue;
                const glm::dvec3 n = glm::normalize(ray.origin + *t * ray.direction - kCenter);
                const glm::dvec3 towards = glm::reflect(ray.direction, n);
                const auto expected =
                    meetsMirror(wall, towards) ? around.along(towards) : std::nullopt;
                if (!expected) continue;
                ++result.pixels;
                result.off += greatestDifference(color(image, x, y), *expected) > 0.02;
            }
        }
    }
    return result;
}

FrameRequest cameraIn(Scene scene, const std::string& id) {
    FrameRequest r = request(std::move(scene), id, kCenter);
    r.width = r.height = 256;
    r.environment.map = "white";  // lights the paint; a mirror without a view would be white
    r.accuracy.planar = PlanarMethod::mirror;
    r.accuracy.curved = CurvedMethod::probe;
    r.accuracy.parallax = Parallax::none;
    r.accuracy.generations = 1;
    return r;
}

class MirrorInProbe : public GlTest, public ::testing::WithParamInterface<bool> {};

TEST_P(MirrorInProbe, EqualsAnOrdinaryCamera) {
    const Wall wall = wallOf(GetParam());
    const SixPictures around(cameraIn(surroundings(wall, flatSilver()), "around"), kCenter);

    Scene scene = surroundings(wall, flatSilver());
    place(scene, sphere(float(kBall), 96, addMaterial(scene, flatSilver())),
          glm::translate(glm::dmat4(1.0), kCenter));
    FrameRequest r = cameraIn(std::move(scene), "ball");
    r.camera.target = kCenter;
    r.camera.yfov = 0.6;
    const Compared ball = compareBall(r, wall, around);
    EXPECT_GT(ball.pixels, 8000);
    EXPECT_EQ(ball.off, 0) << "of " << ball.pixels;

    // The mirror does show something: without mirrored views the pictures are other ones.
    FrameRequest plain = cameraIn(surroundings(wall, flatSilver()), "plain");
    plain.effects.planarReflection = false;
    const Compared without = compareBall(r, wall, SixPictures(plain, kCenter));
    EXPECT_GT(without.off, without.pixels / 2);
}

INSTANTIATE_TEST_SUITE_P(Mirrors, MirrorInProbe, ::testing::Bool(), [](const auto& each) {
    return each.param ? "BelowTheBall" : "NextToTheBall";
});

// The passes: a mirrored view for each face that sees the mirror's front, none for a
// probe behind it, and nothing in the second frame.
TEST_F(MirrorsInProbes, AreDrawnOncePerFaceThatSeesTheirFront) {
    for (const bool behind : {false, true}) {
        Wall wall = wallOf(true);
        if (behind) wall.worldFromMirror[3][1] += 2.0 * kMirrorAt;  // above the ball, facing up
        Scene scene = surroundings(wall, flatSilver());
        place(scene, sphere(float(kBall), 32, addMaterial(scene, flatSilver())),
              glm::translate(glm::dmat4(1.0), kCenter));
        FrameRequest r = cameraIn(std::move(scene), behind ? "behind" : "before");
        r.camera.position = kCenter + glm::dvec3(0, 0.02, 0.09);
        r.camera.target = kCenter;
        r.camera.yfov = 0.6;
        const auto mirrorsInFaces = [](const FramePlan& plan) {
            return std::count_if(plan.passes.begin(), plan.passes.end(), [](const Pass& p) {
                return p.kind() == "mirror" && p.generation == 2;
            });
        };
        const FramePlan first = renderer().render(r).plan;
        // The lower face, and the four about it, whose lower halves see it.
        EXPECT_EQ(mirrorsInFaces(first), behind ? 0 : 5) << toText(first);
        EXPECT_EQ(mirrorsInFaces(renderer().render(r).plan), 0);
    }
}

}  // namespace
}  // namespace clerestory::test
