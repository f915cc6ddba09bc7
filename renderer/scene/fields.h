// Kinds of fields. Each struct that clients or files fill has one table, fields(value, visit),
// which calls visit(name, member, kind, description) for every field. The reader, the checks, the
// JSON schema, the page and the documents use this table.
#pragma once

#include <glm/glm.hpp>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
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
struct Nested {};                 // a struct that has a fields() table
struct NestedInBody : Nested {};  // the same, which links do not have
struct Rotation {};               // a Quaternion, given in any form of scene/geometry.h
struct NestedPreset {};           // the same, which may also be given as the name of its preset
struct NestedList {               // a list of such structs
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
// One std::variant<S...>, likewise.
struct NestedUnion {
    const char* name;
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

// A text, or a list of structs; see the member's type.
struct TextOrList {
    Text text;
    std::size_t maxItems;
};

struct FieldError {
    std::string pointer;  // JSON Pointer (RFC 6901) into the request
    std::string detail;   // what was wrong
    std::string allowed;  // what would be right
    bool operator==(const FieldError&) const = default;
};
// Errors of one request or file that are listed. Reading ends after them, so that neither time nor
// answers grow with what is wrong.
inline constexpr std::size_t kMaxFieldErrors = 64;

}  // namespace clerestory

// Helpers for visitors of field tables: types of members, and ranges as text.
namespace clerestory::field {

template <class T>
struct Unwrap {
    using type = T;
    static constexpr bool optional = false;
};
template <class T>
struct Unwrap<std::optional<T>> {
    using type = T;
    static constexpr bool optional = true;
};

template <class Kind>
inline constexpr bool isRequired = false;
template <class Kind>
inline constexpr bool isRequired<Required<Kind>> = true;

// How many numbers a value holds; 1 for a plain number.
template <class T>
inline constexpr std::size_t components = 1;
template <>
inline constexpr std::size_t components<glm::dvec3> = 3;
template <std::size_t N>
inline constexpr std::size_t components<std::array<double, N>> = N;

template <class T>
inline constexpr bool isWhole = std::is_integral_v<T>;

// The value behind an optional field, or null.
template <class T>
const T* valueOf(const T& value) {
    return &value;
}
template <class T>
const T* valueOf(const std::optional<T>& value) {
    return value ? &*value : nullptr;
}

inline std::string numberText(double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.10g", value);
    return text;
}

template <class T>
std::string allowedText(const Range& range) {
    const std::string span = numberText(range.min) + " to " + numberText(range.max);
    if (isWhole<T>) return "a whole number from " + span;
    if (components<T> == 1) return "a number from " + span;
    return std::to_string(components<T>) + " numbers from " + span;
}

template <class E>
std::vector<std::string_view> wordsOf(const Choice<E>& choice) {
    std::vector<std::string_view> words;
    for (const auto& [word, value] : choice.words) words.push_back(word);
    return words;
}

template <class E>
std::string_view wordFor(const Choice<E>& choice, E value) {
    for (const auto& [word, candidate] : choice.words) {
        if (candidate == value) return word;
    }
    return {};
}

}  // namespace clerestory::field
