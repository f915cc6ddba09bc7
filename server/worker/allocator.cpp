// The allocator of the C library, which ends the process of a worker when a small allocation fails
// (see endWithoutMemory()), takes Mesa's blocks from pools (see BlockPool), and makes the pages of
// large blocks resident in one call. Linked only into the program, so that every library and driver
// uses these definitions.
#include "scene/import/sandbox/jail.h"
#include "server/base/block_pool.h"
#include "server/base/pages.h"
#include "server/base/process.h"
#include "server/worker/confinement.h"

#include <dlfcn.h>
#include <malloc.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstring>

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)

extern "C" void* __libc_malloc(std::size_t);
extern "C" void* __libc_calloc(std::size_t, std::size_t);
extern "C" void* __libc_realloc(void*, std::size_t);
extern "C" void* __libc_memalign(std::size_t, std::size_t);
extern "C" void __libc_free(void*);

namespace {

using clerestory::BlockPool;
using clerestory::commandBlocks;
using clerestory::shaderBlocks;

// Code that allocates more, for a texture or a picture, handles failure, and only its frame fails.
constexpr std::size_t kSmall = 1 << 20;

// Blocks of these sizes, in bytes, are textures, buffers and pictures, which are written from end
// to end. Larger ones may be reserves.
constexpr std::size_t kMinWhole = 256 << 10, kMaxWhole = 64 << 20;

bool hasHugePages(std::size_t size) {
    return size >= clerestory::kMappedBlock && size <= kMaxWhole;
}

void* checked(void* memory, std::size_t size) {
    if (memory && hasHugePages(size)) clerestory::useHugePages(memory, size);
    if (memory && size >= kMinWhole && size <= kMaxWhole) clerestory::makeResident(memory, size);
    if (memory || size == 0 || size >= kSmall) return memory;
    if (clerestory::endsWithoutMemory()) _exit(clerestory::kEndedWithoutMemory);
    return nullptr;
}

BlockPool* poolFor(std::size_t size) {
    return shaderBlocks.fits(size)    ? &shaderBlocks
           : commandBlocks.fits(size) ? &commandBlocks
                                      : nullptr;
}

BlockPool* poolOf(const void* memory) {
    return shaderBlocks.owns(memory)    ? &shaderBlocks
           : commandBlocks.owns(memory) ? &commandBlocks
                                        : nullptr;
}

void* pooled(std::size_t size) {
    BlockPool* const pool = poolFor(size);
    return pool ? pool->take() : nullptr;
}

}  // namespace

extern "C" void* malloc(std::size_t size) {
    if (void* const block = pooled(size)) return block;
    return hasHugePages(size) ? memalign(clerestory::kHugePage, size)
                              : checked(__libc_malloc(size), size);
}
extern "C" void* calloc(std::size_t count, std::size_t size) {
    const bool small = count == 0 || size < kSmall / count;
    if (void* const block = small ? pooled(count * size) : nullptr) {
        return std::memset(block, 0, count * size);
    }
    void* const zeros = __libc_calloc(count, size);
    return checked(zeros, zeros || small ? count * size : kSmall);  // the product may overflow
}
extern "C" void free(void* memory) {
    BlockPool* const pool = poolOf(memory);
    if (!pool) return __libc_free(memory);
    const int error = errno;  // free() keeps it
    pool->give(memory);
    errno = error;
}
extern "C" void* realloc(void* memory, std::size_t size) {
    const BlockPool* const pool = poolOf(memory);
    if (!pool) return checked(__libc_realloc(memory, size), size);
    void* const moved = size > 0 ? malloc(size) : nullptr;
    if (moved) std::memcpy(moved, memory, std::min(size, pool->blockBytes()));
    if (moved || size == 0) free(memory);
    return moved;
}
extern "C" std::size_t malloc_usable_size(void* memory) {
    if (const BlockPool* const pool = poolOf(memory)) return pool->blockBytes();
    static const auto next =
        reinterpret_cast<std::size_t (*)(void*)>(dlsym(RTLD_NEXT, "malloc_usable_size"));
    return next(memory);
}
extern "C" void* memalign(std::size_t alignment, std::size_t size) {
    const std::size_t least = hasHugePages(size) ? clerestory::kHugePage : 1;
    return checked(__libc_memalign(std::max(alignment, least), size), size);
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
