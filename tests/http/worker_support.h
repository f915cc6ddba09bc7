// Servers whose renderers are processes.
#pragma once

#include "tests/support/test_server.h"

#include <string>

namespace clerestory::test {

// As testConfig(), with render workers.
inline Config workerConfig() {
    Config config = testConfig();
    config.singleProcess = false;
    config.workers.program.file = CLERESTORY_PROGRAM;
    config.workers.program.arguments = {"--scene",    "six-walls", "--log-level",     "off",
                                        "--queue",    "256",       "--queue-seconds", "60",
                                        "--deadline", "60"};
    return config;
}

// A small frame from the i-th of several places.
inline std::string frameBody(int i) {
    return smallFrame(R"("camera": {"position": [)" + std::to_string(0.01 * i) +
                      R"(, 1, 2], "target": [0, 1, 0]})");
}

}  // namespace clerestory::test
