#include "scene/name_pattern.h"

#include "scene/spelling.h"

namespace clerestory {

// The last `*` takes one character more where what follows it does not fit: an earlier one need not
// be tried again.
bool matchesName(std::string_view pattern, std::string_view name) {
    constexpr std::size_t kNowhere = std::string_view::npos;
    std::size_t p = 0, n = 0, star = kNowhere, taken = 0;
    while (n < name.size()) {
        if (p < pattern.size() && pattern[p] == '*') {
            star = p++;
            taken = n;
        } else if (p < pattern.size() && pattern[p] == name[n]) {
            ++p;
            ++n;
        } else if (star != kNowhere) {
            p = star + 1;
            n = ++taken;
        } else {
            return false;
        }
    }
    return pattern.find_first_not_of('*', p) == kNowhere;
}

FieldError matchesNoNode(std::string pointer, std::string_view pattern,
                         const std::vector<std::string_view>& names) {
    return {std::move(pointer),
            "the pattern \"" + std::string(pattern) + "\" matches no node of the scene",
            names.empty() ? "no node has a name" : "names: " + listedNearest(pattern, names)};
}

}  // namespace clerestory
