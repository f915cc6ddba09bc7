// Hashes what a plan will draw: the content of a map is known by the passes that make it.
#pragma once

#include "plan/graph/frame_plan.h"
#include "plan/graph/stage.h"
#include "scene/hash.h"

#include <cstdint>
#include <span>

namespace clerestory {

// 0 for a scene that wears its own.
std::uint64_t hashOf(const MaterialBindings& materials);

// Of everything that decides the pixels of those of plan.passes: what is drawn, where it stands, of
// what it is made, in which light, into how many texels. Equal hashes, equal pictures.
std::uint64_t hashOfPasses(const FramePlan& plan, std::span<const std::size_t> passes,
                           const Stage& stage, const EnvironmentMap& environment);

}  // namespace clerestory
