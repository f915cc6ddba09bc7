#include "server/scenes/scene_light.h"

namespace clerestory {

void lightWithSky(Scene& scene) {
    scene.warnings.push_back({"unknownEnvironment", scene.environment,
                              "no environment map of that name is loaded; 'sky' lights the scene"});
    scene.environment = "sky";
    updateContentHash(scene);
}

}  // namespace clerestory
