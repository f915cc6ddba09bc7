// Further samples of the pixels of a view in which the picture has contrast. graph/pass.h describes
// the members that every pass type has.
#pragma once

#include "plan/graph/sample_costs.h"
#include "plan/graph/target.h"
#include "plan/request/frame_request.h"
#include "scene/hash.h"

#include <glm/glm.hpp>

#include <string_view>
#include <vector>

namespace clerestory {

struct Stage;

// Chooses the pixels of the finished picture of a view that differ most from their neighbours as
// displayed, and executes the passes of the view again for each further sample: displaced by a
// fraction of a pixel, and only in these pixels. They become the mean radiance of their samples.
struct Supersampling {
    // The picture itself, or one that a mirror in it shows. The pixel p, from the lower left, is at
    // p / scale + origin in the picture. `chosen` receives depths: of the far end where a pixel is
    // chosen, otherwise of the near end, so that nothing is drawn there.
    struct Part {
        glm::dvec2 origin{0.0};
        double scale = 1.0;
        TargetId chosen = kNoTarget;
        bool operator==(const Part&) const = default;
    };
    // A pass of the plan to execute again.
    struct Repeated {
        std::size_t pass = 0;
        std::size_t part = 0;  // that it draws; index of parts
        bool operator==(const Repeated&) const = default;
    };
    std::vector<Part> parts;       // the picture itself first
    std::vector<Repeated> passes;  // in order
    std::uint32_t samples = 2;     // of each chosen pixel; one is there already
    double share = 1.0;            // greatest share of the pixels that may be chosen, 0..1
    double leastContrast = 0.0;    // of a chosen pixel: difference of sRGB values, 0..1
    // Pixels whose first samples differ less have no more of them.
    std::uint32_t firstSamples = 2;
    double leastDifference = 0.0;
    ToneMap curve = ToneMap::neutral;
    float exposureFactor = 1.0f;
    bool transparent = false;  // differences of alpha count, too

    std::string_view kind() const { return "supersampling"; }
    std::vector<TargetId> reads() const { return {}; }
    std::string_view knobs() const { return "/accuracy/samples, /accuracy/sampleShare"; }
    // Without those of the passes that it executes; see work.h.
    std::uint64_t shadedSamples(const TargetSpec&, const SampleFactors&) const { return 0; }
    friend void addTo(PlanHash&, const Supersampling&, const Stage&) {}  // of frames only
    bool operator==(const Supersampling&) const = default;
};

// Where the sample is in its pixel, from the middle, in pixels: -0.5..0.5. The first is in the
// middle, three are the corners of a triangle, the others are pairs on opposite sides, from the
// sequence R2 (Roberts 2018). The mean of the first four, and of every even number above, is the
// middle; of another number it is not, and edges would move. Radius, angle and beginning: those of
// the smallest errors of edges.
glm::dvec2 samplePlace(std::uint32_t sample);

}  // namespace clerestory
