#include "plan/request/filter_request.h"

#include <type_traits>

namespace clerestory {
namespace {

constexpr KernelNumbers kIdentity{0, 0, 0, 0, 1, 0, 0, 0, 0};

std::string reasonToLeaveOut(const TwirlFilter& filter) {
    if (filter.amount == 0.0) return "an amount of 0 changes nothing";
    if (filter.radius == 0.0) return "a radius of 0 contains no pixel";
    return {};
}

std::string reasonToLeaveOut(const ConvolveFilter& filter) {
    const auto* numbers = std::get_if<KernelNumbers>(&filter.kernel);
    return numbers && *numbers == kIdentity ? "the kernel is the identity" : "";
}

std::string reasonToLeaveOut(const GlowFilter& filter) {
    if (filter.strength == 0.0) return "a strength of 0 spreads nothing";
    if (filter.radius <= 1.0) return "a radius of at most one pixel spreads nothing";
    return {};
}

}  // namespace

KernelNumbers numbersOf(KernelName name) {
    constexpr double n = 1.0 / 9.0, s = 1.0 / 16.0;
    switch (name) {
        case KernelName::sharpen:
            return {0, -1, 0, -1, 5, -1, 0, -1, 0};
        case KernelName::box:
            return {n, n, n, n, n, n, n, n, n};
        case KernelName::gaussian:
            return {s, 2 * s, s, 2 * s, 4 * s, 2 * s, s, 2 * s, s};
        // The picture plus its gradient away from that corner.
        case KernelName::embossNorthWest:
            return {-1, -1, 0, -1, 1, 1, 0, 1, 1};
        case KernelName::embossNorthEast:
            return {0, -1, -1, 1, 1, -1, 1, 1, 0};
        case KernelName::embossSouthEast:
            return {1, 1, 0, 1, 1, -1, 0, -1, -1};
        case KernelName::embossSouthWest:
            return {0, 1, 1, -1, 1, 1, -1, -1, 0};
    }
    return kIdentity;
}

std::string_view typeOf(const FilterRequest& filter) {
    return std::visit([](const auto& held) { return std::decay_t<decltype(held)>::kType; }, filter);
}

std::string reasonToLeaveOut(const FilterRequest& filter) {
    return std::visit([](const auto& held) { return reasonToLeaveOut(held); }, filter);
}

}  // namespace clerestory
