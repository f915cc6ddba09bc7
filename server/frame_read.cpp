// JSON -> FrameRequest. One visitor reads every struct: each wrong field becomes a FieldError with
// its pointer, and the walk goes on, so that a client learns of all its mistakes at once.
#include "server/field_values.h"
#include "server/frame_json.h"
#include "server/spelling.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <set>

namespace clerestory {
namespace {

using nlohmann::json;
using namespace field;

// RFC 6901. Long names are cut: the document should not carry the client's bytes back.
std::string joined(const std::string& pointer, std::string_view name) {
    std::string text = pointer + "/";
    for (const char c : name.substr(0, 64)) {
        if (c == '~') {
            text += "~0";
        } else if (c == '/') {
            text += "~1";
        } else {
            text += c;
        }
    }
    return text;
}

class Reader {
public:
    explicit Reader(std::vector<FieldError>& errors) : errors_(errors) {}

    template <class S>
    void object(const json& value, S& target, const std::string& pointer) {
        if (!value.is_object()) {
            refuse(pointer, std::string("is ") + value.type_name(), "an object");
            return;
        }
        std::vector<std::string_view> known;
        fields(target,
               [&](const char* name, auto& member, const auto& kind, const char* /*words*/) {
                   known.push_back(name);
                   const auto found = value.find(name);
                   if (found == value.end()) return;
                   if constexpr (Unwrap<std::decay_t<decltype(member)>>::optional) {
                       this->optionalMember(*found, member, kind, pointer + "/" + name);
                   } else {
                       this->member(*found, member, kind, pointer + "/" + name);
                   }
               });
        for (const auto& item : value.items()) {
            if (std::find(known.begin(), known.end(), item.key()) == known.end()) {
                refuse(joined(pointer, item.key()),
                       "is not a known field" + didYouMean(item.key(), known), listed(known));
            }
        }
    }

private:
    void refuse(std::string pointer, std::string detail, std::string allowed) {
        errors_.push_back({std::move(pointer), std::move(detail), std::move(allowed)});
    }

    // An optional member is filled only by a sound value.
    template <class T, class K>
    void optionalMember(const json& value, std::optional<T>& target, const K& kind,
                        const std::string& pointer) {
        T inner = target.value_or(T{});
        const std::size_t before = errors_.size();
        member(value, inner, kind, pointer);
        if (errors_.size() == before) target = std::move(inner);
    }

    template <class T>
    void member(const json& value, T& target, const Range& range, const std::string& pointer) {
        if constexpr (components<T> == 1) {
            if (const auto read = number<T>(value, range, pointer)) target = static_cast<T>(*read);
        } else {
            if (!value.is_array() || value.size() != components<T>) {
                refuse(pointer,
                       value.is_array() ? "has " + std::to_string(value.size()) + " elements"
                                        : std::string("is ") + value.type_name(),
                       allowedText<T>(range));
                return;
            }
            for (std::size_t i = 0; i < components<T>; ++i) {
                const auto read =
                    number<double>(value[i], range, pointer + "/" + std::to_string(i));
                if (read) target[static_cast<int>(i)] = *read;
            }
        }
    }

    // Checked as a double, so that narrowing can lose nothing.
    template <class T>
    std::optional<double> number(const json& value, const Range& range,
                                 const std::string& pointer) {
        if (!value.is_number()) {
            refuse(pointer, std::string("is ") + value.type_name(), allowedText<T>(range));
            return std::nullopt;
        }
        const double read = value.get<double>();
        if (!std::isfinite(read) || read < range.min || read > range.max) {
            refuse(pointer, "is out of range", allowedText<T>(range));
            return std::nullopt;
        }
        if (isWhole<T> && read != std::floor(read)) {
            refuse(pointer, "is not a whole number", allowedText<T>(range));
            return std::nullopt;
        }
        return read;
    }

    void member(const json& value, std::string& target, const Text& kind,
                const std::string& pointer) {
        const std::string allowed = "at most " + std::to_string(kind.maxLength) + " bytes of text";
        if (!value.is_string()) {
            refuse(pointer, std::string("is ") + value.type_name(), allowed);
        } else if (value.get_ref<const std::string&>().size() > kind.maxLength) {
            refuse(pointer, "is too long", allowed);
        } else {
            target = value.get<std::string>();
        }
    }

    void member(const json& value, bool& target, const Flag&, const std::string& pointer) {
        if (value.is_boolean()) {
            target = value.get<bool>();
        } else {
            refuse(pointer, std::string("is ") + value.type_name(), "true or false");
        }
    }

    template <class E>
    void member(const json& value, E& target, const Choice<E>& choice, const std::string& pointer) {
        const std::string allowed = "one of: " + listed(wordsOf(choice));
        if (!value.is_string()) {
            refuse(pointer, std::string("is ") + value.type_name(), allowed);
            return;
        }
        const auto& word = value.get_ref<const std::string&>();
        for (const auto& [candidate, meaning] : choice.words) {
            if (candidate == word) {
                target = meaning;
                return;
            }
        }
        refuse(pointer, "is not a known word" + didYouMean(word, wordsOf(choice)), allowed);
    }

    template <class S>
    void member(const json& value, S& target, const Nested&, const std::string& pointer) {
        object(value, target, pointer);
    }

    // A preset's name, or an object that starts from a preset and sets single knobs.
    void member(const json& value, Accuracy& target, const NestedPreset&,
                const std::string& pointer) {
        if (!value.is_string() && !value.is_object()) {
            refuse(pointer, std::string("is ") + value.type_name(),
                   "one of: " + listed(wordsOf(presetChoice())) + "; or an object of knobs");
            return;
        }
        Preset preset = target.preset;
        if (value.is_string()) {
            member(value, preset, presetChoice(), pointer);
            target = accuracyOf(preset);
            return;
        }
        if (const auto found = value.find("preset"); found != value.end() && found->is_string()) {
            for (const auto& [word, meaning] : presetChoice().words) {
                if (word == found->get_ref<const std::string&>()) preset = meaning;
            }
        }
        target = accuracyOf(preset);
        object(value, target, pointer);
    }

    std::vector<FieldError>& errors_;
};

// Follows the parser, so that a doubled key or a number too large is told with its place.
class PlaceInDocument {
public:
    bool operator()(int depth, json::parse_event_t event, json& parsed) {
        using Event = json::parse_event_t;
        if (depth > kMaxJsonDepth) {
            throw RequestError(
                notJson("The body is nested deeper than " + std::to_string(kMaxJsonDepth) + "."));
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
            text = joined(text, level.isArray ? std::to_string(level.index) : level.key);
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
        throw RequestError(
            notJson(text.empty()
                        ? "The body is empty; {} asks for the default frame."
                        : "The body stops being JSON at byte " + std::to_string(error.byte) + "."));
    } catch (const json::out_of_range&) {
        throw RequestError(invalidFields(
            {{place.pointer(), "is out of range", "a number that a double can hold"}}));
    }
    if (!place.doubled.empty()) throw RequestError(invalidFields(place.doubled));
    return parsed;
}

FrameRequest frameRequestFrom(const json& body, const FrameRequest& defaults) {
    std::vector<FieldError> errors;
    FrameRequest request = defaults;
    Reader(errors).object(body, request, "");
    // The rules that bind several fields speak only of fields that are sound by themselves.
    if (errors.empty()) errors = problems(request);
    if (!errors.empty()) throw RequestError(invalidFields(std::move(errors)));
    return request;
}

}  // namespace clerestory
