#include "plan/request/view_settings.h"

#include "scene/hash.h"

#include <algorithm>
#include <optional>

namespace clerestory {
namespace {

template <class T>
void addField(PlanHash& hash, const T& value) {
    hash.add(value);
}
template <class T>
void addField(PlanHash& hash, const std::optional<T>& value) {
    hash.add(value.has_value());
    if (value) hash.add(*value);
}

template <class Struct>
void addFields(PlanHash& hash, Struct value) {
    fields(value, [&](std::string_view, const auto& field, auto&&...) { addField(hash, field); });
}

}  // namespace

glm::dmat3 worldFromMap(const FrameRequest& request, const Scene& scene) {
    glm::dquat rotation = scene.environmentRotation;
    if (const auto& q = request.environment.rotation) {
        rotation = glm::dquat((*q)[3], (*q)[0], (*q)[1], (*q)[2]);
    }
    return glm::mat3_cast(glm::normalize(rotation));
}

ViewSettings viewSettings(const FrameRequest& request, const Scene& scene,
                          std::uint32_t maxAnisotropy) {
    ViewSettings settings;
    settings.effects = request.effects;
    settings.accuracy = request.accuracy;
    settings.accuracy.anisotropy =
        std::min(request.accuracy.anisotropy, std::max(1u, maxAnisotropy));
    settings.skyVisible = request.environment.visible;
    settings.environmentIntensity = static_cast<float>(request.environment.intensity);
    settings.mapFromWorld = glm::transpose(worldFromMap(request, scene));
    settings.pointSize = static_cast<float>(request.pointSize);

    const Accuracy defaults;
    settings.accuracy.samples = defaults.samples;
    settings.accuracy.sampleShare = defaults.sampleShare;
    settings.accuracy.edgeFilter = defaults.edgeFilter;
    settings.accuracy.generations = defaults.generations;
    settings.accuracy.maxMilliseconds = defaults.maxMilliseconds;
    settings.accuracy.maxError = defaults.maxError;
    return settings;
}

ViewSettings captureSettings(ViewSettings settings) {
    settings.effects.environmentReflection = true;  // without it nothing is captured
    settings.accuracy.curvedSamples = Accuracy{}.curvedSamples;
    settings.accuracy.emitterCoverage = Accuracy{}.emitterCoverage;
    return settings;
}

std::uint64_t hashOf(const ViewSettings& settings) {
    const auto& [effects, accuracy, skyVisible, environmentIntensity, mapFromWorld, pointSize] =
        settings;
    PlanHash hash;
    addFields(hash, effects);
    addFields(hash, accuracy);
    hash.add(skyVisible);
    hash.add(environmentIntensity);
    hash.add(mapFromWorld);
    hash.add(pointSize);
    return hash.value();
}

}  // namespace clerestory
