// The curve by which radiance becomes display colour.
#pragma once

namespace clerestory {

enum class ToneMap { neutral, aces, linear };

}  // namespace clerestory
