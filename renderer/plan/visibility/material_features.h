// Features of programs (graph/features.h) that follow from materials and their textures.
#pragma once

#include "plan/graph/stage.h"

namespace clerestory {

// Of a surface with this material on this mesh, apart from what a view adds to them.
Features materialFeatures(const Scene& scene, const Material& material, const Mesh& mesh,
                          const Effects& effects);

// Union of the texture features that glass adds to those, over all glass of the scene.
Features texturesOfGlass(const Stage& stage);

// Union of the features of all surfaces, for shaders whose rays may hit any of them.
Features featuresOfAll(const Stage& stage);

}  // namespace clerestory
