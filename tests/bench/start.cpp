// `bench_start CLERESTORY [FLAG...]`: time from the start of `clerestory serve` to the first frame
// of the chapel over HTTP, repeated; and memory at that time. With --cold: first use, with empty
// and with filled caches. Other flags are those of `serve`.
#include "command_line.h"
#include "program.h"
#include "statistics.h"
#include "tests/bench/cold_start.h"
#include "tests/support/free_port.h"

#include <httplib.h>
#include <signal.h>
#include <sys/wait.h>
#include <cstdio>
#include <fstream>
#include <string>
#include <thread>

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
    const Stopwatch watch;
    const pid_t pid = startProgram(command);
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

int runWarm(const std::vector<std::string>& command) {
    std::vector<double> times;
    for (int i = 0; i < 6; ++i) {
        const Start start = startOnce(command);
        std::printf("start %d: first chapel frame after %.0f ms, %zu bytes, %s\n", i,
                    start.firstFrameMs, start.bytes, start.memory.c_str());
        if (i > 0) times.push_back(start.firstFrameMs);
    }
    std::printf("median of the last five: %.0f ms\n", median(times));
    return 0;
}

int measure(int argc, char** argv) {
    CommandLine line("Time from process start to the first frame");
    ColdOptions options;
    bool cold = false;
    line.addRequired("program", options.program, "the program that is measured");
    line.addFlag("--cold", cold, "with empty caches, and with those that the first run filled");
    line.addList("--scenes", options.scenes, "built-in scenes, shared scenes or files, by commas",
                 ',');
    line.add("--shared", options.shared, "folder of the shared scenes");
    line.add("--runs", options.runs, "how often each row is measured; medians are printed",
             {1, 100});
    // Other flags are those of serve.
    if (const auto status = line.parse(argc, argv, &options.flags)) return *status;
    if (cold) return runCold(options);
    std::vector<std::string> command = {options.program};
    command.insert(command.end(), options.flags.begin(), options.flags.end());
    return runWarm(command);
}

}  // namespace
}  // namespace clerestory::bench

int main(int argc, char** argv) {
    return clerestory::bench::runProgram("bench_start", clerestory::bench::measure, argc, argv);
}
