#include "server/api/api_document.h"

#include "server/api/frame_json.h"
#include "server/api/openapi.h"
#include "server/base/problem.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cctype>
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

std::string code(const ordered_json& value) {
    return "`" + (value.is_string() ? value.get<std::string>() : value.dump()) + "`";
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

std::string rangeOf(const ordered_json& schema) {
    if (!schema.contains("minimum")) return "";
    if (!schema.contains("maximum")) return ", at least " + schema["minimum"].dump();
    return ", " + schema["minimum"].dump() + " to " + schema["maximum"].dump();
}

std::string typeOf(const ordered_json& schema) {
    if (schema.contains("$ref")) return linkTo(schema["$ref"]);
    for (const char* key : {"oneOf", "anyOf"}) {
        if (schema.contains(key)) return joined(schema[key], " or ", typeOf);
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
           typeOf(items);
}

// The schema that lists the fields of `schema`: its own, that of its items, or that of one of its
// forms. Null if there is none. `path` is extended for items.
const ordered_json* fieldsIn(const ordered_json& schema, std::string& path) {
    if (schema.contains("properties")) return &schema;
    if (schema.contains("items")) {
        path += "[]";
        return fieldsIn(schema["items"], path);
    }
    if (!schema.contains("oneOf")) return nullptr;
    for (const ordered_json& form : schema["oneOf"]) {
        if (form.contains("properties")) return &form;
    }
    return nullptr;
}

// One row for each field, also of nested objects. Fields of requests have a default and a unit.
void addRows(std::string& out, const ordered_json& object, const std::string& prefix,
             bool request) {
    const ordered_json required = object.value("required", ordered_json::array());
    for (const auto& [name, schema] : object["properties"].items()) {
        const bool always = std::find(required.begin(), required.end(), name) != required.end();
        std::string path = prefix + name;
        out += "| `" + path + "` | " + escaped(typeOf(schema)) + " | ";
        if (request) {
            if (schema.contains("default")) out += code(schema["default"]);
            if (always) out += "required";
            out += " | " + schema.value("x-unit", "");
        } else {
            out += always ? "always" : "optional";
        }
        out += " | " + escaped(schema.value("description", "")) + " |\n";
        if (const ordered_json* nested = fieldsIn(schema, path)) {
            addRows(out, *nested, path + ".", request);
        }
    }
}

std::string schemaSection(const std::string& name, const ordered_json& schema, bool request) {
    std::string out = "### " + name + "\n\n";
    if (!schema.contains("properties")) return out + typeOf(schema) + "\n\n";
    out +=
        request
            ? "| Field | Type and range | Default | Unit | Description |\n|---|---|---|---|---|\n"
            : "| Field | Type | Present | Description |\n|---|---|---|---|\n";
    addRows(out, schema, "", request);
    return out + "\n";
}

std::string contentText(const ordered_json& content) {
    std::string out;
    for (const auto& [type, media] : content.items()) {
        out += (out.empty() ? "`" : ", `") + type + "`";
        const bool json = media.contains("schema") && type.find("json") != std::string::npos;
        if (json) out += " " + typeOf(media["schema"]);
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
                " | " + escaped(typeOf(parameter["schema"])) + " | " +
                escaped(parameter.value("description", "")) + " |\n";
    }
    if (fieldCount > 0) {
        out += "Query: the fields of " + linkTo("/FrameRequest") + " except lists of objects (";
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
        out += "Body: " + contentText(operation["requestBody"]["content"]) + "\n\n";
    }
    out += "| Status | Content | Description |\n|---|---|---|\n";
    for (const auto& [status, response] : operation["responses"].items()) {
        out += "| " + status + " | " +
               contentText(response.value("content", ordered_json::object())) + " | " +
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
                           headTooLarge(0, 0),
                           internalError(),
                           notImplemented(),
                           clientLeft(),
                           tooManyConnections(),
                           streamsFull(),
                           bodiesFull(),
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
        out += "| " + std::to_string(problem.status) + " | `" + problem.code + "` | " +
               problem.title + " | " + (problem.retryAfterSeconds > 0 ? "yes" : "") + " |\n";
    }
    return out;
}

}  // namespace

std::string apiDocument() {
    const ordered_json document = openApiDocument();
    std::string out =
        "# API reference\n\n"
        "Generated from the field tables by `apiDocument()`; do not edit. The [request "
        "guide](requests.md) explains\n"
        "how fields work together, [cameras](camera.md) describes poses and lenses. `GET "
        "/openapi.json` is the same as OpenAPI 3.1. Fields\n"
        "with a default are optional; generate TypeScript types with `openapi-typescript "
        "--default-non-nullable=false`.\n\n" +
        plainText(document["info"]["description"]) +
        "\n\n## Routes\n\n"
        "Where the server runs with `--token-file`, every route except health, readiness and the "
        "page requires\n"
        "`Authorization: Bearer TOKEN`. `HEAD` works wherever `GET`\n"
        "does; `OPTIONS` lists the methods of a path.\n\n";
    for (const auto& [path, operations] : document["paths"].items()) {
        for (const auto& [method, operation] : operations.items()) {
            out += operationSection(path, method, operation);
        }
    }
    // A request names the schemas of its own fields; all others are parts of responses.
    std::string requests, responses;
    const ordered_json& schemas = document["components"]["schemas"];
    for (const auto& [name, schema] : schemas.items()) {
        const bool request =
            !schema.contains("properties") || schema.contains("additionalProperties");
        (request ? requests : responses) += schemaSection(name, schema, request);
    }
    return out +
           "## Request fields\n\nUnknown fields are errors. A dot separates the field of a nested "
           "object; `[]` marks the entries of a list.\n\n" +
           requests + "## Responses\n\n" + responses +
           "## Problem codes\n\nErrors are `application/problem+json` (RFC 9457), see "
           "[Problem](#problem). `type` ends in the code.\n\n" +
           problemTable();
}

}  // namespace clerestory
