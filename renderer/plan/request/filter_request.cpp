#include "plan/request/filter_request.h"

#include <algorithm>
#include <set>
#include <string_view>

namespace clerestory {
namespace {

constexpr KernelNumbers kIdentity{0, 0, 0, 0, 1, 0, 0, 0, 0};

struct TypeRules {
    const char* article;
    std::set<std::string_view> fields;
    std::vector<std::string_view> needed;
    const char* allowed;
};

TypeRules rulesOf(FilterType type) {
    switch (type) {
        case FilterType::twirl:
            return {"a twirl", {"amount", "radius"}, {"amount"}, "type, amount, radius"};
        case FilterType::convolve:
            return {"a convolution", {"kernel", "edge"}, {"kernel"}, "type, kernel, edge"};
        case FilterType::glow:
            return {"a glow",
                    {"threshold", "strength", "radius"},
                    {},
                    "type, threshold, strength, radius"};
    }
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
        // The picture itself, and how much brighter it grows away from that corner.
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

std::vector<FieldError> problems(const std::vector<FilterRequest>& filters,
                                 const std::string& pointer) {
    std::vector<FieldError> errors;
    for (std::size_t i = 0; i < filters.size(); ++i) {
        FilterRequest filter = filters[i];  // the tables visit values that may be written
        const std::string at = pointer + "/" + std::to_string(i);
        if (!filter.type) {
            errors.push_back({at + "/type", "is missing", "twirl, convolve or glow"});
            continue;
        }
        const TypeRules rules = rulesOf(*filter.type);
        fields(filter, [&](std::string_view name, const auto& member, const auto&, const char*) {
            const std::string field = at + "/" + std::string(name);
            const auto is = [&](std::string_view other) { return other == name; };
            if (name == "type") return;
            if (member.has_value() && !rules.fields.contains(name)) {
                errors.push_back(
                    {field, std::string("is no field of ") + rules.article, rules.allowed});
            }
            if (!member.has_value() && std::any_of(rules.needed.begin(), rules.needed.end(), is)) {
                errors.push_back({field, "is missing",
                                  std::string("what ") + rules.article + " cannot do without"});
            }
        });
    }
    return errors;
}

std::string reasonToLeaveOut(const FilterRequest& filter) {
    switch (*filter.type) {
        case FilterType::twirl:
            if (*filter.amount == 0.0) return "an amount of 0 turns nothing";
            if (filter.radius == 0.0) return "a radius of 0 holds nothing";
            break;
        case FilterType::convolve: {
            const auto* numbers = std::get_if<KernelNumbers>(&*filter.kernel);
            if (numbers && *numbers == kIdentity) return "the kernel keeps each pixel as it is";
            break;
        }
        case FilterType::glow:
            if (filter.strength == 0.0) return "a strength of 0 spreads nothing";
            if (filter.radius && *filter.radius <= 1.0) {
                return "a radius of at most a pixel spreads nothing";
            }
            break;
    }
    return {};
}

}  // namespace clerestory
