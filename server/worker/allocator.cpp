// The C library's allocator, but that a renderer's process ends when it has no memory left for
// little things; see endWithoutMemory(). It belongs to the program alone, whose definitions of
// these functions are those that every library and driver in its process calls.
#include "scene/import/sandbox/sanitizer.h"
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

// Whoever asks for more, a texture, a picture, expects a no, and that frame alone is told so.
constexpr std::size_t kLittle = 1 << 20;

void* orEnd(void* memory, std::size_t size) {
    if (memory || size == 0 || size >= kLittle) return memory;
    if (clerestory::endsWithoutMemory()) _exit(clerestory::kEndedWithoutMemory);
    return nullptr;
}

}  // namespace

extern "C" void* malloc(std::size_t size) {
    return orEnd(__libc_malloc(size), size);
}
extern "C" void* calloc(std::size_t count, std::size_t size) {
    const bool little = count == 0 || size < kLittle / count;
    return orEnd(__libc_calloc(count, size), little ? count * size : kLittle);
}
extern "C" void* realloc(void* memory, std::size_t size) {
    return orEnd(__libc_realloc(memory, size), size);
}
extern "C" void* memalign(std::size_t alignment, std::size_t size) {
    return orEnd(__libc_memalign(alignment, size), size);
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
