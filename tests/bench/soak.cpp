// Asks for frames of many kinds for a long time, and looks whether server and renderer grow:
// scripts/soak
#include "tests/bench/process_tree.h"
#include "tests/bench/statistics.h"
#include "tests/support/raw_client.h"
#include "tests/support/server_process.h"

#include <array>
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

namespace {

using namespace clerestory::test;
using clerestory::bench::Holdings;
using clerestory::bench::holdingsOf;
using clerestory::bench::Stopwatch;

// The n-th request: every scene, size and way comes round again and again, through lenses and at
// moments that do not repeat within 1,000 frames.
std::string requestOf(long n, long width) {
    constexpr std::array kScenes = {"six-walls", "orbiting-cubes", "teapots", "meadow"};
    constexpr std::array kWays = {
        R"("accuracy": "draft")",
        R"("effects": {"emission": false, "planarReflection": false})",
        R"("output": {"format": "png"})",
        R"("output": {"channel": "depth", "format": "npy"})",
        R"("filters": [{"type": "twirl", "amount": 0.01}])",
        R"("accuracy": {"preset": "draft", "curved": "traced"})",
        R"("output": {"channel": "through", "format": "npy"})",
    };
    const double place = 0.001 * static_cast<double>(n % 1000);
    char text[320];
    std::snprintf(
        text, sizeof text,
        R"({"scene": "%s", "width": %ld, "height": %ld, "time": %.3f, "camera": {"yfov": %.4f}, %s})",
        kScenes[n % kScenes.size()], width + width / 10 * (n % 5),
        3 * width / 4 + width / 13 * (n % 5), 4.0 * place, 0.6 + 0.4 * place,
        kWays[n / 4 % kWays.size()]);
    return text;
}

// Scenes are made when they are first asked for.
void awaitScenes(int port, long width) {
    for (long n = 0; n < 4; ++n) {
        while (statusOf(ask(port, post("/v1/frames", requestOf(n, width)), 60)) == 409) {
            std::this_thread::sleep_for(std::chrono::milliseconds(100));
        }
    }
}

struct Sample {
    double frames;
    Holdings holdings;
};

// Bytes for each 1,000 frames: the line through the samples with the least squares of distances.
double slope(const std::vector<Sample>& samples) {
    double x = 0, y = 0;
    for (const Sample& s : samples) {
        x += s.frames / static_cast<double>(samples.size());
        y += static_cast<double>(s.holdings.bytes) / static_cast<double>(samples.size());
    }
    double xx = 0, xy = 0;
    for (const Sample& s : samples) {
        xx += (s.frames - x) * (s.frames - x);
        xy += (s.frames - x) * (static_cast<double>(s.holdings.bytes) - y);
    }
    return xx > 0.0 ? 1000.0 * xy / xx : 0.0;
}

}  // namespace

int main(int argc, char** argv) {
    const long frames = argc > 1 ? std::atol(argv[1]) : 86'400;
    const long width = argc > 2 ? std::atol(argv[2]) : 160;  // of the smallest, pixels
    // How busy the machine is must not matter: no frame is refused for what others take of it.
    const ServerProcess server({"--queue-seconds", "3600"});
    if (!server.waitUntilReady()) return 1;
    awaitScenes(server.port(), width);
    std::atomic<long> next{0}, failed{0};
    std::vector<std::jthread> clients;
    const Stopwatch watch;
    for (int c = 0; c < 2; ++c) {
        clients.emplace_back([&] {
            std::optional<RawClient> client;
            for (long n = next++; n < frames; n = next++) {
                if (!client) client.emplace(server.port());
                client->send(post("/v1/frames", requestOf(n, width)));
                const int status = statusOf(client->answer(120));
                if (status != 200 && failed++ < 5)
                    std::fprintf(stderr, "%d: %s\n", status, requestOf(n, width).c_str());
                if (status == 0) client.reset();
            }
        });
    }
    // Every kind has come more often than caches hold after a quarter.
    std::vector<Sample> samples;
    const long step = std::max(1L, frames / 100);
    for (long at = frames / 4; at <= frames; at += step) {
        while (next < at) std::this_thread::sleep_for(std::chrono::milliseconds(20));
        samples.push_back({static_cast<double>(at), holdingsOf(server.id())});
    }
    clients.clear();
    const auto rangeOf = [&](auto what) {
        std::size_t low = ~std::size_t{0}, high = 0;
        for (const Sample& s : samples) {
            low = std::min(low, s.holdings.*what);
            high = std::max(high, s.holdings.*what);
        }
        return std::pair(low, high);
    };
    const auto [leastBytes, mostBytes] = rangeOf(&Holdings::bytes);
    const auto [leastFiles, mostFiles] = rangeOf(&Holdings::descriptors);
    const auto [leastThreads, mostThreads] = rangeOf(&Holdings::threads);
    const double growth = slope(samples);
    std::printf("%ld frames in %.0f s, load average %.1f\n\n", frames, 1e-3 * watch.milliseconds(),
                clerestory::bench::loadAverage());
    std::printf("| row | what | figure | bar | |\n|---|---|---|---|---|\n");
    const auto row = [](const std::string& what, const std::string& figure, const char* bar,
                        bool held) {
        std::printf("| M1 | %s | %s | %s | %s |\n", what.c_str(), figure.c_str(), bar,
                    held ? "held" : "MISSED");
        return held ? 0 : 1;
    };
    char text[96];
    int missed = row("frames not answered with 200", std::to_string(failed), "0", failed == 0);
    std::snprintf(text, sizeof text, "%.1f kB (%.1f to %.1f MB)", 1e-3 * growth,
                  1e-6 * static_cast<double>(leastBytes), 1e-6 * static_cast<double>(mostBytes));
    missed += row("memory of server, worker and standby for each 1,000 frames", text, "1 kB",
                  growth < 1000.0);
    std::snprintf(text, sizeof text, "%zu to %zu", leastFiles, mostFiles);
    missed += row("descriptors", text, "constant", leastFiles == mostFiles);
    std::snprintf(text, sizeof text, "%zu to %zu", leastThreads, mostThreads);
    missed += row("threads", text, "constant", leastThreads == mostThreads);
    std::printf("\n%d missed\n", missed);
    return failed == 0 ? 0 : 1;
}
