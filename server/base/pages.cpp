#include "server/base/pages.h"

#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>

namespace clerestory {
namespace {

void adviseWithin(void* memory, std::size_t bytes, std::size_t page, int advice) noexcept {
    const auto begin = reinterpret_cast<std::uintptr_t>(memory);
    const std::uintptr_t first = (begin + page - 1) / page * page;
    const std::uintptr_t end = (begin + bytes) / page * page;
    if (first >= end) return;
    const int error = errno;
    madvise(reinterpret_cast<void*>(first), end - first, advice);
    errno = error;
}

}  // namespace

void useHugePages(void* memory, std::size_t bytes) noexcept {
    adviseWithin(memory, bytes, kHugePage, MADV_HUGEPAGE);
}

void makeResident(void* memory, std::size_t bytes) noexcept {
#ifdef MADV_POPULATE_WRITE
    adviseWithin(memory, bytes, static_cast<std::size_t>(getpagesize()), MADV_POPULATE_WRITE);
#else
    (void)memory, (void)bytes;
#endif
}

}  // namespace clerestory
