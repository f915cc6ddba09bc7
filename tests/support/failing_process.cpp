// Preloaded into a server and its renderers; see failing_process.h. Its functions replace the C
// library's below the program's allocator (server/worker/allocator.cpp).
#include "tests/support/failing_process.h"

#include <dlfcn.h>
#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstddef>
#include <cstdlib>
#include <cstring>

using clerestory::test::ProcessFaults;

namespace {

ProcessFaults* faults = nullptr;
std::atomic<std::int64_t> failingFromStart{0};  // in this process

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
    if (memory == MAP_FAILED) return;
    faults = static_cast<ProcessFaults*>(memory);
    failingFromStart = faults->failingFromStart.exchange(0);
}

bool counted(std::atomic<std::int64_t>& left) {
    return left > 0 && --left == 0;
}

bool fails(std::size_t bytes) {
    if (!faults || bytes < faults->leastBytes) return false;
    if (!counted(faults->failingAllocation) && !counted(failingFromStart)) return false;
    errno = ENOMEM;
    return true;
}

// The replaced function, looked up at the first call; dlsym() does not allocate.
template <class Function>
void find(Function*& real, const char* name) {
    if (!real) real = reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}

}  // namespace

extern "C" void* __libc_malloc(std::size_t size) {
    static void* (*real)(std::size_t) = nullptr;
    find(real, "__libc_malloc");
    return fails(size) ? nullptr : real(size);
}
extern "C" void* __libc_calloc(std::size_t count, std::size_t size) {
    static void* (*real)(std::size_t, std::size_t) = nullptr;
    find(real, "__libc_calloc");
    return fails(count * size) ? nullptr : real(count, size);
}
extern "C" void* __libc_realloc(void* memory, std::size_t size) {
    static void* (*real)(void*, std::size_t) = nullptr;
    find(real, "__libc_realloc");
    return fails(size) ? nullptr : real(memory, size);
}
extern "C" void* __libc_memalign(std::size_t alignment, std::size_t size) {
    static void* (*real)(std::size_t, std::size_t) = nullptr;
    find(real, "__libc_memalign");
    return fails(size) ? nullptr : real(alignment, size);
}

extern "C" unsigned glGetGraphicsResetStatus() {
    using Status = unsigned (*)();
    static const auto real = reinterpret_cast<Status>(dlsym(RTLD_NEXT, "glGetGraphicsResetStatus"));
    constexpr unsigned kInnocentContextReset = 0x8254;
    std::int64_t own = ::getpid();
    if (faults && faults->resetProcess.compare_exchange_strong(own, 0)) {
        return kInnocentContextReset;
    }
    return real ? real() : 0;
}
