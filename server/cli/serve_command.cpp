// `clerestory serve`: from start to the signal that ends it.
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
    // Blocked before any thread begins, so that only sigwait() below takes them.
    sigset_t signals;
    sigemptyset(&signals);
    sigaddset(&signals, SIGINT);
    sigaddset(&signals, SIGTERM);
    pthread_sigmask(SIG_BLOCK, &signals, nullptr);
    std::signal(SIGHUP, SIG_IGN);  // a terminal that goes takes nobody with it

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
    logInfo({"stopping: running frames finish"});
    // A second signal ends the program at once.
    pthread_sigmask(SIG_UNBLOCK, &signals, nullptr);
    server.stop();
    // Everybody is answered; the importer is a child that ends with this process.
    if (server.service() && server.service()->library().importing()) std::_Exit(0);
    return 0;
}

}  // namespace clerestory
