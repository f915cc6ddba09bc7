#include "tests/support/overload.h"

#include "measures/percentile.h"
#include "tests/support/clock.h"
#include "tests/support/raw_client.h"

#include <poll.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstring>
#include <fstream>
#include <mutex>
#include <random>
#include <sstream>
#include <thread>

namespace clerestory::test {
namespace {

// A request that is under way.
struct PendingRequest {
    RawClient client;
    double due = 0.0;  // seconds after the start
    std::string answer;
};

bool whole(const std::string& answer) {
    const std::string length = headerOf(answer, "Content-Length");
    return statusOf(answer) > 0 && !length.empty() && bodyOf(answer).size() == std::stoul(length);
}

SentRequest shotOf(const std::string& answer, double milliseconds) {
    return {.status = whole(answer) ? statusOf(answer) : 0,
            .milliseconds = milliseconds,
            .saysWhen = !headerOf(answer, "Retry-After").empty()};
}

// One request after the other, with pauses.
std::vector<SentRequest> inTurn(int port, const std::string& request, double seconds,
                                double pauseMs, const char* from) {
    std::vector<SentRequest> shots;
    std::seed_seq seed(from, from + std::strlen(from));
    std::mt19937 chance(seed);
    const auto start = Clock::now();
    while (secondsSince(start) < seconds) {
        const auto asked = Clock::now();
        const std::string answer = ask(port, request, 60.0, from);
        shots.push_back(shotOf(answer, 1000.0 * secondsSince(asked)));
        // Random, because clients with equal periods would meet always or never.
        const double pause = pauseMs * std::uniform_real_distribution(0.5, 1.5)(chance);
        std::this_thread::sleep_for(std::chrono::duration<double, std::milli>(pause));
    }
    return shots;
}

std::vector<SentRequest> wellBehaved(int port, double seconds, double pauseMs) {
    std::vector<SentRequest> all;
    std::mutex mutex;
    std::vector<std::thread> threads;
    for (const char* from : {"127.0.0.11", "127.0.0.12", "127.0.0.13"}) {
        threads.emplace_back([&, from] {
            const std::vector<SentRequest> shots =
                inTurn(port, slowFrame(), seconds, pauseMs, from);
            const std::lock_guard lock(mutex);
            all.insert(all.end(), shots.begin(), shots.end());
        });
    }
    for (std::thread& thread : threads) thread.join();
    return all;
}

double serviceMs(int port) {
    std::vector<double> times;
    for (int i = 0; i < 9; ++i) {
        const auto asked = Clock::now();
        ask(port, slowFrame(), 60.0);
        times.push_back(1000.0 * secondsSince(asked));
    }
    std::sort(times.begin(), times.end());
    return times[times.size() / 2];
}

// Processor time of all threads of a process since its start.
double processorSeconds(pid_t id) {
    std::ifstream file("/proc/" + std::to_string(id) + "/stat");
    std::string text{std::istreambuf_iterator<char>(file), {}};
    // After the name, which may hold anything: state and ten more, then user and system ticks.
    std::istringstream fields(text.substr(std::min(text.rfind(')') + 1, text.size())));
    std::string skipped;
    for (int i = 0; i < 11; ++i) fields >> skipped;
    double user = 0.0, system = 0.0;
    fields >> user >> system;
    return (user + system) / static_cast<double>(::sysconf(_SC_CLK_TCK));
}

}  // namespace

std::string slowFrame() {
    return post("/v1/frames", R"({"scene": "six-walls", "width": 640, "height": 480})",
                "Connection: close\r\n");
}

std::vector<SentRequest> openLoop(int port, const std::string& request, double perSecond,
                                  double seconds, double patience, const char* from) {
    std::vector<PendingRequest> flights;
    std::vector<SentRequest> shots;
    const auto start = Clock::now();
    const int total = std::max(1, static_cast<int>(perSecond * seconds));
    int begun = 0;
    char buffer[65536];
    while (begun < total || !flights.empty()) {
        const double now = secondsSince(start);
        for (; begun < total && begun / perSecond <= now; ++begun) {
            PendingRequest flight{RawClient(port, from), begun / perSecond, ""};
            if (flight.client.connected() && flight.client.send(request)) {
                flights.push_back(std::move(flight));
            } else {
                shots.push_back({});
            }
        }
        std::vector<pollfd> waits;
        for (const PendingRequest& flight : flights)
            waits.push_back({flight.client.socket(), POLLIN, 0});
        const double next = begun < total ? begun / perSecond - secondsSince(start) : 0.1;
        ::poll(waits.data(), waits.size(), static_cast<int>(std::clamp(1000.0 * next, 0.0, 100.0)));
        std::vector<PendingRequest> still;
        for (std::size_t i = 0; i < flights.size(); ++i) {
            PendingRequest& flight = flights[i];
            const bool late = secondsSince(start) > seconds + patience;
            if (waits[i].revents == 0 && !late) {
                still.push_back(std::move(flight));
                continue;
            }
            const ssize_t n = ::recv(flight.client.socket(), buffer, sizeof buffer, MSG_DONTWAIT);
            if (n > 0) flight.answer.append(buffer, static_cast<std::size_t>(n));
            if (n > 0 && !whole(flight.answer)) {
                still.push_back(std::move(flight));
            } else {
                shots.push_back(shotOf(flight.answer, 1000.0 * (secondsSince(start) - flight.due)));
            }
        }
        flights.clear();
        for (PendingRequest& flight : still) flights.push_back(std::move(flight));
    }
    return shots;
}

CheapFlood cheapFlood(const ServerProcess& server, double seconds) {
    CheapFlood result;
    const auto frame = [](int n, const std::string& size) {
        // Different each time, so that no cache answers, and of one kind, whose cost is known.
        return post(
            "/v1/frames",
            R"({"scene": "six-walls", "time": )" + std::to_string(1e-3 * n) + ", " + size + "}",
            "Connection: close\r\n");
    };
    const std::string tiny = R"("width": 16, "height": 16)";
    const std::string expensive = R"("width": 960, "height": 540, "accuracy": {"preset": "fine"})";
    ask(server.port(), frame(0, tiny), 60);
    ask(server.port(), frame(0, expensive), 60);
    std::atomic<bool> ending{false};
    std::atomic<int> number{1};
    std::mutex mutex;
    std::vector<std::thread> threads;
    for (int i = 0; i < 24; ++i) {
        threads.emplace_back([&] {
            while (!ending) {
                const auto asked = Clock::now();
                const std::string answer =
                    ask(server.port(), frame(number++, tiny), 60, "127.0.0.21");
                const std::lock_guard lock(mutex);
                result.flooder.push_back(shotOf(answer, 1000.0 * secondsSince(asked)));
            }
        });
    }
    const auto start = Clock::now();
    while (secondsSince(start) < seconds) {
        std::this_thread::sleep_for(std::chrono::seconds(1));
        const auto asked = Clock::now();
        const std::string answer = ask(server.port(), frame(number++, expensive), 60, "127.0.0.22");
        result.moderate.push_back(shotOf(answer, 1000.0 * secondsSince(asked)));
    }
    ending = true;
    for (std::thread& thread : threads) thread.join();
    return result;
}

double percentile(const std::vector<SentRequest>& shots, int status, double share) {
    std::vector<double> times;
    for (const SentRequest& shot : shots) {
        if (shot.status == status) times.push_back(shot.milliseconds);
    }
    return clerestory::percentile(std::move(times), share);
}

int countOf(const std::vector<SentRequest>& shots, int status) {
    return static_cast<int>(std::count_if(shots.begin(), shots.end(), [&](const SentRequest& shot) {
        return shot.status == status;
    }));
}

double Overload::goodput() const {
    return 1e-3 * countOf(frames, 200) * serviceMs / seconds;
}

Overload overload(const ServerProcess& server, double factor, double seconds) {
    Overload result;
    result.serviceMs = serviceMs(server.port());
    const double ours = processorSeconds(::getpid()), theirs = processorSeconds(server.id());
    const auto start = Clock::now();
    std::thread health([&] {
        result.health =
            openLoop(server.port(), get("/healthz", "Connection: close\r\n"), 20.0, seconds, 30.0);
    });
    result.frames =
        openLoop(server.port(), slowFrame(), factor * 1000.0 / result.serviceMs, seconds, 60.0);
    result.seconds = secondsSince(start);
    const double whole = result.seconds * std::thread::hardware_concurrency();
    result.clientShare = (processorSeconds(::getpid()) - ours) / whole;
    result.frontShare = (processorSeconds(server.id()) - theirs) / whole;
    health.join();
    return result;
}

Flood flood(const ServerProcess& server, double seconds) {
    Flood result;
    const double service = serviceMs(server.port());
    // Three clients that together request well under half of the server's capacity.
    const double pause = 8.0 * service;
    // Long enough for a few responses to each client on a slow machine.
    seconds = std::max(seconds, 0.001 * 60.0 * service);
    result.alone = wellBehaved(server.port(), seconds, pause);
    std::thread flooder([&] {
        result.flooder = openLoop(server.port(), slowFrame(), 4.0 * 1000.0 / service, seconds, 60.0,
                                  "127.0.0.10");
    });
    result.duringFlood = wellBehaved(server.port(), seconds, pause);
    flooder.join();
    return result;
}

ShutdownCounts endUnderLoad(int times, const std::vector<std::string>& flags) {
    ShutdownCounts endings{.times = times};
    for (int i = 0; i < times; ++i) {
        ServerProcess server(flags);
        if (server.port() == 0 || !server.waitUntilReady()) continue;
        std::atomic<bool> signalled{false}, over{false};
        std::mutex mutex;
        std::vector<std::thread> clients;
        for (int k = 0; k < 8; ++k) {
            clients.emplace_back([&, k] {
                const std::string request =
                    k % 2 ? slowFrame() : get("/v1/scenes", "Connection: close\r\n");
                while (!over) {
                    RawClient client(server.port());
                    const bool sent = client.connected() && client.send(request);
                    const bool sure = sent && !signalled;  // asked before the signal
                    const std::string answer = sent ? client.receive(60.0) : "";
                    const std::lock_guard lock(mutex);
                    if (whole(answer)) {
                        (statusOf(answer) == 200 ? endings.answered : endings.refused)++;
                    } else if (answer.empty() && !sure) {
                        ++endings.notReached;
                    } else {
                        ++endings.broken;
                    }
                }
            });
        }
        std::this_thread::sleep_for(std::chrono::milliseconds(150 + 37 * (i % 7)));
        const auto start = Clock::now();
        signalled = true;
        const int status = server.end(SIGTERM);
        endings.slowestExit = std::max(endings.slowestExit, secondsSince(start));
        endings.cleanExits += WIFEXITED(status) && WEXITSTATUS(status) == 0;
        over = true;
        for (std::thread& client : clients) client.join();
    }
    return endings;
}

}  // namespace clerestory::test
