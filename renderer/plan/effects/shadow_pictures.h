// What the lights of a frame see: who casts shadows, the pictures of each light, and their places
// in the shadow map.
//
//     const Casters casters(stage);
//     std::vector<Shadow> shadows;
//     const auto shadow = shadowOf(stage, casters, light, edgesOf(preset));
//     if (shadow) shadows.push_back(*shadow);
//     const std::optional<MapSize> size = placeInSmallestMap(shadows);
#pragma once

#include "plan/graph/stage.h"
#include "plan/request/frame_request.h"

#include <cstdint>
#include <optional>
#include <vector>

namespace clerestory {

// Hides light. The ground is below everything that it could shade.
bool casts(const Stage& stage, const Surface& surface);
// Some light passes it.
bool tints(const Stage& stage, const Surface& surface);

// The casters of a frame, and which of them clips change.
class Casters {
public:
    explicit Casters(const Stage& stage);
    bool any() const { return still_ || moving_; }
    bool anyChange() const { return moving_; }
    // Some change, and others do not.
    bool mixed() const { return still_ && moving_; }
    bool change(const Surface& surface) const {
        return !changes_.empty() && changes_[surface.instance];
    }
    // Of the clusters of all casters, 0..1.
    double changingShare() const { return changingShare_; }

private:
    std::vector<bool> changes_;  // by instance; empty: none
    bool still_ = false, moving_ = false;
    double changingShare_ = 0.0;
};

// Edges of pictures, texels.
struct PictureEdges {
    std::uint32_t sun, cone, face;
    PictureEdges half() const { return {sun / 2, cone / 2, face / 2}; }
};
PictureEdges edgesOf(Preset preset);

// A light and its pictures.
struct Shadow {
    std::size_t light;  // of Stage::lights
    LightShadow::Kind kind;
    std::uint32_t edge;
    std::vector<View> views;
    bool lasts = false;  // while clips play and the light rests, the views are the same
    TargetRect first;    // of the map; set by placeInSmallestMap()
};

// Nothing if no caster is in the way of the light.
std::optional<Shadow> shadowOf(const Stage& stage, const Casters& casters, std::size_t light,
                               const PictureEdges& edges);

struct MapSize {
    std::uint32_t width, height;  // texels
};
// Places the pictures in the smallest map. Returns its size, or nothing if it would be too large.
std::optional<MapSize> placeInSmallestMap(std::vector<Shadow>& shadows);

}  // namespace clerestory
