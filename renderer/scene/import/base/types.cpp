#include "scene/import/base/types.h"

#include <array>
#include <sstream>

namespace clerestory {

std::string_view nameOf(ImportError::Reason reason) {
    constexpr std::array<std::string_view, 7> kNames{
        "notFound", "unsupported", "malformed", "crashed", "timedOut", "memory", "limit"};
    return kNames[static_cast<std::size_t>(reason)];
}

std::string encoded(const ImportLimits& l) {
    std::ostringstream text;
    text << l.cpu.count() << ' ' << l.addressSpaceBytes << ' ' << l.fileBytes << ' '
         << l.maxTriangles << ' ' << l.maxNodes << ' ' << l.maxImagePixels << ' ' << l.maxFiles;
    return text.str();
}

ImportLimits decodedLimits(const std::string& text) {
    ImportLimits limits;
    std::istringstream in(text);
    std::int64_t cpu = 0;
    if (in >> cpu) {
        limits.cpu = std::chrono::seconds(cpu);
    }
    for (std::uint64_t* value : {&limits.addressSpaceBytes, &limits.fileBytes, &limits.maxTriangles,
                                 &limits.maxNodes, &limits.maxImagePixels, &limits.maxFiles}) {
        std::uint64_t read = 0;
        if (in >> read) {
            *value = read;
        }
    }
    return limits;
}

}  // namespace clerestory
