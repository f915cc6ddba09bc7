// `clerestory serve`: from start to the signal that ends it.
#include "server/commands.h"
#include "server/server.h"

#include <spdlog/async.h>
#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <iostream>

namespace clerestory {
namespace {

constexpr std::size_t kLogLines = 8192;

// Nobody waits for whoever reads the log: when it is not read, its oldest lines go.
void logWithoutWaiting() {
    spdlog::init_thread_pool(kLogLines, 1);
    spdlog::set_default_logger(std::make_shared<spdlog::async_logger>(
        "clerestory", std::make_shared<spdlog::sinks::stderr_sink_mt>(), spdlog::thread_pool(),
        spdlog::async_overflow_policy::overrun_oldest));
}

}  // namespace

int runServe(const CommandLine& line) {
    // Blocked before any thread begins, so that only sigwait() below takes them.
    sigset_t signals;
    sigemptyset(&signals);
    sigaddset(&signals, SIGINT);
    sigaddset(&signals, SIGTERM);
    pthread_sigmask(SIG_BLOCK, &signals, nullptr);
    std::signal(SIGHUP, SIG_IGN);  // a terminal that goes takes nobody with it

    logWithoutWaiting();
    spdlog::set_level(spdlog::level::from_str(line.config.logLevel));
    Server server(line.config);
    server.start();
    std::cout << "Clerestory listens on http://" << line.config.http.host << ":" << server.port()
              << "/" << std::endl;

    int signal = 0;
    sigwait(&signals, &signal);
    spdlog::info("stopping: running frames finish");
    // A second signal ends the program at once.
    pthread_sigmask(SIG_UNBLOCK, &signals, nullptr);
    server.stop();
    // Everybody is answered; the importer is a child that ends with this process.
    if (server.service() && server.service()->library().importing()) std::_Exit(0);
    return 0;
}

}  // namespace clerestory
