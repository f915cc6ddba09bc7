// Difficult cases of reflections: eyes in and near the mirror's plane, straight down, very small
// and very large scenes, far from the origin, odd frame sizes. Every pixel must be finite.
#include "sight.h"

#include <glm/gtc/matrix_transform.hpp>

namespace clerestory::test {
namespace {

class HardCases : public GlTest {};

// A mirror floor (z = 0), lamps above it, a mirror ball and a pane, all of them times `scale`; and
// the explicitly mirrored lamps instead of the floor.
Scene floorScene(const glm::dmat4& world, bool mirroredCopy, bool extras) {
    Scene scene;
    const glm::dvec3 places[] = {{-0.6, 0.2, 0.5}, {0.5, -0.5, 0.3}, {0.2, 0.6, 0.8}};
    for (int copy = 0; copy < (mirroredCopy ? 2 : 1); ++copy) {
        const glm::dmat4 flip =
            glm::scale(glm::dmat4(1.0), glm::dvec3(1.0, 1.0, copy == 1 ? -1.0 : 1.0));
        for (int i = 0; i < 3; ++i) {
            glm::dmat4 m = glm::translate(glm::dmat4(1.0), places[i]);
            m = glm::rotate(m, 0.5 + 0.4 * i, glm::dvec3(1.0, 0.3, 0.2));
            const glm::vec3 radiance(0.2f + 0.3f * float(i), 0.9f - 0.2f * float(i), 0.5f);
            place(scene, quad(0.2f, addMaterial(scene, glowing(radiance))), world * flip * m);
        }
    }
    if (!mirroredCopy) place(scene, quad(1.5f, addMaterial(scene, mirrorMetal())), world);
    if (extras) {
        Material glass{.name = "glass", .metallic = 0.0f, .roughness = 0.0f, .transmission = 1.0f};
        place(scene, sphere(0.2f, 24, addMaterial(scene, mirrorMetal())), world * moved(0, 0, 0.4));
        place(scene, quad(0.3f, addMaterial(scene, glass)), world * moved(0.3, 0.1, 0.6));
    }
    return scene;
}

FrameRequest forced(Scene scene, const std::string& id, const glm::dvec3& eye) {
    FrameRequest r = request(std::move(scene), id, eye);
    r.accuracy.planar = PlanarMethod::mirror;
    r.accuracy.curved = CurvedMethod::probe;
    r.accuracy.glass = GlassMethod::backdrop;
    r.accuracy.probeSize = 64;
    r.environment.map = "white";
    return r;
}

TEST_F(HardCases, AnyEyeHeightOverAMirrorIsFiniteAndStable) {
    FrameRequest r = forced(floorScene(glm::dmat4(1.0), false, true), "heights", {0, 0, 1});
    r.camera.up = glm::dvec3(0, 0, 1);
    r.camera.znear = 1e-3;
    std::vector<double> heights{0.0};
    for (double h = 1e-7; h < 2e3; h *= 10.0) heights.insert(heights.end(), {h, -h});
    for (const double height : heights) {
        r.camera.position = glm::dvec3(0.1, -2.0, height);
        for (const double down : {0.0, 0.2, 1.0}) {
            r.camera.target = glm::dvec3(0.1, 0.0, height - down);
            const Image image = renderer().render(r).image;
            ASSERT_EQ(badSamples(image), 0u) << height << " down " << down;
            for (std::uint32_t i = 0; i < 64 * 64; ++i) {
                const glm::vec3 c = color(image, i % 64, i / 64);
                ASSERT_LE(std::max({c.x, c.y, c.z}), 1.02f) << height << " down " << down;
            }
        }
    }
}

TEST_F(HardCases, LookingDownOnAMirrorShowsTheMirroredSceneAtAnyRoll) {
    FrameRequest seen = request(floorScene(glm::dmat4(1.0), false, false), "down", {0, 0, 1});
    FrameRequest direct = request(floorScene(glm::dmat4(1.0), true, false), "copy", {0, 0, 1});
    seen.accuracy.planar = PlanarMethod::mirror;
    for (int degrees = 0; degrees < 360; degrees += 5) {
        const double a = glm::radians(double(degrees));
        for (FrameRequest* r : {&seen, &direct}) {
            r->camera.position = glm::dvec3(0.05, 0.02, 1.3);
            r->camera.target = glm::dvec3(0.05, 0.02, 0.0);
            r->camera.up = glm::dvec3(std::cos(a), std::sin(a), 0.0);
        }
        const Image mirrored = renderer().render(seen).image;
        const Image copy = renderer().render(direct).image;
        int off = 0, lit = 0;
        for (std::uint32_t i = 0; i < 64 * 64; ++i) {
            lit += color(copy, i % 64, i / 64).y > 0.0f;
            off += greatestDifference(color(mirrored, i % 64, i / 64),
                                      color(copy, i % 64, i / 64)) > 2e-3f;
        }
        EXPECT_GT(lit, 100);
        EXPECT_EQ(off, 0) << degrees;
    }
}

double psnr(const Image& a, const Image& b) {
    double squares = 0.0;
    const std::size_t samples = std::size_t{a.width} * a.height * a.channels;
    for (std::size_t i = 0; i < samples; ++i) {
        squares += std::pow(double(a.floats()[i]) - b.floats()[i], 2.0);
    }
    return squares == 0.0 ? 200.0 : -10.0 * std::log10(squares / double(samples));
}

TEST_F(HardCases, ScenesOfAnyScaleGiveTheSameImage) {
    const auto picture = [](double scale) {
        const glm::dmat4 world = glm::scale(glm::dmat4(1.0), glm::dvec3(scale));
        FrameRequest r =
            forced(floorScene(world, false, true), "scaled", scale * glm::dvec3(0.3, -1.6, 0.9));
        r.camera.target = glm::dvec3(0.0, 0.0, 0.2 * scale);
        r.camera.up = glm::dvec3(0, 0, 1);
        r.camera.znear = 0.01 * scale;
        return renderer().render(r).image;
    };
    const Image one = picture(1.0);
    EXPECT_EQ(badSamples(one), 0u);
    for (const double scale : {1e-3, 1e-2, 0.3, 7.0, 1e2, 1e3}) {
        EXPECT_GT(psnr(picture(scale), one), 60.0) << scale;
    }
}

TEST_F(HardCases, DistanceFromTheOriginDoesNotChangeTheImage) {
    const auto picture = [](double far) {
        const glm::dvec3 shift(far, -far, 0.5 * far);
        FrameRequest r = forced(floorScene(glm::translate(glm::dmat4(1.0), shift), false, true),
                                "far", shift + glm::dvec3(0.3, -1.6, 0.9));
        r.camera.target = shift + glm::dvec3(0.0, 0.0, 0.2);
        r.camera.up = glm::dvec3(0, 0, 1);
        return renderer().render(r).image;
    };
    const Image here = picture(0.0);
    for (const double far : {1e2, 1e4, 1e6}) {
        const Image there = picture(far);
        double sum = 0.0;
        for (std::uint32_t i = 0; i < 64 * 64; ++i) {
            sum += greatestDifference(color(here, i % 64, i / 64), color(there, i % 64, i / 64));
        }
        EXPECT_EQ(badSamples(there), 0u);
        EXPECT_LE(sum / (64 * 64) * 255.0, 0.5) << far;
    }
}

TEST_F(HardCases, FramesOfAnySizeAreDrawn) {
    FrameRequest r = forced(floorScene(glm::dmat4(1.0), false, true), "sizes", {0.3, -1.6, 0.9});
    r.camera.target = glm::dvec3(0.0, 0.0, 0.2);
    r.camera.up = glm::dvec3(0, 0, 1);
    for (const auto& [width, height] :
         {std::pair(1u, 1u), {1u, 97u}, {131u, 1u}, {2u, 3u}, {7u, 5u}, {333u, 77u}}) {
        for (const double scale : {1.0, 0.3}) {
            r.width = width;
            r.height = height;
            r.accuracy.planarScale = scale;
            const Image image = renderer().render(r).image;
            EXPECT_EQ(image.width, width);
            EXPECT_EQ(badSamples(image), 0u) << width << " x " << height;
        }
    }
}

// An orthographic camera's mirror against the mirrored scene.
TEST_F(HardCases, ParallelProjectionsMirrorToo) {
    const auto picture = [](bool copy) {
        Scene scene = floorScene(glm::dmat4(1.0), copy, false);
        const glm::dmat4 worldFromCamera =
            worldFromLookAt({0.4, -2.0, 1.5}, {0.0, 0.0, 0.1}, {0, 0, 1});
        scene.cameras.push_back({.name = "parallel",
                                 .node = addNode(scene, "camera", worldFromCamera),
                                 .orthographic = true,
                                 .yHalfHeight = 1.1,
                                 .znear = 0.1,
                                 .zfar = 20.0});
        FrameRequest r = request(std::move(scene), copy ? "copy" : "mirror");
        r.camera = {};
        r.camera.name = "parallel";
        r.accuracy.planar = PlanarMethod::mirror;
        return renderer().render(r).image;
    };
    const Image mirrored = picture(false), copy = picture(true);
    int off = 0, lit = 0;
    for (std::uint32_t i = 0; i < 64 * 64; ++i) {
        lit += color(copy, i % 64, i / 64).y > 0.0f;
        off += greatestDifference(color(mirrored, i % 64, i / 64), color(copy, i % 64, i / 64)) >
               2e-3f;
    }
    EXPECT_EQ(badSamples(mirrored), 0u);
    EXPECT_GT(lit, 100);
    EXPECT_EQ(off, 0);
}

}  // namespace
}  // namespace clerestory::test
