// The first minute: servers with empty caches receive requests for every preset and every effect
// from several clients. Compiling shaders makes frames late. It is not overload, and no response
// may say so. No time is asserted.
#include "tests/support/plain_effects.h"
#include "tests/support/raw_client.h"
#include "tests/support/server_process.h"

#include <gtest/gtest.h>
#include <httplib.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <atomic>
#include <charconv>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <mutex>
#include <optional>
#include <thread>

namespace clerestory::test {
namespace {

using namespace std::chrono_literals;
namespace fs = std::filesystem;

constexpr std::size_t kClients = 3;
// Seconds. The chapel's shaders take longer, 34 s on two idle cores when all are compiled one after
// the other; three frames without compilation do not, also where seven others use each core.
constexpr const char* kDeadline = "30";
// Seconds. A few small frames fill this queue only if compilation counts as waiting work.
constexpr const char* kQueue = "60";
// Every undocumented response is reported; after this number of them the test ends.
constexpr int kMaxWrong = 10;

// Empty folders for all caches of the servers that are started from here on.
class EmptyCaches {
public:
    EmptyCaches() {
        const std::string test = testing::UnitTest::GetInstance()->current_test_info()->name();
        folder_ = fs::path(CLERESTORY_TEST_OUTPUT) / ("cold-start-" + test);
        fs::remove_all(folder_);
        set("MESA_SHADER_CACHE_DIR", "mesa");
        set("XDG_CACHE_HOME", "xdg");
        set("HOME", "home");
        ::unsetenv("MESA_SHADER_CACHE_DISABLE");
    }
    ~EmptyCaches() {
        std::error_code error;
        fs::remove_all(folder_, error);
        for (const auto& [variable, value] : former_) {
            value ? ::setenv(variable.c_str(), value->c_str(), 1) : ::unsetenv(variable.c_str());
        }
    }
    EmptyCaches(const EmptyCaches&) = delete;
    EmptyCaches& operator=(const EmptyCaches&) = delete;

private:
    void set(const char* variable, const char* name) {
        const char* value = std::getenv(variable);
        former_[variable] = value ? std::optional<std::string>(value) : std::nullopt;
        fs::create_directories(folder_ / name);
        ::setenv(variable, (folder_ / name).c_str(), 1);
    }

    fs::path folder_;
    std::map<std::string, std::optional<std::string>> former_;
};

// Every preset with all effects; with the usual preset every effect alone, and none.
std::vector<std::string> requestsFor(const std::string& scene) {
    const std::vector<std::string> effects = {
        "emission",       "refraction", "planarReflection", "environmentReflection",
        "materialLayers", "shadows",    "indirectLight"};
    std::vector<std::string> list;
    const auto add = [&](const char* preset, const std::vector<std::string>& on) {
        // A fine frame costs the most after compilation too; it stays far below the deadline.
        const bool fine = std::string_view(preset) == "fine";
        nlohmann::ordered_json body = {{"scene", scene},
                                       {"width", fine ? 96 : 160},
                                       {"height", fine ? 54 : 90},
                                       {"accuracy", preset}};
        for (const std::string& effect : effects) {
            body["effects"][effect] = std::find(on.begin(), on.end(), effect) != on.end();
        }
        list.push_back(body.dump());
    };
    for (const char* preset : {"standard", "draft", "fine"}) add(preset, effects);
    for (const std::string& effect : effects) add("standard", {effect});
    add("standard", {});
    return list;
}

httplib::Client clientOf(const ServerProcess& server) {
    httplib::Client client("127.0.0.1", server.port());
    client.set_keep_alive(true);
    client.set_tcp_nodelay(true);
    client.set_read_timeout(std::chrono::seconds(600));  // CTest ends a test that waits for ever
    return client;
}

// Between 0 and 1: the member `progress`, or "42 %" in the detail.
std::optional<double> progressOf(const nlohmann::json& problem) {
    const auto member = problem.find("progress");
    if (member != problem.end() && member->is_number()) return member->get<double>();
    const std::string detail = problem.value("detail", "");
    const std::size_t end = detail.find(" %");
    if (end == std::string::npos) return std::nullopt;
    const std::size_t before = detail.find_last_not_of("0123456789", end - 1);
    const std::size_t begin = before == std::string::npos ? 0 : before + 1;
    int percent = 0;
    const auto read = std::from_chars(detail.data() + begin, detail.data() + end, percent);
    if (read.ec != std::errc() || begin == end) return std::nullopt;
    return percent / 100.0;
}

// Responses to a client that repeats one request.
class Waiting {
public:
    // The wait that the response requests; none if it is not a response that a client may receive
    // while shaders compile, with the reason in `wrong`.
    std::optional<std::chrono::seconds> after(const httplib::Result& result, std::string& wrong) {
        wrong.clear();
        if (!result) {
            wrong = "no answer: " + httplib::to_string(result.error());
            return std::nullopt;
        }
        const auto refuse = [&](const std::string& what) {
            wrong = what + ": " + std::to_string(result->status) + " " + result->body;
            return std::nullopt;
        };
        if (result->status != 409 && result->status != 503) return refuse("unexpected status");
        const int seconds = std::atoi(result->get_header_value("Retry-After").c_str());
        if (seconds < 1) return refuse("no Retry-After");
        if (result->get_header_value("Content-Type") != "application/problem+json") {
            return refuse("not a problem document");
        }
        const auto problem = nlohmann::json::parse(result->body, nullptr, false);
        if (!problem.is_object() || problem.value("status", 0) != result->status ||
            problem.value("title", "").empty() || problem.value("detail", "").empty()) {
            return refuse("not a problem document");
        }
        const auto progress = progressOf(problem);
        if (!progress) return refuse("no progress");
        if (*progress < 0.0 || *progress > 1.0) return refuse("progress out of range");
        // Within a stage; a later stage starts from 0.
        std::string stage = problem.value("code", "") + problem.value("stage", "");
        for (const char c : problem.value("detail", "")) {
            if (c < '0' || c > '9') stage += c;
        }
        const auto known = reached_.emplace(stage, *progress).first;
        if (*progress < known->second) return refuse("progress went back");
        known->second = *progress;
        return std::chrono::seconds(seconds);
    }

private:
    std::map<std::string, double> reached_;
};

// Frames of one server: each request until it has its picture. All pictures of a request with the
// same revision of the light are equal.
class Frames {
public:
    explicit Frames(const ServerProcess& server) : server_(server) {}

    // Every request, starting with this one, repeated according to Retry-After.
    void askAll(const std::vector<std::string>& requests, std::size_t first) {
        httplib::Client client = clientOf(server_);
        for (std::size_t i = 0; i < requests.size(); ++i) {
            const std::string& request = requests[(first + i) % requests.size()];
            Waiting waiting;
            for (;;) {
                const auto result = client.Post("/v1/frames", request, "application/json");
                if (result && result->status == 200) {
                    keep(request, result->get_header_value("Clerestory-Light"), result->body);
                    break;
                }
                std::string wrong;
                const auto wait = waiting.after(result, wrong);
                if (!wait) {
                    ADD_FAILURE() << request << "\n  " << wrong;
                    if (++wrong_ >= kMaxWrong) return;
                }
                std::this_thread::sleep_for(wait.value_or(1s));
            }
        }
    }
    bool givenUp() const { return wrong_ >= kMaxWrong; }
    // Requests that have a picture.
    std::size_t pictures() const { return pictures_.size(); }

private:
    void keep(const std::string& request, const std::string& light, const std::string& bytes) {
        const std::lock_guard lock(mutex_);
        const auto [known, isNew] = pictures_[request].emplace(light, bytes);
        if (!isNew && known->second != bytes) {
            ADD_FAILURE() << request << "\n  an equal request got other bytes, light: "
                          << (light.empty() ? "none" : light);
        }
    }

    const ServerProcess& server_;
    std::mutex mutex_;
    std::map<std::string, std::map<std::string, std::string>> pictures_;  // by request, by light
    std::atomic<int> wrong_{0};
};

// Polls /readyz: 503 with a reason, then 200, and never 503 again.
class Readiness {
public:
    explicit Readiness(const ServerProcess& server)
        : thread_([this, client = clientOf(server)]() mutable {
              while (!ending_) {
                  look(client);
                  std::this_thread::sleep_for(50ms);
              }
          }) {}
    ~Readiness() { end(); }
    Readiness(const Readiness&) = delete;
    Readiness& operator=(const Readiness&) = delete;

    void end() {
        ending_ = true;
        if (thread_.joinable()) thread_.join();
    }
    void await() const { ready_.wait(false); }

private:
    void look(httplib::Client& client) {
        const auto result = client.Get("/readyz");
        if (failed_) return;
        std::string wrong;
        if (!result) {
            wrong = "no answer: " + httplib::to_string(result.error());
        } else if (result->status == 200) {
            ready_ = true;
            ready_.notify_all();
        } else if (result->status != 503) {
            wrong = std::to_string(result->status) + " " + result->body;
        } else if (ready_) {
            wrong = "no longer ready: " + result->body;
        } else if (std::atoi(result->get_header_value("Retry-After").c_str()) < 1) {
            wrong = "no Retry-After: " + result->body;
        }
        if (wrong.empty()) return;
        ADD_FAILURE() << "/readyz: " << wrong;
        failed_ = true;
        ready_ = true;  // nothing more to wait for
        ready_.notify_all();
    }

    std::atomic<bool> ending_{false}, ready_{false};
    bool failed_ = false;
    std::thread thread_;  // last: it uses the members above
};

// Over all labels; -1: there is no such line.
double sumOf(const std::string& metrics, const std::string& name) {
    double sum = -1.0;
    for (std::size_t at = 0; (at = metrics.find("\n" + name, at)) != std::string::npos;) {
        at += name.size() + 1;
        const std::size_t end = metrics.find('\n', at);
        const std::size_t value = metrics.rfind(' ', end);
        if (metrics[at] != ' ' && metrics[at] != '{') continue;  // a longer name
        sum = std::max(sum, 0.0) + std::atof(metrics.c_str() + value);
    }
    return sum;
}

void expectFirstUse(const std::vector<std::string>& scenes) {
    const EmptyCaches caches;
    std::vector<std::string> flags = {"--deadline", kDeadline,         "--queue-seconds",
                                      kQueue,       "--first-compile", "fast"};
    std::vector<std::string> requests;
    for (const std::string& scene : scenes) {
        flags.insert(flags.end(), {"--scene", scene});
        for (std::string& request : requestsFor(scene)) requests.push_back(std::move(request));
    }
    const ServerProcess server(flags);
    ASSERT_GT(server.port(), 0);
    Readiness readiness(server);
    Frames frames(server);
    std::vector<std::thread> clients;
    for (std::size_t c = 0; c < kClients; ++c) {
        clients.emplace_back([&, c] { frames.askAll(requests, c * requests.size() / kClients); });
    }
    for (std::thread& client : clients) client.join();
    ASSERT_FALSE(frames.givenUp());
    EXPECT_EQ(frames.pictures(), requests.size());
    readiness.await();
    frames.askAll(requests, 0);  // all is compiled
    readiness.end();

    httplib::Client client = clientOf(server);
    const auto metrics = client.Get("/metrics");
    ASSERT_TRUE(metrics && metrics->status == 200);
    EXPECT_GT(sumOf(metrics->body, "clerestory_shader_compile_seconds_total"), 0.0);
    EXPECT_GT(sumOf(metrics->body, "clerestory_shader_programs_total"), 0.0);
    EXPECT_EQ(metric(server.port(), R"(clerestory_worker_events{event="ended"})"), 0.0);
}

// The first renderer compiles without optimising; the standby replaces it without failed requests.
TEST(ColdStart, TheOptimisingRendererGivesTheSameBytes) {
    const EmptyCaches caches;
    const ServerProcess server({"--scene", "teapots", "--first-compile", "fast"});
    ASSERT_GT(server.port(), 0);
    httplib::Client client = clientOf(server);
    const auto renderer = client.Get("/v1/renderer");
    ASSERT_TRUE(renderer);
    if (renderer->status == 200 &&
        !nlohmann::json::parse(renderer->body).at("software").get<bool>()) {
        GTEST_SKIP() << "the driver always optimises";
    }
    std::map<std::string, std::string> pictures;  // by renderer
    while (!pictures.contains("2")) {
        const auto frame =
            client.Get("/v1/frames?width=160&height=90&output.format=png" + kPlainLink);
        ASSERT_TRUE(frame);
        if (frame->status == 409 || frame->status == 503) {
            ASSERT_TRUE(frame->has_header("Retry-After")) << frame->body;
            continue;
        }
        ASSERT_EQ(frame->status, 200) << frame->body;
        const auto [seen, isNew] =
            pictures.emplace(frame->get_header_value("Clerestory-Worker"), frame->body);
        EXPECT_EQ(seen->second, frame->body);
    }
    EXPECT_EQ(pictures.at("1"), pictures.at("2"));
    EXPECT_EQ(metric(server.port(), R"(clerestory_worker_events{event="ended"})"), 0.0);
}

TEST(ColdStart, NoFrameOfTheChapelIsLost) {
    expectFirstUse({"chapel"});
}

TEST(ColdStart, NoFrameOfTwoScenesIsLost) {
    expectFirstUse({"teapots", "meadow"});
}

}  // namespace
}  // namespace clerestory::test
