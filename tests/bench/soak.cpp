// Requests frames of many kinds for a long time and measures whether server and renderer grow:
// scripts/soak
#include "tests/bench/bars.h"
#include "tests/bench/process_tree.h"
#include "tests/support/raw_client.h"
#include "tests/support/server_process.h"

#include <algorithm>
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
using clerestory::bench::Bars;
using clerestory::bench::holdingsOf;
using clerestory::bench::Resources;

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

// Scenes are loaded at their first request.
void awaitScenes(int port, long width) {
    for (long n = 0; n < 4; ++n) {
        while (statusOf(ask(port, post("/v1/frames", requestOf(n, width)), 60)) == 409) {
            std::this_thread::sleep_for(std::chrono::milliseconds(100));
        }
    }
}

// Memory of an idle server.
struct Sample {
    double frames;
    Resources holdings;
    double server, worker;  // bytes allocated, of the worker that answers
};

Sample atRest(const ServerProcess& server, long frames) {
    std::this_thread::sleep_for(std::chrono::milliseconds(500));  // connections end
    return {static_cast<double>(frames), holdingsOf(server.id()),
            metric(server.port(), "clerestory_http_allocated_bytes"),
            metric(server.port(), "clerestory_allocated_bytes")};
}

// Bytes for each 1,000 frames: the median of the slopes between any two samples (Theil and Sen),
// for what is kept at rest is one of a few amounts, by which maps the last frames needed.
template <class Bytes>
double growthOf(const std::vector<Sample>& samples, Bytes bytes) {
    std::vector<double> slopes;
    for (std::size_t i = 0; i < samples.size(); ++i) {
        for (std::size_t k = i + 1; k < samples.size(); ++k) {
            slopes.push_back((bytes(samples[k]) - bytes(samples[i])) /
                             (samples[k].frames - samples[i].frames));
        }
    }
    return 1000.0 * clerestory::bench::median(slopes);
}

// Sends these requests from `clients` clients; returns how many were not answered with 200.
long drive(int port, long from, long to, long width, int many) {
    std::atomic<long> next{from}, failed{0};
    std::vector<std::jthread> clients;
    for (int c = 0; c < many; ++c) {
        clients.emplace_back([&] {
            std::optional<RawClient> client;
            for (long n = next++; n < to; n = next++) {
                if (!client) client.emplace(port);
                client->send(post("/v1/frames", requestOf(n, width)));
                const int status = statusOf(client->answer(120));
                if (status != 200 && failed++ < 5)
                    std::fprintf(stderr, "%d: %s\n", status, requestOf(n, width).c_str());
                if (status == 0) client.reset();
            }
        });
    }
    clients.clear();
    return failed;
}

std::string words(const char* format, double a, double b, double c) {
    char text[96];
    std::snprintf(text, sizeof text, format, a, b, c);
    return text;
}

}  // namespace

int main(int argc, char** argv) {
    const long wanted = argc > 1 ? std::atol(argv[1]) : 86'400;
    const long width = argc > 2 ? std::atol(argv[2]) : 160;  // of the smallest, pixels
    // Load from other programs must not cause rejections.
    // Per-thread caches of the allocator would count as allocated, and fill slowly.
    const ServerProcess server({"--queue-seconds", "3600"}, [] {
        ::setenv("GLIBC_TUNABLES", "glibc.malloc.tcache_count=0", 1);
    });
    if (!server.waitUntilReady()) return 1;
    awaitScenes(server.port(), width);
    constexpr long kStages = 24, kKinds = 4 * 7 * 5;
    const long stageFrames = (wanted + kStages - 1) / kStages;
    const long frames = stageFrames * kStages;
    // More clients than will come, so that every pool has the threads it will ever need.
    long failed = drive(server.port(), 0, 4 * kKinds, width, 8);
    std::vector<Sample> samples;
    for (long stage = 0; stage < kStages; ++stage) {
        const long until = stageFrames * (stage + 1);
        failed += drive(server.port(), until - stageFrames, until, width, 2);
        // One after the other and always the same, for what is kept depends on the last ones.
        failed += drive(server.port(), 0, kKinds, width, 1);
        // Every kind has come more often than caches hold after a quarter.
        const Sample sample = atRest(server, until);
        std::fprintf(stderr,
                     "%ld frames: %.3f and %.3f MB allocated, %.2f MB resident, %zu threads\n",
                     until, 1e-6 * sample.server, 1e-6 * sample.worker,
                     1e-6 * static_cast<double>(sample.holdings.bytes), sample.holdings.threads);
        if (stage >= kStages / 4) samples.push_back(sample);
    }
    const auto rangeOf = [&](auto what) {
        const auto [low, high] = std::minmax_element(
            samples.begin(), samples.end(),
            [&](const Sample& a, const Sample& b) { return what(a) < what(b); });
        return std::pair(what(*low), what(*high));
    };
    const std::string counted = std::to_string(frames) + " frames: ";
    Bars bars;
    const auto row = [&](const char* what, const std::string& figure, const char* bar, bool held) {
        bars.add({.row = "M1", .what = counted + what, .figure = figure, .bar = bar, .held = held});
    };
    row("not answered with 200", std::to_string(failed), "0", failed == 0);
    const auto growth = [&](const char* what, auto bytes) {
        const auto [low, high] = rangeOf(bytes);
        const double each = growthOf(samples, bytes);
        row(what, words("%.2f kB (%.2f to %.2f MB)", 1e-3 * each, 1e-6 * low, 1e-6 * high), "1 kB",
            each < 1000.0);
    };
    growth("allocated by server and worker, for each 1,000 frames",
           [](const Sample& s) { return s.server + s.worker; });
    growth("resident memory of server, worker and standby, for each 1,000 frames",
           [](const Sample& s) { return static_cast<double>(s.holdings.bytes); });
    const auto constant = [&](const char* what, std::size_t Resources::*count) {
        const auto [low, high] = rangeOf([&](const Sample& s) { return s.holdings.*count; });
        row(what, std::to_string(low) + " to " + std::to_string(high), "constant", low == high);
    };
    constant("descriptors", &Resources::descriptors);
    constant("threads", &Resources::threads);
    return bars.end();
}
