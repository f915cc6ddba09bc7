// Helpers for visitors of field tables: types of members, and ranges as text.
#pragma once

#include "scene/fields.h"

#include <glm/glm.hpp>

#include <array>
#include <cmath>
#include <cstdio>
#include <optional>
#include <type_traits>

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
