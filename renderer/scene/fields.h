// Kinds of fields. Each struct that clients or files fill has one table, fields(value, visit),
// which calls visit(name, member, kind, description) for every field. The reader, the checks, the
// JSON schema, the page and the documents use this table.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace clerestory {

struct Range {  // numbers, and each component of a vector
    double min, max;
    const char* unit = nullptr;  // plural, such as "pixels"; `x-unit` in the schema
};
struct Text {
    std::size_t maxLength;
};
struct Flag {};
struct Nested {};        // a struct that has a fields() table
struct Rotation {};      // a Quaternion, given in any form of scene/rotation.h
struct NestedPreset {};  // the same, which may also be given as the name of its preset
struct NestedList {      // a list of such structs
    std::size_t maxItems;
};
struct NestedPresetList {  // each of which may also be given as the name of its preset
    std::size_t maxItems;
};
// A list of std::variant<S...>. The member `type` of each element selects the alternative whose
// S::kType it equals.
struct NestedUnionList {
    std::size_t maxItems;
    const char* name;  // of the union in the schema; an alternative is the type followed by it
};
// A field that must be present.
template <class Kind>
struct Required {
    Kind kind;
};
template <class Kind>
Required(Kind) -> Required<Kind>;
template <class E>
struct Choice {
    // The allowed words with their values, in the order of the documents.
    std::vector<std::pair<std::string_view, E>> words;
};

// One of the words, or an array of numbers, each within the range.
template <class E>
struct ChoiceOrNumbers {
    Choice<E> choice;
    Range range;
};

struct FieldError {
    std::string pointer;  // JSON Pointer (RFC 6901) into the request
    std::string detail;   // what was wrong
    std::string allowed;  // what would be right
    bool operator==(const FieldError&) const = default;
};

}  // namespace clerestory
