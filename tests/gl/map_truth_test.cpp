// Environment maps where naive formulae fail: levels, edges of cube faces, rotated maps, the sky at
// any near and far plane, generations, and glass with reversed winding.
#include "own_sky.h"
#include "room.h"
#include "sight.h"

#include <glm/gtc/matrix_transform.hpp>

namespace clerestory::test {
namespace {

class MapTruth : public GlTest {};

// Smooth light from all around: the sum of a few cosine lobes, so that steps can only come from the
// map's own seams.
glm::vec3 smoothLight(const glm::dvec3& d) {
    return {0.5 + 0.4 * d.x * d.y + 0.05 * d.z, 0.5 + 0.3 * d.y * d.z - 0.1 * d.x,
            0.5 + 0.3 * d.x * d.z + 0.1 * d.y};
}

// A flat metal before the eye that fills the picture and mirrors the map.
FrameRequest rough(float roughness, double distance, const std::string& map) {
    Scene scene;
    Material m = mirrorMetal(1.0f, roughness);
    m.reflection = Reflection::none;
    place(scene, quad(float(40.0 * distance), addMaterial(scene, m)));
    FrameRequest r = request(std::move(scene), "metal", {0, 0, distance});
    r.camera.znear = 1e-3 * distance;
    r.environment.map = map;
    r.environment.visible = false;
    return r;
}

// R2: the level of a rough reflection is the lobe's, not the magnification's.
TEST_F(MapTruth, BlurIsIndependentOfEyeDistance) {
    addMap("stripes", 64, glm::dmat3(1.0), [](const glm::dvec3& d) {
        return glm::vec3(
            std::fmod(std::floor(8.0 + 6.0 * std::atan2(d.x, d.z)), 2.0) == 0.0 ? 1.0f : 0.1f);
    });
    for (const float roughness : {0.0f, 0.15f, 0.4f, 0.8f}) {
        const Image near = renderer().render(rough(roughness, 0.01, "stripes")).image;
        const Image far = renderer().render(rough(roughness, 100.0, "stripes")).image;
        const double greatest = greatestDifference(near, far);
        EXPECT_LT(greatest, 2e-3) << roughness;
    }
}

// R6: looking into the map across its edges and corners: no step there is larger than 1.2 times the
// largest within a face. The mirror is turned so that every edge and corner passes the picture.
TEST_F(MapTruth, NoSeamsAtCubeEdgesAndCorners) {
    addMap("smooth", 32, glm::dmat3(1.0), smoothLight);
    for (const float roughness : {0.0f, 0.2f, 0.5f, 0.9f}) {
        double atEdges = 0.0, within = 0.0;
        FrameRequest r = rough(roughness, 1.0, "smooth");
        r.width = r.height = 96;
        for (int turn = 0; turn < 6; ++turn) {
            // The picture is 90 degrees wide about an axis between three faces, or between two.
            const glm::dvec3 axis =
                glm::normalize(turn < 4 ? glm::dvec3(turn & 1 ? 1 : -1, turn & 2 ? 1 : -1, 1)
                                        : glm::dvec3(turn & 1 ? 1 : -1, 0, 1));
            const glm::dquat q(glm::dvec3(0, 0, 1), axis);  // turns +Z there
            const glm::dquat worldFromMap = glm::conjugate(q);
            r.environment.rotation = {worldFromMap.x, worldFromMap.y, worldFromMap.z,
                                      worldFromMap.w};
            const Image image = renderer().render(r).image;
            const auto faceOf = [&](std::uint32_t x, std::uint32_t y) {
                const Ray ray = sightOfPixel(r, x, y);
                const glm::dvec3 d =
                    q * glm::dvec3(ray.direction.x, ray.direction.y, -ray.direction.z);
                const glm::dvec3 a = glm::abs(d);
                const int k = a.x >= a.y && a.x >= a.z ? 0 : a.y >= a.z ? 1 : 2;
                return 2 * k + (d[k] < 0.0);
            };
            for (std::uint32_t y = 0; y < r.height; ++y) {
                for (std::uint32_t x = 1; x < r.width; ++x) {
                    const double step =
                        greatestDifference(color(image, x, y), color(image, x - 1, y));
                    double& greatest = faceOf(x, y) == faceOf(x - 1, y) ? within : atEdges;
                    greatest = std::max(greatest, step);
                }
            }
        }
        EXPECT_GT(within, 0.0);
        EXPECT_LE(atEdges, 1.2 * within) << roughness;
    }
}

// R6: turning the map's texels by a quarter and turning the map by request give one picture.
TEST_F(MapTruth, FilteringCommutesWithQuarterTurns) {
    const glm::dquat quarter = glm::angleAxis(glm::half_pi<double>(), glm::dvec3(0, 1, 0));
    addMap("upright", 32, glm::dmat3(1.0), smoothLight);
    addMap("turned", 32, glm::mat3_cast(glm::conjugate(quarter)), smoothLight);
    for (const float roughness : {0.0f, 0.3f, 0.7f, 1.0f}) {
        FrameRequest r = rough(roughness, 1.0, "turned");
        r.accuracy.environmentSamples = 512;  // each texel turns the set of samples its own way
        const Image texels = renderer().render(r).image;
        r.environment.map = "upright";
        r.environment.rotation = {quarter.x, quarter.y, quarter.z, quarter.w};
        const Image asked = renderer().render(r).image;
        const double greatest = greatestDifference(texels, asked);
        EXPECT_LT(greatest, 4e-3) << roughness;
    }
}

// C6: the sky is at no distance.
TEST_F(MapTruth, TheSkyIsThereAtAnyNearAndFarPlane) {
    addMap("smooth", 32, glm::dmat3(1.0), smoothLight);
    FrameRequest r = request(Scene{}, "sky", {3, 2, 1});
    r.environment.map = "smooth";
    const Image plain = renderer().render(r).image;
    EXPECT_GT(centerColor(plain).x, 0.1f);
    for (const auto& [znear, zfar] : {std::pair(1e-3, 1e6), {1e-3, 1.0}, {100.0, 1e6}}) {
        r.camera.znear = znear;
        r.camera.zfar = zfar;
        EXPECT_EQ(renderer().render(r).image.data, plain.data) << znear << " to " << zfar;
    }
}

// I1: what a generation adds is what the last one passed on: at most rho to its number.
TEST_F(MapTruth, AnotherGenerationAddsAtMostTheRemainingLight) {
    const float rho = 0.6f;
    const auto picture = [&](std::uint32_t generations) {
        Scene scene;
        Room{glm::vec3(1.0f)}.build(scene);
        Material metal = mirrorMetal(rho);
        metal.reflection = Reflection::mirror;
        const Index m = addMaterial(scene, metal);
        place(scene, sphere(0.6f, 32, m), moved(-0.8, 0, 0));
        place(scene, sphere(0.6f, 32, m), moved(0.8, 0.1, 0.05));
        FrameRequest r = request(std::move(scene), "generations", {0, 0.3, 2.8});
        r.accuracy.curved = CurvedMethod::probe;
        r.accuracy.generations = generations;
        return renderer().render(r).image;
    };
    Image before = picture(1);
    for (std::uint32_t b = 2; b <= 3; ++b) {
        const Image now = picture(b);
        const double most = greatestDifference(now, before);
        EXPECT_LE(most, std::pow(rho, double(b - 1)) + 0.01) << b;
        EXPECT_GT(most, 0.0) << b;
        before = now;
    }
}

// G5: a two-sided pane has no inside: turned winding and turned normals change no pixel.
TEST_F(MapTruth, WindingOfTwoSidedPanesDoesNotMatter) {
    addMap("smooth", 32, glm::dmat3(1.0), smoothLight);
    const auto picture = [](bool turned) {
        Scene scene;
        place(scene, quad(0.4f, addMaterial(scene, glowing({2, 1, 0.5f}))), moved(0.2, 0.1, -1));
        Material m{.name = "pane",
                   .metallic = 0.0f,
                   .roughness = 0.0f,
                   .doubleSided = true,
                   .transmission = 1.0f};
        MeshDraft pane = quad(1.0f, addMaterial(scene, m));
        if (turned) {
            for (std::size_t i = 0; i < pane.indices.size(); i += 3) {
                std::swap(pane.indices[i + 1], pane.indices[i + 2]);
            }
            for (Vertex& v : pane.vertices) v.normal = -v.normal;
        }
        place(scene, std::move(pane), glm::rotate(glm::dmat4(1.0), 0.6, glm::dvec3(0.2, 1, 0)));
        FrameRequest r = request(std::move(scene), "pane", {0.3, 0.2, 1.6});
        r.environment.map = "smooth";
        r.accuracy.glass = GlassMethod::backdrop;
        return renderer().render(r).image;
    };
    const Image front = picture(false), back = picture(true);
    int off = 0;
    for (std::uint32_t i = 0; i < 64 * 64; ++i) {
        off += greatestDifference(color(front, i % 64, i / 64), color(back, i % 64, i / 64)) > 1e-3;
    }
    EXPECT_EQ(off, 0);
}

}  // namespace
}  // namespace clerestory::test
