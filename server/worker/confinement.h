// Restrictions of a worker process, against faults of drivers and scenes.
#pragma once

#include <cstdint>

namespace clerestory {

// The process is killed when the thread that started it ends.
void endWithParent();

// What is enforced in a worker process.
struct Confinement {
    int landlock = 0;  // ABI version; 0: the kernel has none
    bool systemCallFilter = false;
};

// From now on the process gains no privileges, writes no core files, opens no network sockets,
// creates no io_uring, namespaces or handles of processes, does not reach the memory, descriptors
// and signals of its parent, and has this limit of address space in bytes (0: none). Child
// processes inherit it; the importer sets its own limits. Call it before there are other threads.
// What this kernel does not have is logged and left out. Throws std::runtime_error if something
// that it has cannot be enforced.
Confinement confine(std::uint64_t addressSpaceBytes);

// From now on the process ends with this status when an allocation of less than a megabyte fails,
// anywhere in it: drivers then draw wrong pictures without an error, or hang, and the standby can
// take over. Larger allocations fail as usual. Only in the program `clerestory`; see allocator.cpp.
inline constexpr int kEndedWithoutMemory = 5;
void endWithoutMemory();
bool endsWithoutMemory();

}  // namespace clerestory
