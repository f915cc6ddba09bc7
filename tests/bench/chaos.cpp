// Prints what clients notice when a renderer, all renderers or the server end, each figure with its
// limit: scripts/chaos
#include "tests/bench/bars.h"
#include "tests/bench/process_tree.h"
#include "tests/bench/statistics.h"
#include "tests/support/raw_client.h"
#include "tests/support/server_process.h"

#include <atomic>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <mutex>
#include <thread>
#include <utility>

namespace {

using namespace clerestory::test;
using clerestory::bench::Bars;
using clerestory::bench::percentile;
using clerestory::bench::Stopwatch;
using clerestory::bench::workersOf;
using namespace std::chrono_literals;

// Held where the figure is not above the bar.
Figure figure(const char* row, const std::string& what, const char* format, double value,
              double bar, const char* barText) {
    char text[96];
    std::snprintf(text, sizeof text, format, value);
    return {.row = row, .what = what, .figure = text, .bar = barText, .held = value <= bar};
}

// A process that has ended stays in the table until its parent waits for it.
bool lives(pid_t id) {
    std::ifstream file("/proc/" + std::to_string(id) + "/stat");
    const std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
    const std::size_t at = text.rfind(") ");
    return at != std::string::npos && text[at + 2] != 'Z';
}

void awaitBoth(const ServerProcess& server) {
    for (int i = 0; i < 3000; ++i) {
        if (metric(server.port(), "clerestory_workers{role=\"warmStandby\"}") == 1 &&
            metric(server.port(), "clerestory_workers{role=\"active\"}") == 1) {
            return;
        }
        std::this_thread::sleep_for(20ms);
    }
}

std::string frameOf(int i) {
    return R"({"scene": "six-walls", "width": 320, "height": 240, "exposure": )" +
           std::to_string(i % 8) + "}";
}

// Four clients that request frames continuously and know the expected bytes.
class Clients {
public:
    explicit Clients(int port) {
        for (int i = 0; i < 8; ++i) {
            expected_.push_back(std::string(bodyOf(ask(port, post("/v1/frames", frameOf(i)), 60))));
        }
        for (int c = 0; c < 4; ++c) threads_.emplace_back([this, c, port] { run(c, port); });
    }
    ~Clients() { end(); }
    void end() {
        ending_ = true;
        for (std::thread& thread : threads_) thread.join();
        threads_.clear();
    }
    std::vector<double> times() {
        const std::lock_guard lock(mutex_);
        return std::exchange(times_, {});
    }
    int wrong() const { return wrong_; }

private:
    void run(int n, int port) {
        RawClient client(port);
        for (; !ending_; ++n) {
            const Stopwatch watch;
            client.send(post("/v1/frames", frameOf(n)));
            const std::string answer = client.answer(120);
            const bool right = statusOf(answer) == 200 && bodyOf(answer) == expected_[n % 8];
            if (!right) ++wrong_;
            const std::lock_guard lock(mutex_);
            times_.push_back(watch.milliseconds());
        }
    }
    std::vector<std::string> expected_;
    std::vector<std::thread> threads_;
    std::mutex mutex_;
    std::vector<double> times_;
    std::atomic<bool> ending_{false};
    std::atomic<int> wrong_{0};
};

// The slowest response around each of `count` signals to the active worker.
void strike(Bars& bars, const char* row, const char* what, int number, int times, double barMs,
            const char* barText, bool standby) {
    std::vector<std::string> flags = {"--scene", "six-walls"};
    if (!standby) flags.push_back("--no-standby");
    const ServerProcess server(flags);
    server.waitUntilReady();
    Clients clients(server.port());
    std::vector<double> slowest;
    for (int i = 0; i < times; ++i) {
        if (standby) {
            awaitBoth(server);
        } else {
            server.waitUntilReady();
        }
        std::this_thread::sleep_for(100ms);
        const auto workers = workersOf(server.id());
        if (workers.empty()) continue;
        clients.times();
        kill(workers.front(), number);
        std::this_thread::sleep_for(std::chrono::duration<double, std::milli>(1.2 * barMs));
        const std::vector<double> about = clients.times();
        slowest.push_back(percentile(about, 1.0));
    }
    clients.end();
    const std::string name = std::to_string(times) + " x " + what;
    bars.add(figure(row, name + ": slowest answer, p99", "%.0f ms", percentile(slowest, 0.99),
                    barMs, barText));
    bars.add(figure(row, name + ": slowest answer, median", "%.0f ms", percentile(slowest, 0.5),
                    barMs, barText));
    bars.add(figure(row, name + ": frames lost or wrong", "%.0f", clients.wrong(), 0, "0"));
}

void frontKilled(Bars& bars, int times) {
    std::vector<double> back;
    int stray = 0;
    for (int i = 0; i < times; ++i) {
        std::vector<pid_t> workers;
        {
            ServerProcess server({"--scene", "six-walls"});
            server.waitUntilReady();
            workers = workersOf(server.id());
        }
        std::this_thread::sleep_for(100ms);
        for (const pid_t id : workers) stray += lives(id);
        const Stopwatch watch;
        const ServerProcess again({"--scene", "six-walls"});
        again.waitUntilReady();
        back.push_back(watch.milliseconds());
    }
    const std::string name = std::to_string(times) + " x server killed";
    bars.add(figure("U3", name + ": processes left behind", "%.0f", stray, 0, "0"));
    bars.add(figure("U3", name + ": serving again, median", "%.0f ms", percentile(back, 0.5), 1000,
                    "1000 ms"));
}

}  // namespace

int main(int argc, char** argv) {
    const bool isShort = argc > 1 && std::strcmp(argv[1], "--short") == 0;
    Bars bars;
    strike(bars, "G1", "worker killed, warm standby", SIGKILL, isShort ? 5 : 100, 250, "250 ms",
           true);
    strike(bars, "G1", "worker killed, no standby", SIGKILL, isShort ? 3 : 20, 2000, "2000 ms",
           false);
    strike(bars, "G2", "worker stopped", SIGSTOP, isShort ? 2 : 20, 3250,
           "silence 3000 ms + 250 ms", true);
    frontKilled(bars, isShort ? 3 : 20);
    return bars.end();
}
