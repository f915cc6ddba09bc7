// Which switch of a request a pass, a decision or an omission belongs to.
#pragma once

#include <cstdint>
#include <string_view>

namespace clerestory {

enum class Effect { base, emission, refraction, planarReflection, environmentReflection, filters };
std::string_view nameOf(Effect effect);

}  // namespace clerestory
