// `clerestory serve`: runs the server until SIGINT or SIGTERM.
#include "server/base/log.h"
#include "server/cli/commands.h"
#include "server/scenes/shader_cache.h"
#include "server/server.h"

#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <iostream>

namespace clerestory {

int runServe(const CommandLine& line) {
    // Blocked before any thread starts, so that only sigwait() below receives them.
    sigset_t signals;
    sigemptyset(&signals);
    sigaddset(&signals, SIGINT);
    sigaddset(&signals, SIGTERM);
    pthread_sigmask(SIG_BLOCK, &signals, nullptr);
    std::signal(SIGHUP, SIG_IGN);  // closing the terminal does not stop the server

    logWithoutWaiting();
    setLogLevel(line.config.logLevel);
    Config config = line.config;
    config.workers.compileFastFirst =
        config.fastStart && !compiledBefore(firstSourceOf(config.scenes));
    Server server(config);
    server.start();
    std::cout << "Clerestory listens on http://" << config.http.host << ":" << server.port() << "/"
              << std::endl;

    int signal = 0;
    sigwait(&signals, &signal);
    logInfo({"stopping: waiting for running frames"});
    // A second signal terminates the program immediately.
    pthread_sigmask(SIG_UNBLOCK, &signals, nullptr);
    server.stop();
    // Every request is answered. An import would delay the end; it runs in a child process, which
    // ends with this one.
    if (server.backend().importing()) std::_Exit(0);
    return 0;
}

}  // namespace clerestory
