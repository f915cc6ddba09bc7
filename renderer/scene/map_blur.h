// A Gaussian blur of a captured or loaded environment map.
#pragma once

#include "scene/fields.h"

#include <concepts>
#include <cstdint>
#include <type_traits>

namespace clerestory {

// The kernel covers 2 size + 1 texels in each direction. `size` and the standard deviation are in
// texels at the centre of a face. No blur if either is 0.
struct MapBlur {
    std::uint32_t size = 0;
    double stdev = 0.0;
    bool changes() const { return size > 0 && stdev > 0.0; }
    bool operator==(const MapBlur&) const = default;
};

inline constexpr std::uint32_t kLargestBlur = 64;

template <class B, class V>
requires std::same_as<std::remove_const_t<B>, MapBlur>
void fields(B& b, V&& visit) {
    visit("size", b.size, Range{0, kLargestBlur},
          "half-width of the kernel, texels: 2 size + 1 along each direction; 0: none");
    visit("stdev", b.stdev, Range{0, kLargestBlur}, "standard deviation, texels; 0: none");
}

}  // namespace clerestory
