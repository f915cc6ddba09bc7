// Query of a link -> body of a request, which the reader of bodies checks.
#include "scene/fields.h"
#include "scene/spelling.h"
#include "server/api/frame_json.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <charconv>
#include <functional>

namespace clerestory {
namespace {

using nlohmann::json;
using namespace field;

// Text that is not a number stays text; the reader reports it.
json numberOr(std::string_view text) {
    double value = 0.0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size()) return std::string(text);
    return value;
}

// Lists of objects are JSON. Text that is not stays text; the reader reports it.
json listOr(const std::string& text) {
    try {
        return strictJson(text);
    } catch (const RequestError&) {
        return text;
    }
}

template <class T>
json valueFrom(const std::string& text, const T*, const Range&) {
    if constexpr (components<T> == 1) {
        return numberOr(text);
    } else {
        json list = json::array();
        for (std::size_t begin = 0; begin <= text.size() && list.size() <= components<T>;) {
            const std::size_t end = std::min(text.find(',', begin), text.size());
            list.push_back(numberOr(std::string_view(text).substr(begin, end - begin)));
            begin = end + 1;
        }
        return list;
    }
}

json valueFrom(const std::string& text, const Quaternion*, const Rotation&) {
    json list = json::array();
    for (std::size_t begin = 0; begin <= text.size() && list.size() < 10;) {
        const std::size_t end = std::min(text.find(',', begin), text.size());
        list.push_back(numberOr(std::string_view(text).substr(begin, end - begin)));
        begin = end + 1;
    }
    return list;
}

template <class E, std::size_t N>
json valueFrom(const std::string& text, const std::variant<E, std::array<double, N>>*,
               const ChoiceOrNumbers<E>& kind) {
    if (text.find(',') == std::string::npos) return text;
    return valueFrom(text, static_cast<const std::array<double, N>*>(nullptr), kind.range);
}

template <class T>
json valueFrom(const std::string& text, const T*, const Flag&) {
    if (text == "1" || text == "true") return true;
    if (text == "0" || text == "false") return false;
    return text;
}

json valueFrom(const std::string& text, const PlacedScenes*, const TextOrList&) {
    return text.starts_with('[') ? listOr(text) : json(text);
}

template <class T, class K>
json valueFrom(const std::string& text, const T*, const K&) {
    constexpr bool isList = std::is_same_v<K, NestedList> || std::is_same_v<K, NestedUnionList>;
    return isList ? listOr(text) : json(text);
}

template <class T, class K>
json valueFrom(const std::string& text, const T* type, const Required<K>& required) {
    return valueFrom(text, type, required.kind);
}

struct QueryField {
    std::string path;       // "camera.yfov"
    std::string shortName;  // "yfov"
    std::function<json(const std::string&)> read;
};

template <class S>
void collect(std::vector<QueryField>& all, const std::string& prefix);

// `type`, and the fields of all alternatives; one name has one kind in all of them.
template <class... S>
void collectUnion(std::vector<QueryField>& all, const std::string& prefix,
                  const std::variant<S...>*) {
    std::vector<QueryField> found;
    found.push_back({prefix + "type", "type", [](const std::string& text) { return text; }});
    (collect<S>(found, prefix), ...);
    for (QueryField& f : found) {
        const bool known = std::any_of(all.begin(), all.end(),
                                       [&](const QueryField& each) { return each.path == f.path; });
        if (!known) all.push_back(std::move(f));
    }
}

template <class S>
void collect(std::vector<QueryField>& all, const std::string& prefix) {
    S defaults;
    fields(defaults, [&](const char* name, auto& member, const auto& kind, const char*) {
        using T = typename Unwrap<std::decay_t<decltype(member)>>::type;
        using K = std::decay_t<decltype(kind)>;
        const std::string path = prefix + name;
        if constexpr (std::is_same_v<K, Nested> || std::is_same_v<K, NestedPreset>) {
            collect<T>(all, path + ".");
        } else if constexpr (std::is_same_v<K, NestedUnion>) {
            collectUnion(all, path + ".", static_cast<const T*>(nullptr));
        } else if constexpr (!std::is_same_v<K, NestedInBody>) {
            all.push_back({path, name, [kind](const std::string& text) {
                               return valueFrom(text, static_cast<const T*>(nullptr), kind);
                           }});
        }
    });
}

const std::vector<QueryField>& queryFields() {
    static const std::vector<QueryField> all = [] {
        std::vector<QueryField> list;
        collect<FrameRequest>(list, "");
        return list;
    }();
    return all;
}

// By full path, by short name, or by last parts ("lens.type", "yfov") that only one path has.
const QueryField* fieldNamed(const std::string& name) {
    const auto byPath = [](std::string_view path) -> const QueryField* {
        for (const QueryField& f : queryFields()) {
            if (f.path == path) return &f;
        }
        return nullptr;
    };
    if (const QueryField* f = byPath(name)) return f;
    if (const auto it = shortQueryNames().find(name); it != shortQueryNames().end()) {
        return byPath(it->second);
    }
    const QueryField* only = nullptr;
    for (const QueryField& f : queryFields()) {
        if (f.shortName != name && !f.path.ends_with("." + name)) continue;
        if (only) return nullptr;
        only = &f;
    }
    return only;
}

std::string pointerOf(const std::string& path) {
    std::string text = "/" + path;
    std::replace(text.begin(), text.end(), '.', '/');
    return text;
}

}  // namespace

const std::map<std::string, std::string, std::less<>>& shortQueryNames() {
    static const std::map<std::string, std::string, std::less<>> names = {
        {"accuracy", "accuracy.preset"},
        {"camera", "camera.name"},
        {"environment", "environment.map"},
        {"eye", "camera.position"}};
    return names;
}

namespace {

// Names for several fields or for an object: size=512, size=640x360, fit=all. False: not such a
// name.
bool readGroup(const std::string& name, const std::string& text, json& body,
               std::map<std::string, std::string>& given, std::vector<FieldError>& errors) {
    const auto take = [&](const char* path, json value) {
        if (given.emplace(path, name).second) {
            body[json::json_pointer(pointerOf(path))] = std::move(value);
        } else {
            errors.push_back({pointerOf(path), "is given twice", "each field once"});
        }
    };
    if (name == "size") {
        const std::size_t cross = text.find('x');
        const std::string width = text.substr(0, cross);
        take("width", numberOr(width));
        take("height", numberOr(cross == std::string::npos ? width : text.substr(cross + 1)));
        return true;
    }
    if (name == "fit") {
        if (text != "all") {
            errors.push_back({"/camera/fit", "is not a known word in a link",
                              "all, or the names camera.fit.node, camera.fit.material, ..."});
        } else if (!body.contains("/camera/fit"_json_pointer)) {
            body["/camera/fit"_json_pointer] = json::object();
        }
        return true;
    }
    return false;
}

}  // namespace

json bodyFromQuery(const std::multimap<std::string, std::string>& query) {
    std::vector<FieldError> errors;
    json body = bodyFromQuery(query, errors);
    if (!errors.empty()) throw RequestError(invalidFields(std::move(errors)));
    return body;
}

json bodyFromQuery(const std::multimap<std::string, std::string>& query,
                   std::vector<FieldError>& errors) {
    std::map<std::string, std::string> given;  // path -> name in the query
    json body = json::object();
    for (const auto& [name, text] : query) {
        if (readGroup(name, text, body, given, errors)) continue;
        const QueryField* f = fieldNamed(name);
        if (!f) {
            std::vector<std::string_view> known;
            for (const QueryField& each : queryFields()) {
                known.push_back(each.path);
                if (each.shortName != each.path && fieldNamed(each.shortName) == &each) {
                    known.push_back(each.shortName);
                }
            }
            for (const auto& [word, path] : shortQueryNames()) known.push_back(word);
            known.insert(known.end(), {"size", "fit"});
            errors.push_back({"/" + name.substr(0, 64),
                              "is not a known query name" + didYouMean(name, known),
                              listed(known)});
            continue;
        }
        if (!given.emplace(f->path, name).second) {
            errors.push_back({pointerOf(f->path), "is given twice", "each field once"});
            continue;
        }
        body[json::json_pointer(pointerOf(f->path))] = f->read(text);
    }
    return body;
}

namespace {

const nlohmann::ordered_json& referenced(const nlohmann::ordered_json& schemas,
                                         const std::string& reference) {
    return schemas[reference.substr(reference.rfind('/') + 1)];
}

// The schema of a field of the first alternative that has it; of `type`, with the words of all.
nlohmann::ordered_json fieldOfUnion(const nlohmann::ordered_json& schemas,
                                    const std::string& reference, const std::string& name) {
    nlohmann::ordered_json found, types = nlohmann::ordered_json::array();
    for (const auto& each : referenced(schemas, reference)["oneOf"]) {
        const auto alternative = each["$ref"].get<std::string>();
        const auto& properties = referenced(schemas, alternative)["properties"];
        types.push_back(properties["type"]["const"]);
        if (found.is_null() && properties.contains(name)) found = properties[name];
    }
    if (name != "type") return found;
    return {{"type", "string"}, {"enum", std::move(types)}, {"description", "type of the lens"}};
}

// Whether it is a list of them.
bool holdsObjects(const nlohmann::ordered_json& schema) {
    if (schema.value("type", "") != "array") return false;
    const nlohmann::ordered_json& items = schema["items"];
    return items.contains("$ref") || items.contains("oneOf") || items.value("type", "") == "object";
}

}  // namespace

nlohmann::ordered_json frameQueryParameters() {
    nlohmann::ordered_json list = nlohmann::ordered_json::array();
    const nlohmann::ordered_json schemas = frameRequestSchemas();
    const nlohmann::ordered_json& schema = schemas["FrameRequest"];
    for (const QueryField& f : queryFields()) {
        nlohmann::ordered_json at = schema;
        for (std::size_t begin = 0; begin < f.path.size();) {
            const std::size_t end = std::min(f.path.find('.', begin), f.path.size());
            const std::string part = f.path.substr(begin, end - begin);
            if (at.contains("$ref")) {
                at = fieldOfUnion(schemas, at["$ref"].get<std::string>(), part);
            } else {
                if (at.contains("oneOf")) at = nlohmann::ordered_json(at["oneOf"].back());
                at = nlohmann::ordered_json(at["properties"][part]);
            }
            begin = end + 1;
        }
        std::string description = at.value("description", "");
        at.erase("description");
        if (holdsObjects(at)) {
            list.push_back({{"name", f.path},
                            {"in", "query"},
                            {"description", description + "; as JSON"},
                            {"content", {{"application/json", {{"schema", std::move(at)}}}}}});
            continue;
        }
        if (f.path == "scene") {
            at = nlohmann::ordered_json(at["oneOf"].front());
            description += ", as JSON";
        }
        nlohmann::ordered_json parameter = {{"name", f.path},
                                            {"in", "query"},
                                            {"description", std::move(description)},
                                            {"schema", std::move(at)}};
        const nlohmann::ordered_json& shape = parameter["schema"].contains("oneOf")
                                                  ? parameter["schema"]["oneOf"][0]
                                                  : parameter["schema"];
        if (shape.value("type", "") == "array") {
            parameter["style"] = "form";
            parameter["explode"] = false;
        }
        list.push_back(std::move(parameter));
    }
    return list;
}

}  // namespace clerestory
