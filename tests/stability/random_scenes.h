// Seeded random small scenes and valid random requests for them. Equal seeds give equal scenes.
#pragma once

#include "tests/gl/support.h"

#include <cstdint>

namespace clerestory::test {

class RandomSource {
public:
    explicit RandomSource(std::uint64_t seed) : state_(seed) {}
    std::uint64_t bits();                    // splitmix64 (Steele, Lea and Flood 2014)
    double real(double low, double high);    // [low, high)
    std::uint32_t below(std::uint32_t end);  // 0..end - 1
    bool is(double probability) { return real(0.0, 1.0) < probability; }
    glm::dvec3 inBox(double half);
    glm::dvec3 direction();

private:
    std::uint64_t state_;
};

// Up to a dozen things within 2 metres of the origin: lamps, mirrors that face mirrors, balls in
// balls, glass in glass, panes, some in a closed room with probes in its corners; now and then
// turned inside out, flattened, far away or of odd size.
Scene randomScene(RandomSource& chance, const std::string& id);

// A scene that can be right: what is in it is of common size, and four radii apart (nearer, a cube
// that is captured in a ball's middle shows highlights that its surface does not see, or the inside
// of another body; sheets in one place have no front), lamps are of at most 10, about glass of at
// most 1, and there are mirrors of metal, or panes, or balls of glass. All are smooth, or all of a
// roughness of 0.1 to 0.3: beyond, a mirror's lobe is wider than its picture.
Scene randomPlainScene(RandomSource& chance, const std::string& id, bool smooth);

// A valid request: any camera, lens, switches and knobs, at the size of a stamp (at most 24 pixels,
// cubes of 16 texels). Linear float colour.
FrameRequest randomRequest(RandomSource& chance, const std::string& scene);
// The same request from elsewhere, through another lens.
void randomCamera(RandomSource& chance, FrameRequest& request);

}  // namespace clerestory::test
