// What every instance wears in one frame: the scene's own materials, and changed copies of them
// where a request overrides something.
#pragma once

#include "scene/scene.h"

#include <vector>

namespace clerestory {

// A material's number is its place in Scene::materials, or, from scene.materials.size() on, that
// number more than its place in `own`. The scene's are uploaded once; those beyond are the frame's.
// Empty lists, which cost nothing, mean the scene as it is.
struct MaterialBindings {
    std::vector<Material> own;
    std::vector<Index> materialOfInstance;  // empty: each instance's own

    Index materialOf(const Scene& scene, Index instance) const {
        return materialOfInstance.empty() ? scene.instances[instance].material
                                          : materialOfInstance[instance];
    }
    const Material& material(const Scene& scene, Index index) const {
        return index < scene.materials.size() ? scene.materials[index]
                                              : own[index - scene.materials.size()];
    }
};

}  // namespace clerestory
