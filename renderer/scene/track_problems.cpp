// The checks of tracks: they need the fields of what a track animates.
#include "scene/animated_field.h"
#include "scene/animation.h"
#include "scene/scene.h"

#include <algorithm>
#include <cmath>

namespace clerestory {

std::size_t componentsOf(AnimatedProperty property, std::string_view field) {
    switch (property) {
        case AnimatedProperty::rotation:
            return 4;
        case AnimatedProperty::weights:
            return 0;
        case AnimatedProperty::visible:
            return 1;
        case AnimatedProperty::material:
            return componentsOf(Material{}, field);
        case AnimatedProperty::light:
            return componentsOf(LightFactors{}, field);
        case AnimatedProperty::camera:
            return componentsOf(Camera{}, field);
        default:
            return 3;
    }
}

bool isValid(const Track& track, std::size_t targets) {
    const auto inRange = [](float v) { return std::abs(v) <= kMaxKey; };  // false for a NaN
    const std::size_t parts = track.interpolation == Interpolation::cubicSpline ? 3 : 1;
    const std::size_t keys = track.times.size(), n = track.components();
    return track.target < targets && keys > 0 && n > 0 && track.values.size() == keys * parts * n &&
           (track.property == AnimatedProperty::weights ||
            n == componentsOf(track.property, track.field)) &&
           std::all_of(track.values.begin(), track.values.end(), inRange) &&
           std::all_of(track.times.begin(), track.times.end(),
                       [&](float t) { return inRange(t) && t >= 0.0f; }) &&
           std::is_sorted(track.times.begin(), track.times.end());
}

}  // namespace clerestory
