// Patterns of names: `*` matches any characters, also none; every other character itself.
//
//     matchesName("wheel *", "wheel front left")  // true
//     matchesName("lid", "Lid")                   // false
#pragma once

#include "scene/fields.h"

#include <string>
#include <string_view>
#include <vector>

namespace clerestory {

inline bool isNamePattern(std::string_view text) {
    return text.find('*') != std::string_view::npos;
}

// Takes at most as many steps as the product of both lengths.
bool matchesName(std::string_view pattern, std::string_view name);

// The error that a pattern matches none of the nodes, whose names (namesOf()) it lists.
FieldError matchesNoNode(std::string pointer, std::string_view pattern,
                         const std::vector<std::string_view>& names);

}  // namespace clerestory
