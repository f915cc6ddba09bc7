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
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace clerestory {

// Why a text is not accepted.
struct JsonTextError : std::runtime_error {
    enum class Kind { syntax, depth, numberRange };
    JsonTextError(Kind reason, std::size_t at, std::string where)
        : std::runtime_error("invalid JSON"), kind(reason), byte(at), pointer(std::move(where)) {}
    Kind kind;
    std::size_t byte;     // of syntax: where reading ended, from 1
    std::string pointer;  // of numberRange: JSON Pointer of the number
};

// maxDepth: lists and objects within each other. Of equal names in an object the last one counts.
// doubled: receives the JSON Pointers of such names; reading ends after kMaxFieldErrors of them.
// Throws JsonTextError.
nlohmann::json jsonFrom(std::string_view text, std::size_t maxDepth,
                        std::vector<std::string>* doubled = nullptr);

}  // namespace clerestory
