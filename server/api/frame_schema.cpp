// The field tables as JSON Schema (2020-12).
#include "scene/fields.h"
#include "server/api/comparison_json.h"
#include "server/api/frame_json.h"
#include "server/api/sequence_request.h"

#include <nlohmann/json.hpp>

#include <cctype>

namespace clerestory {
namespace {

using nlohmann::ordered_json;
using namespace field;

template <class S>
ordered_json objectSchema();

ordered_json schemaReference(const std::string& name) {
    return {{"$ref", "#/components/schemas/" + name}};
}

template <class T>
ordered_json schemaOf(const T*, const Range& range) {
    ordered_json schema;
    if constexpr (isWhole<T>) {
        schema = {{"type", "integer"},
                  {"minimum", static_cast<std::int64_t>(range.min)},
                  {"maximum", static_cast<std::int64_t>(range.max)}};
    } else if constexpr (components<T> == 1) {
        schema = {{"type", "number"}, {"minimum", range.min}, {"maximum", range.max}};
    } else {
        schema = {{"type", "array"},
                  {"items", {{"type", "number"}, {"minimum", range.min}, {"maximum", range.max}}},
                  {"minItems", components<T>},
                  {"maxItems", components<T>}};
    }
    if (range.unit) schema["x-unit"] = range.unit;
    return schema;
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
    return {{"type", "array"}, {"maxItems", list.maxItems}, {"items", objectSchema<T>()}};
}
ordered_json schemaOf(const PlacedScenes*, const TextOrList& kind) {
    return {{"oneOf",
             {schemaOf(static_cast<const std::string*>(nullptr), kind.text),
              schemaOf(static_cast<const std::vector<PlacedScene>*>(nullptr),
                       NestedList{kind.maxItems})}}};
}
// The union itself is a component: see addUnion().
template <class... S>
ordered_json schemaOf(const std::vector<std::variant<S...>>*, const NestedUnionList& list) {
    return {{"type", "array"}, {"maxItems", list.maxItems}, {"items", schemaReference(list.name)}};
}
template <class... S>
ordered_json schemaOf(const std::variant<S...>*, const NestedUnion& one) {
    return schemaReference(one.name);
}
template <class T, class K>
ordered_json schemaOf(const T* type, const Required<K>& required) {
    return schemaOf(type, required.kind);
}
template <class T>
ordered_json schemaOf(const T*, const NestedPreset&) {
    return {
        {"oneOf", {{{"type", "string"}, {"enum", wordsOf(presetChoice())}}, objectSchema<T>()}}};
}
template <class T>
ordered_json schemaOf(const std::vector<T>*, const NestedPresetList& list) {
    return {{"type", "array"},
            {"maxItems", list.maxItems},
            {"items", schemaOf(static_cast<const T*>(nullptr), NestedPreset{})}};
}

// The default of a field; structs have none, because their fields do.
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
void addDefault(ordered_json& schema, const glm::dvec3& value, const Range&) {
    schema["default"] = {value.x, value.y, value.z};
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
    // The settings of each preset, for forms; `x-` marks an OpenAPI extension.
    ordered_json& presets = schema["oneOf"][1]["x-presets"];
    for (const auto& [word, preset] : presetChoice().words) {
        presets[std::string(word)] = accuracyJson(accuracyOf(preset));
    }
}

template <class S>
ordered_json objectSchema() {
    ordered_json properties = ordered_json::object(), required = ordered_json::array();
    S defaults;
    fields(defaults, [&](const char* name, auto& member, const auto& kind, const char* words) {
        using Held = std::decay_t<decltype(member)>;
        using T = typename Unwrap<Held>::type;
        ordered_json schema = schemaOf(static_cast<const T*>(nullptr), kind);
        schema["description"] = words;
        if constexpr (!Unwrap<Held>::optional) addDefault(schema, member, kind);
        properties[name] = std::move(schema);
        if (isRequired<std::decay_t<decltype(kind)>>) required.push_back(name);
    });
    ordered_json schema = {
        {"type", "object"}, {"additionalProperties", false}, {"properties", std::move(properties)}};
    if (!required.empty()) schema["required"] = std::move(required);
    return schema;
}

// Adds an alternative of a union: its fields and `type`, which identifies the alternative.
template <class S>
void addAlternative(ordered_json& schemas, const std::string& unionName) {
    std::string name = std::string(S::kType) + unionName;
    name[0] = static_cast<char>(std::toupper(name[0]));
    ordered_json schema = objectSchema<S>();
    ordered_json properties = {
        {"type", {{"type", "string"}, {"const", S::kType}, {"description", "which one it is"}}}};
    properties.update(schema["properties"]);
    schema["properties"] = std::move(properties);
    ordered_json required = ordered_json::array({"type"});
    for (const auto& member : schema.value("required", ordered_json::array())) {
        required.push_back(member);
    }
    schema["required"] = std::move(required);
    ordered_json& whole = schemas[unionName];
    whole["oneOf"].push_back(schemaReference(name));
    whole["discriminator"]["propertyName"] = "type";
    whole["discriminator"]["mapping"][std::string(S::kType)] = schemaReference(name)["$ref"];
    schemas[name] = std::move(schema);
}
template <class... S>
void addUnion(ordered_json& schemas, const std::variant<S...>*, const std::string& name) {
    (addAlternative<S>(schemas, name), ...);
}
// Every union of the request and of the structs in it.
template <class S>
void addUnions(ordered_json& schemas) {
    S defaults;
    fields(defaults, [&]<class T, class K>(const char*, T&, const K& kind, const char*) {
        using Held = typename Unwrap<T>::type;
        if constexpr (std::is_same_v<K, NestedUnionList>) {
            addUnion(schemas, static_cast<const typename Held::value_type*>(nullptr), kind.name);
        } else if constexpr (std::is_same_v<K, NestedUnion>) {
            addUnion(schemas, static_cast<const Held*>(nullptr), kind.name);
        } else if constexpr (std::is_same_v<K, Nested>) {
            addUnions<Held>(schemas);
        }
    });
}

}  // namespace

ordered_json frameRequestSchemas() {
    ordered_json schemas = {{"FrameRequest", objectSchema<FrameRequest>()},
                            {"Accuracy", objectSchema<Accuracy>()}};
    addUnions<FrameRequest>(schemas);
    return schemas;
}

ordered_json comparisonRequestSchema() {
    return objectSchema<ComparisonRequest>();
}

ordered_json sequenceRequestSchema() {
    ordered_json schema = objectSchema<SequenceRequest>();
    const ordered_json frame = schemaReference("FrameRequest");
    schema["properties"]["common"] = frame;
    schema["properties"]["frames"]["items"] = frame;
    return schema;
}

}  // namespace clerestory
