// What a worker may not do, whatever its drivers and its scenes make it do.
#pragma once

#include <cstdint>

namespace clerestory {

// The process is killed when the thread that started it ends.
void endWithParent();

// From now on: no new privileges, no core files, no sockets of the network, no more address space
// than so many bytes (0: any). Children inherit it, except that the importer sets limits of its
// own. What the kernel refuses is logged and left out.
void confine(std::uint64_t addressSpaceBytes);

}  // namespace clerestory
