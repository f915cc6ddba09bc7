// Flat mirrors where naive formulae fail: mesh origins, tiles, low eyes, objects through the plane,
// image borders, dark light, and objects in contact with a rough floor.
#include "sight.h"

#include <glm/gtc/matrix_transform.hpp>

#include <utility>

namespace clerestory::test {
namespace {

class MirrorTruth : public GlTest {};

FrameRequest mirrored(Scene scene, const std::string& id, const glm::dvec3& eye) {
    FrameRequest r = request(std::move(scene), id, eye);
    r.accuracy.planar = PlanarMethod::mirror;
    return r;
}

// Three lamps about half a metre before the plane z = 0.
void placeLamps(Scene& scene) {
    const glm::dvec3 places[] = {{-0.5, 0.25, 0.5}, {0.5, -0.5, 0.75}, {0.25, 0.5, 1.25}};
    for (int i = 0; i < 3; ++i) {
        glm::dmat4 m = glm::translate(glm::dmat4(1.0), places[i]);
        m = glm::rotate(m, 0.4 + 0.3 * i, glm::dvec3(0.3, 1.0, 0.2));
        place(scene, quad(0.25f, addMaterial(scene, glowing({0.3f + 0.3f * float(i), 0.8f, 0.2f}))),
              m);
    }
}

// P2: a plane's point has the sign of its normal's distance. Sizes that floats hold exactly.
TEST_F(MirrorTruth, MeshOriginsOfMirrorsDoNotMatter) {
    const auto picture = [](const glm::vec3& origin) {
        Scene scene;
        placeLamps(scene);
        MeshDraft sheet = quad(1.5f, addMaterial(scene, mirrorMetal()));
        for (Vertex& v : sheet.vertices) v.position += origin;
        place(scene, std::move(sheet), glm::translate(glm::dmat4(1.0), -glm::dvec3(origin)));
        return renderer().render(mirrored(std::move(scene), "origin", {0.25, 0.125, 2})).image;
    };
    const Image plain = picture(glm::vec3(0.0f));
    EXPECT_EQ(badSamples(plain), 0u);
    for (const glm::vec3& origin : {glm::vec3(0, 0, 3), {0, 0, -3}, {8, -4, 2}, {-64, 128, 32}}) {
        EXPECT_EQ(picture(origin).data, plain.data) << origin.x << ' ' << origin.z;
    }
}

// P6: four cameras with shifted lenses show the four quarters of one.
TEST_F(MirrorTruth, FourTilesEqualTheWholeFrame) {
    Scene scene;
    placeLamps(scene);
    place(scene, quad(1.5f, addMaterial(scene, mirrorMetal())));
    FrameRequest r = mirrored(std::move(scene), "tiles", {0.4, 0.3, 2});
    r.camera.target = glm::dvec3(-0.1, 0.1, 0.0);
    r.camera.yfov.reset();
    r.camera.intrinsics = Intrinsics{.fx = 48, .fy = 48, .cx = 48, .cy = 48};
    r.width = r.height = 96;
    const Image whole = renderer().render(r).image;
    r.width = r.height = 48;
    int off = 0, lit = 0;
    for (std::uint32_t tile = 0; tile < 4; ++tile) {
        const std::uint32_t left = tile % 2 * 48, top = tile / 2 * 48;
        r.camera.intrinsics->cx = 48.0 - left;
        r.camera.intrinsics->cy = 48.0 - top;
        const Image part = renderer().render(r).image;
        for (std::uint32_t i = 0; i < 48 * 48; ++i) {
            const glm::vec3 expected = color(whole, left + i % 48, top + i / 48);
            lit += expected.y > 0.1f;
            off += greatestDifference(color(part, i % 48, i / 48), expected) > 1.0 / 255.0;
        }
    }
    EXPECT_GT(lit, 500);
    EXPECT_LE(off, 9) << "one pixel in a thousand, at silhouettes";
}

// P7: an eye a hundredth of its near distance over a mirror. Two walls a centimetre apart twenty
// metres away keep their order in it, whichever is drawn first; an oblique near plane mixes them.
TEST_F(MirrorTruth, LowEyesOverMirrorsSeeNearBeforeFar) {
    for (const double height : {1e-3, 1e-2, 0.1}) {
        for (const bool nearFirst : {true, false}) {
            Scene scene;
            const Index red = addMaterial(scene, unlit({1, 0, 0, 1}));
            const Index green = addMaterial(scene, unlit({0, 1, 0, 1}));
            const glm::dmat4 upright =
                glm::rotate(glm::dmat4(1.0), glm::half_pi<double>(), glm::dvec3(1, 0, 0));
            for (const bool isNear : {nearFirst, !nearFirst}) {
                place(scene, quad(10.0f, isNear ? red : green),
                      glm::translate(glm::dmat4(1.0), glm::dvec3(0, isNear ? 20.0 : 20.01, 0)) *
                          upright);
            }
            place(scene, quad(19.0f, addMaterial(scene, mirrorMetal())));
            FrameRequest r = mirrored(std::move(scene), "low", {0, 0, height});
            r.camera.target = glm::dvec3(0, 1, height);
            r.camera.up = glm::dvec3(0, 0, 1);
            r.camera.yfov = 0.05;
            r.camera.znear = 0.1;
            r.output.channel = Channel::objectId;
            const Image ids = renderer().render(r).image;
            r.output.channel = Channel::color;
            const Image seen = renderer().render(r).image;
            int onMirror = 0, wrong = 0;
            for (std::uint32_t i = 0; i < 64 * 64; ++i) {
                if (number(ids, i % 64, i / 64) != 3.0f) continue;
                ++onMirror;
                wrong += color(seen, i % 64, i / 64) != glm::vec3(1, 0, 0);
            }
            EXPECT_GT(onMirror, 500) << height;
            EXPECT_EQ(wrong, 0) << "of " << onMirror << " at " << height;
        }
    }
}

// P7: of one pair of triangles, half before and half behind the plane, only the half before it.
TEST_F(MirrorTruth, ObjectsThroughAMirrorShowTheFrontHalfOnly) {
    Scene scene;
    Material sheet{.name = "sheet", .doubleSided = true, .unlit = true};
    sheet.baseColorTexture.texture = addTexture2x2(
        scene, {glm::u8vec4(255, 0, 0, 255), {0, 255, 0, 255}, {255, 0, 0, 255}, {0, 255, 0, 255}},
        Wrap::clampToEdge);
    // Its x axis, red to green, is along z through the mirror.
    glm::dmat4 across(1.0);
    across[0] = {0, 0, 1, 0};
    across[2] = {-1, 0, 0, 0};
    place(scene, quad(0.5f, addMaterial(scene, sheet)), across);
    place(scene, quad(2.0f, addMaterial(scene, mirrorMetal())));
    FrameRequest r = mirrored(std::move(scene), "straddling", {1.0, 0.1, 1.5});
    r.camera.target = glm::dvec3(0.0);
    r.width = r.height = 128;
    const Image image = renderer().render(r).image;
    r.output.channel = Channel::objectId;
    const Image ids = renderer().render(r).image;
    int red = 0, green = 0;
    for (std::uint32_t i = 0; i < 128 * 128; ++i) {
        const glm::vec3 c = color(image, i % 128, i / 128);
        red += c.x > 0.0f;
        green += c.y > 0.5f && number(ids, i % 128, i / 128) == 2.0f;
    }
    EXPECT_EQ(red, 0);
    EXPECT_GT(green, 100);
}

// P8: neither the order in the file nor what was drawn before decides what facing mirrors show.
TEST_F(MirrorTruth, OrderAndEarlierFramesDoNotMatter) {
    const auto scene = [](bool otherOrder) {
        Scene s;
        const Index silver = addMaterial(s, mirrorMetal(0.8f));
        const auto far = [&] { place(s, quad(3.0f, silver), moved(0, 0, -1)); };
        const auto back = [&] {
            place(s, quad(3.0f, silver),
                  glm::rotate(moved(0, 0, 1), glm::pi<double>(), glm::dvec3(0, 1, 0)));
        };
        if (otherOrder) back();
        far();
        if (!otherOrder) back();
        placeLamps(s);
        return s;
    };
    FrameRequest r = mirrored(scene(false), "facing", {0.2, 0.1, 0.4});
    r.accuracy.generations = 4;
    const Image image = renderer().render(r).image;
    FrameRequest elsewhere = r;
    elsewhere.camera.position = glm::dvec3(-0.4, -0.3, 0.1);
    elsewhere.camera.target = glm::dvec3(0.3, 0.0, 1.0);
    renderer().render(elsewhere);
    EXPECT_EQ(renderer().render(r).image.data, image.data) << "after another pose";
    FrameRequest reversed = mirrored(scene(true), "reversed", {0.2, 0.1, 0.4});
    reversed.accuracy.generations = 4;
    EXPECT_EQ(renderer().render(reversed).image.data, image.data) << "in another order";
}

// P9: a rough mirror that fills the picture, between six walls of one radiance: what lies beyond
// the picture's edge is as bright, and nothing darkens towards it.
TEST_F(MirrorTruth, RoughMirrorsAreUniformUpToTheBorder) {
    for (const float roughness : {0.1f, 0.2f, 0.3f, 0.5f}) {
        for (const std::uint32_t samples : {1u, 16u}) {
            Scene scene;
            const Index wall = addMaterial(scene, glowing(glm::vec3(0.5f)));
            for (int axis = 0; axis < 3; ++axis) {
                for (const double side : {-1.0, 1.0}) {
                    glm::dmat4 m(0.0);
                    m[0][(axis + 1) % 3] = m[1][(axis + 2) % 3] = m[2][axis] = 1.0;
                    m[3] = glm::dvec4(0, 0, 4, 1);
                    m[3][axis] += side * 5.0;
                    place(scene, quad(5.0f, wall), m);
                }
            }
            Material rough = mirrorMetal(1.0f, roughness);
            rough.reflection = Reflection::mirror;
            place(scene, quad(4.5f, addMaterial(scene, rough)));
            FrameRequest r = mirrored(std::move(scene), "border", {0.3, 0.2, 1.5});
            r.accuracy.planarSamples = samples;
            const Image image = renderer().render(r).image;
            double least = 1e9, most = 0.0;
            for (std::uint32_t i = 0; i < 64 * 64; ++i) {
                least = std::min(least, double(color(image, i % 64, i / 64).x));
                most = std::max(most, double(color(image, i % 64, i / 64).x));
            }
            EXPECT_GT(least, 0.4975) << roughness << ", samples " << samples;
            EXPECT_LT(most, 0.5025) << roughness << ", samples " << samples;
        }
    }
}

// E2: strips of radiance 1e-4 to 1e-2 in a mirror: half floats keep the steps below a display code,
// where eight linear bits would have five steps of a dozen codes.
TEST_F(MirrorTruth, DarkLightHasNoBandsInAMirror) {
    constexpr int kStrips = 96;
    Scene scene;
    for (int i = 0; i < kStrips; ++i) {
        const float radiance = 1e-4f * std::pow(100.0f, float(i) / (kStrips - 1));
        place(scene, quad(1.0f, addMaterial(scene, glowing(glm::vec3(radiance)))),
              glm::scale(moved((i + 0.5) * 4.0 / kStrips - 2.0, 0, 1.0),
                         glm::dvec3(2.0 / kStrips, 2.0, 1.0)));
    }
    place(scene, quad(2.0f, addMaterial(scene, mirrorMetal())));
    FrameRequest r = mirrored(std::move(scene), "ramp", {0, 0, 0.5});
    r.width = 192;
    r.height = 8;
    r.camera.yfov = 0.1;
    r.output.format = OutputFormat::png;
    r.toneMap = ToneMap::linear;
    const Image image = renderer().render(r).image;
    int before = -1, greatest = 0, least = 255, most = 0;
    for (std::uint32_t x = 0; x < image.width; ++x) {
        const int code = static_cast<int>(image.data[(4u * image.width + x) * image.channels]);
        if (before >= 0) greatest = std::max(greatest, std::abs(code - before));
        before = code;
        least = std::min(least, code);
        most = std::max(most, code);
    }
    EXPECT_LE(greatest, 1);
    EXPECT_GT(most - least, 15) << "the ramp itself is seen";
}

// From a quarter to three quarters of the step from dark on the left to light on the right, pixels.
double widthInRow(const Image& image, std::uint32_t y) {
    double place[2] = {0.0, 0.0};
    const float white = color(image, 250, y).x;
    for (std::uint32_t x = 250; x-- > 1;) {
        const float a = color(image, x - 1, y).x / white, b = color(image, x, y).x / white;
        for (const int i : {0, 1}) {
            const float level = i == 0 ? 0.25f : 0.75f;
            if (a < level && b >= level) place[i] = x - 1 + (level - a) / (b - a);
        }
    }
    return place[1] - place[0];
}

// The same by the law of the cone for a GGX lobe across the plane of incidence, for an edge in the
// plane y = 0 that the floor z = 0 mirrors.
double widthByLaw(const FrameRequest& r, std::uint32_t y, double alpha) {
    const double focal = 0.5 * r.height / std::tan(0.5 * r.camera.yfov.value());
    const Ray ray = sight(r, 0.5 * r.width, y + 0.5);
    const glm::dvec3 floor = ray.origin - ray.origin.z / ray.direction.z * ray.direction;
    const double d1 = glm::distance(ray.origin, floor);
    const double d2 = -floor.y / ray.direction.y;  // to the wall, along the mirrored ray
    return 2.0 / std::sqrt(3.0) * 2.0 * alpha * focal * d2 / (d1 + d2) * -ray.direction.z;
}

FrameRequest alongTheFloor(Scene scene, const std::string& id) {
    FrameRequest r = mirrored(std::move(scene), id, {0, -4, 3});
    r.camera.target = glm::dvec3(0, 0, 0);
    r.camera.up = glm::dvec3(0, 0, 1);
    r.camera.yfov = 0.9;
    r.width = r.height = 256;
    return r;
}

// R4: a wall on a rough floor, half of it white and half black, and that edge is mirrored: sharp at
// its foot, wider with the distance from it by the law of the cone.
TEST_F(MirrorTruth, RoughFloorsAreSharpAtContact) {
    Scene scene;
    const glm::dmat4 upright =
        glm::rotate(glm::dmat4(1.0), glm::half_pi<double>(), glm::dvec3(1, 0, 0));
    for (const double side : {-1.0, 1.0}) {
        place(scene, quad(8.0f, addMaterial(scene, glowing(glm::vec3(side > 0.0 ? 1.0f : 0.0f)))),
              moved(8.0 * side, 0, 0) * upright);
    }
    Material rough = mirrorMetal(1.0f, 0.3f);
    rough.reflection = Reflection::mirror;
    place(scene, quad(12.0f, addMaterial(scene, rough)));
    FrameRequest r = alongTheFloor(std::move(scene), "foot");
    for (const std::uint32_t samples : {1u, 64u}) {
        r.accuracy.planarSamples = samples;
        const Image image = renderer().render(r).image;
        double before = 0.0;
        for (std::uint32_t y = 130; y < 256; y += 12) {
            const double predicted = widthByLaw(r, y, 0.09);
            const double width = widthInRow(image, y);
            EXPECT_GT(width, 0.98 * before) << samples << " samples, row " << y;
            if (y == 130) {
                EXPECT_LT(width, 1.5) << samples << " samples, at the foot";
            } else {
                // One look-up is between two levels of the picture, whose widths differ by 2.
                EXPECT_NEAR(width / predicted, 1.0, samples > 1 ? 0.1 : 0.35)
                    << samples << " samples, row " << y;
            }
            before = width;
        }
    }
}

// A wall that ends before a black sky, on a rough floor and nearer to it than a tenth of the way to
// the eye: where the lobe is several pixels wide, its silhouette is no step from one pixel to the
// next.
TEST_F(MirrorTruth, SilhouettesNearRoughFloorsAreSoft) {
    Scene scene;
    const glm::dmat4 upright =
        glm::rotate(glm::dmat4(1.0), glm::half_pi<double>(), glm::dvec3(1, 0, 0));
    place(scene, quad(8.0f, addMaterial(scene, glowing(glm::vec3(1.0f)))),
          moved(8.0, 0, 0) * upright);
    Material rough = mirrorMetal(1.0f, 0.5f);
    rough.reflection = Reflection::mirror;
    place(scene, quad(12.0f, addMaterial(scene, rough)));
    const FrameRequest r = alongTheFloor(std::move(scene), "silhouette");
    const Image image = renderer().render(r).image;
    for (std::uint32_t y = 136; y <= 144; y += 2) {
        EXPECT_GT(widthByLaw(r, y, 0.25), 6.0);
        const float white = color(image, 250, y).x;
        float step = 0.0f;
        for (std::uint32_t x = 1; x < 250; ++x) {
            step =
                std::max(step, std::abs(color(image, x, y).x - color(image, x - 1, y).x) / white);
        }
        EXPECT_LT(step, 0.45f) << "row " << y;
    }
}

// A black wall that crosses the pixels at an angle stands on a rough floor under a white sky. The
// mirrored view shows the sky behind the wall's foot, and it may shine neither on the floor there
// nor a little before it, whether the floor reads one place or averages directions, as at `fine`.
TEST_F(MirrorTruth, TheSkyBehindAWallDoesNotShineAtItsFoot) {
    Scene scene;
    const double turn = 0.17;
    const glm::dmat4 upright = glm::rotate(glm::rotate(glm::dmat4(1.0), turn, glm::dvec3(0, 0, 1)),
                                           glm::half_pi<double>(), glm::dvec3(1, 0, 0));
    place(scene, quad(20.0f, addMaterial(scene, unlit(glm::vec4(0, 0, 0, 1)))), upright);
    Material rough = mirrorMetal(1.0f, 0.3f);
    rough.reflection = Reflection::mirror;
    place(scene, quad(12.0f, addMaterial(scene, rough)));
    FrameRequest r = mirrored(std::move(scene), "sky at the foot", {0, -4, 3});
    r.accuracy.preset = Preset::standard;
    r.camera.target = glm::dvec3(0, 0, 0);
    r.camera.up = glm::dvec3(0, 0, 1);
    r.camera.yfov = 0.9;
    r.width = r.height = 256;
    r.environment.map = "white";
    const glm::dvec3 front(std::sin(turn), -std::cos(turn), 0.0);
    for (const std::uint32_t directions : {1u, 8u}) {
        r.accuracy.planarSamples = directions;
        const FramePlan plan = renderer().plan(r);
        const auto picture =
            std::find_if(plan.targets.begin(), plan.targets.end(),
                         [](const TargetSpec& t) { return t.levels > 1 && t.depth; });
        ASSERT_NE(picture, plan.targets.end()) << toText(plan);
        EXPECT_LT(picture->width, 200u) << "half the size";
        const Image image = renderer().render(r).image;
        int atFoot = 0, before = 0;
        double sum = 0.0;
        for (std::uint32_t i = 0; i < 256 * 256; ++i) {
            const Ray ray = sight(r, i % 256 + 0.5, i / 256 + 0.5);
            if (ray.direction.z >= 0.0) continue;
            const glm::dvec3 floor = ray.origin - ray.origin.z / ray.direction.z * ray.direction;
            const double distance = glm::dot(floor, front);
            if (distance <= 0.0 || distance > 0.15) continue;
            const float shown = color(image, i % 256, i / 256).x;
            if (distance <= 0.05) {
                ++atFoot;
                EXPECT_LT(shown, 0.1f)
                    << i % 256 << ", " << i / 256 << ", " << directions << " directions";
            } else {
                ++before;
                sum += shown;
            }
        }
        EXPECT_GT(atFoot, 300);
        EXPECT_GT(before, 600);
        EXPECT_LT(sum / before, 0.025) << directions << " directions";
    }
}

}  // namespace
}  // namespace clerestory::test
