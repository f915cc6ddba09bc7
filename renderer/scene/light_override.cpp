#include "scene/light_override.h"

#include "scene/spelling.h"

#include <algorithm>
#include <string_view>

namespace clerestory {

std::vector<FieldError> problems(const Scene& scene, const std::vector<LightOverride>& overrides,
                                 const std::string& pointer) {
    std::vector<FieldError> errors;
    if (overrides.empty()) return errors;
    const std::vector<std::string_view> known = namesOf(scene.lights);
    for (std::size_t i = 0; i < overrides.size(); ++i) {
        const std::optional<std::string>& name = overrides[i].light;
        if (!name || std::binary_search(known.begin(), known.end(), std::string_view(*name))) {
            continue;
        }
        errors.push_back({pointer + "/" + std::to_string(i) + "/light",
                          "the scene has no light of this name" + didYouMean(*name, known),
                          known.empty() ? "no light has a name" : listedNearest(*name, known)});
    }
    return errors;
}

std::vector<Light> lightsWith(std::vector<Light> lights,
                              const std::vector<LightOverride>& overrides) {
    for (const LightOverride& o : overrides) {
        for (Light& light : lights) {
            if (o.light && light.name != *o.light) continue;
            if (o.radius) light.radius = static_cast<float>(*o.radius);
        }
    }
    return lights;
}

}  // namespace clerestory
