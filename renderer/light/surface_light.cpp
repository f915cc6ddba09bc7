#include "light/surface_light.h"

#include <glm/gtc/packing.hpp>

#include <algorithm>

namespace clerestory::light {
namespace {

constexpr float kMaxHalf = 65504.0f;

std::uint32_t pair(float a, float b) {
    return glm::packHalf2x16(glm::clamp(glm::vec2(a, b), -kMaxHalf, kMaxHalf));
}

}  // namespace

LightValue packed(const LightAtVertex& l) {
    return {{pair(l.irradiance.r, l.irradiance.g), pair(l.irradiance.b, l.nearby.r),
             pair(l.nearby.g, l.nearby.b), pair(l.visible.w, l.turned.w),
             pair(l.turned.x, l.turned.y), pair(l.turned.z, l.visible.x),
             pair(l.visible.y, l.visible.z), 0u}};
}

LightAtVertex unpacked(const LightValue& value) {
    glm::vec2 h[8];
    for (int i = 0; i < 8; ++i) h[i] = glm::unpackHalf2x16(value.halves[i]);
    return {.irradiance = {h[0].x, h[0].y, h[1].x},
            .turned = {h[4].x, h[4].y, h[5].x, h[3].y},
            .visible = {h[5].y, h[6].x, h[6].y, h[3].x},
            .nearby = {h[1].y, h[2].x, h[2].y}};
}

}  // namespace clerestory::light
