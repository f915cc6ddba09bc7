// The material of every instance in one frame: the scene's materials, and modified copies where a
// request overrides them.
#pragma once

#include "scene/scene.h"

#include <vector>

namespace clerestory {

// A material index below scene.materials.size() refers to Scene::materials, others to `own` after
// subtracting that size. The scene's materials are uploaded once, `own` for each frame. Empty lists
// mean that nothing is overridden.
struct MaterialBindings {
    std::vector<Material> own;
    std::vector<Index> materialOfInstance;  // empty: those of the scene

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
