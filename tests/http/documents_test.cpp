// The server's self-description: schema, renderer, health, metrics, the web page.
#include "tests/support/soon.h"
#include "tests/support/test_server.h"

#include "comparison/comparison.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <regex>
#include <set>
#include <sstream>

namespace clerestory::test {
namespace {

using nlohmann::json;
using testing::HasSubstr;

json documentAt(const char* path) {
    auto client = sharedServer().client();
    const auto result = client.Get(path);
    if (!result || result->status != 200) {
        ADD_FAILURE() << path;
        return nullptr;
    }
    EXPECT_EQ(result->get_header_value("Content-Type"), "application/json");
    return json::parse(result->body);
}

// Every name of a table must stand in the schema's properties, and nothing else may.
template <class S>
void expectListed(const json& schema) {
    S value;
    std::size_t count = 0;
    fields(value, [&](const char* name, auto&, const auto&, const char* words) {
        ++count;
        ASSERT_TRUE(schema["properties"].contains(name)) << name;
        EXPECT_EQ(schema["properties"][name]["description"], words);
    });
    EXPECT_EQ(schema["properties"].size(), count);
    EXPECT_EQ(schema["additionalProperties"], false);
}

TEST(Documents, OpenApiListsEveryFieldAndEveryRoute) {
    const json document = documentAt("/openapi.json");
    EXPECT_EQ(document["openapi"], "3.1.0");
    const json& frame = document["components"]["schemas"]["FrameRequest"];
    expectListed<FrameRequest>(frame);
    expectListed<ComparisonRequest>(document["components"]["schemas"]["ComparisonRequest"]);
    const json& properties = frame["properties"];
    expectListed<CameraRequest>(properties["camera"]);
    expectListed<Intrinsics>(properties["camera"]["properties"]["intrinsics"]);
    expectListed<Effects>(properties["effects"]);
    expectListed<Accuracy>(properties["accuracy"]["oneOf"][1]);
    expectListed<EnvironmentRequest>(properties["environment"]);
    expectListed<Output>(properties["output"]);
    EXPECT_EQ(properties["filters"]["items"]["$ref"], "#/components/schemas/Filter");
    EXPECT_EQ(properties["filters"]["maxItems"], kMaxFilters);
    expectListed<MaterialOverride>(properties["overrides"]["items"]);
    EXPECT_EQ(properties["overrides"]["maxItems"], 64);
    EXPECT_EQ(properties["width"]["default"], 1280);
    EXPECT_EQ(properties["width"]["maximum"], 4096);
    EXPECT_EQ(properties["width"]["type"], "integer");
    EXPECT_EQ(properties["accuracy"]["default"], "standard");
    const json& presets = properties["accuracy"]["oneOf"][1]["x-presets"];
    EXPECT_EQ(presets.size(), 3u);
    EXPECT_EQ(presets["draft"]["generations"], accuracyOf(Preset::draft).generations);
    EXPECT_EQ(properties["camera"]["properties"]["position"]["maxItems"], 3);
    auto paths = sharedServer().server().routes().paths();
    const auto ofRenderer = sharedServer().backend().routes().paths();
    paths.insert(paths.end(), ofRenderer.begin(), ofRenderer.end());
    for (auto [path, method] : paths) {
        std::transform(method.begin(), method.end(), method.begin(), ::tolower);
        EXPECT_TRUE(document["paths"][path].contains(method)) << path;
    }
}

TEST(Documents, FiltersAreATaggedUnion) {
    const json schemas = documentAt("/openapi.json")["components"]["schemas"];
    const json& filter = schemas["Filter"];
    EXPECT_EQ(filter["discriminator"]["propertyName"], "type");
    EXPECT_EQ(filter["oneOf"].size(), std::variant_size_v<FilterRequest>);
    for (const auto& [type, reference] : filter["discriminator"]["mapping"].items()) {
        const std::string name = reference.get<std::string>().substr(21);
        EXPECT_THAT(filter["oneOf"], testing::Contains(json{{"$ref", reference}}));
        EXPECT_EQ(schemas[name]["properties"]["type"]["const"], type);
        EXPECT_EQ(schemas[name]["additionalProperties"], false);
        EXPECT_EQ(schemas[name]["required"][0], "type");
    }
    EXPECT_EQ(schemas["TwirlFilter"]["required"], json({"type", "amount"}));
    EXPECT_EQ(schemas["TwirlFilter"]["properties"]["radius"]["x-unit"], "pixels");
    EXPECT_EQ(schemas["GlowFilter"]["required"], json({"type"}));
    EXPECT_EQ(schemas["GlowFilter"]["properties"]["radius"]["default"], 32.0);
    const json& kernel = schemas["ConvolveFilter"]["properties"]["kernel"]["oneOf"];
    EXPECT_EQ(kernel[0]["enum"][0], "sharpen");
    EXPECT_EQ(kernel[1]["minItems"], 9);
}

// The parts of `value` that do not match the schema, by JSON Pointer.
void compare(const json& document, json schema, const json& value, const std::string& pointer,
             std::vector<std::string>& wrong) {
    if (schema.contains("$ref")) {
        schema = document.at(json::json_pointer(schema["$ref"].get<std::string>().substr(1)));
    }
    for (const char* either : {"oneOf", "anyOf"}) {
        if (!schema.contains(either)) continue;
        // The errors of the best matching alternative.
        std::vector<std::string> least(1000);
        for (const json& alternative : schema[either]) {
            std::vector<std::string> found;
            compare(document, alternative, value, pointer, found);
            if (found.size() < least.size()) least = std::move(found);
        }
        wrong.insert(wrong.end(), least.begin(), least.end());
        return;
    }
    const std::string type = schema["type"].is_array()
                                 ? schema["type"][value.is_null() ? 1 : 0].get<std::string>()
                                 : schema["type"].get<std::string>();
    const bool fits = type == "object"    ? value.is_object()
                      : type == "array"   ? value.is_array()
                      : type == "string"  ? value.is_string()
                      : type == "boolean" ? value.is_boolean()
                      : type == "integer" ? value.is_number_integer()
                      : type == "number"  ? value.is_number()
                                          : value.is_null();
    if (!fits) return wrong.push_back(pointer + " is no " + type);
    const json words = schema.value("enum", json::array());
    if (!words.empty() && std::find(words.begin(), words.end(), value) == words.end()) {
        wrong.push_back(pointer + " is no word of the schema");
    }
    if (type == "array") {
        for (std::size_t i = 0; i < value.size(); ++i) {
            compare(document, schema["items"], value[i], pointer + "/" + std::to_string(i), wrong);
        }
    }
    if (type != "object" || !schema.contains("properties")) return;
    for (const auto& [name, part] : value.items()) {
        if (!schema["properties"].contains(name)) {
            wrong.push_back(pointer + "/" + name + " is not described");
        } else {
            compare(document, schema["properties"][name], part, pointer + "/" + name, wrong);
        }
    }
    for (const json& name : schema.value("required", json::array())) {
        if (!value.contains(name))
            wrong.push_back(pointer + "/" + std::string(name) + " is missing");
    }
}

TEST(Documents, ResponsesMatchTheirSchema) {
    sharedServer().awaitReady();
    auto client = sharedServer().client();
    const json document = documentAt("/openapi.json");
    const auto expectDescribed = [&](const char* schema, const json& value) {
        std::vector<std::string> wrong;
        compare(document, document["components"]["schemas"][schema], value, "", wrong);
        EXPECT_THAT(wrong, testing::IsEmpty()) << schema;
    };
    const json scenes = documentAt("/v1/scenes");
    expectDescribed("SceneList", scenes);
    std::size_t described = 0;
    for (const json& scene : scenes["scenes"]) {
        expectDescribed("Scene", documentAt(("/v1/scenes/" + std::string(scene["id"])).c_str()));
        described += scene["state"] == "ready";
    }
    EXPECT_GT(described, 0u);
    expectDescribed("Renderer", documentAt("/v1/renderer"));
    expectDescribed("Status", documentAt("/healthz"));
    expectDescribed("EnvironmentList", documentAt("/v1/environments"));
    expectDescribed("Environment", documentAt("/v1/environments/studio"));
    expectDescribed("Plan", json::parse(postJson(client, "/v1/plans", smallFrame())->body));
    const std::string composed = smallFrame(R"("effects": {"shadows": true}, "ground": {})");
    const json plan = json::parse(postJson(client, "/v1/plans", composed)->body);
    expectDescribed("Plan", plan);
    EXPECT_TRUE(plan.contains("composition"));
    const auto examined = postJson(client, "/v1/frames?explain=health", smallFrame());
    ASSERT_TRUE(examined && examined->status == 200);
    const json health = json::parse(partsOf(*examined).at(1).second);
    expectDescribed("Plan", health);
    EXPECT_TRUE(health.contains("health"));
    const auto started =
        postJson(client, "/v1/comparisons", smallFrame(R"("frames": 1, "samples": 2)"));
    ASSERT_TRUE(started);
    expectDescribed("Job", json::parse(started->body));
    const std::string place = started->get_header_value("Location");
    json job;
    EXPECT_TRUE(within(kPatience, [&] {
        job = documentAt(place.c_str());
        return job.value("state", "") != "queued" && job.value("state", "") != "running";
    }));
    EXPECT_EQ(job["state"], "done");
    expectDescribed("Job", job);
    expectDescribed("Problem",
                    json::parse(postJson(client, "/v1/plans", R"({"width": -1})")->body));
}

TEST(Documents, EveryResponseHasASchema) {
    const json document = documentAt("/openapi.json");
    std::size_t count = 0;
    for (const auto& [path, operations] : document["paths"].items()) {
        for (const auto& [method, operation] : operations.items()) {
            for (const auto& [status, response] : operation["responses"].items()) {
                const json contents = response.value("content", json::object());
                for (const auto& [type, content] : contents.items()) {
                    EXPECT_FALSE(content.value("schema", json()).empty())
                        << method << " " << path << " " << status << " " << type;
                    ++count;
                }
            }
        }
    }
    EXPECT_GT(count, 40u);
}

// Generated clients call operations by these names.
TEST(Documents, OperationsHaveUniqueIdsAndListTheirErrors) {
    const json document = documentAt("/openapi.json");
    std::set<std::string> names;
    std::size_t count = 0;
    for (const auto& [path, operations] : document["paths"].items()) {
        for (const auto& [method, operation] : operations.items()) {
            ++count;
            EXPECT_TRUE(names.insert(operation.value("operationId", "")).second) << path;
            EXPECT_TRUE(operation["responses"].contains("4XX")) << path;
        }
    }
    EXPECT_GE(count, 20u);
    EXPECT_EQ(document["components"]["securitySchemes"]["token"]["scheme"], "bearer");
    EXPECT_FALSE(document["servers"].empty());
}

TEST(Documents, EveryLinkParameterIsAccepted) {
    auto client = sharedServer().client();
    const json document = documentAt("/openapi.json");
    const json& parameters = document["paths"]["/v1/frames"]["get"]["parameters"];
    EXPECT_GT(parameters.size(), 30u);
    for (const json& parameter : parameters) {
        const std::string name = parameter["name"];
        if (name == "explain") continue;
        // A value that no field accepts: the response must recognise the name and reject the value.
        const auto result = client.Get("/v1/frames?" + name + "=" + std::string(300, 'x'));
        ASSERT_TRUE(result);
        EXPECT_THAT(result->body, testing::Not(HasSubstr("is not a known query name"))) << name;
        EXPECT_EQ(result->status, 422) << name;
    }
}

TEST(Documents, TheRendererReportsItsCapabilities) {
    const json renderer = documentAt("/v1/renderer");
    EXPECT_FALSE(renderer["renderer"].get<std::string>().empty());
    EXPECT_FALSE(renderer["version"].get<std::string>().empty());
    EXPECT_TRUE(renderer["software"].is_boolean());
    EXPECT_GE(renderer["threads"].get<int>(), 1);
    EXPECT_THAT(renderer["environments"], testing::Contains("sky"));
    EXPECT_EQ(renderer["limits"]["edge"], kMaxEdge);
    EXPECT_FALSE(renderer["program"]["version"].get<std::string>().empty());
    EXPECT_EQ(renderer["program"]["build"].get<std::string>().size(), 40u) << "a SHA-1 in hex";
}

TEST(Documents, HealthAndReadiness) {
    sharedServer().awaitReady();
    auto client = sharedServer().client();
    EXPECT_EQ(client.Get("/healthz")->status, 200);
    const auto ready = client.Get("/readyz");
    EXPECT_EQ(ready->status, 200) << ready->body;
}

TEST(Documents, MetricsAreInPrometheusFormat) {
    auto client = sharedServer().client();
    postJson(client, "/v1/frames", smallFrame());
    postJson(client, "/v1/frames", "{");
    const auto result = client.Get("/metrics");
    ASSERT_TRUE(result);
    EXPECT_THAT(result->get_header_value("Content-Type"), HasSubstr("text/plain; version=0.0.4"));
    std::istringstream lines(result->body);
    std::size_t samples = 0;
    for (std::string line; std::getline(lines, line);) {
        if (line.empty() || line[0] == '#') continue;
        const std::size_t space = line.rfind(' ');
        ASSERT_NE(space, std::string::npos) << line;
        EXPECT_TRUE(std::isalpha(static_cast<unsigned char>(line[0]))) << line;
        std::size_t used = 0;
        EXPECT_NO_THROW(std::stod(line.substr(space + 1), &used)) << line;
        EXPECT_EQ(used, line.size() - space - 1) << line;
        ++samples;
    }
    EXPECT_GT(samples, 10u);
    for (const char* name :
         {"clerestory_requests_total{route=\"/v1/frames\",status=\"200\"}",
          "clerestory_requests_total{route=\"/v1/frames\",status=\"400\"}",
          "clerestory_refusals_total{reason=\"notJson\"}", "clerestory_frame_seconds_bucket",
          "clerestory_passes_total{kind=\"surface\"}", "clerestory_queue_depth",
          "clerestory_not_modified_total", "process_resident_memory_bytes"}) {
        EXPECT_THAT(result->body, HasSubstr(name));
    }
}

TEST(Documents, ThePageAndItsFilesComeFromTheProgram) {
    auto client = sharedServer().client();
    const auto page = client.Get("/");
    ASSERT_TRUE(page);
    ASSERT_EQ(page->status, 200);
    EXPECT_EQ(page->get_header_value("Content-Type"), "text/html; charset=utf-8");
    // Every file that the page or one of its modules names is there.
    std::set<std::string> named;
    std::vector<std::string> unread{page->body};
    while (!unread.empty()) {
        const std::string text = std::move(unread.back());
        unread.pop_back();
        static const std::regex reference(
            R"re((?:src|href|from|import)\s*=?\s*"\.?/?([^":#]+)")re");
        for (std::sregex_iterator it(text.begin(), text.end(), reference), end; it != end; ++it) {
            const std::string name = (*it)[1];
            if (name.find('.') == std::string::npos || !named.insert(name).second) continue;
            const auto file = client.Get("/" + name);
            ASSERT_TRUE(file);
            EXPECT_EQ(file->status, 200) << name;
            unread.push_back(file->body);
        }
    }
    EXPECT_GE(named.size(), 2u) << "a script and a style";
}

TEST(Documents, HaveEntityTags) {
    auto client = sharedServer().client();
    for (const char* path : {"/", "/viewer.js", "/style.css", "/openapi.json"}) {
        SCOPED_TRACE(path);
        const auto first = client.Get(path);
        ASSERT_TRUE(first && first->status == 200);
        const std::string etag = first->get_header_value("ETag");
        ASSERT_FALSE(etag.empty());
        const auto again = client.Get(path, unless(etag));
        ASSERT_TRUE(again);
        EXPECT_EQ(again->status, 304);
        EXPECT_EQ(again->body, "");
        EXPECT_EQ(again->get_header_value("ETag"), etag);
        EXPECT_FALSE(again->has_header("Content-Length"));
        const auto other = client.Get(path, unless("\"x\""));
        ASSERT_TRUE(other);
        EXPECT_EQ(other->body, first->body);
    }
}

}  // namespace
}  // namespace clerestory::test
