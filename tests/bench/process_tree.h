// The processes of a server, and their resources.
#pragma once

#include <sys/types.h>

#include <cstddef>
#include <string>
#include <vector>

namespace clerestory::bench {

std::string commandLineOf(pid_t id);
// The render workers of a server, the oldest first, which is the one that answers.
std::vector<pid_t> workersOf(pid_t server);

struct Resources {
    std::size_t bytes = 0;  // resident
    std::size_t descriptors = 0, threads = 0;
};
// Sums over a server and its render workers.
Resources holdingsOf(pid_t server);

}  // namespace clerestory::bench
