// What is drawn into: a level of a texture, or multisampled memory that is resolved into one.
#pragma once

#include "gl/texture.h"

#include <cstdint>
#include <span>

namespace clerestory::gl {

// Memory that is drawn into and never sampled.
enum class RenderFormat { rgba16f, rgba32f, depth32f };
class Renderbuffer {
public:
    Renderbuffer(RenderFormat format, std::uint32_t width, std::uint32_t height,
                 std::uint32_t samples);
    Renderbuffer(Renderbuffer&&) = default;
    ~Renderbuffer();
    Name name() const { return name_.get(); }
    RenderFormat format() const { return format_; }

private:
    RenderFormat format_;
    OwnedName name_;
};

struct FramebufferDescription {
    const Texture* color = nullptr;  // this, or colorSamples
    std::uint32_t level = 0;
    std::uint32_t face = 0;  // cubes only
    const Renderbuffer* colorSamples = nullptr;
    const Renderbuffer* depth = nullptr;
    std::uint32_t width = 0, height = 0;  // of the level
};

class Framebuffer {
public:
    // What it is built from must outlive it. Throws std::runtime_error when it is not complete.
    explicit Framebuffer(const FramebufferDescription& description);
    Framebuffer(Framebuffer&&) = default;
    ~Framebuffer();

    void bind() const;  // to draw into, with a viewport that covers it
    void resolveInto(const Framebuffer& target) const;  // same size
    void scaleInto(const Framebuffer& target) const;    // bilinear; not from multisampled memory
    void readBytes(std::span<std::byte> rgba) const;    // 8 bits a channel, first row first
    void readFloats(std::span<float> rgba) const;
    std::uint32_t width() const { return width_; }
    std::uint32_t height() const { return height_; }

private:
    std::uint32_t width_, height_;
    std::uint32_t kind_;  // equal for equal formats of what is drawn into
    OwnedName name_;
};

}  // namespace clerestory::gl
