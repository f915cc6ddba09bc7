#include "plan/cost/cost.h"

#include <algorithm>
#include <limits>

namespace clerestory {
namespace {

// Sponza and the chapel: 77 to 105 ms for 224,000 triangles over 921,600 pixels; cube faces of 256,
// 512 and 1024 in 59, 126 and 360 ms. Rays including shading of hits, in the chapel: brass figure
// (1.3 % of the frame) 29 ms, its floor (12 %) 160 ms, a glass ball of 5,700 pixels 45 ms.
constexpr Prices kSoftware{0.6, 1.6e-4, 4.5e-5, 1.8e-6, 8.0, 1.6e-3, 1.6e-3};
// The same with rays on the processor, two cores, shading of hits included, with the density of
// `standard`: 69,000 pixels of the teapots' metal 44 ms, 33,000 of their glass 36 ms, 106,000 of a
// chrome knot that reflects itself 134 ms, 59,000 of a glass ball 37 ms. Reading the records and
// adding the light takes some 6 ms.
constexpr Prices kProcessorRays{0.6, 1.6e-4, 4.5e-5, 1.8e-6, 6.0, 6e-4, 1.5e-4};
// Not measured: a GPU of a few TFLOP/s draws about 1e9 triangles and 1e10 pixels per second.
constexpr Prices kHardware{0.05, 1e-6, 1e-7, 4e-9, 0.05, 2e-6, 2e-6};

double rayMilliseconds(const Work& work, const Prices& p) {
    if (!(work.rayPixels > 0.0)) return 0.0;
    return p.rayFrame + work.rayPixels * (p.rayPixel + p.raySegment * (work.rays - 1.0));
}

}  // namespace

const Prices& pricesOf(bool software, bool processorRays) {
    if (!software) return kHardware;
    return processorRays ? kProcessorRays : kSoftware;
}

double milliseconds(const Work& work) {
    const Prices& p = pricesOf(work.software, work.processorRays);
    const double drawn = p.view * work.views + p.triangle * work.triangles + p.pixel * work.pixels +
                         p.copiedPixel * work.copiedPixels;
    return drawn / std::max(1.0, work.frames) + rayMilliseconds(work, p);
}

std::size_t cheapest(std::span<const Candidate> candidates, double tolerance) {
    std::size_t best = 0;
    const auto rank = [&](const Candidate& c) {
        // Accurate candidates first, by time; then the others, by error.
        const bool enough = c.error <= tolerance;
        return std::pair(enough ? 0.0 : c.error, enough ? c.milliseconds : 0.0);
    };
    for (std::size_t i = 1; i < candidates.size(); ++i) {
        if (rank(candidates[i]) < rank(candidates[best])) best = i;
    }
    return best;
}

double toleranceOf(Preset preset) {
    switch (preset) {
        case Preset::draft:
            return 3e-2;
        case Preset::standard:
            return 6e-3;
        case Preset::fine:
            return 1.2e-3;
    }
    return 6e-3;
}

// Square roots of relMSE over curved mirrors, measured against the reference at 480x270 with each
// method requested (docs/accuracy.md); for the first three scenes, geometric means. Roughness hides
// errors.
//                  environment   probe   traced
//   teapots             1.95      0.95    0.44
//   orbiting-cubes      1.45      1.27    0.16
//   six-walls           0.69      0.15    0.15
//   Sponza, inside      3.9       2.0     1.1
// Indoors an environment map shows the sky, which is many times as bright as the room.
double environmentError(double roughness, double enclosed) {
    const double e = std::clamp(enclosed, 0.0, 1.0);
    return (1.25 - 0.6 * std::clamp(roughness, 0.0, 1.0)) * (1.0 + 3.0 * e * e * e * e);
}
// Sponza's urns are one mesh along the whole court; a cube in its middle shows other surroundings
// than those of each urn.
double probeError(double roughness, double apart) {
    const double a = std::clamp(apart, 0.0, 1.0);
    return (0.55 - 0.3 * std::clamp(roughness, 0.0, 1.0)) * std::min(1.0 + 5.5 * a, 4.0);
}
// One ray is traced along the centre of the lobe.
double tracedError(double roughness) {
    return 0.2 + 0.9 * std::max(0.0, roughness - 0.1);
}
// Measured together with rays: chapel 0.24 and 0.21, meadow 0.18 and 0.24, orbiting-cubes 0.16 and
// 0.17.
double mirrorError(double roughness) {
    return 0.9 * tracedError(roughness);
}

double glassEnvironmentError() {
    return 2.7;
}
// A pane does not displace what is behind it; only its reflection is approximate.
double backdropError(bool solid, bool backFaces) {
    if (!solid) return 0.06;
    return backFaces ? 2.2 : 2.7;
}
double glassRaySegments(bool solid, std::uint32_t bounces) {
    return solid ? std::min(4.0, 1.0 + bounces) : 2.0;
}

// In an animated scene the next frame shows another time, which invalidates most cubes.
double framesPerCapture(bool sceneMoves) {
    return sceneMoves ? 1.0 : 16.0;
}

}  // namespace clerestory
