// R7: connections in great number: sequential ones with random contents, and as many concurrent
// ones as the machine has descriptors for.
#include "tests/support/attacks.h"

#include "tests/support/clock.h"
#include "tests/support/raw_client.h"

#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <random>

namespace clerestory::test {
namespace {

// The first bytes of other protocols, and almost valid requests.
std::vector<std::string> beginnings() {
    return {std::string("\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03", 11),
            "PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n",
            "SSH-2.0-OpenSSH_9.2p1\r\n",
            std::string("\x00\x00\x00\x2a\xff\x53\x4d\x42", 8),
            "*1\r\n$4\r\nPING\r\n",
            get("/healthz"),
            get("/v1/frames?width=64&height=48"),
            post("/v1/frames", R"({"scene": "six-walls", "width": 8, "height": 8})")};
}

std::string garbage(std::mt19937& random, const std::vector<std::string>& begins) {
    std::string bytes = begins[random() % begins.size()];
    const auto any = [&] { return static_cast<char>(random()); };
    switch (random() % 4) {
        case 0:  // random bytes
            bytes.assign(1 + random() % 300, ' ');
            std::generate(bytes.begin(), bytes.end(), any);
            break;
        case 1:  // cut
            bytes.resize(random() % bytes.size());
            break;
        default:  // some bytes are others
            for (std::uint32_t i = random() % 8; i > 0; --i) bytes[random() % bytes.size()] = any();
    }
    return bytes;
}

std::string number(double value) {
    return std::to_string(static_cast<long>(value));
}

// Raises the number of descriptors to this limit, or to the process's maximum.
std::size_t raised(std::size_t wanted) {
    rlimit files{wanted, wanted};
    if (setrlimit(RLIMIT_NOFILE, &files) != 0) {
        getrlimit(RLIMIT_NOFILE, &files);
        files.rlim_cur = files.rlim_max;
        setrlimit(RLIMIT_NOFILE, &files);
    }
    getrlimit(RLIMIT_NOFILE, &files);
    return files.rlim_cur;
}

constexpr std::size_t kCrowd = 100'000;
constexpr std::size_t kOthers = 400;  // descriptors that are no connections

}  // namespace

std::vector<Figure> connectionFloods(const Target& target, int connections) {
    const std::vector<std::string> begins = beginnings();
    std::mt19937 random(7);
    worstAnswer(target.server.port());
    const std::size_t before = target.server.residentBytes();
    const std::size_t files = target.server.descriptors();
    const auto start = Clock::now();
    int reached = 0, answered = 0, nonsense = 0;
    double worst = 0.0;
    for (int i = 0; i < connections; ++i) {
        // Ports rest for a while before they can be used again.
        const std::string from = "127.0.2." + std::to_string(1 + i / 10'000);
        RawClient client(target.server.port(), from.c_str());
        reached += client.connected() && client.send(garbage(random, begins));
        if (i % 16 == 0) {  // the others leave at once
            const std::string answer = client.receive(0.02);
            answered += !answer.empty();
            nonsense += !answer.empty() && !answer.starts_with("HTTP/1.1 ");
        }
        if (i % 1000 == 0) {
            const double other = worstAnswer(target.server.port(), 1);
            worst = other < 0 ? 1e9 : std::max(worst, other);
        }
    }
    const double seconds = secondsSince(start);
    std::size_t after = target.server.descriptors();
    for (int i = 0; i < 400 && after > files; ++i) {
        worstAnswer(target.server.port(), 1);
        after = target.server.descriptors();
    }
    const double rise =
        1e-6 * (static_cast<double>(target.server.residentBytes()) - static_cast<double>(before));
    return {{.row = "R7",
             .what = std::to_string(connections) + " connections of garbage, one after the other",
             .figure = std::to_string(reached) + " reached it in " + number(seconds) + " s; " +
                       std::to_string(answered) + " answers read, " + std::to_string(nonsense) +
                       " not HTTP; others " + number(worst) + " ms at worst; " + number(rise) +
                       " MB more, " + std::to_string(files) + " descriptors before and " +
                       std::to_string(after) + " after",
             .bar = "no crash, others answered, nothing kept",
             .held = reached == connections && nonsense == 0 && worst < 1e9 && after <= files &&
                     rise < 20.0,
             .timely = worst < 1000.0}};
}

std::vector<Figure> liveCrowd() {
    const ServerProcess server(
        {"--scene", "six-walls", "--connections", std::to_string(kCrowd), "--idle-seconds", "600"},
        [] { raised(kCrowd + kOthers); });
    const std::size_t most = std::min(raised(kCrowd + kOthers) - kOthers, kCrowd);
    worstAnswer(server.port());
    const std::size_t before = server.residentBytes();
    std::vector<RawClient> crowd;
    std::size_t open = 0, answered = 0;
    for (std::size_t i = 0; i < most; ++i) {
        // An address has some 28,000 ports to connect from.
        const std::string from = "127.0.1." + std::to_string(1 + i / 20'000);
        crowd.emplace_back(server.port(), from.c_str());
        open += crowd.back().connected() && crowd.back().send(get("/healthz"));
    }
    for (RawClient& client : crowd) answered += statusOf(client.answer(5.0)) == 200;
    const double worst = worstAnswer(server.port());
    const double rise = static_cast<double>(server.residentBytes()) - static_cast<double>(before);
    return {{.row = "R7",
             .what = std::to_string(open) + " connections at once, each kept after its answer",
             .figure = std::to_string(answered) + " answered; others " + number(worst) +
                       " ms at worst; " + number(rise / static_cast<double>(most)) +
                       " bytes of memory each",
             .bar = std::to_string(kCrowd) + " where descriptors suffice (here " +
                    std::to_string(most) + ")",
             .held = open == most && answered == most && worst >= 0,
             .timely = worst < 1000.0}};
}

}  // namespace clerestory::test
