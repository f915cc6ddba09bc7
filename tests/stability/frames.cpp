#include "tests/stability/frames.h"

#include <glm/gtc/matrix_transform.hpp>

namespace clerestory::test {

Image drawn(const FrameRequest& request) {
    Frame frame = renderer().render(request, Readback::health);
    std::uint64_t bad = 0;
    for (const TargetHealth& target : frame.health) bad += target.nonFinite + target.negative;
    EXPECT_TRUE(atMost("non-finite scan", "bad texels of a frame's targets", double(bad), 0.0));
    EXPECT_FALSE(frame.health.empty());
    return std::move(frame.image);
}

double mostApart(const Image& a, const Image& b) {
    if (a.data.size() != b.data.size()) return HUGE_VAL;
    double most = 0.0;
    for (std::size_t i = 0; i < a.data.size() / sizeof(float); ++i) {
        most = std::max(most, std::abs(double(a.floats()[i]) - b.floats()[i]));
    }
    return most;
}

double decibelsApart(const Image& a, const Image& b) {
    double squares = 0.0;
    const std::size_t samples = a.data.size() / sizeof(float);
    for (std::size_t i = 0; i < samples; ++i) {
        squares += std::pow(double(a.floats()[i]) - b.floats()[i], 2.0);
    }
    return squares == 0.0 ? 200.0 : -10.0 * std::log10(squares / double(samples));
}

Image averaged(const Image& image, std::uint32_t edge) {
    Image mean = makeImage(image.width / edge, image.height / edge, 3, PixelType::float32);
    for (std::uint32_t y = 0; y < mean.height * edge; ++y) {
        for (std::uint32_t x = 0; x < mean.width * edge; ++x) {
            float* to = mean.floats() + 3 * (std::size_t{y / edge} * mean.width + x / edge);
            for (int c = 0; c < 3; ++c) to[c] += color(image, x, y)[c] / float(edge * edge);
        }
    }
    return mean;
}
Mask whole(const Mask& mask, std::uint32_t edge) {
    Mask result{mask.width / edge, mask.height / edge, {}};
    result.inside.assign(std::size_t{result.width} * result.height, 1);
    for (std::uint32_t y = 0; y < result.height * edge; ++y) {
        for (std::uint32_t x = 0; x < result.width * edge; ++x) {
            result.inside[std::size_t{y / edge} * result.width + x / edge] &=
                mask.inside[std::size_t{y} * mask.width + x];
        }
    }
    return result;
}

Scene floorScene(const glm::dmat4& world, bool mirroredCopy, bool extras) {
    Scene scene;
    const glm::dvec3 places[] = {{-0.6, 0.2, 0.5}, {0.5, -0.5, 0.3}, {0.2, 0.6, 0.8}};
    for (int copy = 0; copy < (mirroredCopy ? 2 : 1); ++copy) {
        const glm::dmat4 turned =
            glm::scale(glm::dmat4(1.0), glm::dvec3(1.0, 1.0, copy == 1 ? -1.0 : 1.0));
        for (int i = 0; i < 3; ++i) {
            glm::dmat4 m = glm::translate(glm::dmat4(1.0), places[i]);
            m = glm::rotate(m, 0.5 + 0.4 * i, glm::dvec3(1.0, 0.3, 0.2));
            const glm::vec3 radiance(0.2f + 0.3f * float(i), 0.9f - 0.2f * float(i), 0.5f);
            place(scene, quad(0.2f, addMaterial(scene, glowing(radiance))), world * turned * m);
        }
    }
    if (!mirroredCopy) place(scene, quad(1.5f, addMaterial(scene, mirrorMetal())), world);
    if (extras) {
        place(scene, sphere(0.2f, 16, addMaterial(scene, mirrorMetal())), world * moved(0, 0, 0.4));
        place(scene, quad(0.3f, addMaterial(scene, clearGlass())), world * moved(0.3, 0.1, 0.6));
    }
    return scene;
}

FrameRequest byPictures(Scene scene, const std::string& id, const glm::dvec3& eye) {
    FrameRequest r = request(std::move(scene), id, eye);
    r.accuracy.planar = PlanarMethod::mirror;
    r.accuracy.curved = CurvedMethod::probe;
    r.accuracy.glass = GlassMethod::backdrop;
    r.accuracy.probeSize = 32;
    r.accuracy.generations = 1;
    r.environment.map = "white";
    return r;
}

}  // namespace clerestory::test
