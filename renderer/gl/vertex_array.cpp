// Vertex arrays.
#include "gl/vertex_array.h"

#include "gl/context.h"

namespace clerestory::gl {
namespace {

Name newVertexArray() {
    ++Context::current().counters().vertexArrays;
    GLuint name = 0;
    glGenVertexArrays(1, &name);
    return name;
}

}  // namespace

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

void drawIndexed(std::uint32_t firstIndex, std::uint32_t indexCount, std::uint32_t instance) {
    const std::uintptr_t offset = std::uintptr_t{firstIndex} * sizeof(std::uint32_t);
    Context::current().firstUse().draw([&] {
        glDrawElementsInstancedBaseInstance(GL_TRIANGLES, static_cast<GLsizei>(indexCount),
                                            GL_UNSIGNED_INT, reinterpret_cast<const void*>(offset),
                                            1, instance);
    });
}

void submitDraws() {
    if (Context::current().capabilities().software) glFlush();
}

void drawTriangle() {
    Context::current().firstUse().draw([] { glDrawArrays(GL_TRIANGLES, 0, 3); });
}

}  // namespace clerestory::gl
