// What lights a scene whose side file names a map that is not at hand.
#pragma once

#include "scene/scene.h"

namespace clerestory {

// The sky instead, and a warning.
void lightWithSky(Scene& scene);

}  // namespace clerestory
