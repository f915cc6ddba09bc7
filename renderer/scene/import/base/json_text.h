// Reads JSON text from outside, in time proportional to its length:
//
//     std::vector<std::string> doubled;
//     const nlohmann::json body = jsonFrom(text, 16, &doubled);
//
// nlohmann's parser takes quadratic time in the elements of a list when it has a callback, so this
// builds the value from the parser's events instead.
#pragma once

#include <nlohmann/json.hpp>

#include <cstddef>
#include <limits>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace clerestory {

// Why a text is not accepted.
struct JsonTextError : std::runtime_error {
    enum class Kind { syntax, depth, elements, values, numberRange };
    JsonTextError(Kind reason, std::size_t at, std::string where)
        : std::runtime_error("invalid JSON"), kind(reason), byte(at), pointer(std::move(where)) {}
    Kind kind;
    std::size_t byte;     // of syntax: where reading ended, from 1
    std::string pointer;  // of numberRange and elements: JSON Pointer of the number or list
};

// Reading ends beyond them, before the rest is built: a value of two bytes of text takes up to 180
// bytes of memory.
struct JsonSizes {
    std::size_t elements = std::numeric_limits<std::size_t>::max();  // of one list
    std::size_t values = std::numeric_limits<std::size_t>::max();    // of the text
};

// maxDepth: lists and objects within each other. Of equal names in an object the last one counts.
// doubled: receives the JSON Pointers of such names; reading ends after kMaxFieldErrors of them.
// Throws JsonTextError.
nlohmann::json jsonFrom(std::string_view text, std::size_t maxDepth,
                        std::vector<std::string>* doubled = nullptr, const JsonSizes& sizes = {});

}  // namespace clerestory
