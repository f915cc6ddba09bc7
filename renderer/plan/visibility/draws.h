// From the surfaces of a scene to the draws of one view: culling, shader features, order.
#pragma once

#include "plan/graph/stage.h"
#include "plan/visibility/coverage.h"

#include <span>

namespace clerestory {

// A cluster of a surface in the view frustum.
struct SeenCluster {
    std::uint32_t firstIndex = 0, indexCount = 0;
    double distance = 0.0;  // from the eye to the nearest point of its box, metres
    double share = 0.0;     // fraction of the picture that its box covers, 0..1
    LightList lights;
    Bounds box;  // relative to the eye, world axes
};

// A surface that may be visible in the view, and how it is drawn there.
struct SeenSurface {
    const Surface* surface = nullptr;
    Bounds box;          // of its clusters in view, relative to the eye, world axes
    double share = 0.0;  // estimated fraction of the picture (coverage.h); 0 if it needs no effect
    std::vector<SeenCluster> clusters;
    Features features = 0;
    std::uint32_t reflection = kNoReflection;
    std::optional<std::uint32_t> label;  // see Draw::label
    bool overBackdrop = false;           // glass that is drawn over a copy of the picture behind it
    Primitive primitive = Primitive::triangles;
    float pointSize = 1.0f;  // see Draw::pointSize
};

struct SeenView {
    std::vector<SeenSurface> surfaces;
    std::uint64_t clusters = 0, culled = 0;
    double overdraw = 0.0;          // predicted layers of opaque surfaces, mean over the picture
    std::uint32_t maxLights = 0;    // maximum number that reach one draw, before the limit
    std::uint64_t mapsLeftOut = 0;  // of layers; see leaveOutExcessMaps()
    bool anyLit = false, anyEmissive = false;
    std::uint64_t triangles = 0;  // lines and points count too
    // Union over all surfaces, and over all glass, of the scene; their programs share them.
    Features sharedFeatures = 0, glassFeatures = 0;
};

// Returns the surfaces in the view frustum and in front of the clip plane. `hidden`: surfaces to
// omit (a mirror from its own picture, the owner of a cube); sorted indices of Stage::surfaces.
SeenView seenFrom(const Stage& stage, const View& view, std::span<const std::size_t> hidden = {});

struct DrawLists {
    std::vector<Draw> depth;   // depth prepass: large occluders, near to far; may be empty
    std::vector<Draw> opaque;  // near to far, or by state with a depth prepass; masked last
    // Blended draws and glass over a backdrop, far to near.
    struct Behind {
        double distance;  // metres
        bool glass;
        std::size_t seen;  // index of SeenView::surfaces
        Draw draw;
        Bounds box;  // of the draw, relative to the eye, world axes
    };
    std::vector<Behind> through;
};

DrawLists drawLists(const SeenView& seen);

// What the instances of the draws cover at most.
ScreenBox coveredBy(std::span<const Draw> draws, const View& view, const Stage& stage);

}  // namespace clerestory
