// The field tables as JSON Schema (2020-12).
#include "scene/field_values.h"
#include "server/api/comparison_json.h"
#include "server/api/frame_json.h"
#include "server/api/sequence_request.h"

#include <nlohmann/json.hpp>

namespace clerestory {
namespace {

using nlohmann::ordered_json;
using namespace field;

template <class S>
ordered_json objectSchema();

template <class T>
ordered_json schemaOf(const T*, const Range& range) {
    if constexpr (isWhole<T>) {
        return {{"type", "integer"},
                {"minimum", static_cast<std::int64_t>(range.min)},
                {"maximum", static_cast<std::int64_t>(range.max)}};
    } else if constexpr (components<T> == 1) {
        return {{"type", "number"}, {"minimum", range.min}, {"maximum", range.max}};
    } else {
        return {{"type", "array"},
                {"items", {{"type", "number"}, {"minimum", range.min}, {"maximum", range.max}}},
                {"minItems", components<T>},
                {"maxItems", components<T>}};
    }
}
ordered_json schemaOf(const Quaternion*, const Rotation&) {
    ordered_json forms = ordered_json::array();
    for (const int count : {4, 9, 3}) {
        forms.push_back({{"type", "array"},
                         {"items", {{"type", "number"}}},
                         {"minItems", count},
                         {"maxItems", count}});
    }
    return {{"oneOf", std::move(forms)}};
}
template <class T>
ordered_json schemaOf(const T*, const Text& text) {
    return {{"type", "string"}, {"maxLength", text.maxLength}};
}
template <class T>
ordered_json schemaOf(const T*, const Flag&) {
    return {{"type", "boolean"}};
}
template <class T>
ordered_json schemaOf(const T*, const Choice<T>& choice) {
    return {{"type", "string"}, {"enum", wordsOf(choice)}};
}
template <class E, std::size_t N>
ordered_json schemaOf(const std::variant<E, std::array<double, N>>*,
                      const ChoiceOrNumbers<E>& kind) {
    return {{"oneOf",
             {schemaOf(static_cast<const E*>(nullptr), kind.choice),
              schemaOf(static_cast<const std::array<double, N>*>(nullptr), kind.range)}}};
}
template <class T>
ordered_json schemaOf(const T*, const Nested&) {
    return objectSchema<T>();
}
template <class T>
ordered_json schemaOf(const std::vector<T>*, const NestedList& list) {
    return {{"type", "array"}, {"maxItems", list.most}, {"items", objectSchema<T>()}};
}
template <class T>
ordered_json schemaOf(const T*, const NestedPreset&) {
    return {
        {"oneOf", {{{"type", "string"}, {"enum", wordsOf(presetChoice())}}, objectSchema<T>()}}};
}
template <class T>
ordered_json schemaOf(const std::vector<T>*, const NestedPresetList& list) {
    return {{"type", "array"},
            {"maxItems", list.most},
            {"items", schemaOf(static_cast<const T*>(nullptr), NestedPreset{})}};
}

// What a field is when it is left out; nothing for structs, whose fields say it themselves.
template <class T, class K>
void addDefault(ordered_json&, const T&, const K&) {}
template <class T>
void addDefault(ordered_json& schema, const T& value, const Range&) {
    if constexpr (components<T> == 1) schema["default"] = value;
}
template <std::size_t N>
void addDefault(ordered_json& schema, const std::array<double, N>& value, const Range&) {
    schema["default"] = value;
}
template <class T>
void addDefault(ordered_json& schema, const T& value, const Flag&) {
    schema["default"] = value;
}
template <class E>
void addDefault(ordered_json& schema, const E& value, const Choice<E>& choice) {
    schema["default"] = std::string(wordFor(choice, value));
}
void addDefault(ordered_json& schema, const Accuracy& value, const NestedPreset&) {
    schema["default"] = std::string(wordFor(presetChoice(), value.preset));
    // What each preset's name stands for, so that a form can show it; `x-` as OpenAPI extensions
    // go.
    ordered_json& presets = schema["oneOf"][1]["x-presets"];
    for (const auto& [word, preset] : presetChoice().words) {
        presets[std::string(word)] = accuracyJson(accuracyOf(preset));
    }
}

template <class S>
ordered_json objectSchema() {
    ordered_json properties = ordered_json::object();
    S defaults;
    fields(defaults, [&](const char* name, auto& member, const auto& kind, const char* words) {
        using Held = std::decay_t<decltype(member)>;
        using T = typename Unwrap<Held>::type;
        ordered_json schema = schemaOf(static_cast<const T*>(nullptr), kind);
        schema["description"] = words;
        if constexpr (!Unwrap<Held>::optional) addDefault(schema, member, kind);
        properties[name] = std::move(schema);
    });
    return {
        {"type", "object"}, {"additionalProperties", false}, {"properties", std::move(properties)}};
}

}  // namespace

ordered_json frameRequestSchema() {
    return objectSchema<FrameRequest>();
}

ordered_json comparisonRequestSchema() {
    return objectSchema<ComparisonRequest>();
}

ordered_json sequenceRequestSchema() {
    ordered_json schema = objectSchema<SequenceRequest>();
    // The frame's fields stand once.
    const ordered_json frame = {{"$ref", "#/components/schemas/FrameRequest"}};
    schema["properties"]["common"] = frame;
    schema["properties"]["frames"]["items"] = frame;
    return schema;
}

}  // namespace clerestory
