// What a pass, a decision or an omission belongs to: the requested view, or one object, map or
// filter.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace clerestory {

struct Subject {
    enum class Kind {
        view,         // the requested view as a whole
        environment,  // environment map that lights the scene
        map,          // environment map that a material names
        mirror,       // flat mirror
        probe,        // captured cube
        glass,        // glass object
        lights,       // punctual lights
        filter,       // post-filter
    };
    Kind kind = Kind::view;
    // Of the object or map, or the type of the filter; empty for the view, except for one of
    // several views of a lens.
    std::string name;
    std::uint32_t index = 0;  // of a filter: its position in the request
    bool operator==(const Subject&) const = default;
};
std::string_view nameOf(Subject::Kind kind);

// Identifies the subject within a plan: "mirror:floor", "filter0:glow"; "surface" for the view,
// "surface:left" for one of several.
std::string nameOf(const Subject& subject);

}  // namespace clerestory
