// The allocator of the C library, which ends the process of a worker when a small allocation fails;
// see endWithoutMemory(). Linked only into the program, so that every library and driver uses these
// definitions.
#include "scene/import/sandbox/jail.h"
#include "server/worker/confinement.h"

#include <unistd.h>

#include <cerrno>
#include <cstddef>

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)

extern "C" void* __libc_malloc(std::size_t);
extern "C" void* __libc_calloc(std::size_t, std::size_t);
extern "C" void* __libc_realloc(void*, std::size_t);
extern "C" void* __libc_memalign(std::size_t, std::size_t);

namespace {

// Code that allocates more, for a texture or a picture, handles failure, and only its frame fails.
constexpr std::size_t kSmall = 1 << 20;

void* checked(void* memory, std::size_t size) {
    if (memory || size == 0 || size >= kSmall) return memory;
    if (clerestory::endsWithoutMemory()) _exit(clerestory::kEndedWithoutMemory);
    return nullptr;
}

}  // namespace

extern "C" void* malloc(std::size_t size) {
    return checked(__libc_malloc(size), size);
}
extern "C" void* calloc(std::size_t count, std::size_t size) {
    const bool small = count == 0 || size < kSmall / count;
    return checked(__libc_calloc(count, size), small ? count * size : kSmall);
}
extern "C" void* realloc(void* memory, std::size_t size) {
    return checked(__libc_realloc(memory, size), size);
}
extern "C" void* memalign(std::size_t alignment, std::size_t size) {
    return checked(__libc_memalign(alignment, size), size);
}
extern "C" void* aligned_alloc(std::size_t alignment, std::size_t size) {
    return memalign(alignment, size);
}
extern "C" int posix_memalign(void** memory, std::size_t alignment, std::size_t size) {
    if (alignment % sizeof(void*) != 0 || (alignment & (alignment - 1)) != 0 || alignment == 0) {
        return EINVAL;
    }
    void* const made = memalign(alignment, size);
    if (!made) return ENOMEM;
    *memory = made;
    return 0;
}

#endif
