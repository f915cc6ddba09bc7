// Textures and samplers.
#include "gl/texture.h"

#include "gl/context.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <stdexcept>
#include <string>

namespace clerestory::gl {
namespace {

struct FormatWords {
    GLenum internal, layout, type;
};

FormatWords wordsOf(TextureFormat format) {
    switch (format) {
        case TextureFormat::rgba8:
            return {GL_RGBA8, GL_RGBA, GL_UNSIGNED_BYTE};
        case TextureFormat::srgba8:
            return {GL_SRGB8_ALPHA8, GL_RGBA, GL_UNSIGNED_BYTE};
        case TextureFormat::rg16f:
            return {GL_RG16F, GL_RG, GL_FLOAT};
        case TextureFormat::rgba16f:
            return {GL_RGBA16F, GL_RGBA, GL_FLOAT};
        case TextureFormat::rgba32f:
            return {GL_RGBA32F, GL_RGBA, GL_FLOAT};
        case TextureFormat::rgba32ui:
            return {GL_RGBA32UI, GL_RGBA_INTEGER, GL_UNSIGNED_INT};
        case TextureFormat::depth32f:
            return {GL_DEPTH_COMPONENT32F, GL_DEPTH_COMPONENT, GL_FLOAT};
    }
    return {};
}

GLenum targetOf(const TextureDescription& d) {
    return d.kind == TextureKind::cube ? GL_TEXTURE_CUBE_MAP : GL_TEXTURE_2D;
}

GLint wordOf(Wrapping wrapping) {
    switch (wrapping) {
        case Wrapping::repeat:
            return GL_REPEAT;
        case Wrapping::mirroredRepeat:
            return GL_MIRRORED_REPEAT;
        case Wrapping::clampToEdge:
            return GL_CLAMP_TO_EDGE;
    }
    return GL_REPEAT;
}

GLint minifyWord(bool linear, LevelFilter levels) {
    switch (levels) {
        case LevelFilter::none:
            return linear ? GL_LINEAR : GL_NEAREST;
        case LevelFilter::nearest:
            return linear ? GL_LINEAR_MIPMAP_NEAREST : GL_NEAREST_MIPMAP_NEAREST;
        case LevelFilter::linear:
            return linear ? GL_LINEAR_MIPMAP_LINEAR : GL_NEAREST_MIPMAP_LINEAR;
    }
    return GL_LINEAR;
}

Name newTexture() {
    ++Context::current().counters().textures;
    GLuint name = 0;
    glGenTextures(1, &name);
    return name;
}

Name newSampler() {
    ++Context::current().counters().samplers;
    GLuint name = 0;
    glGenSamplers(1, &name);
    return name;
}

std::uint32_t levelsOf(std::uint32_t width, std::uint32_t height) {
    return static_cast<std::uint32_t>(std::bit_width(std::max(width, height)));
}

struct Storage {
    std::uint32_t width, height, levels;
    std::uint32_t firstLevel;  // of them, that the texture begins with
};

Storage storageOf(const TextureDescription& d) {
    Storage storage{d.width, d.height, d.levels, 0};
    if (!d.alike || !Context::current().capabilities().software) return storage;
    storage.levels = std::max(d.levels, std::min(2u, levelsOf(d.width, d.height)));
    const bool small = std::uint64_t{d.width} * d.height <= kMaxAlike;
    if (!small || (!std::has_single_bit(d.width) && !std::has_single_bit(d.height))) return storage;
    return {2 * d.width + 1, 2 * d.height + 1, storage.levels + 1, 1};
}

Name newRenderbuffer() {
    ++Context::current().counters().textures;
    GLuint name = 0;
    glGenRenderbuffers(1, &name);
    return name;
}

Name newFramebuffer() {
    ++Context::current().counters().framebuffers;
    GLuint name = 0;
    glGenFramebuffers(1, &name);
    return name;
}

std::uint32_t kindOf(const FramebufferDescription& d) {
    return static_cast<std::uint32_t>(d.color->description().format) | (d.depth ? 1u : 0u) << 8 |
           static_cast<std::uint32_t>(d.further.size()) << 10;
}

}  // namespace

Texture::Texture(const TextureDescription& description)
    : description_(description), name_(newTexture()) {
    const GLenum target = targetOf(description);
    const Storage storage = storageOf(description);
    firstLevel_ = storage.firstLevel;
    glActiveTexture(GL_TEXTURE0);
    glBindTexture(target, name_.get());
    const GLenum format = wordsOf(description.format).internal;
    const auto width = static_cast<GLsizei>(storage.width);
    const auto height = static_cast<GLsizei>(storage.height);
    glTexStorage2D(target, static_cast<GLsizei>(storage.levels), format, width, height);
    glTexParameteri(target, GL_TEXTURE_BASE_LEVEL, static_cast<GLint>(firstLevel_));
    GLint complete = 0;
    glGetTexParameteriv(target, GL_TEXTURE_IMMUTABLE_FORMAT, &complete);
    if (!complete) {
        const GLuint name = name_.get();
        glDeleteTextures(1, &name);
        throw std::runtime_error("no memory for a texture of " + std::to_string(description.width) +
                                 "x" + std::to_string(description.height));
    }
}

Texture::~Texture() {
    const GLuint name = name_.get();
    glDeleteTextures(1, &name);
}

void Texture::uploadPart(const Rect& part, std::span<const std::byte> texels) const {
    const FormatWords words = wordsOf(description_.format);
    bind(0);
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    glTexSubImage2D(GL_TEXTURE_2D, static_cast<GLint>(firstLevel_), static_cast<int>(part.x),
                    static_cast<int>(part.y), static_cast<GLsizei>(part.width),
                    static_cast<GLsizei>(part.height), words.layout, words.type, texels.data());
}

void Texture::uploadHalves(std::span<const std::uint64_t> rgba) const {
    assert(rgba.size() == std::size_t{description_.width} * description_.height);
    bind(0);
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    glTexSubImage2D(GL_TEXTURE_2D, static_cast<GLint>(firstLevel_), 0, 0,
                    static_cast<GLsizei>(description_.width),
                    static_cast<GLsizei>(description_.height), GL_RGBA, GL_HALF_FLOAT, rgba.data());
}

void Texture::upload(std::uint32_t level, std::uint32_t face, std::span<const std::byte> texels) {
    const FormatWords words = wordsOf(description_.format);
    bind(0);
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    const GLenum target = description_.kind == TextureKind::cube
                              ? GL_TEXTURE_CUBE_MAP_POSITIVE_X + face
                              : static_cast<GLenum>(GL_TEXTURE_2D);
    glTexSubImage2D(target, static_cast<GLint>(firstLevel_ + level), 0, 0,
                    static_cast<GLsizei>(std::max(1u, description_.width >> level)),
                    static_cast<GLsizei>(std::max(1u, description_.height >> level)), words.layout,
                    words.type, texels.data());
}

void Texture::copyPart(const Texture& from, const Rect& part) const {
    assert(from.description_.format == description_.format);
    const auto x = static_cast<GLint>(part.x), y = static_cast<GLint>(part.y);
    glCopyImageSubData(from.name(), GL_TEXTURE_2D, static_cast<GLint>(from.firstLevel_), x, y, 0,
                       name(), GL_TEXTURE_2D, static_cast<GLint>(firstLevel_), x, y, 0,
                       static_cast<GLsizei>(part.width), static_cast<GLsizei>(part.height), 1);
}

void Texture::read(std::uint32_t level, std::span<std::byte> texels) const {
    bind(0);
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    glGetTexImage(GL_TEXTURE_2D, static_cast<GLint>(firstLevel_ + level), GL_RGBA, GL_UNSIGNED_BYTE,
                  texels.data());
}

void Texture::bind(unsigned int unit) const {
    glActiveTexture(GL_TEXTURE0 + unit);
    glBindTexture(targetOf(description_), name_.get());
}

Sampler::Sampler(const SamplerDescription& d) : name_(newSampler()) {
    const GLuint name = name_.get();
    glSamplerParameteri(name, GL_TEXTURE_WRAP_S, wordOf(d.wrapU));
    glSamplerParameteri(name, GL_TEXTURE_WRAP_T, wordOf(d.wrapV));
    glSamplerParameteri(name, GL_TEXTURE_MAG_FILTER, d.magnifyLinear ? GL_LINEAR : GL_NEAREST);
    glSamplerParameteri(name, GL_TEXTURE_MIN_FILTER, minifyWord(d.minifyLinear, d.levels));
    if (d.levelsBelow > 0) {
        glSamplerParameterf(name, GL_TEXTURE_LOD_BIAS, -static_cast<float>(d.levelsBelow));
    }
    if (d.compare) {
        glSamplerParameteri(name, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
        glSamplerParameteri(name, GL_TEXTURE_COMPARE_FUNC, GL_GEQUAL);
    }
    if (d.anisotropy > 1) {
        constexpr GLenum kTextureMaxAnisotropy = 0x84FE;
        glSamplerParameterf(name, kTextureMaxAnisotropy, static_cast<float>(d.anisotropy));
    }
}

Sampler::~Sampler() {
    const GLuint name = name_.get();
    glDeleteSamplers(1, &name);
}

void Sampler::bind(unsigned int unit) const {
    glBindSampler(unit, name_.get());
}

DepthBuffer::DepthBuffer(std::uint32_t width, std::uint32_t height) : name_(newRenderbuffer()) {
    glBindRenderbuffer(GL_RENDERBUFFER, name_.get());
    glRenderbufferStorage(GL_RENDERBUFFER, GL_DEPTH_COMPONENT32F, static_cast<int>(width),
                          static_cast<int>(height));
}

DepthBuffer::~DepthBuffer() {
    const GLuint name = name_.get();
    glDeleteRenderbuffers(1, &name);
}

Framebuffer::Framebuffer(const FramebufferDescription& d)
    : width_(d.width),
      height_(d.height),
      kind_(kindOf(d)),
      further_(static_cast<int>(d.further.size())),
      name_(newFramebuffer()) {
    glBindFramebuffer(GL_FRAMEBUFFER, name_.get());
    if (d.color->description().format == TextureFormat::depth32f) {
        glFramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, d.color->name(),
                               0);
        glDrawBuffer(GL_NONE);
        glReadBuffer(GL_NONE);
    } else {
        const GLenum image = d.color->description().kind == TextureKind::cube
                                 ? GL_TEXTURE_CUBE_MAP_POSITIVE_X + d.face
                                 : targetOf(d.color->description());
        glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, image, d.color->name(),
                               static_cast<GLint>(d.color->firstLevel() + d.level));
    }
    for (std::size_t i = 0; i < d.further.size(); ++i) {
        glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT1 + static_cast<GLenum>(i),
                               targetOf(d.further[i]->description()), d.further[i]->name(),
                               static_cast<GLint>(d.further[i]->firstLevel()));
    }
    if (!d.further.empty()) {
        std::vector<GLenum> drawn;
        for (std::size_t i = 0; i <= d.further.size(); ++i) {
            drawn.push_back(GL_COLOR_ATTACHMENT0 + static_cast<GLenum>(i));
        }
        glDrawBuffers(static_cast<GLsizei>(drawn.size()), drawn.data());
    }
    if (d.depth) {
        glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER,
                                  d.depth->name());
    }
    if (const GLenum status = glCheckFramebufferStatus(GL_FRAMEBUFFER);
        status != GL_FRAMEBUFFER_COMPLETE) {
        const GLuint name = name_.get();
        glDeleteFramebuffers(1, &name);
        throw std::runtime_error("a framebuffer of " + std::to_string(width_) + "x" +
                                 std::to_string(height_) + " is not complete (status " +
                                 std::to_string(status) + "), probably for lack of memory");
    }
}

Framebuffer::~Framebuffer() {
    const GLuint name = name_.get();
    glDeleteFramebuffers(1, &name);
}

void Framebuffer::bind() const {
    glBindFramebuffer(GL_FRAMEBUFFER, name_.get());
    glViewport(0, 0, static_cast<int>(width_), static_cast<int>(height_));
    Context::current().firstUse().setTarget(kind_);
}

void Framebuffer::copyInto(const Framebuffer& target) const {
    const auto w = static_cast<int>(width_), h = static_cast<int>(height_);
    glBindFramebuffer(GL_READ_FRAMEBUFFER, name_.get());
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, target.name_.get());
    glBlitFramebuffer(0, 0, w, h, 0, 0, w, h, GL_COLOR_BUFFER_BIT, GL_NEAREST);
}

void Framebuffer::copyDepthInto(const Framebuffer& target) const {
    const auto w = static_cast<int>(width_), h = static_cast<int>(height_);
    glBindFramebuffer(GL_READ_FRAMEBUFFER, name_.get());
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, target.name_.get());
    glBlitFramebuffer(0, 0, w, h, 0, 0, w, h, GL_DEPTH_BUFFER_BIT, GL_NEAREST);
}

void Framebuffer::scaleInto(const Framebuffer& target) const {
    glBindFramebuffer(GL_READ_FRAMEBUFFER, name_.get());
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, target.name_.get());
    glBlitFramebuffer(0, 0, static_cast<int>(width_), static_cast<int>(height_), 0, 0,
                      static_cast<int>(target.width_), static_cast<int>(target.height_),
                      GL_COLOR_BUFFER_BIT, GL_LINEAR);
}

void Framebuffer::readBytes(std::span<std::byte> rgba) const {
    assert(rgba.size() == std::size_t{4} * width_ * height_);
    read(whole(), GL_RGBA, GL_UNSIGNED_BYTE, rgba.data());
}

void Framebuffer::readFloats(std::span<float> rgba) const {
    readFloats(whole(), rgba);
}

void Framebuffer::readFloats(const Rect& part, std::span<float> rgba) const {
    assert(rgba.size() == std::size_t{4} * part.width * part.height);
    read(part, GL_RGBA, GL_FLOAT, rgba.data());
}

void Framebuffer::readReds(const Rect& part, std::span<float> reds) const {
    assert(reds.size() == std::size_t{part.width} * part.height);
    read(part, GL_RED, GL_FLOAT, reds.data());
}

void Framebuffer::readDepths(std::span<float> depths) const {
    readDepths(whole(), depths);
}

void Framebuffer::readDepths(const Rect& part, std::span<float> depths) const {
    assert(depths.size() == std::size_t{part.width} * part.height);
    read(part, GL_DEPTH_COMPONENT, GL_FLOAT, depths.data());
}

void Framebuffer::readHalves(std::span<std::uint64_t> rgba) const {
    assert(rgba.size() == std::size_t{width_} * height_);
    read(whole(), GL_RGBA, GL_HALF_FLOAT, rgba.data());
}

void Framebuffer::readWords(const Rect& part, std::span<std::byte> rgba) const {
    assert(rgba.size() == std::size_t{16} * part.width * part.height);
    read(part, GL_RGBA_INTEGER, GL_UNSIGNED_INT, rgba.data());
}

void Framebuffer::read(const Rect& part, unsigned format, unsigned type, void* pixels) const {
    glBindFramebuffer(GL_READ_FRAMEBUFFER, name_.get());
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    glReadPixels(static_cast<int>(part.x), static_cast<int>(part.y), static_cast<int>(part.width),
                 static_cast<int>(part.height), format, type, pixels);
}

void Framebuffer::clearFurther(const Rect& part) const {
    const GLuint zero[4] = {0, 0, 0, 0};
    glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    glEnable(GL_SCISSOR_TEST);
    glScissor(static_cast<int>(part.x), static_cast<int>(part.y), static_cast<int>(part.width),
              static_cast<int>(part.height));
    for (int i = 1; i <= further_; ++i) glClearBufferuiv(GL_COLOR, i, zero);
    glDisable(GL_SCISSOR_TEST);
}

void Framebuffer::bindPart(const Rect& part) const {
    bind();
    glViewport(static_cast<int>(part.x), static_cast<int>(part.y), static_cast<int>(part.width),
               static_cast<int>(part.height));
}

}  // namespace clerestory::gl
