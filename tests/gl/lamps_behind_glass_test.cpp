// Lamps behind rough glass, whose light it scatters towards the eye.
#include "glass_truth.h"

#include <cmath>
#include <numeric>

namespace clerestory::test {
namespace {

class LampsBehindGlass : public GlTest {
protected:
    // A pane or a body at the origin, and a lamp of 10 cd at `at`; seen along -z.
    static Scene lampBehind(const Material& glass, const glm::dvec3& at = {0.0, 0.0, -0.5}) {
        Scene scene;
        place(scene, glass.thickness > 0.0f ? cube(0.5f, addMaterial(scene, glass))
                                            : quad(6.0f, addMaterial(scene, glass)));
        addLight(scene, {.intensity = glm::vec3(10.0f)}, moved(at.x, at.y, at.z));
        return scene;
    }
    // Squares of `half` metres about the origin from far away.
    static FrameRequest fromAfar(Scene scene, double half, std::uint32_t edge) {
        constexpr double kAway = 40.0;
        FrameRequest r = through(std::move(scene), "lamp behind", {0.0, 0.0, kAway});
        r.camera.yfov = 2.0 * std::atan(half / kAway);
        r.width = r.height = edge;
        return r;
    }
    static double mean(const Image& image) {
        double sum = 0.0;
        for (std::uint32_t y = 0; y < image.height; ++y) {
            for (std::uint32_t x = 0; x < image.width; ++x) sum += color(image, x, y).x;
        }
        return sum / (double(image.width) * image.height);
    }
};

// A pane sends light of intensity I on with its transmittance T, and scatters it by small angles
// only: the radiance towards a far eye, integrated over the pane, is T I.
TEST_F(LampsBehindGlass, LoseNoLight) {
    for (const float ior : {1.3f, 1.5f, 1.8f}) {
        for (const float roughness : {0.2f, 0.3f, 0.5f}) {
            const double half = 1.5;
            const Image image =
                renderer()
                    .render(fromAfar(lampBehind(clearGlass(ior, roughness)), half, 512))
                    .image;
            const double power = mean(image) * 4.0 * half * half;
            EXPECT_NEAR(power / (10.0 * paneTransmits(1.0, ior)), 1.0, 0.06)
                << ior << ' ' << roughness;
        }
    }
}

// Through clear glass a lamp is not seen, as without any.
TEST_F(LampsBehindGlass, AreNotSeenThroughClearGlass) {
    const Image image =
        renderer().render(fromAfar(lampBehind(clearGlass(1.5f, 0.0f)), 1.0, 64)).image;
    EXPECT_EQ(mean(image), 0.0);
}

TEST_F(LampsBehindGlass, AreHiddenByWhatIsBetween) {
    for (const bool between : {false, true}) {
        Scene scene = lampBehind(clearGlass(1.5f, 0.4f), {0.0, 0.0, -1.0});
        place(scene, quad(3.0f, addMaterial(scene, lambert(0.0f, 0.0f))),
              moved(0.0, 0.0, between ? -0.5 : -1.5));
        FrameRequest r = fromAfar(std::move(scene), 0.5, 64);
        r.effects.shadows = true;
        const double seen = mean(renderer().render(r).image);
        if (between) {
            EXPECT_LT(seen, 1e-3);
        } else {
            EXPECT_GT(seen, 1.0);
        }
    }
}

// A wall that faces the eye, whose shell has no far wall there: what the picture shows in front of
// the lamp is on no way of its light.
TEST_F(LampsBehindGlass, AreSeenThroughOpenShellsWhateverIsInFrontOfThem) {
    double seen[2] = {};
    for (const bool covered : {false, true}) {
        Scene scene;
        Material wall = clearGlass(1.5f, 0.5f);
        wall.doubleSided = true;
        MeshDraft bowl = sphere(1.0f, 64, addMaterial(scene, wall));
        std::vector<std::uint32_t> half;
        for (std::size_t i = 0; i < bowl.indices.size(); i += 3) {
            const auto* corners = &bowl.indices[i];
            if (bowl.vertices[corners[0]].position.z > 0.1f)
                half.insert(half.end(), corners, corners + 3);
        }
        bowl.indices = half;
        place(scene, std::move(bowl));
        addLight(scene, {.intensity = glm::vec3(10.0f)}, moved(0.0, -0.6, -1.0));
        // On the line from the eye to the lamp, not on that through the middle of the picture.
        place(scene, quad(0.1f, addMaterial(scene, lambert(0.0f))),
              moved(0.0, -0.24, covered ? 2.0 : -9.0));
        FrameRequest r = through(std::move(scene), "bowl", {0.0, 0.0, 4.0});
        r.accuracy.glass = GlassMethod::backdrop;
        seen[covered] = centerColor(renderer().render(r).image).x;
    }
    EXPECT_GT(seen[0], 0.1);
    EXPECT_EQ(seen[0], seen[1]);
}

// From several sides, near the lamp's direction and next to it.
TEST_F(LampsBehindGlass, AreThoseOfTheReference) {
    for (const float thickness : {0.0f, 1.0f}) {
        for (const float roughness : {0.3f, 0.5f}) {
            for (const double aside : {0.0, 0.15, 0.3}) {
                Material glass = clearGlass(1.5f, roughness);
                glass.thickness = thickness;
                const Scene scene = lampBehind(glass, {0.0, 0.0, -2.0});
                FrameRequest r = through(Scene(scene), "several",
                                         {4.0 * std::sin(aside), 0.0, 4.0 * std::cos(aside)});
                r.camera.target = {0.0, 0.0, 0.0};
                r.camera.yfov = 0.004;
                r.width = r.height = 16;
                const std::vector<double> truth = tracedPixels(scene, r);  // all about the same
                const double expected =
                    std::accumulate(truth.begin(), truth.end(), 0.0) / double(truth.size());
                for (const GlassMethod method : {GlassMethod::backdrop, GlassMethod::traced}) {
                    r.accuracy.glass = method;
                    // Far from the middle the lobe is an approximation.
                    EXPECT_NEAR(centerColor(renderer().render(r).image).x / expected, 1.0,
                                aside < 0.2 ? 0.08 : 0.3)
                        << thickness << ' ' << roughness << ' ' << aside << ' ' << int(method);
                }
            }
        }
    }
}

}  // namespace
}  // namespace clerestory::test
