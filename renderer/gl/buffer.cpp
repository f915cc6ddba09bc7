// Buffers and buffer textures.
#include "gl/buffer.h"

#include "gl/context.h"

namespace clerestory::gl {
namespace {

Name newBuffer() {
    ++Context::current().counters().buffers;
    GLuint name = 0;
    glGenBuffers(1, &name);
    glBindBuffer(GL_COPY_WRITE_BUFFER, name);  // a name becomes an object when first bound
    return name;
}

// llvmpipe compiles a shader again for a buffer texture whose size in bytes is a power of two where
// the previous one was not, or has zeros in bits 8 to 15 (it reads them as a number of levels).
// Sizes of 4096 n + 768 have neither property, so that one variant serves every content.
std::size_t allocatedSize(std::size_t size) {
    constexpr std::size_t kStep = 4096, kRemainder = 768;
    return size <= kRemainder ? kRemainder
                              : (size - kRemainder + kStep - 1) / kStep * kStep + kRemainder;
}

// The copy target belongs to no vertex array and no program, so writing there disturbs nothing.
void fill(Name name, std::span<const std::byte> content, GLenum usage) {
    glBindBuffer(GL_COPY_WRITE_BUFFER, name);
    glBufferData(GL_COPY_WRITE_BUFFER, static_cast<GLsizeiptr>(allocatedSize(content.size())),
                 nullptr, usage);
    glBufferSubData(GL_COPY_WRITE_BUFFER, 0, static_cast<GLsizeiptr>(content.size()),
                    content.data());
}

GLenum wordOf(BufferFormat format) {
    switch (format) {
        case BufferFormat::rgba32f:
            return GL_RGBA32F;
        case BufferFormat::rg32f:
            return GL_RG32F;
        case BufferFormat::rgba32ui:
            return GL_RGBA32UI;
        case BufferFormat::r32ui:
            return GL_R32UI;
        case BufferFormat::rgba8:
            return GL_RGBA8;
    }
    return GL_RGBA32F;
}

Name newVertexArray() {
    ++Context::current().counters().vertexArrays;
    GLuint name = 0;
    glGenVertexArrays(1, &name);
    return name;
}

}  // namespace

Buffer::Buffer() : name_(newBuffer()) {}

Buffer::Buffer(std::span<const std::byte> content) : name_(newBuffer()) {
    fill(name_.get(), content, GL_STATIC_DRAW);
}

Buffer Buffer::sharing(std::span<const std::byte> content) {
    Context& context = Context::current();
    if (!context.capabilities().readsClientMemory || content.empty()) return Buffer(content);
    constexpr GLenum kExternalVirtualMemoryBuffer = 0x9160;  // GL_AMD_pinned_memory
    Buffer buffer;
    glBindBuffer(kExternalVirtualMemoryBuffer, buffer.name_.get());
    glBufferData(kExternalVirtualMemoryBuffer, static_cast<GLsizeiptr>(content.size()),
                 content.data(), GL_STATIC_DRAW);
    glBindBuffer(kExternalVirtualMemoryBuffer, 0);
    context.counters().bytesShared += content.size();
    return buffer;
}

Buffer::~Buffer() {
    const GLuint name = name_.get();
    glDeleteBuffers(1, &name);
}

void Buffer::assign(std::span<const std::byte> content) {
    fill(name_.get(), content, GL_STREAM_DRAW);
}

void Buffer::replace(std::size_t offset, std::span<const std::byte> content) {
    glBindBuffer(GL_COPY_WRITE_BUFFER, name_.get());
    glBufferSubData(GL_COPY_WRITE_BUFFER, static_cast<GLintptr>(offset),
                    static_cast<GLsizeiptr>(content.size()), content.data());
}

void Buffer::bindUniform(unsigned int binding) const {
    glBindBufferBase(GL_UNIFORM_BUFFER, binding, name_.get());
}

void Buffer::bindUniform(unsigned int binding, std::size_t offset, std::size_t size) const {
    glBindBufferRange(GL_UNIFORM_BUFFER, binding, name_.get(), static_cast<GLintptr>(offset),
                      static_cast<GLsizeiptr>(size));
}

BufferTexture::BufferTexture(const Buffer& buffer, BufferFormat format)
    : name_([] {
          ++Context::current().counters().textures;
          GLuint name = 0;
          glGenTextures(1, &name);
          return name;
      }()) {
    glActiveTexture(GL_TEXTURE0);
    glBindTexture(GL_TEXTURE_BUFFER, name_.get());
    glTexBuffer(GL_TEXTURE_BUFFER, wordOf(format), buffer.name());
}

BufferTexture::~BufferTexture() {
    const GLuint name = name_.get();
    glDeleteTextures(1, &name);
}

void BufferTexture::bind(unsigned int unit) const {
    glActiveTexture(GL_TEXTURE0 + unit);
    glBindTexture(GL_TEXTURE_BUFFER, name_.get());
}

VertexArray::VertexArray(std::span<const Attribute> attributes, const Buffer* indices)
    : name_(newVertexArray()) {
    glBindVertexArray(name_.get());
    for (const Attribute& a : attributes) {
        glBindBuffer(GL_ARRAY_BUFFER, a.buffer->name());
        glEnableVertexAttribArray(a.slot);
        glVertexAttribPointer(a.slot, static_cast<GLint>(a.components), GL_FLOAT, GL_FALSE,
                              static_cast<GLsizei>(a.stride),
                              reinterpret_cast<const void*>(std::uintptr_t{a.offset}));
        glVertexAttribDivisor(a.slot, a.perInstance ? 1 : 0);
    }
    if (indices) glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, indices->name());
    glBindVertexArray(0);
}

VertexArray::~VertexArray() {
    const GLuint name = name_.get();
    glDeleteVertexArrays(1, &name);
}

void VertexArray::bind() const {
    glBindVertexArray(name_.get());
}

namespace {
GLenum modeOf(Topology topology) {
    switch (topology) {
        case Topology::points:
            return GL_POINTS;
        case Topology::lines:
            return GL_LINES;
        case Topology::triangles:
            break;
    }
    return GL_TRIANGLES;
}
}  // namespace

void drawIndexed(Topology topology, std::uint32_t firstIndex, std::uint32_t indexCount,
                 std::uint32_t instance) {
    const std::uintptr_t offset = std::uintptr_t{firstIndex} * sizeof(std::uint32_t);
    Context::current().firstUse().draw([&] {
        glDrawElementsInstancedBaseInstance(modeOf(topology), static_cast<GLsizei>(indexCount),
                                            GL_UNSIGNED_INT, reinterpret_cast<const void*>(offset),
                                            1, instance);
    });
}

void setWidth(float pixels) {
    glPointSize(pixels);
    glLineWidth(pixels);
}

void submitDraws() {
    if (Context::current().capabilities().software) glFlush();
}

Fence::Fence() : sync_(glFenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0)) {
    glFlush();
}
Fence::~Fence() {
    if (sync_) glDeleteSync(static_cast<GLsync>(sync_));
}
void Fence::wait() const {
    constexpr GLuint64 kSecond = 1'000'000'000;
    while (sync_ && glClientWaitSync(static_cast<GLsync>(sync_), 0, kSecond) == GL_TIMEOUT_EXPIRED) {
    }
}

double drawnPixels() {
    GLint viewport[4] = {};
    glGetIntegerv(GL_VIEWPORT, viewport);
    return double(viewport[2]) * double(viewport[3]);
}

void drawTriangle() {
    Context::current().firstUse().draw([] { glDrawArrays(GL_TRIANGLES, 0, 3); });
}

}  // namespace clerestory::gl
