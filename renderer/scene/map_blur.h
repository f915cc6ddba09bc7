// A Gaussian blur that a captured or stored map asks for.
#pragma once

#include "scene/fields.h"

#include <concepts>
#include <cstdint>
#include <type_traits>

namespace clerestory {

// Over 2 size + 1 texels along each direction, weights that fall with the standard deviation, both
// in texels in the middle of a face. None where either is 0.
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
