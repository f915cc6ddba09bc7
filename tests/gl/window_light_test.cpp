// Light from a window of the environment map, which rays in random directions rarely find.
#include "own_sky.h"

#include <cmath>
#include <numbers>

namespace clerestory::test {
namespace {

class WindowLight : public GlTest {};

const glm::dvec3 kWindow = glm::normalize(glm::dvec3(-1.0, 1.0, 0.0));

// Black but for a disc of 7 degrees.
glm::vec3 window(const glm::dvec3& direction) {
    return glm::vec3(glm::dot(direction, kWindow) > 0.9925 ? 100.0f : 0.0f);
}

}  // namespace

// A black wall at x = -1 of height 1 hides the window, at 45 degrees, from the floor up to x = 0.
TEST_F(WindowLight, HasAShadowAndEvenLightNextToIt) {
    addMap("window", 64, glm::dmat3(1.0), window);
    Scene scene;
    const double quarter = 0.5 * std::numbers::pi;
    place(scene, quad(4.0f, addMaterial(scene, lambert(0.5f))),
          glm::rotate(glm::dmat4(1.0), -quarter, glm::dvec3(1.0, 0.0, 0.0)));
    Material black = lambert(0.0f);
    black.doubleSided = true;
    place(scene, quad(1.0f, addMaterial(scene, black)),
          glm::translate(glm::dmat4(1.0), glm::dvec3(-1.0, 0.0, 0.0)) *
              glm::rotate(glm::dmat4(1.0), quarter, glm::dvec3(0.0, 1.0, 0.0)));
    FrameRequest r = request(std::move(scene), "window", {0.0, 5.0, 0.0});
    r.camera.target = glm::dvec3(0.0);
    r.camera.up = glm::dvec3(0.0, 0.0, -1.0);
    r.camera.yfov = 0.6;
    r.environment.map = "window";
    r.effects.indirectLight = true;
    ASSERT_TRUE(renderer().completeLight(r).complete);
    const Image image = renderer().render(r).image;

    const double open = 0.5 * 100.0 * 2.0 * (1.0 - 0.9925) * kWindow.y;
    double lit = 0.0, hidden = 0.0;
    int litPixels = 0, hiddenPixels = 0;
    for (std::uint32_t y = 24; y < 40; ++y) {
        for (std::uint32_t x = 0; x < 64; ++x) {
            const double metres = 5.0 * std::tan(0.3) * (x + 0.5 - 32.0) / 32.0;
            const double off = double{color(image, x, y).x} / open;
            if (metres > 0.6) {
                lit += (off - 1.0) * (off - 1.0);
                ++litPixels;
            } else if (metres > -0.8 && metres < -0.5) {
                hidden += off * off;
                ++hiddenPixels;
            }
        }
    }
    ASSERT_GT(litPixels, 100);
    ASSERT_GT(hiddenPixels, 40);
    EXPECT_LT(std::sqrt(lit / litPixels), 0.05);
    EXPECT_LT(std::sqrt(hidden / hiddenPixels), 0.05);
}

}  // namespace clerestory::test
