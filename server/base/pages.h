// Pages of memory that is written soon, from end to end.
//
// A system gives memory its pages when they are first written, 4 KB with each page fault. That
// takes 0.2 us on a computer and 10 to 15 us on some virtual machines, where a frame writes
// hundreds of megabytes when it is the first of its size.
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

// Its pages are to have 2 MB, which takes a twentieth of the time. For memory that is unmapped as a
// whole.
void useHugePages(void* memory, std::size_t bytes) noexcept;

// All pages by one call (Linux 5.14).
void makeResident(void* memory, std::size_t bytes) noexcept;

}  // namespace clerestory
