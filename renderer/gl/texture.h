// Textures of fixed size and format, the samplers that define how they are read, and framebuffers:
// a level of a texture to draw into.
#pragma once

#include "gl/api.h"

#include <compare>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace clerestory::gl {

// A part of a picture, in pixels from its lower left corner.
struct Rect {
    std::uint32_t x = 0, y = 0, width = 0, height = 0;
};

enum class TextureKind { plane, cube };
enum class TextureFormat { rgba8, srgba8, rg16f, rgba16f, rgba32f, rgba32ui, depth32f };

struct TextureDescription {
    TextureKind kind = TextureKind::plane;
    TextureFormat format = TextureFormat::rgba8;
    std::uint32_t width = 1;
    std::uint32_t height = 1;
    std::uint32_t levels = 1;
    // llvmpipe compiles a shader for whether the edges of a plane that it reads are powers of two,
    // and for whether it has smaller levels. With this, planes of all sizes are alike to it: they
    // have at least two levels, and edges that are powers of two become the second level of storage
    // with odd edges. That costs memory, so planes of more than kMaxAlike texels keep such edges.
    // Shaders must not ask such a texture for its number of levels. Other drivers ignore it.
    bool alike = false;
};
inline constexpr std::uint64_t kMaxAlike = 1 << 20;

class Texture {
public:
    // Throws std::runtime_error when the driver has no memory for it.
    explicit Texture(const TextureDescription& description);
    Texture(Texture&&) = default;
    ~Texture();

    // One level of one face, first row first, tightly packed: four bytes a texel for the 8-bit
    // formats, four integers for rgba32ui, floats for the others.
    void upload(std::uint32_t level, std::uint32_t face, std::span<const std::byte> texels);
    // A part of level 0 of a plane.
    void uploadPart(const Rect& part, std::span<const std::byte> texels) const;
    // Level 0 of an rgba16f plane, four halves a texel, red in the lowest bits.
    void uploadHalves(std::span<const std::uint64_t> rgba) const;
    // The same part of level 0 of another plane of this format.
    void copyPart(const Texture& from, const Rect& part) const;
    // The bytes of one level of an 8-bit plane, as they were uploaded.
    void read(std::uint32_t level, std::span<std::byte> texels) const;
    void bind(unsigned int unit) const;
    Name name() const { return name_.get(); }
    const TextureDescription& description() const { return description_; }
    // Where level 0 lies in the storage.
    std::uint32_t firstLevel() const { return firstLevel_; }

private:
    TextureDescription description_;
    std::uint32_t firstLevel_ = 0;
    OwnedName name_;
};

enum class Wrapping { repeat, mirroredRepeat, clampToEdge };
enum class LevelFilter { none, nearest, linear };

struct SamplerDescription {
    Wrapping wrapU = Wrapping::clampToEdge;
    Wrapping wrapV = Wrapping::clampToEdge;
    bool magnifyLinear = true;
    bool minifyLinear = true;
    LevelFilter levels = LevelFilter::none;
    std::uint32_t anisotropy = 1;
    int levelsBelow = 0;  // finer than the one whose texel is as wide as a pixel
    // Of a depth texture: the share of the texels around that are not nearer than the third
    // coordinate; depth is reversed.
    bool compare = false;
    auto operator<=>(const SamplerDescription&) const = default;
};

class Sampler {
public:
    explicit Sampler(const SamplerDescription& description);
    Sampler(Sampler&&) = default;
    ~Sampler();
    void bind(unsigned int unit) const;

private:
    OwnedName name_;
};

// Depths, as 32-bit floats, that are drawn into and never sampled.
class DepthBuffer {
public:
    DepthBuffer(std::uint32_t width, std::uint32_t height);
    DepthBuffer(DepthBuffer&&) = default;
    ~DepthBuffer();
    Name name() const { return name_.get(); }

private:
    OwnedName name_;
};

struct FramebufferDescription {
    // A depth texture takes the place of `depth`; there is no colour then.
    const Texture* color = nullptr;
    std::uint32_t level = 0;
    std::uint32_t face = 0;  // cubes only
    const DepthBuffer* depth = nullptr;
    // Drawn into at the same time: outputs 1 and following of a shader. Level 0.
    std::vector<const Texture*> further = {};
    std::uint32_t width = 0, height = 0;  // of the level
};

class Framebuffer {
public:
    // What it is built from must outlive it. Throws std::runtime_error when it is not complete.
    explicit Framebuffer(const FramebufferDescription& description);
    Framebuffer(Framebuffer&&) = default;
    ~Framebuffer();

    void bind() const;                               // to draw into, with a viewport that covers it
    void bindPart(const Rect& part) const;           // the viewport is the part
    void copyInto(const Framebuffer& target) const;  // same size
    void copyDepthInto(const Framebuffer& target) const;  // same size
    void scaleInto(const Framebuffer& target) const;      // bilinear
    void readBytes(std::span<std::byte> rgba) const;      // 8 bits a channel, first row first
    void readFloats(std::span<float> rgba) const;
    void readFloats(const Rect& part, std::span<float> rgba) const;
    void readReds(const Rect& part, std::span<float> reds) const;
    void readDepths(std::span<float> depths) const;
    void readDepths(const Rect& part, std::span<float> depths) const;
    void readHalves(std::span<std::uint64_t> rgba) const;               // red in the lowest bits
    void readWords(const Rect& part, std::span<std::byte> rgba) const;  // of rgba32ui
    // Sets a part of the further textures to 0. The framebuffer is bound.
    void clearFurther(const Rect& part) const;
    std::uint32_t width() const { return width_; }
    std::uint32_t height() const { return height_; }

private:
    Rect whole() const { return {0, 0, width_, height_}; }
    // pixels: of the part, tightly packed, as OpenGL's format and type say.
    void read(const Rect& part, unsigned format, unsigned type, void* pixels) const;

    std::uint32_t width_, height_;
    std::uint32_t kind_;  // equal for equal formats of what is drawn into
    int further_;
    OwnedName name_;
};

}  // namespace clerestory::gl
