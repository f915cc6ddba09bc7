// The switch of a request to which a pass, a decision or an omission belongs.
#pragma once

#include <cstdint>
#include <string_view>

namespace clerestory {

enum class Effect {
    base,
    emission,
    refraction,
    planarReflection,
    environmentReflection,
    materialLayers,
    shadows,
    indirectLight,
    filters
};
std::string_view nameOf(Effect effect);

}  // namespace clerestory
