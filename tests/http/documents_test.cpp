// What the server tells about itself: schema, renderer, health, metrics, the page.
#include "tests/support/test_server.h"

#include "comparison/comparison_request.h"
#include "server/server_routes.h"

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
    expectListed<FilterRequest>(properties["filters"]["items"]);
    EXPECT_EQ(properties["filters"]["maxItems"], kMostFilters);
    const json& kernel = properties["filters"]["items"]["properties"]["kernel"]["oneOf"];
    EXPECT_EQ(kernel[0]["enum"][0], "sharpen");
    EXPECT_EQ(kernel[1]["minItems"], 9);
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
    for (auto [path, method] : routePaths()) {
        std::transform(method.begin(), method.end(), method.begin(), ::tolower);
        EXPECT_TRUE(document["paths"][path].contains(method)) << path;
    }
}

TEST(Documents, EveryParameterOfALinkIsTaken) {
    auto client = sharedServer().client();
    const json document = documentAt("/openapi.json");
    const json& parameters = document["paths"]["/v1/frames"]["get"]["parameters"];
    EXPECT_GT(parameters.size(), 30u);
    for (const json& parameter : parameters) {
        const std::string name = parameter["name"];
        if (name == "explain") continue;
        // A value that no field takes: the answer must know the name and refuse the value.
        const auto result = client.Get("/v1/frames?" + name + "=" + std::string(300, 'x'));
        ASSERT_TRUE(result);
        EXPECT_THAT(result->body, testing::Not(HasSubstr("is not a known query name"))) << name;
        EXPECT_EQ(result->status, 422) << name;
    }
}

TEST(Documents, TheRendererTellsWhatItIs) {
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
    auto client = sharedServer().client();
    EXPECT_EQ(client.Get("/healthz")->status, 200);
    const auto ready = client.Get("/readyz");
    EXPECT_EQ(ready->status, 200) << ready->body;
}

TEST(Documents, MetricsAreTextThatPrometheusReads) {
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

}  // namespace
}  // namespace clerestory::test
