// The main function of a worker process, which owns the renderer and the scenes and answers the
// requests that come through its pipe. It ends when its server ends.
#pragma once

#include "server/backend/local_backend.h"

namespace clerestory {

// The worker's command, in the place of `serve`, and the descriptor of its pipe.
inline constexpr const char* kWorkerCommand = "worker";
inline constexpr int kWorkerSocket = 3;

struct WorkerOptions {
    std::size_t threads = 16;       // that answer requests, at most
    double hangSeconds = 60.0;      // the process ends when one piece of work takes longer
    std::uint64_t memoryBytes = 0;  // of address space; 0: any
    std::string logLevel = "info";
    std::size_t renderers = 1;  // that share the processors
};

// Answers requests until the server ends; returns the exit code.
int runWorker(const WorkerOptions& options, const LocalBackendOptions& backend);

}  // namespace clerestory
