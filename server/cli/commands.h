// The commands of the program. Each returns 0; on failure it throws an exception with a message of
// one line, which main() prints before it exits with 2.
#pragma once

#include "server/cli/config.h"

namespace clerestory {

int runServe(const CommandLine& line);
int runRender(const CommandLine& line);
int runPlan(const CommandLine& line);
int runReference(const CommandLine& line);
int runCompare(const CommandLine& line);
int runCompile(const CommandLine& line);
int runSequence(const CommandLine& line);
int runSign(const CommandLine& line);
int runScenes();

}  // namespace clerestory
