// Framebuffers and renderbuffers.
#include "gl/framebuffer.h"

#include "gl/context.h"

#include <cassert>
#include <stdexcept>
#include <string>

namespace clerestory::gl {
namespace {

GLenum wordOf(RenderFormat format) {
    switch (format) {
        case RenderFormat::rgba16f:
            return GL_RGBA16F;
        case RenderFormat::rgba32f:
            return GL_RGBA32F;
        case RenderFormat::depth32f:
            return GL_DEPTH_COMPONENT32F;
    }
    return GL_RGBA16F;
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
    const std::uint32_t color = d.color ? static_cast<std::uint32_t>(d.color->description().format)
                                        : static_cast<std::uint32_t>(d.colorSamples->format());
    return color | (d.depth ? 1u : 0u) << 8 | (d.colorSamples ? 1u : 0u) << 9;
}

}  // namespace

Renderbuffer::Renderbuffer(RenderFormat format, std::uint32_t width, std::uint32_t height,
                           std::uint32_t samples)
    : format_(format), name_(newRenderbuffer()) {
    glBindRenderbuffer(GL_RENDERBUFFER, name_.get());
    glRenderbufferStorageMultisample(GL_RENDERBUFFER, samples > 1 ? static_cast<int>(samples) : 0,
                                     wordOf(format), static_cast<int>(width),
                                     static_cast<int>(height));
}

Renderbuffer::~Renderbuffer() {
    const GLuint name = name_.get();
    glDeleteRenderbuffers(1, &name);
}

Framebuffer::Framebuffer(const FramebufferDescription& d)
    : width_(d.width), height_(d.height), kind_(kindOf(d)), name_(newFramebuffer()) {
    glBindFramebuffer(GL_FRAMEBUFFER, name_.get());
    if (d.colorSamples) {
        glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER,
                                  d.colorSamples->name());
    } else {
        const GLenum image = d.color->description().kind == TextureKind::cube
                                 ? GL_TEXTURE_CUBE_MAP_POSITIVE_X + d.face
                                 : static_cast<GLenum>(GL_TEXTURE_2D);
        glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, image, d.color->name(),
                               static_cast<GLint>(d.color->firstLevel() + d.level));
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

void Framebuffer::resolveInto(const Framebuffer& target) const {
    const auto w = static_cast<int>(width_), h = static_cast<int>(height_);
    glBindFramebuffer(GL_READ_FRAMEBUFFER, name_.get());
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, target.name_.get());
    glBlitFramebuffer(0, 0, w, h, 0, 0, w, h, GL_COLOR_BUFFER_BIT, GL_NEAREST);
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
    glBindFramebuffer(GL_READ_FRAMEBUFFER, name_.get());
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    glReadPixels(0, 0, static_cast<int>(width_), static_cast<int>(height_), GL_RGBA,
                 GL_UNSIGNED_BYTE, rgba.data());
}

void Framebuffer::readFloats(std::span<float> rgba) const {
    assert(rgba.size() == std::size_t{4} * width_ * height_);
    glBindFramebuffer(GL_READ_FRAMEBUFFER, name_.get());
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    glReadPixels(0, 0, static_cast<int>(width_), static_cast<int>(height_), GL_RGBA, GL_FLOAT,
                 rgba.data());
}

}  // namespace clerestory::gl
