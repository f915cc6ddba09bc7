// The shading formulae in the precision of the GPU and in double.
#pragma once

#include "tests/unit/optics_support.h"

namespace clerestory::test {
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
namespace twin {
namespace {
using namespace glm;
using uint = unsigned int;
// Made while configuring, of shaders/include; see CMakeLists.txt.
#include "optics.glsl"
// After optics.glsl, which it needs.
#include "glass.glsl"
#include "reflection_lookup.glsl"
#include "sampling.glsl"
#include "srgb.glsl"
#include "tonemap.glsl"
}  // namespace
}  // namespace twin
#pragma GCC diagnostic pop
}  // namespace clerestory::test
