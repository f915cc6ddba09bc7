// Memory that OpenGL reads: buffers, textures that look into one, and vertex arrays, which say
// where vertices come from.
#pragma once

#include "gl/api.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace clerestory::gl {

// Bytes past the end of shared memory that a driver may read, because it fetches whole vectors.
inline constexpr std::size_t kSharedMemoryTail = 64;
// Reallocates the list unless it has capacity for that tail and wastes less than an eighth.
template <class T>
void fitForSharing(std::vector<T>& list) {
    const std::size_t least = list.size() + (kSharedMemoryTail + sizeof(T) - 1) / sizeof(T);
    if (list.capacity() >= least && list.capacity() <= least + least / 8) return;
    std::vector<T> fitted;
    fitted.reserve(least);
    fitted.insert(fitted.end(), list.begin(), list.end());
    list = std::move(fitted);
}

class Buffer {
public:
    // Filled once, never changed.
    explicit Buffer(std::span<const std::byte> content);
    // Empty; assign() replaces the whole content, of any size.
    Buffer();
    Buffer(Buffer&&) = default;
    ~Buffer();

    // Reads `content` where it lies, without a copy, where the driver can (readsClientMemory),
    // else copies it. Either way it must stay as it is, with kSharedMemoryTail readable bytes after
    // it, for as long as this buffer lives.
    static Buffer sharing(std::span<const std::byte> content);

    void assign(std::span<const std::byte> content);
    // A part of what assign() has filled, from `offset` in bytes on; the size stays.
    void replace(std::size_t offset, std::span<const std::byte> content);
    void bindUniform(unsigned int binding) const;
    void bindUniform(unsigned int binding, std::size_t offset, std::size_t size) const;
    Name name() const { return name_.get(); }

private:
    OwnedName name_;
};

enum class BufferFormat { rgba32f, rg32f, r32ui, rgba32ui, rgba8 };

// What shaders read by index: texels of a buffer that must outlive it.
class BufferTexture {
public:
    explicit BufferTexture(const Buffer& buffer, BufferFormat format = BufferFormat::rgba32f);
    BufferTexture(BufferTexture&&) = default;
    ~BufferTexture();
    void bind(unsigned int unit) const;

private:
    OwnedName name_;
};

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

enum class Topology { triangles, lines, points };
// With the bound vertex array and program. `instance` chooses the per-instance attributes.
void drawIndexed(Topology topology, std::uint32_t firstIndex, std::uint32_t indexCount,
                 std::uint32_t instance);
// Width of the lines and points that are drawn next, in pixels; 1 before the first call. A driver
// with a smaller limit draws them as wide as that.
void setWidth(float pixels);
// Makes a software driver start the submitted draws: it bins triangles into tiles on the calling
// thread and rasterises tiles on others only after a flush. Hardware starts without it.
void submitDraws();
// The draws that were submitted before it was made; a software driver starts them.
class Fence {
public:
    Fence();
    ~Fence();
    Fence(Fence&& other) noexcept : sync_(std::exchange(other.sync_, nullptr)) {}
    Fence& operator=(Fence&& other) noexcept {
        std::swap(sync_, other.sync_);
        return *this;
    }
    void wait() const;  // until they are finished

private:
    void* sync_;  // GLsync
};
// Of the viewport.
double drawnPixels();
void drawTriangle();  // three vertices without attributes

}  // namespace clerestory::gl
