#include "light/surface_light.h"

#include <glm/gtc/packing.hpp>

#include <algorithm>
#include <cmath>

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
             pair(l.visible.y, l.visible.z), pair(l.sides.x, l.sides.y)}};
}

LightAtVertex unpacked(const LightValue& value) {
    glm::vec2 h[8];
    for (int i = 0; i < 8; ++i) h[i] = glm::unpackHalf2x16(value.halves[i]);
    return {.irradiance = {h[0].x, h[0].y, h[1].x},
            .turned = {h[4].x, h[4].y, h[5].x, h[3].y},
            .visible = {h[5].y, h[6].x, h[6].y, h[3].x},
            .nearby = {h[1].y, h[2].x, h[2].y},
            .sides = h[7]};
}

EmittersValue packed(const EmittersAtVertex& e) {
    return {{pair(e.light.r, e.light.g), pair(e.light.b, e.flux.x), pair(e.flux.y, e.flux.z), 0u}};
}

EmittersAtVertex unpacked(const EmittersValue& value) {
    glm::vec2 h[3];
    for (int i = 0; i < 3; ++i) h[i] = glm::unpackHalf2x16(value.halves[i]);
    return {.light = {h[0].x, h[0].y, h[1].x}, .flux = {h[1].y, h[2].x, h[2].y}};
}

LightAtVertex ofBothSides(const SideLight& front, const SideLight& back, const glm::vec3& normal,
                          const glm::vec3& nearby) {
    const glm::vec3 ahead(front.visible);
    const glm::vec3 behind = glm::reflect(glm::vec3(back.visible), normal);
    const float a = glm::dot(ahead, ahead), b = glm::dot(behind, behind);
    const float both = glm::dot(ahead, behind) / std::max({a, b, 1e-20f});
    return {.irradiance = front.irradiance,
            .turned = glm::vec4(back.irradiance, back.visible.w),
            .visible = glm::vec4(a >= b ? ahead : behind, front.visible.w + kOfSides),
            .nearby = nearby,
            .sides = a >= b ? glm::vec2(1.0f, both) : glm::vec2(both, 1.0f)};
}

glm::dvec3 LightGrid::point(std::size_t i) const {
    const glm::dvec3 at(static_cast<double>(i % count.x),
                        static_cast<double>(i / count.x % count.y),
                        static_cast<double>(i / count.x / count.y));
    return first + spacing * at;
}

LightGrid gridOver(const Bounds& bounds, std::uint32_t cells) {
    constexpr double kMaxAlong = 64.0;
    LightGrid grid;
    if (bounds.empty() || cells == 0) return grid;
    const glm::dvec3 size = glm::dvec3(bounds.max) - glm::dvec3(bounds.min);
    const double least = std::max({size.x, size.y, size.z, 1e-30}) / kMaxAlong;
    const glm::dvec3 thick = glm::max(size, glm::dvec3(least));
    const double edge = std::cbrt(thick.x * thick.y * thick.z / cells);
    const glm::dvec3 along = glm::clamp(glm::round(thick / edge), 1.0, kMaxAlong);
    grid.count = glm::uvec3(along);
    grid.spacing = thick / along;
    grid.first =
        0.5 * (glm::dvec3(bounds.min) + glm::dvec3(bounds.max)) - 0.5 * thick + 0.5 * grid.spacing;
    grid.values.resize(grid.points());
    return grid;
}

LightAtVertex lightAt(const LightGrid& grid, const glm::dvec3& position) {
    const glm::dvec3 last = glm::dvec3(grid.count) - 1.0;
    const glm::dvec3 at = glm::clamp((position - grid.first) / grid.spacing, glm::dvec3(0.0), last);
    const glm::uvec3 low(glm::min(glm::floor(at), glm::max(last - 1.0, 0.0)));
    const glm::dvec3 part = at - glm::dvec3(low);
    LightAtVertex sum{.turned = glm::vec4(0.0f), .visible = glm::vec4(0.0f)};
    for (std::uint32_t corner = 0; corner < 8; ++corner) {
        const glm::uvec3 step(corner & 1u, corner >> 1 & 1u, corner >> 2);
        double weight = 1.0;
        for (int axis = 0; axis < 3; ++axis) {
            weight *= step[axis] != 0 ? part[axis] : 1.0 - part[axis];
        }
        if (!(weight > 0.0)) continue;
        const glm::uvec3 p = glm::min(low + step, grid.count - 1u);
        const LightAtVertex l = unpacked(
            grid.values[p.x + std::size_t{grid.count.x} * (p.y + std::size_t{grid.count.y} * p.z)]);
        const auto w = static_cast<float>(weight);
        sum.irradiance += w * l.irradiance;
        sum.turned += w * l.turned;
        sum.visible += w * l.visible;
        sum.nearby += w * l.nearby;
        sum.sides += w * l.sides;
    }
    return sum;
}

std::vector<LightValue> lightOfMoving(const SurfaceLight& light, const Pose& pose) {
    std::vector<LightValue> values;
    for (const std::uint32_t i : light.moving) {
        const Instance& instance = light.scene->instances[i];
        const Bounds& bounds = boundsOf(pose, light.scene->meshes[instance.mesh]);
        const glm::dvec4 centre(0.5 * (glm::dvec3(bounds.min) + glm::dvec3(bounds.max)), 1.0);
        values.push_back(
            packed(lightAt(light.grid, glm::dvec3(pose.worldFromNode[instance.node] * centre))));
    }
    return values;
}

}  // namespace clerestory::light
