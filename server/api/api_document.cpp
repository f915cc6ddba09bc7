// docs/api.md from the OpenAPI document.
#include "server/api/openapi.h"

#include "server/api/frame_json.h"
#include "server/base/problem.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <map>
#include <set>

namespace clerestory {
namespace {

using nlohmann::ordered_json;

std::string escaped(std::string text) {
    for (std::size_t i = 0; (i = text.find('|', i)) != std::string::npos; i += 2) {
        text.insert(i, "\\");
    }
    return text;
}

std::string plainText(const ordered_json& value) {
    return value.get<std::string>();
}

std::string linkTo(const std::string& reference) {
    const std::string name = reference.substr(reference.rfind('/') + 1);
    std::string anchor = name;
    std::transform(anchor.begin(), anchor.end(), anchor.begin(), ::tolower);
    return "[" + name + "](#" + anchor + ")";
}

std::string joined(const ordered_json& list, const char* separator,
                   std::string (*textOf)(const ordered_json&)) {
    std::string out;
    for (const ordered_json& each : list) out += (out.empty() ? "" : separator) + textOf(each);
    return out;
}

std::string decimal(const ordered_json& value) {
    if (!value.is_number_float()) return value.dump();
    char text[32];
    std::snprintf(text, sizeof text, "%.9g", value.get<double>());
    return text;
}

std::string code(const ordered_json& value) {
    if (value.is_string()) return "`" + value.get<std::string>() + "`";
    return "`" + (value.is_number() ? decimal(value) : value.dump()) + "`";
}

std::string rangeOf(const ordered_json& schema) {
    if (!schema.contains("minimum")) return "";
    if (!schema.contains("maximum")) return ", at least " + decimal(schema["minimum"]);
    return ", " + decimal(schema["minimum"]) + " to " + decimal(schema["maximum"]);
}

std::string typeText(const ordered_json& schema) {
    if (schema.contains("$ref")) return linkTo(schema["$ref"]);
    for (const char* key : {"oneOf", "anyOf"}) {
        if (schema.contains(key)) return joined(schema[key], " or ", typeText);
    }
    if (schema.contains("const")) return code(schema["const"]);
    if (schema.contains("enum")) return joined(schema["enum"], ", ", code);
    if (!schema.contains("type")) return "any";
    if (schema["type"].is_array()) return joined(schema["type"], " or ", plainText);
    const std::string type = schema["type"];
    if (type == "string") {
        const bool bounded = schema.contains("maxLength");
        return bounded ? "text, at most " + schema["maxLength"].dump() + " bytes" : "text";
    }
    if (type != "array") return type + rangeOf(schema);
    const ordered_json& items = schema["items"];
    if (schema.contains("minItems") && schema["minItems"] == schema["maxItems"]) {
        return schema["minItems"].dump() + " numbers" + rangeOf(items);
    }
    const bool bounded = schema.contains("maxItems");
    return "list of " + (bounded ? "at most " + schema["maxItems"].dump() + " " : "") +
           typeText(items);
}

// The schema that lists the fields of `schema`: its own, that of its items, or that of one of its
// forms. Null if there is none. `path` is extended for items.
const ordered_json* fieldsIn(const ordered_json& schema, std::string& path) {
    if (schema.contains("properties")) return &schema;
    if (schema.contains("items")) {
        const std::string list = path;
        path += "[]";
        const ordered_json* fields = fieldsIn(schema["items"], path);
        if (!fields) path = list;
        return fields;
    }
    if (!schema.contains("oneOf")) return nullptr;
    for (const ordered_json& form : schema["oneOf"]) {
        if (form.contains("properties") || form.value("type", "") == "array") {
            if (const ordered_json* fields = fieldsIn(form, path)) return fields;
        }
    }
    return nullptr;
}

// Tables of fields. An object that appears again refers to its first appearance.
class FieldTables {
public:
    // Requests have columns for default and unit, responses for presence.
    std::string section(const std::string& name, const ordered_json& schema, bool request) {
        std::string out = "### " + name + "\n\n";
        if (!schema.contains("properties")) return out + typeText(schema) + "\n\n";
        const auto [first, isNew] = first_.emplace(schema["properties"].dump(), name);
        if (!isNew) return out + "Fields as `" + first->second + "`.\n\n";
        out += request ? "| Field | Type and range | Default | Unit | Description "
                         "|\n|---|---|---|---|---|\n"
                       : "| Field | Type | Present | Description |\n|---|---|---|---|\n";
        addRows(out, schema, "", request);
        return out + "\n";
    }

private:
    void addRows(std::string& out, const ordered_json& object, const std::string& prefix,
                 bool request) {
        const ordered_json required = object.value("required", ordered_json::array());
        for (const auto& [name, schema] : object["properties"].items()) {
            const bool always = std::find(required.begin(), required.end(), name) != required.end();
            std::string path = prefix + name;
            out += "| `" + path + "` | " + escaped(typeText(schema)) + " | ";
            if (request) {
                if (schema.contains("default")) out += code(schema["default"]);
                if (always) out += "required";
                out += " | " + schema.value("x-unit", "");
            } else {
                out += always ? "always" : "optional";
            }
            out += " | " + escaped(schema.value("description", ""));
            const ordered_json* nested = fieldsIn(schema, path);
            const auto [first, isNew] =
                first_.emplace(nested ? (*nested)["properties"].dump() : path, path);
            if (nested && !isNew) out += " (fields as `" + first->second + "`)";
            out += " |\n";
            if (nested && isNew) addRows(out, *nested, path + ".", request);
        }
    }

    std::map<std::string, std::string> first_;  // an object's properties -> its path
};

std::string mediaTypes(const ordered_json& content) {
    std::string out;
    for (const auto& [type, media] : content.items()) {
        out += (out.empty() ? "`" : ", `") + type + "`";
        const bool json = media.contains("schema") && type.find("json") != std::string::npos;
        if (json) out += " " + typeText(media["schema"]);
    }
    return out;
}

// The fields of a frame are parameters of a link; they are described once, as fields.
std::string parameterRows(const ordered_json& parameters) {
    std::set<std::string> fieldPaths;
    for (const ordered_json& field : frameQueryParameters()) fieldPaths.insert(field["name"]);
    std::string rows, out;
    std::size_t fieldCount = 0;
    for (const ordered_json& parameter : parameters) {
        if (parameter["in"] == "query" && fieldPaths.contains(parameter["name"])) {
            ++fieldCount;
            continue;
        }
        rows += "| " + code(parameter["name"]) + " | " + parameter["in"].get<std::string>() +
                " | " + escaped(typeText(parameter["schema"])) + " | " +
                escaped(parameter.value("description", "")) + " |\n";
    }
    if (fieldCount > 0) {
        out += "Query: the fields of " + linkTo("/FrameRequest") + "; lists of objects are JSON (";
        for (const auto& [name, path] : shortQueryNames()) {
            out += (name == shortQueryNames().begin()->first ? "`" : ", `") + name +
                   "` is short for `" + path + "`";
        }
        out += ").\n\n";
    }
    if (rows.empty()) return out;
    return out + "| Parameter | In | Type | Description |\n|---|---|---|---|\n" + rows + "\n";
}

std::string operationSection(const std::string& path, std::string method,
                             const ordered_json& operation) {
    std::transform(method.begin(), method.end(), method.begin(), ::toupper);
    std::string out = "### " + method + " " + path + "\n\n" + plainText(operation["summary"]) + ".";
    if (operation.contains("description")) out += " " + plainText(operation["description"]);
    out += "\n\n" + parameterRows(operation.value("parameters", ordered_json::array()));
    if (operation.contains("requestBody")) {
        out += "Body: " + mediaTypes(operation["requestBody"]["content"]) + "\n\n";
    }
    out += "| Status | Content | Description |\n|---|---|---|\n";
    for (const auto& [status, response] : operation["responses"].items()) {
        if (status == "default" || status == "4XX") continue;  // described once for all
        out += "| " + status + " | " +
               mediaTypes(response.value("content", ordered_json::object())) + " | " +
               escaped(response.value("description", "")) + " |\n";
    }
    return out + "\n";
}

std::string problemTable() {
    const Problem all[] = {notJson(""),
                           badRequest(""),
                           unauthorized(),
                           forbidden(""),
                           notFound(""),
                           methodNotAllowed(""),
                           requestTimeout("", 0),
                           stillLoading(""),
                           stillMeasuring("", 0),
                           lengthRequired(),
                           tooLarge(0),
                           uriTooLong(0, 0),
                           notJsonType(),
                           encodedBody(),
                           expectationFailed(),
                           misdirected(),
                           invalidFields({}),
                           quarantined(),
                           sceneFailed("", ""),
                           mapFailed("", ""),
                           headTooLarge(0, 0),
                           internalError(),
                           notImplemented(),
                           clientLeft(),
                           tooManyConnections(),
                           streamsFull(),
                           bodiesFull(),
                           responsesFull(),
                           queueFull(1),
                           jobsFull(),
                           noWorker(),
                           renderFailed(),
                           shuttingDown(),
                           notReady(""),
                           stillCompiling(0),
                           overDeadline(0),
                           versionNotSupported(),
                           noRoom("")};
    std::string out = "| Status | Code | Title | `Retry-After` |\n|---|---|---|---|\n";
    for (const Problem& problem : all) {
        out += "| " + std::to_string(problem.status) + " | `" + std::string(nameOf(problem.code)) +
               "` | " + problem.title + " | " + (problem.retryAfterSeconds > 0 ? "yes" : "") +
               " |\n";
    }
    return out;
}

}  // namespace

std::string apiDocument() {
    const ordered_json document = openApiDocument();
    std::string out = R"(# API reference

Generated from the field tables by `apiDocument()`; do not edit. The [request guide](requests.md)
explains how fields work together; [cameras](camera.md) describes poses and lenses.
`GET /openapi.json` has the same content as OpenAPI 3.1. Fields with a default are optional; generate
TypeScript types with `openapi-typescript --default-non-nullable=false`.

)" + plainText(document["info"]["description"]) +
                      R"(

## Routes

If the server runs with `--token-file`, every route except health, readiness and the page requires
`Authorization: Bearer TOKEN`. `HEAD` works wherever `GET` does; `OPTIONS` lists the methods of a
path. Every route may also answer with a [problem document](#problem-codes).

)";
    for (const auto& [path, operations] : document["paths"].items()) {
        for (const auto& [method, operation] : operations.items()) {
            out += operationSection(path, method, operation);
        }
    }
    std::string requests, responses;
    FieldTables tables;
    const ordered_json& schemas = document["components"]["schemas"];
    for (const auto& [name, schema] : schemas.items()) {
        ordered_json own = schema;
        if (name == "ComparisonRequest") {  // a frame's fields and its own
            for (const auto& [field, frame] : schemas["FrameRequest"]["properties"].items()) {
                own["properties"].erase(field);
            }
        }
        // Only requests exclude unknown fields.
        const bool request =
            !schema.contains("properties") || schema.contains("additionalProperties");
        (request ? requests : responses) += tables.section(name, own, request);
    }
    return out + R"(## Request fields

Unknown fields are errors. A dot separates the field of a nested object; `[]` marks the entries of
a list. The body of a comparison has all fields of [FrameRequest](#framerequest) as well.

)" + requests +
           "## Responses\n\n" + responses + R"(## Problem codes

Errors are `application/problem+json` (RFC 9457), see [Problem](#problem). `type` ends in the code.

)" + problemTable();
}

}  // namespace clerestory
