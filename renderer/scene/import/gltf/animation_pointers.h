// Targets of animations as JSON Pointers (KHR_animation_pointer, and the pointers of the glTF
// object model): what of the scene they move.
//
//     animatedBy("/materials/2/emissiveFactor")  // {material, 2, "emissive"}
//
// Known are the node properties that channels without pointers have, KHR_node_visibility, factors
// of materials and texture transforms, and those of punctual lights and cameras.
#pragma once

#include "scene/animation.h"

#include <optional>
#include <string>
#include <string_view>

namespace clerestory {

struct PointerTarget {
    AnimatedProperty property = AnimatedProperty::translation;
    Index index = 0;    // of the file's node, material, light or camera
    std::string field;  // of Track; empty for nodes
};
// Nothing for a pointer that is none of these.
std::optional<PointerTarget> animatedBy(std::string_view pointer);

}  // namespace clerestory
