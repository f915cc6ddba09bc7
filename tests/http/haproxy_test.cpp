// deploy/haproxy.cfg before three servers: one is killed under load, and no client notices.
#include "tests/support/free_port.h"
#include "tests/support/plain_effects.h"
#include "tests/support/raw_client.h"
#include "tests/support/server_process.h"
#include "tests/support/soon.h"

#include <gtest/gtest.h>
#include <httplib.h>
#include <nlohmann/json.hpp>

#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <string>
#include <thread>
#include <vector>

namespace clerestory::test {
namespace {

using namespace std::chrono_literals;

// How many servers the proxy believes to be up, at a port of its own.
std::string stateFrontend(int port) {
    return "frontend state\n"
           "    mode http\n"
           "    timeout client 5s\n"
           "    bind 127.0.0.1:" +
           std::to_string(port) +
           "\n"
           "    http-request return status 200 content-type text/plain lf-string "
           "%[nbsrv(renderers)]\n";
}

class Proxy {
public:
    Proxy(const char* program, int port, const std::vector<int>& servers) : statePort_(freePort()) {
        std::filesystem::create_directories(CLERESTORY_TEST_OUTPUT);
        const std::string stateFile = std::string(CLERESTORY_TEST_OUTPUT) + "/haproxy-state-" +
                                      std::to_string(statePort_) + ".cfg";
        std::ofstream(stateFile) << stateFrontend(statePort_);
        setenv("CLERESTORY_BIND", ("127.0.0.1:" + std::to_string(port)).c_str(), 1);
        for (std::size_t i = 0; i < servers.size(); ++i) {
            setenv(("CLERESTORY_" + std::to_string(i + 1)).c_str(),
                   ("127.0.0.1:" + std::to_string(servers[i])).c_str(), 1);
        }
        std::string words[] = {
            program, "-db",    "-q", "-f", CLERESTORY_SOURCE_DIR "/deploy/haproxy.cfg",
            "-f",    stateFile};
        std::vector<char*> arguments;
        for (std::string& word : words) arguments.push_back(word.data());
        arguments.push_back(nullptr);
        posix_spawn(&id_, program, nullptr, nullptr, arguments.data(), environ);
    }
    ~Proxy() {
        kill(id_, SIGKILL);
        waitpid(id_, nullptr, 0);
    }
    Proxy(const Proxy&) = delete;
    Proxy& operator=(const Proxy&) = delete;

    // Waits until the proxy believes so many servers to be up. Returns false after a minute.
    bool awaitServersUp(int count) const {
        return within(60s, [&] {
            httplib::Client client("127.0.0.1", statePort_);
            const auto result = client.Get("/");
            return result && result->status == 200 && result->body == std::to_string(count);
        });
    }

private:
    const int statePort_;
    pid_t id_ = -1;
};

std::string body(int i) {
    // The scene's name chooses the server, so that all three have some.
    const char* scenes[] = {"six-walls", "orbiting-cubes", "teapots"};
    return R"({"scene": ")" + std::string(scenes[i % 3]) + R"(", "width": 48, "height": 32, )" +
           kPlainEffects + R"(, "exposure": )" + std::to_string(i % 7) + "}";
}

TEST(HaProxy, KillingOneServerUnderLoadLosesNoRequest) {
    const char* program = "/usr/sbin/haproxy";
    if (access(program, X_OK) != 0) GTEST_SKIP() << "haproxy is not installed";
    const std::vector<std::string> flags = {"--scene", "six-walls", "--no-standby",
                                            "--queue-seconds", "60"};
    std::vector<std::unique_ptr<ServerProcess>> servers;
    std::vector<int> ports;
    for (int i = 0; i < 3; ++i) {
        servers.push_back(std::make_unique<ServerProcess>(flags));
        ports.push_back(servers.back()->port());
    }
    for (const auto& server : servers) ASSERT_TRUE(server->waitUntilReady());
    const int port = freePort();
    const Proxy proxy(program, port, ports);

    // Each server has its scenes, and all say the same.
    std::map<std::string, std::string> expected;
    for (const int one : ports) {
        httplib::Client direct("127.0.0.1", one);
        direct.set_read_timeout(60);
        for (int i = 0; i < 21; ++i) {
            auto result = direct.Post("/v1/frames", body(i), "application/json");
            within(30s, [&] {  // its scene loads
                if (result && result->status == 409) {
                    result = direct.Post("/v1/frames", body(i), "application/json");
                }
                return !result || result->status != 409;
            });
            ASSERT_TRUE(result && result->status == 200);
            const auto known = expected.emplace(body(i), result->body).first;
            ASSERT_TRUE(known->second == result->body);
        }
    }
    ASSERT_TRUE(proxy.awaitServersUp(3));

    std::atomic<bool> ending{false};
    std::atomic<int> right{0}, wrong{0};
    std::vector<std::thread> clients;
    for (int c = 0; c < 4; ++c) {
        clients.emplace_back([&, c] {
            httplib::Client client("127.0.0.1", port);
            client.set_keep_alive(true);
            client.set_read_timeout(60);
            for (int n = c; !ending; ++n) {
                const auto result = client.Post("/v1/frames", body(n), "application/json");
                const bool equal =
                    result && result->status == 200 && result->body == expected.at(body(n));
                ++(equal ? right : wrong);
                if (!equal && result) ADD_FAILURE() << result->status << " " << result->body;
            }
        });
    }
    const auto awaitMore = [&] {  // under load, independent of the machine's speed
        const int goal = right + 20;
        EXPECT_TRUE(within(60s, [&] { return right >= goal; }));
    };
    awaitMore();
    const int before = right;
    for (int victim = 0; victim < 2; ++victim) {
        servers[victim]->signal(SIGKILL);
        EXPECT_TRUE(proxy.awaitServersUp(2 - victim));
        awaitMore();
    }
    ending = true;
    for (std::thread& client : clients) client.join();
    EXPECT_EQ(wrong, 0);
    EXPECT_GE(before, 20);
    EXPECT_GE(right, before + 40);
}

}  // namespace
}  // namespace clerestory::test
