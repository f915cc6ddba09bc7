// Memory that OpenGL reads, and a texture that looks into one.
#pragma once

#include "gl/api.h"

#include <cstddef>
#include <span>

namespace clerestory::gl {

// Bytes past the end of shared memory that a driver may read, because it fetches whole vectors.
inline constexpr std::size_t kSharedMemoryTail = 64;

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

enum class BufferFormat { rgba32f, rg32f, r32ui, rgba8 };

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

}  // namespace clerestory::gl
