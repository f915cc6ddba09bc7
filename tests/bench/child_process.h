// A child process of a benchmark: its environment, processor time and exit.
#pragma once

#include <sys/types.h>

#include <map>
#include <string>
#include <vector>

namespace clerestory::bench {

// Settings that replace those of this process; an empty value removes the variable.
using Environment = std::map<std::string, std::string>;

// Standard output and error go to the file; both stay as they are where its name is empty.
pid_t startProgram(std::vector<std::string> command, const Environment& changes = {},
                   const std::string& outputFile = {});

struct Ended {
    int status = 0;                 // as waitpid() reports it
    double processorSeconds = 0.0;  // user and system, with the children that it waited for
};
Ended awaitEnd(pid_t id);

// The process and all its descendants that run now.
std::vector<pid_t> processTree(pid_t id);
// User and system time of these processes and of their children that have ended.
double processorSeconds(const std::vector<pid_t>& processes);

// SIGTERM, then SIGKILL after 20 s; returns when the whole tree has ended.
void stopTree(pid_t id);

}  // namespace clerestory::bench
