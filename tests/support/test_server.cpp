#include "tests/support/test_server.h"
#include "tests/support/soon.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <spdlog/spdlog.h>

namespace clerestory::test {

Config testConfig() {
    spdlog::set_level(spdlog::level::off);  // before any thread of a server looks at it
    Config config;
    config.renderer.debugOutput = true;
    config.http.port = 0;
    config.scenes.scenes = {"six-walls"};
    config.scenes.import.importer = CLERESTORY_PROGRAM;
    config.frameCacheBytes = 0;  // tests repeat requests to draw again
    config.queue = 256;
    config.queueSeconds = 60.0;
    config.deadlineSeconds = 60.0;  // sanitizers are slow
    return config;
}

httplib::Client clientOf(Server& server) {
    httplib::Client client("127.0.0.1", server.port());
    client.set_keep_alive(true);
    client.set_tcp_nodelay(true);
    client.set_read_timeout(600);
    return client;
}

Supervisor& supervisorOf(Server& server) {
    return dynamic_cast<WorkerBackend&>(server.backend()).supervisor();
}

void awaitStandby(Server& server) {
    EXPECT_TRUE(within(kPatience, [&] { return supervisorOf(server).processes().second != 0; }));
}

void killWorker(Server& server) {
    awaitStandby(server);
    const pid_t worker = supervisorOf(server).processes().first;
    ::kill(worker, SIGKILL);
    EXPECT_TRUE(
        within(kPatience, [&] { return supervisorOf(server).processes().first != worker; }));
}

TestServer::TestServer(const Config& config) : server_(config) {
    server_.start();
}

TestServer::~TestServer() {
    std::promise<std::vector<std::string>> messages;
    backend().queue().post([&](Renderer& r) { messages.set_value(r.driverMessages()); });
    for (const std::string& message : messages.get_future().get()) ADD_FAILURE() << message;
}

void TestServer::awaitReady() {
    EXPECT_TRUE(within(kPatience, [&] { return client().Get("/readyz")->status == 200; }));
}

std::uint64_t TestServer::framesDrawn() {
    std::promise<std::uint64_t> frames;
    backend().queue().post([&](Renderer& r) { frames.set_value(r.counters().frames); });
    return frames.get_future().get();
}

std::shared_ptr<void> TestServer::holdRenderer() {
    auto released = std::make_shared<std::promise<void>>();
    auto held = std::make_shared<std::promise<void>>();
    backend().queue().post([held, future = released->get_future().share()](Renderer&) {
        held->set_value();
        future.wait();
    });
    held->get_future().wait();
    return {nullptr, [released](void*) { released->set_value(); }};
}

namespace {

std::unique_ptr<TestServer> shared;

// Ends the shared server while a failed expectation still counts.
class SharedServerCleanup : public testing::Environment {
    void TearDown() override { shared.reset(); }
};
const auto* const kEndOfTests = testing::AddGlobalTestEnvironment(new SharedServerCleanup);

}  // namespace

TestServer& sharedServer() {
    if (!shared) shared = std::make_unique<TestServer>();
    return *shared;
}

httplib::Headers unless(const std::string& entityTags) {
    return {{"If-None-Match", entityTags}, {"Connection", "close"}};
}

httplib::Result postJson(httplib::Client& client, const std::string& path,
                         const std::string& body) {
    return client.Post(path, body, "application/json");
}

httplib::Result postUntilReady(httplib::Client& client, const std::string& path,
                               const std::string& body) {
    httplib::Result answer(nullptr, httplib::Error::Unknown);
    within(kPatience, [&] {
        answer = postJson(client, path, body);
        return !answer || answer->status != 409;
    });
    return answer;
}

std::string smallFrame(const std::string& more) {
    const bool plain = more.find("\"effects\"") == std::string::npos;
    return R"({"scene": "six-walls", "width": 64, "height": 48)" +
           (plain ? ", " + kPlainEffects : "") + (more.empty() ? "" : ", " + more) + "}";
}

nlohmann::json problemOf(const httplib::Result& result, int status) {
    if (!result) {
        ADD_FAILURE() << "no answer: " << httplib::to_string(result.error());
        return nullptr;
    }
    EXPECT_EQ(result->status, status) << result->body;
    EXPECT_EQ(result->get_header_value("Content-Type"), "application/problem+json");
    const auto json = nlohmann::json::parse(result->body, nullptr, false);
    EXPECT_TRUE(json.is_object()) << result->body;
    if (!json.is_object()) return nullptr;
    EXPECT_EQ(json.value("status", 0), status);
    EXPECT_EQ(json.value("requestId", ""), result->get_header_value("X-Request-Id"));
    EXPECT_FALSE(json.value("title", "").empty());
    EXPECT_EQ(json.value("type", ""), "urn:clerestory:problem:" + json.value("code", ""));
    EXPECT_FALSE(json.value("detail", "").empty());
    return json;
}

std::vector<std::pair<std::string, std::string>> partsOf(const httplib::Response& response) {
    const std::string type = response.get_header_value("Content-Type");
    const std::string key = "boundary=";
    const std::size_t at = type.find(key);
    if (at == std::string::npos) return {};
    const std::string mark = "--" + type.substr(at + key.size());
    std::vector<std::pair<std::string, std::string>> parts;
    std::size_t begin = response.body.find(mark);
    while (begin != std::string::npos) {
        const std::size_t head = begin + mark.size() + 2;
        const std::size_t end = response.body.find("\r\n" + mark, head);
        if (end == std::string::npos) break;
        const std::string part = response.body.substr(head, end - head);
        const std::size_t blank = part.find("\r\n\r\n");
        const std::string name = "Content-Type: ";
        const std::size_t from = part.find(name) + name.size();
        parts.emplace_back(part.substr(from, part.find("\r\n", from) - from),
                           part.substr(blank + 4));
        begin = end + 2;
    }
    return parts;
}

}  // namespace clerestory::test
