// `bench_throughput CLERESTORY [SCENE]`: frames per second of one client and of eight, with one
// renderer and with several (`serve --renderers`), measured in turns; and whether all of them give
// the same bytes. With --hits: the time of a frame that is answered from the frame cache.
#include "command_line.h"
#include "program.h"
#include "statistics.h"
#include "tests/bench/child_process.h"
#include "tests/support/free_port.h"

#include <httplib.h>
#include <atomic>
#include <cstdio>
#include <functional>
#include <map>
#include <mutex>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace clerestory::bench {
namespace {

constexpr int kPoses = 16;

struct Options {
    std::string program, scene = "chapel";
    std::uint32_t width = 640, height = 360;
    std::string accuracy = "standard";
    int renderers = 2, clients = 8, rounds = 3;
    double seconds = 5.0;
    bool hits = false;
};

class Served {
public:
    Served(const Options& options, int renderers, const std::vector<std::string>& flags)
        : renderers_(renderers), port_(test::freePort()) {
        std::vector<std::string> command = {
            options.program,   "serve",       "--port",     std::to_string(port_),
            "--scene",         options.scene, "--queue",    "64",
            "--queue-seconds", "600",         "--deadline", "600",
            "--log-level",     "error"};
        command.insert(command.end(), flags.begin(), flags.end());
        id_ = startProgram(command);
    }
    ~Served() { stopTree(id_); }
    Served(const Served&) = delete;
    Served& operator=(const Served&) = delete;

    httplib::Client client() const {
        httplib::Client client("127.0.0.1", port_);
        client.set_keep_alive(true);
        client.set_tcp_nodelay(true);
        client.set_read_timeout(600);
        return client;
    }

    // Returns when every renderer is warm.
    void awaitReady() const {
        auto own = client();
        for (int i = 0; i < 3000; ++i) {
            const auto ready = own.Get("/readyz");
            const auto metrics = own.Get("/metrics");
            const std::string warm =
                "clerestory_workers{role=\"warm\"} " + std::to_string(renderers_);
            if (ready && ready->status == 200 && metrics &&
                metrics->body.find(warm + "\n") != std::string::npos) {
                return;
            }
            std::this_thread::sleep_for(std::chrono::milliseconds(100));
        }
        throw std::runtime_error("the server is not ready after five minutes");
    }

private:
    const int renderers_;
    const int port_;
    pid_t id_ = -1;
};

std::string bodyOf(const Options& options, int pose) {
    char text[512];
    std::snprintf(text, sizeof text,
                  R"({"width": %u, "height": %u, "accuracy": "%s", "exposure": %.2f})",
                  options.width, options.height, options.accuracy.c_str(), 0.01 * pose);
    return text;
}

// The bytes of each pose, of all servers: equal requests give equal bytes.
class Bytes {
public:
    void check(int pose, const std::string& body) {
        const std::lock_guard lock(mutex_);
        const auto [entry, isNew] = hashes_.emplace(pose, std::hash<std::string>()(body));
        if (!isNew && entry->second != std::hash<std::string>()(body)) ++different_;
    }
    int different() const { return different_; }

private:
    std::mutex mutex_;
    std::map<int, std::size_t> hashes_;
    int different_ = 0;
};

// Frames per second of that many clients together.
double rateOf(const Served& server, const Options& options, int clients, Bytes& bytes) {
    std::atomic<int> frames{0};
    std::atomic<bool> failed{false};
    const Stopwatch watch;
    std::vector<std::thread> threads;
    for (int c = 0; c < clients; ++c) {
        threads.emplace_back([&, c] {
            auto client = server.client();
            for (int i = c; watch.milliseconds() < 1e3 * options.seconds; ++i) {
                const int pose = i % kPoses;
                const auto reply =
                    client.Post("/v1/frames", bodyOf(options, pose), "application/json");
                if (!reply || reply->status != 200) {
                    failed = true;
                    return;
                }
                bytes.check(pose, reply->body);
                ++frames;
            }
        });
    }
    for (std::thread& thread : threads) thread.join();
    if (failed) throw std::runtime_error("a frame was not answered");
    return 1e3 * frames / watch.milliseconds();
}

int measureThroughput(const Options& options) {
    Served one(options, 1, {"--frame-cache", "0", "--no-standby"});
    Served several(
        options, options.renderers,
        {"--frame-cache", "0", "--no-standby", "--renderers", std::to_string(options.renderers)});
    one.awaitReady();
    several.awaitReady();
    Bytes bytes;
    for (const Served* server : {&one, &several}) {  // captured maps become resident
        rateOf(*server, options, options.clients, bytes);
    }
    std::map<std::pair<bool, bool>, std::vector<double>> rates;
    for (int round = 0; round < options.rounds; ++round) {
        for (const bool isSeveral : {false, true}) {
            for (const bool many : {false, true}) {
                rates[{isSeveral, many}].push_back(
                    rateOf(isSeveral ? several : one, options, many ? options.clients : 1, bytes));
            }
        }
    }
    const double reference = median(rates[{false, false}]);
    std::printf("%s, %ux%u, %s, %u processors, load %.1f\n", options.scene.c_str(), options.width,
                options.height, options.accuracy.c_str(), std::thread::hardware_concurrency(),
                loadAverage());
    std::printf("%-10s %8s %14s %10s\n", "renderers", "clients", "frames/s", "ratio");
    for (const auto& [key, list] : rates) {
        std::printf("%-10d %8d %14.2f %10.2f\n", key.first ? options.renderers : 1,
                    key.second ? options.clients : 1, median(list), median(list) / reference);
    }
    std::printf("frames with other bytes: %d\n", bytes.different());
    return bytes.different() == 0 ? 0 : 1;
}

int measureHits(const Options& options) {
    Served server(options, 1, {"--no-standby"});
    server.awaitReady();
    auto client = server.client();
    const std::string body = bodyOf(options, 0);
    const auto timeOf = [&] {
        const Stopwatch watch;
        const auto reply = client.Post("/v1/frames", body, "application/json");
        if (!reply || reply->status != 200) throw std::runtime_error("a frame was not answered");
        return std::pair(watch.milliseconds(), reply->has_header("Age"));
    };
    const double drawn = timeOf().first;
    while (!timeOf().second) {  // the renderer reports its scenes at an interval
    }
    std::vector<double> times;
    for (int i = 0; i < 4000; ++i) {
        const auto [milliseconds, hit] = timeOf();
        if (!hit) throw std::runtime_error("an equal request was drawn again");
        times.push_back(milliseconds);
    }
    std::printf(
        "%s, %ux%u: drawn %.1f ms; from the frame cache p50 %.3f ms, p99 %.3f ms, "
        "load %.1f\n",
        options.scene.c_str(), options.width, options.height, drawn, percentile(times, 0.5),
        percentile(times, 0.99), loadAverage());
    return 0;
}

int measure(int argc, char** argv) {
    CommandLine line(
        "Frames per second of several clients; with --hits, the time of stored frames");
    Options options;
    line.addRequired("program", options.program, "the program that is measured");
    line.add("scene", options.scene, "a built-in scene or a file");
    line.addFlag("--hits", options.hits, "frames that are answered from the frame cache");
    line.add("--width", options.width);
    line.add("--height", options.height);
    line.add("--accuracy", options.accuracy);
    line.add("--renderers", options.renderers, "", {2, 8});
    line.add("--clients", options.clients, "", {2, 64});
    line.add("--rounds", options.rounds, "", {1, 100});
    line.add("--seconds", options.seconds, "of each measurement");
    if (const auto status = line.parse(argc, argv)) return *status;
    return options.hits ? measureHits(options) : measureThroughput(options);
}

}  // namespace
}  // namespace clerestory::bench

int main(int argc, char** argv) {
    return clerestory::bench::runProgram("bench_throughput", clerestory::bench::measure, argc,
                                         argv);
}
