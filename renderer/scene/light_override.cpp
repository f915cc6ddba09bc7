#include "scene/light_override.h"

#include "scene/spelling.h"

#include <algorithm>
#include <string_view>

namespace clerestory {
namespace {

float greatest(const glm::vec3& c) {
    return std::max({c.x, c.y, c.z});
}

void apply(const LightOverride& o, Light& light) {
    if (o.color || o.intensity) {
        const float own = greatest(light.intensity);
        const glm::dvec3 color =
            o.color.value_or(own > 0.0f ? glm::dvec3(light.intensity / own) : glm::dvec3(1.0));
        light.intensity = glm::vec3(color * o.intensity.value_or(double{own}));
    }
    if (o.position) light.worldPosition = *o.position;
    if (o.direction) light.worldDirection = glm::normalize(*o.direction);
    if (o.range) light.range = static_cast<float>(*o.range);
    if (o.innerConeAngle) light.innerConeAngle = static_cast<float>(*o.innerConeAngle);
    if (o.outerConeAngle) light.outerConeAngle = static_cast<float>(*o.outerConeAngle);
    if (o.radius) light.radius = static_cast<float>(*o.radius);
}

Light added(const LightOverride& o) {
    Light light{.name = o.light.value_or(""), .kind = *o.type};
    apply(o, light);
    return light;
}

std::string_view nameOf(LightKind kind) {
    switch (kind) {
        case LightKind::point:
            return "point";
        case LightKind::spot:
            return "spot";
        case LightKind::directional:
            return "directional";
    }
    return "";
}

class Checks {
public:
    Checks(const LightOverride& o, std::string at, std::vector<FieldError>& errors)
        : o_(o), at_(std::move(at)), errors_(errors) {}

    void run() {
        const bool aims = o_.type && *o_.type != LightKind::point;
        const bool stands = o_.type && *o_.type != LightKind::directional;
        if (stands && !o_.position) refuse("position", "is missing", "where the new light is");
        if (aims && !o_.direction) refuse("direction", "is missing", "where the new light points");
        if (o_.direction && *o_.direction == glm::dvec3(0.0)) {
            refuse("direction", "has zero length", "a direction");
        }
        if (o_.innerConeAngle && o_.outerConeAngle && *o_.innerConeAngle > *o_.outerConeAngle) {
            refuse("innerConeAngle", "is greater than outerConeAngle", "at most outerConeAngle");
        }
        const bool any = o_.enabled || o_.color || o_.intensity || o_.position || o_.direction ||
                         o_.range || o_.innerConeAngle || o_.outerConeAngle || o_.radius;
        if (!o_.type && !any) refuse("", "changes nothing", "a type, or another field of a light");
    }

private:
    void refuse(const char* field, const char* detail, const char* allowed) {
        errors_.push_back({*field ? at_ + "/" + field : at_, detail, allowed});
    }
    const LightOverride& o_;
    std::string at_;
    std::vector<FieldError>& errors_;
};

}  // namespace

std::vector<FieldError> problems(const Scene& scene, const std::vector<LightOverride>& overrides,
                                 const std::string& pointer) {
    std::vector<FieldError> errors;
    if (overrides.empty()) return errors;
    std::vector<std::string_view> known = namesOf(scene.lights);
    for (std::size_t i = 0; i < overrides.size(); ++i) {
        const std::string at = pointer + "/" + std::to_string(i);
        Checks(overrides[i], at, errors).run();
        const std::optional<std::string>& name = overrides[i].light;
        if (!name) continue;
        const auto place = std::lower_bound(known.begin(), known.end(), std::string_view(*name));
        const bool isKnown = place != known.end() && *place == *name;
        if (isKnown) continue;
        if (overrides[i].type) {
            known.insert(place, *name);
            continue;
        }
        errors.push_back({at + "/light",
                          "the scene has no light of this name" + didYouMean(*name, known),
                          known.empty() ? "no light has a name" : listedNearest(*name, known)});
    }
    return errors;
}

std::vector<Light> lightsWith(std::vector<Light> lights,
                              const std::vector<LightOverride>& overrides) {
    std::vector<bool> on(lights.size(), true);
    for (const LightOverride& o : overrides) {
        if (o.type) {
            lights.push_back(added(o));
            on.push_back(o.enabled.value_or(true));
            continue;
        }
        for (std::size_t i = 0; i < lights.size(); ++i) {
            if (o.light && lights[i].name != *o.light) continue;
            apply(o, lights[i]);
            if (o.enabled) on[i] = *o.enabled;
        }
    }
    for (std::size_t i = 0; i < lights.size(); ++i) {
        if (!on[i]) lights[i].intensity = glm::vec3(0.0f);
    }
    return lights;
}

std::vector<std::string> explained(const std::vector<LightOverride>& overrides) {
    std::vector<std::string> lines;
    for (const LightOverride& o : overrides) {
        const std::string name = o.light ? "light " + *o.light : o.type ? "a light" : "all lights";
        const bool off = o.enabled && !*o.enabled;
        lines.push_back(
            name +
            (o.type ? ": added, " + std::string(nameOf(*o.type)) : std::string(": changed")) +
            (off ? ", off" : ""));
    }
    return lines;
}

glm::dmat4 placeOf(const Light& light, const Pose& pose) {
    glm::dmat4 place = light.node == kNone ? glm::dmat4(1.0) : pose.worldFromNode[light.node];
    if (light.worldPosition) place[3] = glm::dvec4(*light.worldPosition, 1.0);
    if (light.worldDirection) {
        const glm::dvec3 z = -*light.worldDirection;
        const glm::dvec3 other =
            std::abs(z.y) < 0.9 ? glm::dvec3(0.0, 1.0, 0.0) : glm::dvec3(1.0, 0.0, 0.0);
        const glm::dvec3 x = glm::normalize(glm::cross(other, z));
        place[0] = glm::dvec4(x, 0.0);
        place[1] = glm::dvec4(glm::cross(z, x), 0.0);
        place[2] = glm::dvec4(z, 0.0);
    }
    return place;
}

}  // namespace clerestory
