// Filters on the finished picture, as a client asks for them: twirl, convolution, glow. All of them
// work on linear light, in the request's order, after everything is drawn and before tone mapping.
#pragma once

#include "scene/fields.h"

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace clerestory {

enum class FilterType { twirl, convolve, glow };
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

// Only the fields of its type may be set; problems() says which others are.
struct FilterRequest {
    std::optional<FilterType> type;
    std::optional<double> amount;                                   // twirl
    std::optional<double> radius;                                   // twirl, glow
    std::optional<std::variant<KernelName, KernelNumbers>> kernel;  // convolve
    std::optional<EdgeRule> edge;                                   // convolve
    std::optional<double> threshold;                                // glow
    std::optional<double> strength;                                 // glow
    bool operator==(const FilterRequest&) const = default;
};

inline constexpr std::size_t kMaxFilters = 8;
inline constexpr double kDefaultGlowThreshold = 1.0;
inline constexpr double kDefaultGlowStrength = 0.5;
inline constexpr double kDefaultGlowRadius = 32.0;

template <class V>
void fields(FilterRequest& f, V&& visit) {
    visit("type", f.type,
          Choice<FilterType>{{{"twirl", FilterType::twirl},
                              {"convolve", FilterType::convolve},
                              {"glow", FilterType::glow}}},
          "which filter; needed");
    visit(
        "amount", f.amount, Range{-100, 100},
        "twirl, needed: clockwise turn in radians per picture height of distance from the centre; "
        "0 changes nothing");
    visit("radius", f.radius, Range{0, 8192},
          "pixels. twirl: beyond it nothing changes; no limit when absent. glow: how far light "
          "spreads (32)");
    visit("kernel", f.kernel,
          ChoiceOrNumbers<KernelName>{{{{"sharpen", KernelName::sharpen},
                                        {"box", KernelName::box},
                                        {"gaussian", KernelName::gaussian},
                                        {"embossNorthWest", KernelName::embossNorthWest},
                                        {"embossNorthEast", KernelName::embossNorthEast},
                                        {"embossSouthEast", KernelName::embossSouthEast},
                                        {"embossSouthWest", KernelName::embossSouthWest}}},
                                      Range{-1000, 1000}},
          "convolve, needed: a name, or nine numbers row by row from the top left, taken as they "
          "are");
    visit("edge", f.edge,
          Choice<EdgeRule>{{{"clamp", EdgeRule::clamp}, {"repeat", EdgeRule::repeat}}},
          "convolve: what lies beyond the border: its nearest pixel (clamp), or the other side");
    visit("threshold", f.threshold, Range{0, 65504},
          "glow: brightness, after exposure, above which light spreads (1, where a linear display "
          "is white)");
    visit("strength", f.strength, Range{0, 1}, "glow: share of that light that spreads (0.5)");
}

// The numbers of a named kernel. Smoothing ones add up to 1, and so do the others: what is even
// stays as it is.
KernelNumbers numbersOf(KernelName name);

// What no single field can know, with pointers that begin with `pointer`.
std::vector<FieldError> problems(const std::vector<FilterRequest>& filters,
                                 const std::string& pointer = "/filters");

// Why the filter cannot change a bit of any picture; empty when it can. The filter is sound.
std::string reasonToLeaveOut(const FilterRequest& filter);

}  // namespace clerestory
