// Prints the effects of attacks and overload on a server, each figure with its limit:
// scripts/attack
#include "tests/bench/bars.h"
#include "tests/support/attacks.h"
#include "tests/support/overload.h"

#include <sys/resource.h>

#include <algorithm>
#include <cstdio>
#include <cstring>

namespace {

using namespace clerestory::test;
using clerestory::bench::Bars;

std::string text(const char* format, double a, double b = 0.0) {
    char buffer[128];
    std::snprintf(buffer, sizeof buffer, format, a, b);
    return buffer;
}

void attacks(Bars& bars, bool isShort) {
    const std::vector<std::string> quick = {"--head-seconds",  "1", "--body-seconds", "1",
                                            "--write-seconds", "1", "--idle-seconds", "2"};
    std::vector<std::string> flags = {"--scene", "six-walls"};
    if (isShort) flags.insert(flags.end(), quick.begin(), quick.end());
    const ServerProcess server(flags);
    server.waitUntilReady();
    const Target target =
        isShort ? Target{.server = server, .head = 1, .body = 1, .write = 1, .idle = 2, .crowd = 60}
                : Target{.server = server};
    bars.add(wrongRequests(target));
    bars.add(pathAttacks(target));
    bars.add(slowAttacks(target));
    bars.add(crowds(target));
    bars.add(connectionFloods(target, isShort ? 5'000 : 100'000));
}

void fewDescriptors(Bars& bars) {
    const ServerProcess server({"--scene", "six-walls"}, [] {
        const rlimit few{256, 256};
        setrlimit(RLIMIT_NOFILE, &few);
    });
    server.waitUntilReady();
    for (Figure figure : crowds({.server = server})) {
        figure.what += ", 256 descriptors";
        bars.add(figure);
    }
}

void loads(Bars& bars, double factor, double seconds) {
    constexpr double kQueue = 8;
    const ServerProcess server({"--scene", "six-walls", "--queue", "8"});
    server.waitUntilReady();
    const Overload load = overload(server, factor, seconds);
    const std::string name = text("%.0fx overload for %.0f s", factor, seconds);
    const int done = countOf(load.frames, 200), refused = countOf(load.frames, 503);
    const double p99 = percentile(load.frames, 200, 0.99),
                 bound = 1.2 * load.serviceMs * (kQueue + 1);
    bars.add({"L1", name, text("accepted p99 %.0f ms", p99), text("%.0f ms", bound), p99 <= bound});
    const double quick = percentile(load.frames, 503, 0.99);
    bars.add({"L1", name, text("503 p99 %.1f ms", quick), "10 ms", quick <= 10});
    bars.add({"L1", name,
              text("goodput %.0f %% of capacity (%.1f ms a frame)", 100 * load.goodput(),
                   load.serviceMs) +
                  text("; %.0f %% of what these clients leave: they take %.0f %%",
                       100 * load.goodputOfTheRest(), 100 * load.clientShare) +
                  text(" of the machine, the port's process %.0f %%", 100 * load.frontShare),
              "95 % of what the clients leave", load.goodputOfTheRest() >= 0.95});
    const int lost = static_cast<int>(load.frames.size()) - done - refused;
    bars.add({"L1", name, text("%.0f without an answer", lost), "0", lost == 0});
    const double health = percentile(load.health, 200, 0.99);
    bars.add({"L2", name, text("health p99 %.1f ms", health), "10 ms", health <= 10});
}

void fairness(Bars& bars, double seconds) {
    const ServerProcess server({"--scene", "six-walls"});
    server.waitUntilReady();
    const Flood result = flood(server, seconds);
    const double alone = percentile(result.alone, 200, 0.99),
                 loaded = percentile(result.duringFlood, 200, 0.99);
    bars.add({"L3", "three well-behaved clients during a flood",
              text("p99 %.0f ms, alone %.0f ms", loaded, alone), "2 x alone", loaded <= 2 * alone});
    const CheapFlood cheap = cheapFlood(server, std::min(seconds, 9.0));
    const int moderate = static_cast<int>(cheap.moderate.size());
    bars.add({"L3", "one expensive frame a second next to 24 connections of tiny ones",
              std::to_string(countOf(cheap.moderate, 200)) + " of " + std::to_string(moderate) +
                  " answered" + text(", slowest %.0f ms", percentile(cheap.moderate, 200, 1.0)) +
                  "; of the others " + std::to_string(countOf(cheap.flooder, 200)),
              "all", countOf(cheap.moderate, 200) == moderate});
    const int refused =
        static_cast<int>(result.duringFlood.size()) - countOf(result.duringFlood, 200);
    bars.add({"L3", "requests of well-behaved clients rejected", std::to_string(refused), "0",
              refused == 0});
}

void endings(Bars& bars, int times) {
    const ShutdownCounts e = endUnderLoad(times, {"--scene", "six-walls"});
    bars.add({"U1", "SIGTERM under load x " + std::to_string(times),
              std::to_string(e.broken) + " broken of " + std::to_string(e.answered + e.refused) +
                  ", " + std::to_string(e.cleanExits) + " exits with 0, slowest " +
                  text("%.1f s", e.slowestExit),
              "0 broken, all exits 0", e.broken == 0 && e.cleanExits == times});
}

}  // namespace

int main(int argc, char** argv) {
    const bool isShort = argc > 1 && std::strcmp(argv[1], "--short") == 0;
    Bars bars;
    attacks(bars, isShort);
    fewDescriptors(bars);
    bars.add(liveCrowd());
    bars.add(failingAccepts());
    loads(bars, 4, isShort ? 3 : 20);
    loads(bars, 50, isShort ? 2 : 10);
    fairness(bars, isShort ? 3 : 20);
    endings(bars, isShort ? 3 : 50);
    return bars.end();
}
