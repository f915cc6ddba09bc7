#include "measures/mask.h"

#include "scene/classification.h"

#include <algorithm>
#include <functional>
#include <stdexcept>

namespace clerestory {
namespace {

// Numbers of a channel are whole; the half is room for none of them.
Mask maskWhere(const Image& numbers, const std::function<bool(std::uint32_t)>& counts) {
    if (numbers.channels != 1 || numbers.type != PixelType::float32) {
        throw std::runtime_error("a mask is made of a channel of numbers: one float a pixel");
    }
    Mask mask{.width = numbers.width, .height = numbers.height};
    mask.inside.resize(std::size_t(numbers.width) * numbers.height);
    for (std::size_t i = 0; i < mask.inside.size(); ++i) {
        const float number = numbers.floats()[i];
        const bool valid = number >= 0.0f && number < 16777216.0f;  // 2^24: floats count that far
        mask.inside[i] = valid && counts(static_cast<std::uint32_t>(number + 0.5f));
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
    return maskWhere(through, [effect](std::uint32_t is) {
        switch (effect) {
            case Effect::base:
                return is == throughDirect;
            case Effect::refraction:
                return is == throughGlass;
            case Effect::planarReflection:
                return is >= throughFirstMirror;
            case Effect::environmentReflection:
                return is == throughCubeOrRays || is == throughEnvironment;
            case Effect::emission:
            case Effect::filters:
                break;
        }
        return false;
    });
}

Mask emissionMask(const Image& objectIds, const Scene& scene, const MaterialBindings& materials) {
    std::vector<std::uint8_t> glows(scene.instances.size(), 0);
    for (const Surface& surface : surfacesOf(scene, materials)) {
        if (surface.emitter) glows[surface.instance] = 1;
    }
    return maskWhere(objectIds, [&](std::uint32_t id) {
        return id > 0 && id <= glows.size() && glows[id - 1] != 0;
    });
}

}  // namespace clerestory
