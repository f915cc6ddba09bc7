// The main function of the import's child process.
#pragma once

namespace clerestory {

// `clerestory import-child FILE --result-fd N --progress-fd M [--limits TEXT] [--as environment]`.
// Sets the process's limits, enters the jail, imports FILE and writes the blob to the result
// descriptor. Returns an exit code (sandbox/wire.h).
int importChildMain(int argc, char** argv);

}  // namespace clerestory
