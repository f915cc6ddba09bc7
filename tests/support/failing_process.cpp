// Preloaded into a server and its renderers; see failing_process.h. It stands in front of the
// allocator of the C library, whose own functions go on under other names.
#include "tests/support/failing_process.h"

#include <dlfcn.h>
#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>
#include <cstddef>
#include <cstdlib>
#include <cstring>

using clerestory::test::ProcessFaults;

extern "C" void* __libc_malloc(std::size_t);
extern "C" void* __libc_calloc(std::size_t, std::size_t);
extern "C" void* __libc_realloc(void*, std::size_t);
extern "C" void* __libc_memalign(std::size_t, std::size_t);

namespace {

ProcessFaults* faults = nullptr;

bool hasRole(const char* role) {
    char words[256] = {};
    const int file = ::open("/proc/self/cmdline", O_RDONLY | O_CLOEXEC);
    const ssize_t size = ::read(file, words, sizeof words - 1);
    ::close(file);
    const std::size_t first = std::strlen(words) + 1;
    return size > static_cast<ssize_t>(first) && std::strcmp(words + first, role) == 0;
}

__attribute__((constructor)) void begin() {
    const char* name = std::getenv(clerestory::test::kFaultsFile);
    const char* role = std::getenv(clerestory::test::kFaultsRole);
    if (!name || !role || !hasRole(role)) return;
    const int file = ::open(name, O_RDWR | O_CLOEXEC);
    if (file < 0) return;
    void* memory =
        ::mmap(nullptr, sizeof(ProcessFaults), PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
    ::close(file);
    if (memory != MAP_FAILED) faults = static_cast<ProcessFaults*>(memory);
}

bool fails() {
    if (!faults) return false;
    ++faults->allocations;
    if (faults->failingAllocation <= 0 || --faults->failingAllocation != 0) return false;
    errno = ENOMEM;
    return true;
}

}  // namespace

extern "C" void* malloc(std::size_t size) {
    return fails() ? nullptr : __libc_malloc(size);
}
extern "C" void* calloc(std::size_t count, std::size_t size) {
    return fails() ? nullptr : __libc_calloc(count, size);
}
extern "C" void* realloc(void* memory, std::size_t size) {
    return fails() ? nullptr : __libc_realloc(memory, size);
}
extern "C" void* memalign(std::size_t alignment, std::size_t size) {
    return fails() ? nullptr : __libc_memalign(alignment, size);
}
extern "C" void* aligned_alloc(std::size_t alignment, std::size_t size) {
    return memalign(alignment, size);
}
extern "C" int posix_memalign(void** memory, std::size_t alignment, std::size_t size) {
    *memory = memalign(alignment, size);
    return *memory ? 0 : ENOMEM;
}

extern "C" unsigned glGetGraphicsResetStatus() {
    using Status = unsigned (*)();
    static const auto real = reinterpret_cast<Status>(dlsym(RTLD_NEXT, "glGetGraphicsResetStatus"));
    constexpr unsigned kInnocentContextReset = 0x8254;
    if (faults && faults->resets > 0 && faults->resets-- > 0) return kInnocentContextReset;
    return real ? real() : 0;
}
