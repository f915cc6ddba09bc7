#include "scene/import/base/json_fields.h"

#include "scene/import/base/json_text.h"
#include "scene/import/base/types.h"

#include <cmath>
#include <limits>

namespace clerestory {
namespace {

constexpr std::size_t kMaxDepth = 64;  // glTF needs 8; extras may need more

[[noreturn]] void wrongType(const char* key, const char* expected) {
    malformed("\"" + std::string(key) + "\" is not " + expected);
}

const Json* member(const Json& parent, const char* key) {
    const auto found = parent.find(key);
    return found == parent.end() ? nullptr : &*found;
}

}  // namespace

void malformed(const std::string& message) {
    throw ImportError(ImportError::Reason::malformed, message);
}

Json parsedFile(std::string_view text) {
    try {
        Json json = jsonFrom(text, kMaxDepth);
        if (!json.is_object()) {
            malformed("the JSON is not an object");
        }
        return json;
    } catch (const JsonTextError& error) {
        switch (error.kind) {
            case JsonTextError::Kind::depth:
                malformed("the JSON is nested more than " + std::to_string(kMaxDepth) +
                          " levels deep");
            case JsonTextError::Kind::numberRange:
                malformed("the JSON has a number that is out of range: " + error.pointer);
            case JsonTextError::Kind::elements:  // without limits of them
            case JsonTextError::Kind::values:
            case JsonTextError::Kind::syntax:
                break;
        }
        malformed("not valid JSON at byte " + std::to_string(error.byte));
    }
}

double number(const Json& parent, const char* key, double fallback) {
    const Json* value = member(parent, key);
    if (!value) {
        return fallback;
    }
    if (!value->is_number()) {
        wrongType(key, "a number");
    }
    return value->get<double>();  // finite: the parser refuses 1e999
}

float real(const Json& parent, const char* key, float fallback) {
    const double value = number(parent, key, static_cast<double>(fallback));
    if (std::abs(value) > static_cast<double>(std::numeric_limits<float>::max())) {
        wrongType(key, "a number in the range of float");
    }
    return static_cast<float>(value);
}

bool flag(const Json& parent, const char* key, bool fallback) {
    const Json* value = member(parent, key);
    if (value && !value->is_boolean()) {
        wrongType(key, "true or false");
    }
    return value ? value->get<bool>() : fallback;
}

std::string text(const Json& parent, const char* key) {
    const Json* value = member(parent, key);
    if (value && !value->is_string()) {
        wrongType(key, "a string");
    }
    return value ? value->get<std::string>() : std::string();
}

std::uint64_t wholeNumber(const Json& parent, const char* key, std::uint64_t fallback) {
    const double value = number(parent, key, static_cast<double>(fallback));
    constexpr double kLargest = 9007199254740992.0;  // 2^53, the last exact whole number
    if (!(value >= 0.0 && value <= kLargest) || value != std::floor(value)) {
        wrongType(key, "a whole number");
    }
    return static_cast<std::uint64_t>(value);
}

Index indexAt(const Json& parent, const char* key) {
    if (!parent.contains(key)) {
        return kNone;
    }
    const std::uint64_t value = wholeNumber(parent, key, 0);
    if (value >= kNone) {
        wrongType(key, "an index");
    }
    return static_cast<Index>(value);
}

const Json& object(const Json& parent, const char* key) {
    static const Json kEmpty = Json::object();
    const Json* value = member(parent, key);
    if (value && !value->is_object()) {
        wrongType(key, "an object");
    }
    return value ? *value : kEmpty;
}

const Json& array(const Json& parent, const char* key) {
    static const Json kEmpty = Json::array();
    const Json* value = member(parent, key);
    if (value && !value->is_array()) {
        wrongType(key, "a list");
    }
    return value ? *value : kEmpty;
}

const Json* extension(const Json& parent, const char* name) {
    const Json* found = member(object(parent, "extensions"), name);
    if (found && !found->is_object()) {
        wrongType(name, "an object");
    }
    return found;
}

const Json& element(const Json& list, std::size_t i, const char* what) {
    if (i >= list.size() || !list[i].is_object()) {
        malformed(i == kNone ? "an index into " + std::string(what) + " is missing"
                             : std::string(what) + " has no element " + std::to_string(i));
    }
    return list[i];
}

}  // namespace clerestory
