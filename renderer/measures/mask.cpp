#include "measures/mask.h"

#include "scene/classification.h"

#include <algorithm>
#include <functional>
#include <stdexcept>

namespace clerestory {
namespace {

// The channel's values are integers; adding one half rounds.
Mask maskWhere(const Image& values, const std::function<bool(std::uint32_t)>& included) {
    if (values.channels != 1 || values.type != PixelType::float32) {
        throw std::runtime_error("a mask requires an image with one float channel");
    }
    Mask mask{.width = values.width, .height = values.height};
    mask.inside.resize(std::size_t(values.width) * values.height);
    for (std::size_t i = 0; i < mask.inside.size(); ++i) {
        const float value = values.floats()[i];
        const bool valid =
            value >= 0.0f && value < 16777216.0f;  // 2^24: greatest range of exact integers
        mask.inside[i] = valid && included(static_cast<std::uint32_t>(value + 0.5f));
    }
    return mask;
}

}  // namespace

std::uint64_t Mask::pixels() const {
    return static_cast<std::uint64_t>(
        std::count_if(inside.begin(), inside.end(), [](std::uint8_t in) { return in != 0; }));
}

FrameRequest maskRequest(FrameRequest request) {
    request.effects = {};
    request.accuracy.planar = PlanarMethod::mirror;
    request.accuracy.curved = CurvedMethod::probe;
    request.accuracy.glass = GlassMethod::backdrop;
    request.output.channel = Channel::through;
    request.output.format = OutputFormat::npy;
    return request;
}

Mask maskOf(const Image& through, Effect effect) {
    return maskWhere(through, [effect](std::uint32_t value) {
        switch (effect) {
            case Effect::base:
                return value == throughDirect;
            case Effect::refraction:
                return value == throughGlass;
            case Effect::planarReflection:
                return value >= throughFirstMirror;
            case Effect::environmentReflection:
                return value == throughCubeOrRays || value == throughEnvironment;
            case Effect::emission:
            case Effect::filters:
                break;
        }
        return false;
    });
}

Mask emissionMask(const Image& objectIds, const Scene& scene, const MaterialBindings& materials) {
    std::vector<std::uint8_t> emits(scene.instances.size(), 0);
    for (const Surface& surface : surfacesOf(scene, materials)) {
        if (surface.emitter) emits[surface.instance] = 1;
    }
    return maskWhere(objectIds, [&](std::uint32_t id) {
        return id > 0 && id <= emits.size() && emits[id - 1] != 0;
    });
}

}  // namespace clerestory
