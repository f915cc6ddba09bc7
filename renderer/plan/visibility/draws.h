// From the surfaces of a scene to the draws of one view: culled, classed, ordered.
#pragma once

#include "plan/graph/stage.h"
#include "plan/visibility/coverage.h"

#include <span>

namespace clerestory {

// A cluster of a surface in the view.
struct SeenCluster {
    std::uint32_t firstIndex = 0, indexCount = 0;
    double distance = 0.0;  // from the eye to the nearest point of its box, metres
    double share = 0.0;     // of the picture, that its box covers
    LightList lights;
    Bounds box;  // relative to the eye, the world's axes
};

// A surface of which something may be in the view, and how it will be drawn there.
struct SeenSurface {
    const Surface* surface = nullptr;
    Bounds box;          // of its clusters in view, relative to the eye, the world's axes
    double share = 0.0;  // of the picture, about (coverage.h); 0 for what needs no effect
    std::vector<SeenCluster> clusters;
    Features features = 0;
    std::uint32_t reflection = kNoReflection;
    std::uint32_t through = 0;  // see Draw::through
    bool overBackdrop = false;  // glass that is drawn over a picture of what lies behind it
};

struct SeenView {
    std::vector<SeenSurface> surfaces;
    std::uint64_t clusters = 0, culled = 0;
    double overdraw = 0.0;         // predicted layers of opaque surface over the whole picture
    std::uint32_t mostLights = 0;  // the most that reach one draw, before the limit
    bool anyLit = false, anyEmissive = false;
    std::uint64_t triangles = 0;
    // Of all surfaces of the scene and of all its glass, in view or not: their programs share them.
    Features sharedFeatures = 0, glassFeatures = 0;
};

// `hidden`: surfaces that this view does not show (a mirror in its own picture, a probe's owner),
// by their place in Stage::surfaces, sorted.
SeenView seenFrom(const Stage& stage, const View& view, std::span<const std::size_t> hidden = {});

// What a shader needs that may meet any surface of the scene.
Features featuresOfAll(const Stage& stage);

struct DrawLists {
    std::vector<Draw> depth;   // what hides much for its cost, near to far: for a depth prepass
    std::vector<Draw> opaque;  // near to far, or by state when `depth` will be used; masked last
    // Far to near, each with its distance: blended draws and glass over a backdrop.
    struct Behind {
        double distance;
        bool glass;
        std::size_t seen;  // into SeenView::surfaces
        Draw draw;
        Bounds box;  // of the draw, relative to the eye, the world's axes
    };
    std::vector<Behind> through;
};

DrawLists drawLists(const SeenView& seen);

}  // namespace clerestory
