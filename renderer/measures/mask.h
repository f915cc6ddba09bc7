// Which pixels an error is taken on: those whose first surface carries an effect.
#pragma once

#include "image/image.h"
#include "plan/graph/frame_plan.h"
#include "scene/material_bindings.h"

#include <cstdint>
#include <vector>

namespace clerestory {

struct Mask {
    std::uint32_t width = 0, height = 0;
    std::vector<std::uint8_t> inside;  // width * height, not 0: counts
    std::uint64_t pixels() const;      // that count
};

// The frame whose picture tells which pixels carry which effect: the same view with every effect
// on, each served in the way that the channel `through` names apart, so that the masks of two
// accuracy settings are the same.
FrameRequest maskRequest(FrameRequest request);

// Of a picture of the channel `through` drawn for maskRequest(). refraction: glass;
// planarReflection: flat mirrors that show a mirrored picture; environmentReflection: mirrors that
// show a captured cube, rays or the environment map; base: what is none of these. Empty for the
// effects that the channel does not tell: emission, for which see emissionMask(), and filters.
// Throws std::runtime_error unless the picture has one float channel.
Mask maskOf(const Image& through, Effect effect);

// Pixels of things that glow, of a picture of the channel `objectId`. Throws as maskOf().
Mask emissionMask(const Image& objectIds, const Scene& scene,
                  const MaterialBindings& materials = {});

}  // namespace clerestory
