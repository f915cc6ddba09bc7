// Pages of memory that is written soon, from end to end.
//
// A system gives memory its pages when they are first written, 4 KB with each page fault. On some
// virtual machines that takes 10 to 15 us, and the first frame of a scene writes hundreds of
// megabytes.
//
//     useHugePages(block, bytes);
//     makeResident(block, bytes);
//
// Only the whole pages within the memory change, and its content stays. Where the system does not
// have the call, or refuses it, the pages come one by one. `errno` stays.
#pragma once

#include <cstddef>

namespace clerestory {

constexpr std::size_t kHugePage = 2 << 20;

// Its pages are to have 2 MB, which takes a twentieth of the time there. For memory that is
// unmapped as a whole: in a heap that goes on, the next small block would make 2 MB resident.
void useHugePages(void* memory, std::size_t bytes) noexcept;

// All pages by one call (Linux 5.14).
void makeResident(void* memory, std::size_t bytes) noexcept;

}  // namespace clerestory
