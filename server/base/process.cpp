#include "server/base/process.h"

#include "server/base/block_pool.h"

#include <elf.h>
#include <link.h>
#include <malloc.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cstdint>
#include <cstring>
#include <fstream>

namespace clerestory {
namespace {

// Notes are consecutive; name and content are padded to four bytes each (ELF specification).
std::string hexOfBuildIdNote(const char* notes, std::size_t size) {
    const auto padded = [](std::size_t n) { return (n + 3) & ~std::size_t{3}; };
    for (std::size_t at = 0; at + sizeof(ElfW(Nhdr)) <= size;) {
        ElfW(Nhdr) head;
        std::memcpy(&head, notes + at, sizeof head);
        const std::size_t name = at + sizeof head;
        const std::size_t content = name + padded(head.n_namesz);
        const std::size_t next = content + padded(head.n_descsz);
        if (next > size) break;
        if (head.n_type == NT_GNU_BUILD_ID && head.n_namesz == 4 &&
            std::memcmp(notes + name, "GNU", 4) == 0) {
            std::string hex;
            for (std::size_t i = 0; i < head.n_descsz; ++i) {
                constexpr char kDigits[] = "0123456789abcdef";
                const auto byte = static_cast<unsigned char>(notes[content + i]);
                hex += kDigits[byte >> 4];
                hex += kDigits[byte & 15];
            }
            return hex;
        }
        at = next;
    }
    return {};
}

// Called for each loaded object; the first is the program itself.
int visitProgram(dl_phdr_info* info, std::size_t, void* result) {
    auto& hex = *static_cast<std::string*>(result);
    for (int i = 0; i < info->dlpi_phnum && hex.empty(); ++i) {
        const ElfW(Phdr)& header = info->dlpi_phdr[i];
        if (header.p_type != PT_NOTE) continue;
        const auto* notes = reinterpret_cast<const char*>(info->dlpi_addr + header.p_vaddr);
        hex = hexOfBuildIdNote(notes, header.p_memsz);
    }
    return 1;
}

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

std::string versionText() {
    return CLERESTORY_VERSION;
}

std::string buildId() {
    std::string hex;
    dl_iterate_phdr(visitProgram, &hex);
    return hex.empty() ? "none" : hex;
}

double residentBytes() {
    std::ifstream file("/proc/self/statm");
    double pages = 0.0, resident = 0.0;
    file >> pages >> resident;
    return resident * static_cast<double>(sysconf(_SC_PAGESIZE));
}

double allocatedBytes() {
    const struct mallinfo2 info = mallinfo2();
    return static_cast<double>(info.uordblks + info.hblkhd + shaderBlocks.takenBytes() +
                               commandBlocks.takenBytes());
}

void keepHeapsSmall() {
    mallopt(M_MMAP_THRESHOLD, kMappedBlock);
    mallopt(M_TRIM_THRESHOLD, kMappedBlock);
    shaderBlocks.open();
    commandBlocks.open();
}

void releaseUnusedMemory() {
    shaderBlocks.releasePages();
    commandBlocks.releasePages();
    malloc_trim(0);
    dl_iterate_phdr(releaseCompilerCode, nullptr);
}

}  // namespace clerestory
