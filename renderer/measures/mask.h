// The pixels over which an error is measured: those whose first surface shows an effect.
#pragma once

#include "image/image.h"
#include "plan/graph/frame_plan.h"
#include "scene/material_bindings.h"

#include <cstdint>
#include <vector>

namespace clerestory {

struct Mask {
    std::uint32_t width = 0, height = 0;
    std::vector<std::uint8_t> inside;  // width * height; nonzero: counted
    std::uint64_t pixels() const;      // counted
};

// The frame whose `through` channel gives the masks: the same view with every effect on, and with
// techniques that the channel distinguishes, so that all accuracy settings have the same masks.
FrameRequest maskRequest(FrameRequest request);

// The mask of an effect, from the channel `through` of maskRequest(). refraction: glass;
// planarReflection: flat mirrors that show a mirrored view; environmentReflection: mirrors that
// show a captured cube, rays or the environment map; base: none of these. Empty for effects that
// the channel does not distinguish: emission (see emissionMask()) and filters. Throws
// std::runtime_error unless the image has one float channel.
Mask maskOf(const Image& through, Effect effect);

// Pixels of instances that emit, from the channel `objectId`. Throws as maskOf().
Mask emissionMask(const Image& objectIds, const Scene& scene,
                  const MaterialBindings& materials = {});

}  // namespace clerestory
