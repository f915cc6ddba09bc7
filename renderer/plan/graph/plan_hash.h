// Hashes of passes: the content of a map is identified by the passes that draw it.
#pragma once

#include "plan/graph/frame_plan.h"
#include "plan/graph/stage.h"
#include "scene/hash.h"

#include <cstdint>
#include <span>
#include <vector>

namespace clerestory {

// Of each material of the frame's own.
std::vector<std::uint64_t> ownHashesOf(const MaterialBindings& materials);
// 0 if the frame changes no material and hides nothing. `own`: ownHashesOf() them.
std::uint64_t hashOf(const MaterialBindings& materials, std::span<const std::uint64_t> own);

// Hashes everything that determines the pixels of the given passes of `plan` (indices into
// plan.passes): geometry, transforms, materials, lights, targets. Equal hashes mean equal pictures.
std::uint64_t hashOfPasses(const FramePlan& plan, std::span<const std::size_t> passes,
                           const Stage& stage, const EnvironmentMap& environment);

}  // namespace clerestory
