// JSON -> FrameRequest.
#include "server/api/frame_json.h"

#include "scene/import/base/field_reader.h"

#include <nlohmann/json.hpp>

#include <set>

namespace clerestory {
namespace {

using nlohmann::json;

// Follows the parser, to report duplicate keys and numbers out of range with their JSON Pointer.
class PlaceInDocument {
public:
    bool operator()(int depth, json::parse_event_t event, json& parsed) {
        using Event = json::parse_event_t;
        if (depth > kMaxJsonDepth) {
            throw RequestError(notJson("The body is nested more than " +
                                       std::to_string(kMaxJsonDepth) + " levels deep."));
        }
        switch (event) {
            case Event::object_start:
            case Event::array_start:
                levels_.push_back({.isArray = event == Event::array_start});
                break;
            case Event::object_end:
            case Event::array_end:
                levels_.pop_back();
                next();
                break;
            case Event::value:
                next();
                break;
            case Event::key: {
                Level& level = levels_.back();
                level.key = parsed.get<std::string>();
                if (!level.seen.insert(level.key).second) {
                    doubled.push_back({pointer(), "appears twice", "each field once"});
                }
                break;
            }
        }
        return true;
    }

    std::string pointer() const {
        std::string text;
        for (const Level& level : levels_) {
            text = joinedPointer(text, level.isArray ? std::to_string(level.index) : level.key);
        }
        return text;
    }

    std::vector<FieldError> doubled;

private:
    struct Level {
        bool isArray = false;
        std::size_t index = 0;
        std::string key;
        std::set<std::string> seen;
    };
    void next() {
        if (!levels_.empty()) ++levels_.back().index;
    }
    std::vector<Level> levels_;
};

}  // namespace

json strictJson(std::string_view text) {
    PlaceInDocument place;
    json parsed;
    try {
        parsed = json::parse(text, std::ref(place));
    } catch (const json::parse_error& error) {
        throw RequestError(notJson(text.empty()
                                       ? "The body is empty; {} requests the default frame."
                                       : "The body is not valid JSON at byte " +
                                             std::to_string(error.byte) + "."));
    } catch (const json::out_of_range&) {
        throw RequestError(invalidFields(
            {{place.pointer(), "is out of range", "a number in the range of a double"}}));
    }
    if (!place.doubled.empty()) throw RequestError(invalidFields(place.doubled));
    return parsed;
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
