#include "scene/import/assimp/file_system.h"

#include "scene/import/base/types.h"

#include <assimp/MemoryIOWrapper.h>

#include <cstring>
#include <string>

namespace clerestory {

bool AssimpFileSystem::Exists(const char* name) const {
    return folder_.has(name);
}

Assimp::IOStream* AssimpFileSystem::Open(const char* name, const char* mode) {
    if (!mode || mode[0] != 'r') {
        return nullptr;  // importers do not write
    }
    try {
        const std::string content = folder_.read(name);
        auto* bytes = new std::uint8_t[content.size() + 1];
        std::memcpy(bytes, content.data(), content.size());
        return new Assimp::MemoryIOStream(bytes, content.size(), true);
    } catch (const ImportError&) {
        return nullptr;  // for Assimp: the file does not exist
    }
}

void AssimpFileSystem::Close(Assimp::IOStream* stream) {
    delete stream;
}

}  // namespace clerestory
