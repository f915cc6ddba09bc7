// Where vertices come from: attributes with their places in buffers, and the indices.
#pragma once

#include "gl/buffer.h"

#include <cstdint>
#include <span>

namespace clerestory::gl {

struct Attribute {
    std::uint32_t slot = 0;
    std::uint32_t components = 4;  // floats
    std::uint32_t offset = 0;      // bytes
    std::uint32_t stride = 0;      // bytes
    bool perInstance = false;
    const Buffer* buffer = nullptr;
};

class VertexArray {
public:
    // The buffers must outlive it. Without attributes: for shaders that make their own vertices.
    VertexArray(std::span<const Attribute> attributes, const Buffer* indices);
    VertexArray(VertexArray&&) = default;
    ~VertexArray();
    void bind() const;

private:
    OwnedName name_;
};

// With the bound vertex array and program. `instance` chooses the per-instance attributes.
void drawIndexed(std::uint32_t firstIndex, std::uint32_t indexCount, std::uint32_t instance);
// Makes a software driver start the submitted draws: it bins triangles into tiles on the calling
// thread and rasterises tiles on others only after a flush. Hardware starts without it.
void submitDraws();
void drawTriangle();  // three vertices without attributes

}  // namespace clerestory::gl
