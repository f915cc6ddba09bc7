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

// From now on the process ends, with this status, when an allocation of less than a megabyte fails,
// whoever asked for it: drivers draw wrong pictures then and say nothing, or wait for ever, and
// another renderer stands ready. Larger ones fail as ever. In the program `clerestory` alone; see
// allocator.cpp.
inline constexpr int kEndedWithoutMemory = 5;
void endWithoutMemory();
bool endsWithoutMemory();

}  // namespace clerestory
