// File access for Assimp, restricted to the scene's folder.
#pragma once

#include "scene/import/base/scene_folder.h"

#include <assimp/MemoryIOWrapper.h>
#include <assimp/IOSystem.hpp>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

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
            if (std::string_view(name).ends_with(".dae") ||
                std::string_view(name).ends_with(".DAE")) {
                content = withoutLeadingSpaces(content);
            }
            auto* bytes = new std::uint8_t[content.size() + 1];
            std::memcpy(bytes, content.data(), content.size());
            return new Assimp::MemoryIOStream(bytes, content.size(), true);
        } catch (const ImportError&) {
            return nullptr;  // for Assimp: the file does not exist
        }
    }

    void Close(Assimp::IOStream* stream) override { delete stream; }

private:
    // Assimp's reader of COLLADA rejects spaces between a tag and its first number, which XML
    // allows.
    static std::string withoutLeadingSpaces(std::string_view xml) {
        constexpr std::string_view kSpaces = " \t\r\n", kNumber = "+-.0123456789";
        std::string text;
        text.reserve(xml.size());
        for (std::size_t at = 0; at < xml.size();) {
            const std::size_t end = std::min(xml.find('>', at), xml.size() - 1) + 1;
            text.append(xml, at, end - at);
            const std::size_t first = std::min(xml.find_first_not_of(kSpaces, end), xml.size());
            const bool number =
                first < xml.size() && kNumber.find(xml[first]) != std::string_view::npos;
            at = number ? first : end;
        }
        return text;
    }

    const SceneFolder& folder_;
};

}  // namespace clerestory
