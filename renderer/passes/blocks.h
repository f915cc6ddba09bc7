// The uniform blocks and binding numbers of shaders/include as C++ types and macros.
#pragma once

#include <glm/glm.hpp>

#include <cstddef>
#include <span>

// clang-format off
#include "shaders/include/bindings.glsl"

namespace clerestory::blocks {
using glm::vec4, glm::ivec4, glm::mat4;
#define BLOCK_BEGIN(name, slot) struct name {
#define BLOCK_END(instance) };
#include "shaders/include/blocks.glsl"
#undef BLOCK_BEGIN
#undef BLOCK_END
// clang-format on

static_assert(sizeof(ViewBlock) == 272);
static_assert(sizeof(ReflectionBlock) == 144);
static_assert(sizeof(MaterialBlock) == 336);
static_assert(sizeof(LayerBlock) == 464);
static_assert(sizeof(FilterBlock) == 64);

template <class Block>
std::span<const std::byte> bytesOf(const Block& block) {
    return std::as_bytes(std::span(&block, 1));
}

}  // namespace clerestory::blocks
