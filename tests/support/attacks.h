// Attacks that disable a naive server, on a real one: slow, huge, chunked, compressed, smuggling,
// garbage, many connections. Each returns a figure with its limit.
#pragma once

#include "tests/support/figure.h"
#include "tests/support/server_process.h"

namespace clerestory::test {

struct Target {
    const ServerProcess& server;
    double head = 5.0, body = 10.0, write = 10.0, idle = 15.0;  // its limits, seconds
    int crowd = 400;                                            // connections of a slow attack
    int many = 1100;                                            // of the crowd that does nothing
    double grace = 1.5;                                         // seconds that it may be late
};

std::vector<Figure> slowAttacks(const Target& target);                        // C1
std::vector<Figure> wrongRequests(const Target& target);                      // R4, R5, R7
std::vector<Figure> crowds(const Target& target);                             // C2, C3
std::vector<Figure> connectionFloods(const Target& target, int connections);  // R7
std::vector<Figure> liveCrowd();                                              // R7, on its own
std::vector<Figure> failingAccepts();                   // C3, on a server of its own
std::vector<Figure> pathAttacks(const Target& target);  // R6
std::vector<std::string> hostilePaths();                // 500

// The longest of a few requests on new connections, milliseconds: health, which the event loop
// answers, and the renderer's name, which takes a worker. Negative: one was not answered.
double worstAnswer(int port, int tries = 5);

}  // namespace clerestory::test
