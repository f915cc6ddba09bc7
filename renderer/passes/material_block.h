// A material as the shaders read it, from a uniform block or from a table.
#pragma once

#include "passes/blocks.h"
#include "scene/material.h"

namespace clerestory {

blocks::MaterialBlock materialBlock(const Material& material);

}  // namespace clerestory
