#include "server/base/resident.h"

#include <link.h>
#include <malloc.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cstdint>
#include <cstring>
#include <fstream>

namespace clerestory {
namespace {

// LLVM is larger than everything else that is loaded, and is used only while a shader is compiled.
// Its read-only segments are equal to the file.
int releaseCompilerCode(dl_phdr_info* library, std::size_t, void*) {
    if (!library->dlpi_name || !std::strstr(library->dlpi_name, "libLLVM")) return 0;
    const auto page = static_cast<std::uintptr_t>(sysconf(_SC_PAGESIZE));
    for (int i = 0; i < library->dlpi_phnum; ++i) {
        const auto& segment = library->dlpi_phdr[i];
        if (segment.p_type != PT_LOAD || (segment.p_flags & PF_W)) continue;
        const std::uintptr_t begin = (library->dlpi_addr + segment.p_vaddr) / page * page;
        const std::uintptr_t end = library->dlpi_addr + segment.p_vaddr + segment.p_memsz;
        madvise(reinterpret_cast<void*>(begin), (end - begin) / page * page, MADV_DONTNEED);
    }
    return 0;
}

}  // namespace

double residentBytes() {
    std::ifstream file("/proc/self/statm");
    double pages = 0.0, resident = 0.0;
    file >> pages >> resident;
    return resident * static_cast<double>(sysconf(_SC_PAGESIZE));
}

double allocatedBytes() {
    const struct mallinfo2 info = mallinfo2();
    return static_cast<double>(info.uordblks + info.hblkhd);
}

void releaseUnusedMemory() {
    malloc_trim(0);
    dl_iterate_phdr(releaseCompilerCode, nullptr);
}

}  // namespace clerestory
