// JSON -> FrameRequest.
#include "server/api/frame_json.h"

#include "scene/import/base/field_reader.h"
#include "scene/import/base/json_text.h"

#include <nlohmann/json.hpp>

namespace clerestory {

using nlohmann::json;

json strictJson(std::string_view text) {
    try {
        std::vector<std::string> doubled;
        json parsed = jsonFrom(text, kMaxJsonDepth, &doubled,
                               {.elements = kMaxJsonElements, .values = kMaxJsonValues});
        if (doubled.empty()) return parsed;
        std::vector<FieldError> errors;
        for (std::string& pointer : doubled) {
            errors.push_back({std::move(pointer), "appears twice", "each field once"});
        }
        throw RequestError(invalidFields(std::move(errors)));
    } catch (const JsonTextError& error) {
        switch (error.kind) {
            case JsonTextError::Kind::depth:
                throw RequestError(notJson("The body is nested more than " +
                                           std::to_string(kMaxJsonDepth) + " levels deep."));
            case JsonTextError::Kind::elements:
                throw RequestError(
                    invalidFields({{error.pointer, "has too many elements",
                                    "a list of at most " + std::to_string(kMaxJsonElements)}}));
            case JsonTextError::Kind::values:
                throw RequestError(notJson("The body has more than " +
                                           std::to_string(kMaxJsonValues) + " values."));
            case JsonTextError::Kind::numberRange:
                throw RequestError(invalidFields(
                    {{error.pointer, "is out of range", "a number in the range of a double"}}));
            case JsonTextError::Kind::syntax:
                break;
        }
        throw RequestError(notJson(text.empty()
                                       ? "The body is empty; {} requests the default frame."
                                       : "The body is not valid JSON at byte " +
                                             std::to_string(error.byte) + "."));
    }
}

FrameRequest frameRequestFrom(const json& body, const FrameRequest& defaults,
                              std::vector<FieldError> errors) {
    FrameRequest request = defaults;
    FieldReader(errors).object(body, request, "");
    // Rules that involve several fields apply only if each field is valid.
    if (errors.empty()) errors = problems(request);
    if (!errors.empty()) throw RequestError(invalidFields(std::move(errors)));
    return request;
}

}  // namespace clerestory
