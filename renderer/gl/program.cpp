// Compiling and linking.
#include "gl/program.h"

#include "gl/context.h"

#include <cstddef>
#include <stdexcept>
#include <vector>

namespace clerestory::gl {
namespace {

Name compiled(GLenum stage, const std::string& name, const std::string& source) {
    const GLuint shader = glCreateShader(stage);
    const char* text = source.c_str();
    glShaderSource(shader, 1, &text, nullptr);
    glCompileShader(shader);
    GLint ok = 0, length = 0;
    glGetShaderiv(shader, GL_COMPILE_STATUS, &ok);
    if (ok) return shader;
    glGetShaderiv(shader, GL_INFO_LOG_LENGTH, &length);
    std::string log(static_cast<std::size_t>(length), ' ');
    glGetShaderInfoLog(shader, length, nullptr, log.data());
    glDeleteShader(shader);
    throw std::runtime_error("shader " + name + " does not compile: " + log);
}

void replaceByBinary(GLuint program) {
    GLint size = 0;
    glGetProgramiv(program, GL_PROGRAM_BINARY_LENGTH, &size);
    if (size <= 0) return;  // the driver has no cache, and no binaries
    std::vector<std::byte> binary(static_cast<std::size_t>(size));
    GLenum format = 0;
    glGetProgramBinary(program, size, &size, &format, binary.data());
    glProgramBinary(program, format, binary.data(), size);
}

Name linked(const ProgramDescription& d) {
    const GLuint fragment = compiled(GL_FRAGMENT_SHADER, d.name, d.fragmentSource);
    const GLuint program = glCreateProgram();
    for (const GLuint shader : {d.vertex.name(), fragment}) glAttachShader(program, shader);
    glLinkProgram(program);
    for (const GLuint shader : {d.vertex.name(), fragment}) glDetachShader(program, shader);
    glDeleteShader(fragment);
    GLint ok = 0, length = 0;
    glGetProgramiv(program, GL_LINK_STATUS, &ok);
    if (ok && d.loadBinary && Context::current().capabilities().software) {
        replaceByBinary(program);
        glGetProgramiv(program, GL_LINK_STATUS, &ok);
    }
    if (!ok) {
        glGetProgramiv(program, GL_INFO_LOG_LENGTH, &length);
        std::string log(static_cast<std::size_t>(length), ' ');
        glGetProgramInfoLog(program, length, nullptr, log.data());
        glDeleteProgram(program);
        throw std::runtime_error("program " + d.name + " does not link: " + log);
    }
    glObjectLabel(GL_PROGRAM, program, static_cast<GLsizei>(d.name.size()), d.name.data());
    ++Context::current().counters().programs;
    return program;
}

}  // namespace

VertexShader::VertexShader(const std::string& name, const std::string& source)
    : name_(compiled(GL_VERTEX_SHADER, name, source)) {}

VertexShader::~VertexShader() {
    glDeleteShader(name_.get());
}

Program::Program(const ProgramDescription& description)
    : name_(Context::current().firstUse().link([&] { return linked(description); })) {}

Program::~Program() {
    glDeleteProgram(name_.get());
}

void Program::use() const {
    Context::current().firstUse().setProgram(name_.get());
    glUseProgram(name_.get());
}

void releaseShaderCompiler() {
    glReleaseShaderCompiler();
}

}  // namespace clerestory::gl
