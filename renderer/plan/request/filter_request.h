// Filters that a client requests: twirl, convolution, glow. They process linear light in the order
// of the request, after the scene is drawn and before tone mapping.
//
// A new filter needs a struct with kType and fields() here, an overload of reasonToLeaveOut(), and
// its passes; CONTRIBUTING.md lists the steps.
#pragma once

#include "scene/fields.h"

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace clerestory {

enum class KernelName {
    sharpen,
    box,
    gaussian,
    embossNorthWest,
    embossNorthEast,
    embossSouthEast,
    embossSouthWest
};
enum class EdgeRule { clamp, repeat };

// Nine numbers, row by row, first row on top.
using KernelNumbers = std::array<double, 9>;

// A filter is a struct with the word of its `type` and a field table.
struct TwirlFilter {
    static constexpr std::string_view kType = "twirl";
    double amount = 0.0;
    std::optional<double> radius;  // none: no limit
    bool operator==(const TwirlFilter&) const = default;
};

struct ConvolveFilter {
    static constexpr std::string_view kType = "convolve";
    std::variant<KernelName, KernelNumbers> kernel = KernelName::sharpen;
    EdgeRule edge = EdgeRule::clamp;
    bool operator==(const ConvolveFilter&) const = default;
};

struct GlowFilter {
    static constexpr std::string_view kType = "glow";
    double radius = 32.0;
    double threshold = 1.0;
    double strength = 0.5;
    bool operator==(const GlowFilter&) const = default;
};

using FilterRequest = std::variant<TwirlFilter, ConvolveFilter, GlowFilter>;

inline constexpr std::size_t kMaxFilters = 8;

template <class V>
void fields(TwirlFilter& f, V&& visit) {
    visit("amount", f.amount, Required{Range{-100, 100}},
          "clockwise turn in radians per picture height of distance from the centre; 0 changes "
          "nothing");
    visit("radius", f.radius, Range{0, 8192, "pixels"},
          "distance from the centre beyond which nothing changes; no limit when absent");
}

template <class V>
void fields(ConvolveFilter& f, V&& visit) {
    visit("kernel", f.kernel,
          Required{ChoiceOrNumbers<KernelName>{{{{"sharpen", KernelName::sharpen},
                                                 {"box", KernelName::box},
                                                 {"gaussian", KernelName::gaussian},
                                                 {"embossNorthWest", KernelName::embossNorthWest},
                                                 {"embossNorthEast", KernelName::embossNorthEast},
                                                 {"embossSouthEast", KernelName::embossSouthEast},
                                                 {"embossSouthWest", KernelName::embossSouthWest}}},
                                               Range{-1000, 1000}}},
          "a name, or nine weights row by row from the top left, used unchanged");
    visit(
        "edge", f.edge,
        Choice<EdgeRule>{{{"clamp", EdgeRule::clamp}, {"repeat", EdgeRule::repeat}}},
        "pixels beyond the border: the nearest one inside (clamp), or the opposite side (repeat)");
}

template <class V>
void fields(GlowFilter& f, V&& visit) {
    visit("radius", f.radius, Range{0, 8192, "pixels"}, "distance over which light spreads");
    visit("threshold", f.threshold, Range{0, 65504},
          "brightness after exposure above which light spreads; 1 is white on a linear display");
    visit("strength", f.strength, Range{0, 1}, "fraction of that light that spreads");
}

// `type` of the filter.
std::string_view typeOf(const FilterRequest& filter);

// The weights of a named kernel. They add up to 1, so that a uniform picture is unchanged.
KernelNumbers numbersOf(KernelName name);

// Returns why the filter changes no pixel of any picture; empty if it can change one.
std::string reasonToLeaveOut(const FilterRequest& filter);

}  // namespace clerestory
