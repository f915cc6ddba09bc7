// Derived views: reflected views compared with an explicitly reflected scene, cropped ones with the
// whole, cube faces with OpenGL's table; and the screen area of a mirror.
#include "plan/visibility/mirror.h"
#include "plan/visibility/view.h"

#include "plan_scenes.h"

#include <gtest/gtest.h>
#include <random>

namespace clerestory::test {
namespace {

using glm::dmat3;
using glm::dmat4;
using glm::dvec2;
using glm::dvec3;
using glm::dvec4;

constexpr std::uint32_t kImageWidth = 640, kImageHeight = 480;

class Random {
public:
    double in(double low, double high) {
        return std::uniform_real_distribution<double>(low, high)(engine_);
    }
    dvec3 point(double reach) { return {in(-reach, reach), in(-reach, reach), in(-reach, reach)}; }
    dvec3 direction() {
        dvec3 d = point(1.0);
        while (glm::length(d) < 0.1) d = point(1.0);
        return glm::normalize(d);
    }

private:
    std::mt19937 engine_{17};
};

Plane planeThrough(const dvec3& point, const dvec3& normal) {
    return {normal, -glm::dot(normal, point)};
}

View viewFrom(const dvec3& position, const dvec3& target, const dvec3& up = dvec3(0, 1, 0),
              const dmat4& clipFromView = perspective(1.0, 4.0 / 3.0, 0.1, std::nullopt)) {
    View view;
    view.eye = position;
    view.viewFromWorld = glm::inverse(worldFromLookAt(position, target, up));
    view.clipFromView = clipFromView;
    return view;
}

// The way the shaders take: relative to the eye.
dvec4 clip(const View& view, const dvec3& world) {
    return view.clipFromView * dvec4(dmat3(view.viewFromWorld) * (world - view.eye), 1.0);
}
dvec3 ndcFromEye(const View& view, const dvec3& world) {
    const dvec4 c = clip(view, world);
    return dvec3(c) / c.w;
}

// ---- P3 ----------------------------------------------------------------------------------------

TEST(Householder, IsItsOwnInverseAndMirrorsSpace) {
    Random random;
    for (double scale = 1e-3; scale <= 1e3; scale *= 10.0) {
        for (int i = 0; i < 200; ++i) {
            const dvec3 point = random.point(scale), n = random.direction();
            // The result of a scaled mirror.
            const dmat4 worldFromLocal{dmat3(scale)};
            const std::optional<Plane> plane =
                transformed(planeThrough(point / scale, n), worldFromLocal);
            ASSERT_TRUE(plane);
            const dmat4 r = householder(*plane), twice = r * r;
            EXPECT_NEAR(glm::determinant(r), -1.0, 1e-12);
            for (int column = 0; column < 4; ++column) {
                for (int row = 0; row < 4; ++row) {
                    const double one = column == row ? 1.0 : 0.0;
                    EXPECT_NEAR(twice[column][row], one, 1e-12 * std::max(1.0, scale));
                }
            }
            const dvec3 along = glm::cross(n, random.direction());
            EXPECT_LT(glm::length(dvec3(r * dvec4(point + along, 1.0)) - point - along),
                      1e-12 * std::max(1.0, scale));
            // The eye lands as far behind as it was before.
            const dvec3 mirrored(r * dvec4(point + 2.0 * scale * n, 1.0));
            EXPECT_LT(glm::length(mirrored - (point - 2.0 * scale * n)), 1e-11 * scale);
        }
    }
}

// ---- P6 ----------------------------------------------------------------------------------------

std::vector<dmat4> lenses() {
    return {perspective(1.0, 4.0 / 3.0, 0.1, std::nullopt), perspective(3.0, 4.0 / 3.0, 0.1, 50.0),
            perspective(Intrinsics{500, 520, 100, 400, PixelCenter::half}, kImageWidth,
                        kImageHeight, 0.1, std::nullopt),
            orthographic(4.0, 3.0, 0.0, 100.0)};
}

TEST(MirroredView, EqualsThePlainViewOfTheMirroredScene) {
    Random random;
    for (int i = 0; i < 2000; ++i) {
        const dvec3 eye = random.point(10.0);
        const Plane plane = planeThrough(random.point(10.0), random.direction());
        View view = viewFrom(eye, random.point(10.0), random.direction(), lenses()[i % 4u]);
        view.orthographic = i % 4 == 3;
        const View mirrored = mirroredView(view, plane);
        EXPECT_TRUE(mirrored.mirrored);
        EXPECT_FALSE(mirroredView(mirrored, plane).mirrored);
        EXPECT_EQ(mirrored.clipFromView, view.clipFromView);
        EXPECT_NEAR(glm::determinant(dmat3(mirrored.viewFromWorld)), -1.0, 1e-12);
        const dvec3 point = random.point(10.0);
        const dvec4 seen = clip(mirrored, point);
        const dvec4 truth = clip(view, dvec3(householder(plane) * dvec4(point, 1.0)));
        EXPECT_LT(glm::length(seen - truth), 1e-11);
        // Both ways to write the view agree.
        EXPECT_LT(
            glm::length(mirrored.clipFromView * mirrored.viewFromWorld * dvec4(point, 1.0) - seen),
            1e-11);
        // A point of the mirror itself stays on its pixel.
        const dvec3 onMirror = point - plane.distance(point) * plane.normal;
        EXPECT_LT(glm::length(clip(mirrored, onMirror) - clip(view, onMirror)), 1e-11);
        // Points before the plane are kept and points behind it are clipped.
        const double kept = glm::dot(*mirrored.clipPlane, dvec4(point - mirrored.eye, 1.0));
        EXPECT_NEAR(kept, plane.distance(point), 1e-11);
    }
}

TEST(MirroredView, LooksDownAtAnyRollAndFlipsLeftAndRight) {
    const Plane floor{dvec3(0, 1, 0), 0.0};
    const Plane wall{dvec3(0, 0, 1), 0.0};
    for (int degrees = 0; degrees < 360; degrees += 5) {
        const double a = glm::radians(double(degrees));
        // Straight down on a floor: up lies in the picture, the view lies along the normal.
        const View down =
            mirroredView(viewFrom({0, 2, 0}, {0, 0, 0}, {std::sin(a), 0, std::cos(a)}), floor);
        EXPECT_EQ(down.eye, dvec3(0, -2, 0));
        EXPECT_NEAR(ndcFromEye(down, {0, 2, 0}).x, 0.0, 1e-12)
            << "the eye sees itself in the middle";
        EXPECT_NEAR(ndcFromEye(down, {0, 2, 0}).y, 0.0, 1e-12);
        // Facing a mirror, what is at the right is seen at the right: with a look-at camera behind
        // the mirror it would be at the left.
        const dvec3 up(std::sin(a), std::cos(a), 0);
        const View facing = viewFrom({0, 0, 3}, {0, 0, 0}, up);
        const dvec3 right = glm::cross(dvec3(0, 0, -1), up);
        EXPECT_GT(ndcFromEye(mirroredView(facing, wall), right + dvec3(0, 0, 3)).x, 0.0) << degrees;
        EXPECT_NEAR(ndcFromEye(mirroredView(facing, wall), right + dvec3(0, 0, 3)).y, 0.0, 1e-12);
    }
    // With up along the line of sight the plain view has its replacement, and the mirror with it.
    const View degenerate = mirroredView(viewFrom({0, 2, 0}, {0, 0, 0}, {0, 1, 0}), floor);
    EXPECT_TRUE(std::isfinite(degenerate.viewFromWorld[3][1]));
}

// ---- P8 ----------------------------------------------------------------------------------------

// Mirrors at x = 0 and x = l that face each other, an eye and a lamp between them. By the image
// method the k-th image, the first in the mirror at 0, stands at -(k - 1) l - a for odd k and at
// a - k l for even k, a being the lamp's place.
TEST(MirroredView, ImagesBetweenFacingMirrorsAreAtTheirPositions) {
    const double l = 3.0, a = 1.25;
    const Plane left{dvec3(1, 0, 0), 0.0}, right{dvec3(-1, 0, 0), l};
    const View eye = viewFrom({2.0, 0.5, 4.0}, {0.0, 0.2, 0.0});
    View view = eye;
    for (int k = 1; k <= 8; ++k) {
        const Plane& mirror = k % 2 ? left : right;
        EXPECT_GT(eyeHeight(mirror, view), 0.0) << k;
        view = mirroredView(view, mirror);
        EXPECT_LT(eyeHeight(mirror, view), 0.0) << "a mirror does not see itself";
        const double place = k % 2 ? -(k - 1) * l - a : a - k * l;
        const dvec3 image = ndcFromEye(eye, {place, 0.3, 1.0}),
                    seen = ndcFromEye(view, {a, 0.3, 1.0});
        EXPECT_LT(glm::length(image - seen), 1e-12) << k;
        EXPECT_EQ(view.mirrored, k % 2 == 1);
    }
}

// ---- P10 ---------------------------------------------------------------------------------------

TEST(MirroredView, KeepsItsPrecisionFarFromTheOrigin) {
    Random random;
    for (const double far : {0.0, 1e4, 1e6, 1e7}) {
        for (int i = 0; i < 300; ++i) {
            const dvec3 shift = far * random.direction();
            const dvec3 eye = random.point(3.0), target = random.point(3.0),
                        point = random.point(3.0), on = random.point(3.0), n = random.direction();
            const View near = mirroredView(viewFrom(eye, target), planeThrough(on, n));
            const View away =
                mirroredView(viewFrom(eye + shift, target + shift), planeThrough(on + shift, n));
            EXPECT_LT(glm::length(clip(away, point + shift) - clip(near, point)), 1e-6) << far;
            EXPECT_LT(glm::length(*away.clipPlane - *near.clipPlane), 1e-6) << far;
        }
    }
}

// ---- parts of a picture ------------------------------------------------------------------------

dvec2 pixel(const View& view, const dvec3& world, double width, double height) {
    return (dvec2(ndcFromEye(view, world)) * 0.5 + 0.5) * dvec2(width, height);
}

TEST(Cropped, FourTilesEqualTheWholeImage) {
    Random random;
    for (const dmat4& lens : lenses()) {
        const View view = viewFrom({0, 0, 5}, {0, 0, 0}, {0.2, 1, 0}, lens);
        for (int tile = 0; tile < 4; ++tile) {
            // Cut at odd places; one reaches beyond the picture, as a guard band does.
            const double x = tile % 2 ? 213.0 : -16.0, y = tile / 2 ? 101.0 : 0.0;
            const PixelRect part{x, y, tile % 2 ? 427.0 : 229.0, tile / 2 ? 379.0 : 101.0};
            const View crop = cropped(view, part, kImageWidth, kImageHeight);
            EXPECT_EQ(crop.viewFromWorld, view.viewFromWorld);
            for (int i = 0; i < 200; ++i) {
                const dvec3 p = random.point(3.0);
                const dvec2 inPart = pixel(crop, p, part.width, part.height);
                const dvec2 inWhole = pixel(view, p, kImageWidth, kImageHeight);
                EXPECT_LT(glm::length(inPart + dvec2(x, y) - inWhole),
                          1e-9 * std::max(1.0, glm::length(inWhole)));
                EXPECT_EQ(clip(crop, p).w, clip(view, p).w);
                EXPECT_EQ(clip(crop, p).z, clip(view, p).z);
            }
        }
    }
    const View view = viewFrom({0, 0, 5}, {0, 0, 0});
    EXPECT_EQ(cropped(view, {0, 0, kImageWidth, kImageHeight}, kImageWidth, kImageHeight), view);
}

TEST(Cropped, CroppingAndMirroringCommute) {
    const View view = viewFrom({1, 2, 5}, {0, 0, 0});
    const Plane floor{dvec3(0, 1, 0), 0.5};
    const PixelRect part{100, 50, 333, 77};
    EXPECT_EQ(mirroredView(cropped(view, part, kImageWidth, kImageHeight), floor),
              cropped(mirroredView(view, floor), part, kImageWidth, kImageHeight));
}

// ---- where a mirror is on the picture ----------------------------------------------------------

Bounds boxOf(const dvec3& a, const dvec3& b) {
    Bounds box;
    box.add(glm::vec3(a));
    box.add(glm::vec3(b));
    return box;
}

// Against many points of the box, seen one by one: none lies outside of its rectangle, and for
// boxes that reach behind the eye the rectangle is no larger than they fill.
TEST(ScreenBox, ContainsTheVisiblePartOfABox) {
    Random random;
    int behind = 0;
    for (int i = 0; i < 3000; ++i) {
        const dvec3 size(random.in(0.1, 4.0), i % 3 ? random.in(0.1, 4.0) : 0.0,
                         random.in(0.1, 20.0));
        const dvec3 low = random.point(6.0);
        const Bounds box = boxOf(low, low + size);
        const View view =
            viewFrom(dvec3(0.0), random.direction(), dvec3(0, 1, 0), lenses()[i % 3u]);
        const ScreenBox covered = screenBox(view, box);
        ScreenBox measured;
        bool reachesBehind = false;
        for (int k = 0; k < 400; ++k) {
            const dvec3 p = glm::mix(dvec3(box.min), dvec3(box.max),
                                     dvec3(random.in(0, 1), random.in(0, 1), random.in(0, 1)));
            const dvec4 c = clip(view, p);
            reachesBehind |= c.w <= 0.0;
            if (c.w < view.znear || std::abs(c.x) > c.w || std::abs(c.y) > c.w) continue;
            const dvec2 n = dvec2(c) / c.w;
            measured.low = glm::min(measured.low, n);
            measured.high = glm::max(measured.high, n);
        }
        behind += reachesBehind;
        if (measured.low.x > measured.high.x) continue;
        EXPECT_GE(measured.low.x, covered.low.x - 1e-6) << i;
        EXPECT_GE(measured.low.y, covered.low.y - 1e-6) << i;
        EXPECT_LE(measured.high.x, covered.high.x + 1e-6) << i;
        EXPECT_LE(measured.high.y, covered.high.y + 1e-6) << i;
    }
    EXPECT_GT(behind, 500);
}

TEST(ScreenBox, FloorsReachingBehindTheEyeEndAtTheFarEdge) {
    // Two units above a floor that ends 40 units ahead, looking level: its far edge is 0.05 below
    // the horizon in slope; the picture's own edges end the rest.
    const View view = viewFrom({0, 0, 0}, {0, 0, -1});
    const ScreenBox floor = screenBox(view, boxOf({-500, -2, -40}, {500, -2, 100}));
    const double focal = view.clipFromView[1][1];
    EXPECT_EQ(floor.low, dvec2(-1.0));
    EXPECT_EQ(floor.high.x, 1.0);
    EXPECT_NEAR(floor.high.y, -0.05 * focal, 1e-6);
    // A wall at the left that runs past the eye: its far end bounds it at the right.
    const ScreenBox wall = screenBox(view, boxOf({-1, -50, -10}, {-1, 50, 10}));
    EXPECT_EQ(wall.low, dvec2(-1.0));
    EXPECT_NEAR(wall.high.x, -0.1 * view.clipFromView[0][0], 1e-6);
    EXPECT_EQ(wall.high.y, 1.0);
    // A strip of it that is behind the picture's left edge when it passes the eye.
    const ScreenBox strip = screenBox(view, boxOf({-1, 0, -10}, {-1, 0.1, 10}));
    EXPECT_GE(strip.low.y, 0.0);
    EXPECT_LT(strip.high.y, 0.2)
        << "as high as where the picture's edge cuts it, not as at the eye";
    // Behind the eye altogether, and between the eye and the near plane: nothing.
    EXPECT_TRUE(screenBox(view, boxOf({-1, -1, 1}, {1, 1, 2})).empty());
    EXPECT_TRUE(screenBox(view, boxOf({-1, -1, -0.05}, {1, 1, 2})).empty());
    EXPECT_EQ(screenBox(view, boxOf({-1, -1, -1}, {1, 1, 2})).share(), 1.0) << "around the eye";
}

TEST(PixelRect, IncludesTouchedPixelsAndAGuardBand) {
    ScreenBox box;
    box.low = {-0.5, 0.0};
    box.high = {0.25, 0.5};
    EXPECT_EQ(pixelRect(box, 64, 64, 0.0), (PixelRect{16, 32, 24, 16}));
    EXPECT_EQ(pixelRect(box, 64, 64, 4.0), (PixelRect{12, 28, 32, 24}));
    box.low = {-0.501, 0.001};
    EXPECT_EQ(pixelRect(box, 64, 64, 0.0), (PixelRect{15, 32, 25, 16}));
    box.low = {-1.0, -1.0};
    EXPECT_EQ(pixelRect(box, 64, 64, 2.0).x, -2.0) << "may reach beyond the picture";
}

TEST(EdgeOn, OnlyWhenTheWholePlaneIsWithinOnePixelOfItsHorizon) {
    const View view = viewFrom({0, 0, 0}, {0, 0, -1});
    const double pixel = 2.0 / (kImageHeight * view.clipFromView[1][1]);
    for (const double share : {0.1, 0.9, 1.1, 10.0}) {
        const double height = share * view.znear * pixel;
        const Plane floor{dvec3(0, 1, 0), height};
        EXPECT_NEAR(eyeHeight(floor, view), height, 1e-15);
        // The nearest visible point of the floor, in pixels below its horizon.
        const double rows = -0.5 * kImageHeight * ndcFromEye(view, {0, -height, -view.znear}).y;
        EXPECT_EQ(edgeOn(eyeHeight(floor, view), view, kImageHeight), rows < 1.0) << share;
    }
    EXPECT_TRUE(edgeOn(eyeHeight(Plane{dvec3(0, 1, 0), 0.0}, view), view, kImageHeight));
}

TEST(EyeHeight, OfAnOrthographicViewIsTheVisibleSide) {
    View view = viewFrom({0, 0, 5}, {0, 0, 0}, {0, 1, 0}, orthographic(1, 1, 0, 10));
    view.orthographic = true;
    // Wherever the plane stands: the eye of parallel lines of sight is nowhere.
    for (const double offset : {-9.0, 0.0, 9.0}) {
        EXPECT_EQ(eyeHeight({dvec3(0, 0, 1), offset}, view), 1.0);
        EXPECT_EQ(eyeHeight({dvec3(0, 0, -1), offset}, view), -1.0);
        EXPECT_EQ(eyeHeight({dvec3(0, 1, 0), offset}, view), 0.0);
        EXPECT_TRUE(edgeOn(eyeHeight({dvec3(0, 1, 0), offset}, view), view, kImageHeight));
    }
}

// ---- cube faces --------------------------------------------------------------------------------

struct Lookup {
    std::size_t face;
    dvec2 st;  // 0..1
};

// OpenGL 4.3 core, table 8.18, written as the specification has it.
Lookup tableOf(const dvec3& r) {
    const dvec3 m = glm::abs(r);
    if (m.x >= m.y && m.x >= m.z) {
        const double sc = r.x > 0 ? -r.z : r.z;
        return {r.x > 0 ? 0u : 1u, (dvec2(sc, -r.y) / m.x + 1.0) * 0.5};
    }
    if (m.y >= m.z) {
        const double tc = r.y > 0 ? r.z : -r.z;
        return {r.y > 0 ? 2u : 3u, (dvec2(r.x, tc) / m.y + 1.0) * 0.5};
    }
    const double sc = r.z > 0 ? r.x : -r.x;
    return {r.z > 0 ? 4u : 5u, (dvec2(sc, -r.y) / m.z + 1.0) * 0.5};
}

TEST(CubeFaces, MatchLookupsInEveryDirection) {
    Random random;
    for (int i = 0; i < 5000; ++i) {
        const dvec3 center = random.point(100.0);
        const dmat3 worldFromMap =
            i % 2 ? dmat3(worldFromLookAt(dvec3(0.0), random.direction(), random.direction()))
                  : dmat3(1.0);
        const std::array<View, 6> faces = cubeFaceViews(center, 0.01, worldFromMap);
        const dvec3 r = random.direction();
        const Lookup lookup = tableOf(r);
        const dvec3 world = center + worldFromMap * r * random.in(0.1, 50.0);
        int holding = 0;
        for (std::size_t face = 0; face < 6; ++face) {
            const dvec4 c = clip(faces[face], world);
            const bool holds = c.w > 0.0 && std::abs(c.x) < c.w && std::abs(c.y) < c.w;
            holding += holds;
            EXPECT_EQ(holds, face == lookup.face);
        }
        EXPECT_EQ(holding, 1);
        const dvec2 st = dvec2(ndcFromEye(faces[lookup.face], world)) * 0.5 + 0.5;
        EXPECT_LT(glm::length(st - lookup.st), 1e-9);
    }
}

TEST(CubeFaces, AreOrdinaryViewsOfExactlyNinetyDegrees) {
    for (const View& face : cubeFaceViews({1, 2, 3}, 0.25, dmat3(1.0))) {
        EXPECT_NEAR(glm::determinant(dmat3(face.viewFromWorld)), 1.0, 1e-15);
        EXPECT_FALSE(face.mirrored);
        EXPECT_FALSE(face.clipPlane);
        EXPECT_EQ(face.eye, dvec3(1, 2, 3));
        EXPECT_EQ(face.clipFromView[0][0], 1.0);
        EXPECT_EQ(face.clipFromView[1][1], 1.0);
        EXPECT_EQ(face.clipFromView,
                  perspective(Intrinsics{1, 1, 1, 1, PixelCenter::half}, 2, 2, 0.25, std::nullopt));
        EXPECT_EQ(face.viewFromWorld * dvec4(1, 2, 3, 1), dvec4(0, 0, 0, 1));
    }
}

// A mirror seen by a probe: the same on a face as on any other view.
TEST(CubeFaces, MayBeMirrored) {
    const Plane floor{dvec3(0, 1, 0), 1.0};
    for (const View& face : cubeFaceViews({0, 0, 0}, 0.01, dmat3(1.0))) {
        const View mirrored = mirroredView(face, floor);
        EXPECT_LT(glm::length(clip(mirrored, {0.3, 2.0, -4.0}) - clip(face, {0.3, -4.0, -4.0})),
                  1e-14);
    }
}

}  // namespace
}  // namespace clerestory::test
