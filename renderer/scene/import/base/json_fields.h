// Typed access to members of an unchecked JSON object. An absent member has the default; a wrong
// type, or a number outside the range of float, is an ImportError with the key.
#pragma once

#include "scene/material.h"

#include <glm/glm.hpp>
#include <nlohmann/json.hpp>

#include <string>

namespace clerestory {

using Json = nlohmann::json;

[[noreturn]] void malformed(const std::string& message);

// Throws ImportError if the text is not JSON, is not an object or nests more than 64 levels.
Json parsedFile(std::string_view text);

double number(const Json& object, const char* key, double fallback);
float real(const Json& object, const char* key, float fallback);
bool flag(const Json& object, const char* key, bool fallback);
std::string text(const Json& object, const char* key);
// A whole number from 0 to 2^32 - 2, or kNone when absent.
Index indexAt(const Json& object, const char* key);
std::uint64_t wholeNumber(const Json& object, const char* key, std::uint64_t fallback);

// The member, or an empty object (array) if it is absent.
const Json& object(const Json& parent, const char* key);
const Json& array(const Json& parent, const char* key);
// parent.extensions[name], or null.
const Json* extension(const Json& parent, const char* name);
// array[i], which must be an object.
const Json& element(const Json& list, std::size_t i, const char* what);

template <int N>
glm::vec<N, double> numbers(const Json& parent, const char* key,
                            const glm::vec<N, double>& fallback) {
    const Json& list = array(parent, key);
    if (list.empty()) {
        return fallback;
    }
    glm::vec<N, double> result(0.0);
    for (int i = 0; i < N; ++i) {
        const auto index = static_cast<std::size_t>(i);
        if (list.size() != std::size_t{N} || !list[index].is_number()) {
            malformed("\"" + std::string(key) + "\" is not a list of " + std::to_string(N) +
                      " numbers");
        }
        result[i] = list[index].get<double>();
    }
    return result;
}

}  // namespace clerestory
