// File access for Assimp, restricted to the scene's folder.
#pragma once

#include "scene/import/base/scene_folder.h"

#include <assimp/IOSystem.hpp>

namespace clerestory {

class AssimpFileSystem : public Assimp::IOSystem {
public:
    explicit AssimpFileSystem(const SceneFolder& folder) : folder_(folder) {}

    bool Exists(const char* name) const override;
    char getOsSeparator() const override { return '/'; }
    Assimp::IOStream* Open(const char* name, const char* mode) override;
    void Close(Assimp::IOStream* stream) override;

private:
    const SceneFolder& folder_;
};

}  // namespace clerestory
