// How GLSL reads blocks.glsl.
#include "include/bindings.glsl"
#define BLOCK_BEGIN(name, slot) layout(std140, binding = slot) uniform name {
#define BLOCK_END(instance) } instance;
#include "include/blocks.glsl"
