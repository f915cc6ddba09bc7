// deploy/haproxy.cfg under overload, and both proxies with forged addresses, streams and sequences.
#include "server/http/http_server.h"
#include "tests/support/free_port.h"
#include "tests/support/overload.h"
#include "tests/support/raw_client.h"
#include "tests/support/server_process.h"
#include "tests/support/soon.h"

#include <gtest/gtest.h>

#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <regex>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

namespace clerestory::test {
namespace {

using namespace std::chrono_literals;

constexpr const char* kHaProxy = "/usr/sbin/haproxy";
constexpr const char* kNginx = "/usr/sbin/nginx";

std::string contentOf(const std::string& file) {
    std::ostringstream text;
    text << std::ifstream(file).rdbuf();
    return text.str();
}

// A program as a child process.
class Program {
public:
    explicit Program(std::vector<std::string> words) {
        std::vector<char*> arguments;
        for (std::string& word : words) arguments.push_back(word.data());
        arguments.push_back(nullptr);
        posix_spawn(&id_, words.front().c_str(), nullptr, nullptr, arguments.data(), environ);
    }
    ~Program() {
        kill(id_, SIGTERM);
        waitpid(id_, nullptr, 0);
    }
    Program(const Program&) = delete;
    Program& operator=(const Program&) = delete;

private:
    pid_t id_ = -1;
};

// HAProxy with the shipped file. Servers that are not given do not exist.
std::unique_ptr<Program> haProxy(int port, std::vector<int> servers) {
    while (servers.size() < 3) servers.push_back(freePort());
    setenv("CLERESTORY_BIND", ("127.0.0.1:" + std::to_string(port)).c_str(), 1);
    for (std::size_t i = 0; i < servers.size(); ++i) {
        setenv(("CLERESTORY_" + std::to_string(i + 1)).c_str(),
               ("127.0.0.1:" + std::to_string(servers[i])).c_str(), 1);
    }
    return std::make_unique<Program>(std::vector<std::string>{
        kHaProxy, "-db", "-q", "-f", CLERESTORY_SOURCE_DIR "/deploy/haproxy.cfg"});
}

// nginx with the shipped file, whose ports are replaced.
std::unique_ptr<Program> nginx(int port, int server) {
    std::string file = contentOf(CLERESTORY_SOURCE_DIR "/deploy/nginx.conf");
    file = std::regex_replace(file, std::regex("127.0.0.1:8080"),
                              "127.0.0.1:" + std::to_string(server));
    file = std::regex_replace(file, std::regex("listen 8081"),
                              "listen 127.0.0.1:" + std::to_string(port));
    const std::string folder =
        std::string(CLERESTORY_TEST_OUTPUT) + "/nginx-" + std::to_string(port);
    std::filesystem::create_directories(folder);
    const std::string whole = folder + "/nginx.conf";
    std::ofstream(whole) << "daemon off; master_process off; pid " << folder << "/pid; error_log "
                         << folder
                         << "/errors; events {} http { access_log off; client_body_temp_path "
                         << folder << "/body; proxy_temp_path " << folder
                         << "/proxy; fastcgi_temp_path " << folder << "/f; uwsgi_temp_path "
                         << folder << "/u; scgi_temp_path " << folder << "/s;\n"
                         << file << "}\n";
    return std::make_unique<Program>(
        std::vector<std::string>{kNginx, "-p", folder, "-e", folder + "/errors", "-c", whole});
}

bool awaitStatus(int port, const std::string& path, int status) {
    return within(
        30s, [&] { return statusOf(ask(port, get(path, "Connection: close\r\n"))) == status; });
}

// Answers with the name of its client.
class ClientServer {
public:
    ClientServer()
        : front_({.port = 0, .threads = 2, .access = {.clientHeader = "X-Forwarded-For"}},
                 {.quick = [](const Call&, std::string_view) { return std::optional<Answer>(); },
                  .respond =
                      [](const Call& call) {
                          return Answer{.type = "text/plain", .body = call.client};
                      },
                  .refuse =
                      [](const Call& call, const Problem& problem) {
                          return Answer{.status = problem.status,
                                        .type = "application/problem+json",
                                        .body = problemJson(problem, call.requestId)};
                      },
                  .paths = {.open = [](std::string_view) { return true; },
                            .linked = [](std::string_view) { return false; }}}),
          thread_([this] { front_.serve(); }) {}
    ~ClientServer() {
        front_.stop();
        thread_.join();
    }
    int port() const { return front_.port(); }

private:
    HttpServer front_;
    std::thread thread_;
};

// A8 of the catalogue of attacks.
void expectTrueAddresses(int port) {
    for (const char* forged :
         {"", "X-Forwarded-For: 66.6.6.6\r\n", "X-Forwarded-For: 66.6.6.6, 66.6.6.7\r\n",
          "x-forwarded-for: 66.6.6.6\r\nX-Forwarded-For: 66.6.6.7\r\n"}) {
        const std::string answer =
            ask(port, get("/", std::string(forged) + "Connection: close\r\n"), 10, "127.0.0.77");
        EXPECT_EQ(bodyOf(answer), "127.0.0.77") << forged;
    }
}

TEST(Proxies, HaProxyNamesTheTrueClient) {
    if (access(kHaProxy, X_OK) != 0) GTEST_SKIP() << "haproxy is not installed";
    const ClientServer server;
    const int port = freePort();
    const auto proxy = haProxy(port, {server.port()});
    ASSERT_TRUE(awaitStatus(port, "/", 200));
    expectTrueAddresses(port);
}

TEST(Proxies, NginxNamesTheTrueClient) {
    if (access(kNginx, X_OK) != 0) GTEST_SKIP() << "nginx is not installed";
    const ClientServer server;
    const int port = freePort();
    const auto proxy = nginx(port, server.port());
    ASSERT_TRUE(awaitStatus(port, "/", 200));
    expectTrueAddresses(port);
}

TEST(Proxies, NginxPassesStreamsAndSequencesOnAsTheyAreDrawn) {
    if (access(kNginx, X_OK) != 0) GTEST_SKIP() << "nginx is not installed";
    const ServerProcess server({"--scene", "six-walls", "--no-standby"});
    ASSERT_TRUE(server.waitUntilReady());
    const int port = freePort();
    const auto proxy = nginx(port, server.port());
    ASSERT_TRUE(awaitStatus(port, "/readyz", 200));
    auto stream = std::make_unique<RawClient>(port);
    stream->send(get("/v1/stream?width=32&height=24&play=1&fps=20"));
    std::string pictures;
    const auto count = [&] {
        int found = 0;
        for (std::size_t at = 0; (at = pictures.find("--frame", at)) != pictures.npos; ++at)
            ++found;
        return found;
    };
    for (int i = 0; i < 200 && count() < 4; ++i) pictures += stream->receive(0.1);
    EXPECT_GE(count(), 4) << "as they are drawn: the stream has no end";
    stream.reset();  // its frames come before those of a sequence
    const std::string body = R"({"common": {"scene": "six-walls", "width": 32, "height": 24},
        "frames": [{"time": 0}, {"time": 1}, {"time": 2}]})";
    RawClient sequence(port);
    sequence.send(post("/v1/sequences", body, "Accept: multipart/mixed\r\nConnection: close\r\n"));
    const std::string answer = sequence.receive(60);
    EXPECT_EQ(statusOf(answer), 200) << answer.substr(0, 500);
    for (const char* name : {"000000", "000002", "manifest"}) {
        EXPECT_NE(answer.find(name), std::string::npos) << name;
    }
}

// A1 of the catalogue of attacks: no client is left without an answer, and every refusal is the
// server's, which says when to come back.
TEST(Proxies, HaProxyLosesNothingUnderOverload) {
    // Slow enough that fifty times what one server draws are fewer than a thousand requests a
    // second: more than that is a test of the proxy.
    const std::string frame = post("/v1/frames", R"({"scene": "six-walls", "width": 1280,
        "height": 900, "accuracy": "fine", "output": {"quality": 50}})");
    if (access(kHaProxy, X_OK) != 0) GTEST_SKIP() << "haproxy is not installed";
    std::vector<std::unique_ptr<ServerProcess>> servers;
    std::vector<int> ports;
    for (int i = 0; i < 3; ++i) {
        servers.push_back(std::make_unique<ServerProcess>(std::vector<std::string>{
            "--scene", "six-walls", "--no-standby", "--frame-cache", "0"}));
        ports.push_back(servers.back()->port());
        ASSERT_TRUE(servers.back()->waitUntilReady());
        for (int n = 0; n < 3; ++n) ask(ports.back(), frame, 60);
    }
    const auto begun = std::chrono::steady_clock::now();
    for (int n = 0; n < 5; ++n) ask(ports[0], frame, 60);
    const double seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count() / 5;
    for (std::size_t count = 1; count <= ports.size(); ++count) {
        const int port = freePort();
        const auto proxy = haProxy(port, {ports.begin(), ports.begin() + static_cast<long>(count)});
        ASSERT_TRUE(awaitStatus(port, "/readyz", 200));
        for (const double factor : {4.0, 50.0}) {
            const double perSecond = std::min(factor / seconds, 1000.0);
            const auto answers = openLoop(port, frame, perSecond, 2.0, 60.0);
            int lost = 0, byProxy = 0, other = 0;
            for (const SentRequest& one : answers) {
                lost += one.status == 0;
                byProxy +=
                    one.status == 502 || one.status == 504 || (one.status == 503 && !one.saysWhen);
                other += one.status != 0 && one.status != 200 && one.status < 502;
            }
            std::printf(
                "%zu servers, %2.0fx (%.0f a second): %zu requests, %d frames, %d refused, "
                "%d lost, %d answered by the proxy\n",
                count, factor, perSecond, answers.size(), countOf(answers, 200),
                countOf(answers, 503), lost, byProxy);
            EXPECT_EQ(lost, 0);
            EXPECT_EQ(byProxy, 0);
            EXPECT_EQ(other, 0);
            EXPECT_GT(countOf(answers, 200), 0);
        }
    }
}

}  // namespace
}  // namespace clerestory::test
