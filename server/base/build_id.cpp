#include "server/base/build_id.h"

#include <elf.h>
#include <link.h>

#include <cstring>

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

}  // namespace

std::string versionText() {
    return CLERESTORY_VERSION;
}

std::string buildId() {
    std::string hex;
    dl_iterate_phdr(visitProgram, &hex);
    return hex.empty() ? "none" : hex;
}

}  // namespace clerestory
