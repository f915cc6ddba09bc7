// `bench_start CLERESTORY [FLAG...]`: from the start of `clerestory serve` to its first answered
// frame of the chapel over HTTP, several times; and its memory then.
#include "statistics.h"
#include "tests/support/free_port.h"

#include <httplib.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <fstream>
#include <string>
#include <thread>

extern char** environ;

namespace clerestory::bench {
namespace {

std::string statusLine(pid_t pid, const std::string& key) {
    std::ifstream file("/proc/" + std::to_string(pid) + "/status");
    for (std::string line; std::getline(file, line);) {
        if (line.rfind(key, 0) == 0) return line;
    }
    return key + " unknown";
}

struct Start {
    double firstFrameMs = 0.0;
    std::size_t bytes = 0;
    std::string memory;
};

Start startOnce(std::vector<std::string> command) {
    const int port = test::freePort();
    command.insert(command.begin() + 1,
                   {"serve", "--port", std::to_string(port), "--log-level", "error"});
    std::vector<char*> arguments;
    for (std::string& word : command) arguments.push_back(word.data());
    arguments.push_back(nullptr);

    const Stopwatch watch;
    pid_t pid = 0;
    if (posix_spawn(&pid, arguments[0], nullptr, nullptr, arguments.data(), environ) != 0) {
        throw std::runtime_error("cannot start " + command[0]);
    }
    Start result;
    httplib::Client client("127.0.0.1", port);
    client.set_read_timeout(60);
    while (watch.milliseconds() < 60000) {
        const auto reply = client.Post("/v1/frames", R"({"scene":"chapel"})", "application/json");
        if (reply && reply->status == 200) {
            result = {watch.milliseconds(), reply->body.size(), statusLine(pid, "VmRSS")};
            break;
        }
        std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    kill(pid, SIGTERM);
    waitpid(pid, nullptr, 0);
    return result;
}

}  // namespace
}  // namespace clerestory::bench

int main(int argc, char** argv) {
    using namespace clerestory::bench;
    if (argc < 2) {
        std::fprintf(stderr, "usage: bench_start CLERESTORY [FLAG...]\n");
        return 2;
    }
    std::vector<double> times;
    for (int i = 0; i < 6; ++i) {
        const Start start = startOnce({argv + 1, argv + argc});
        std::printf("start %d: first chapel frame after %.0f ms, %zu bytes, %s\n", i,
                    start.firstFrameMs, start.bytes, start.memory.c_str());
        if (i > 0) times.push_back(start.firstFrameMs);
    }
    std::printf("median of the last five: %.0f ms\n", median(times));
    return 0;
}
