// File access for Assimp, restricted to the scene's folder.
#pragma once

#include "scene/import/assimp/accepted_text.h"
#include "scene/import/base/scene_folder.h"
#include "scene/import/base/types.h"

#include <assimp/MemoryIOWrapper.h>
#include <assimp/IOSystem.hpp>

#include <cstdint>
#include <cstring>
#include <string>

namespace clerestory {

class AssimpFileSystem : public Assimp::IOSystem {
public:
    explicit AssimpFileSystem(const SceneFolder& folder) : folder_(folder) {}

    bool Exists(const char* name) const override { return folder_.has(name); }
    char getOsSeparator() const override { return '/'; }

    Assimp::IOStream* Open(const char* name, const char* mode) override {
        if (!mode || mode[0] != 'r') {
            return nullptr;  // importers do not write
        }
        try {
            std::string content = folder_.read(name);
            const std::string extension = lowerExtension(name);
            if (extension == "dae") content = acceptedCollada(content);
            if (extension == "obj") content = acceptedObj(content);
            auto* bytes = new std::uint8_t[content.size() + 1];
            std::memcpy(bytes, content.data(), content.size());
            return new Assimp::MemoryIOStream(bytes, content.size(), true);
        } catch (const ImportError&) {
            return nullptr;  // for Assimp: the file does not exist
        }
    }

    void Close(Assimp::IOStream* stream) override { delete stream; }

private:
    const SceneFolder& folder_;
};

}  // namespace clerestory
