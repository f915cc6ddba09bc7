// Compiled vertex shaders and linked programs.
#pragma once

#include "gl/api.h"

#include <string>

namespace clerestory::gl {

class VertexShader {
public:
    // `name` is for error messages. Throws std::runtime_error with the driver's log when it does
    // not compile.
    VertexShader(const std::string& name, const std::string& source);
    VertexShader(VertexShader&&) = default;
    ~VertexShader();
    Name name() const { return name_.get(); }

private:
    OwnedName name_;
};

struct ProgramDescription {
    std::string name;  // for debuggers and error messages
    const VertexShader& vertex;
    std::string fragmentSource;
    // For a program with nested loops: llvmpipe compiles other code for it when it was linked than
    // when it came from the driver's cache, so that the next process would compile it again. With
    // this, a linked program is replaced by its own binary, which is what the cache holds. Other
    // drivers ignore it.
    bool loadBinary = false;
};

class Program {
public:
    // Throws std::runtime_error with the driver's log when it does not compile or link.
    explicit Program(const ProgramDescription& description);
    Program(Program&&) = default;
    ~Program();
    void use() const;
    Name name() const { return name_.get(); }

private:
    OwnedName name_;
};

// Frees what the driver keeps for compiling shaders; the next one brings it back.
void releaseShaderCompiler();

}  // namespace clerestory::gl
