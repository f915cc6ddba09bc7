// A server in the test's process on a free port.
#pragma once

#include "image/image.h"
#include "server/backend/local_backend.h"
#include "server/server.h"
#include "server/worker/worker_backend.h"
#include "tests/support/plain_effects.h"

#include <httplib.h>
#include <nlohmann/json.hpp>

#include <string>

namespace clerestory::test {

// Small and quiet: a free port, six-walls first, then what the test changes.
Config testConfig();

// With keep-alive and long timeouts.
httplib::Client clientOf(Server& server);

// Requires a server with render workers.
Supervisor& supervisorOf(Server& server);
// Require a server with render workers. Wait for the standby; kill the active worker and wait for
// its replacement.
void awaitStandby(Server& server);
void killWorker(Server& server);

class TestServer {
public:
    explicit TestServer(const Config& config = testConfig());
    ~TestServer();  // expects that the driver had nothing to say
    Server& server() { return server_; }
    LocalBackend& backend() { return dynamic_cast<LocalBackend&>(server_.backend()); }
    httplib::Client client() { return clientOf(server_); }
    void stop() { server_.stop(); }

    // Returns when the default scene's shaders are compiled.
    void awaitReady();

    // Since the renderer was made.
    std::uint64_t framesDrawn();

    // Keeps the OpenGL thread busy until the returned object goes.
    std::shared_ptr<void> holdRenderer();

private:
    Server server_;
};

// One for all tests of a program that change nothing in it.
TestServer& sharedServer();

// The header If-None-Match, on a connection that then closes: clients of the library read the body
// of a 304, which has none, until then.
httplib::Headers unless(const std::string& entityTags);

httplib::Result postJson(httplib::Client& client, const std::string& path, const std::string& body);
// Repeats the request while the answer is 409: its scene is loading, or a budget is being measured.
// Returns the last answer, which is still 409 if that takes minutes.
httplib::Result postUntilReady(httplib::Client& client, const std::string& path,
                               const std::string& body);

// A frame of 64 x 48 of six-walls; `more` adds fields, as in R"("time": 1)". Has kPlainEffects
// unless it adds effects.
std::string smallFrame(const std::string& more = "");

// The body that a problem document must be, or a failed expectation and null.
nlohmann::json problemOf(const httplib::Result& result, int status);

// The parts of a multipart/mixed answer: media type and content.
std::vector<std::pair<std::string, std::string>> partsOf(const httplib::Response& response);

}  // namespace clerestory::test
